//! The manual's table of contacts, row by row, with an emergency stop on the emulated board; and its worked example.

mod rig;

use emulator::{Board, Silicon};
use lang::profile::{Profile, Wiring};
use lang::wire::{self, Control, RunState};
use rig::{BOOT_US, ask, off, read, write_body};

const MANUAL: &str = include_str!("../README.md");

/// Rows of a table between two comments, without its head.
fn rows() -> Vec<Vec<&'static str>> {
    let (_, text) = MANUAL.split_once("<!-- contacts: read by the test `contacts` -->").unwrap();
    let (table, _) = text.split_once("<!-- end of contacts -->").unwrap();
    let lines = table.lines().filter(|line| line.starts_with('|')).skip(2);
    lines.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

/// A machine of three axes with an emergency stop.
fn machine(wiring: &str, n: u8, invert: bool) -> Profile {
    let mut text = format!("name = \"d\"\nhome_order = [\"Z\"]\nwiring = \"{wiring}\"\n");
    for axis in ["x", "y", "z"] {
        text += &format!(
            "[{axis}]\nscale = {{ steps = 80, um = 1000 }}\nstart_rate = 400\naccel = 100000\n\
             top_rate = 20000\nmin_um = -1000000\nmax_um = 1000000\n\
             home = {{ direction = \"negative\", fast_rate = 2000, slow_rate = 200, stroke_um = 330000, \
             pause_ms = 100 }}\n"
        );
    }
    text += &format!("[[input]]\nn = {n}\nrole = \"emergency_stop\"\ninvert = {invert}\n");
    Profile::parse(&text).expect("a profile")
}

/// A contact with its resistor at an input.
struct Contact {
    n: u8,
    /// It rests closed.
    closed: bool,
    /// Level while it is closed; the resistor makes the other one.
    level: bool,
}

impl Contact {
    fn is(&self, board: &mut Board, closed: bool) {
        // The plant's "on" is the closed contact here.
        board.plant_mut().set_active_low(self.n, !self.level);
        board.plant_mut().set_input(self.n, closed);
    }
}

fn control(board: &mut Board, control: Control) {
    ask(board, &write_body(wire::RUN_CONTROL, control as u16), 100_000);
}

fn runs(board: &mut Board) -> bool {
    control(board, Control::Acknowledge);
    control(board, Control::Start);
    let moved = board.plant().motors[0].pulses;
    board.run_us(100_000);
    read(board, wire::RUN_STATE) == Some(RunState::Running as u16)
        && board.plant().motors[0].pulses != moved
}

#[test]
fn each_row_of_the_manuals_table_of_contacts_does_what_it_says() {
    let rows = rows();
    assert_eq!(rows.len(), 6, "{rows:?}");
    for row in rows {
        let [wirings, kind, resistor, invert, broken] = row[..] else { panic!("{row:?}") };
        let invert: bool = invert.trim_matches('`').parse().expect("true or false");
        let level = match (kind.ends_with("to ground"), resistor) {
            (true, "the chip's own" | "10 kOhm to 3.3 V") => false,
            (false, "10 kOhm to ground") if kind.ends_with("to 3.3 V") => true,
            _ => panic!("{row:?}: the resistor goes where the contact goes"),
        };
        let places: &[(&str, u8)] = match wirings {
            "`direct`, or input 17" => &[("direct", 2), ("direct", 4), ("chain", 17)],
            "`chain`" => &[("chain", 6), ("chain", 16)],
            _ => panic!("{row:?}"),
        };
        for &(wiring, n) in places {
            let name = format!("{wiring}, input {n}: {kind}, invert {invert}");
            let contact = Contact { n, closed: kind.starts_with("normally closed"), level };
            let profile = machine(wiring, n, invert);
            assert_eq!(profile.wiring == Wiring::Chain, wiring == "chain");
            let mut board = off(Silicon::default(), &profile, "DO\nG0 X5\nG0 X0\nLOOP\n");
            contact.is(&mut board, contact.closed);
            board.power_up();
            board.run_us(BOOT_US);
            assert!(runs(&mut board), "{name}: at rest it lets the machine run");
            // Pressed: at once, and for as long as it is.
            contact.is(&mut board, !contact.closed);
            board.run_us(20_000);
            assert_eq!(read(&mut board, wire::FAULT), Some(14), "{name}: pressed");
            assert_eq!(read(&mut board, wire::FAULT_INPUT), Some(n.into()), "{name}");
            assert!(!runs(&mut board), "{name}: pressed, and started");
            contact.is(&mut board, contact.closed);
            board.run_us(100_000);
            assert!(runs(&mut board), "{name}: released");
            // Its wire breaks.
            let answers = match broken {
                "answers" => true,
                "is not noticed" => false,
                _ => panic!("{row:?}"),
            };
            contact.is(&mut board, false);
            board.run_us(20_000);
            let state = read(&mut board, wire::RUN_STATE);
            let stopped = state == Some(RunState::Fault as u16);
            assert_eq!(stopped, answers, "{name}: its wire is broken");
            assert_eq!(!runs(&mut board), answers, "{name}: its wire is broken, and started");
        }
    }
}

#[test]
fn the_worked_example_is_a_machine_that_its_wires_let_run() {
    let (_, text) = MANUAL.split_once("### A worked example\n").unwrap();
    let (_, text) = text.split_once("```toml\n").unwrap();
    let (text, _) = text.split_once("```\n").unwrap();
    let profile = Profile::parse(text).expect("a profile");
    assert_eq!(profile.wiring, Wiring::Direct);
    let mut board = off(Silicon::default(), &profile, "DO\nG0 X5\nG0 X0\nLOOP\n");
    // All four contacts are closed to ground at rest.
    for n in 1..=4 {
        Contact { n, closed: true, level: false }.is(&mut board, true);
    }
    board.power_up();
    board.run_us(BOOT_US);
    let [high, low] = wire::INPUTS.to_be_bytes();
    let reply = ask(&mut board, &[1, 4, high, low, 0, 1], 20_000);
    assert_eq!(reply.get(3..5), Some(&[0, 0][..]), "all inputs are off");
    assert!(runs(&mut board));
    Contact { n: 4, closed: true, level: false }.is(&mut board, false);
    board.run_us(20_000);
    assert_eq!(read(&mut board, wire::FAULT), Some(14));
}
