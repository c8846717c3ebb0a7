//! A board with a program, buttons, and a record of every step.

use emulator::{Board, Edge, Plant, Signal, TICKS_PER_SECOND};
pub use firmware::motion::physics::Step;
use lang::profile::{Profile, Wiring};
use lang::wire::{FAULT, MACHINE_POSITIONS, RUN_STATE};
use pasapas::bench::stand::{Stand, image_on};
use pasapas::board::Build;
use pasapas::board::judge::Judge;
use pasapas::torture::stand::{framed, read_body, write_body};

use crate::judged::{self, Commanded};

/// Ticks in a millisecond.
pub const MS: u64 = TICKS_PER_SECOND / 1_000;
/// Longest run of a test, ms.
const LONGEST_MS: u64 = 600_000;
/// A finger on a button, ms: longer than the input filter takes.
pub const PRESS_MS: u64 = 40;
/// The output that a test's program switches on last, in the chain.
pub const DONE: u8 = 8;

/// A board that holds a program, at rest. Every step that it makes is judged when it is dropped.
#[derive(Clone)]
pub struct Lab {
    /// The board.
    pub board: Board,
    profile: Profile,
    judge: Judge,
    commanded: Option<Commanded>,
    abrupt: Option<&'static str>,
}

/// What the pins did in a run.
pub struct Run {
    /// Every step, in order.
    pub steps: Vec<Step>,
    /// Every edge.
    pub edges: Vec<Edge>,
    /// When Start was accepted at the latest: the button's press, ticks.
    pub began: u64,
    /// When [`DONE`] went on, ticks.
    pub ended: u64,
}

impl Lab {
    /// A board of a build with a script on it; the script's end switches [`DONE`] on.
    pub fn new(build: &Build, profile: &Profile, script: &str) -> Lab {
        // An end would take the output back, and a Start press would run the program again.
        let done = if profile.wiring == Wiring::Chain { DONE } else { 2 };
        let text = format!("{script}\nSetOut {done}, ON\nWaitIn {done}, ON\n");
        let (program, image) = image_on(&build.part, profile, &text).expect("a script");
        let mut stand = Stand::on(build, profile).expect("a board");
        stand.upload(&image).expect("an upload");
        let mut board = stand.copy();
        // Time that is let pass is not cut short.
        board.plant_mut().stop_at_output = false;
        board.record(true);
        let judge = Judge::new(profile, board.plant());
        let commanded = Commanded::by(build, profile, &program, script);
        Lab { board, profile: profile.clone(), judge, commanded, abrupt: None }
    }

    /// The last motion is stopped at once, for a reason.
    pub fn stops_abruptly(&mut self, reason: &'static str) {
        self.abrupt = Some(reason);
    }

    /// It was not stopped after all.
    pub fn goes_to_its_end(&mut self) {
        self.abrupt = None;
    }

    /// Holds every step so far to the profile, its drivers, and where the script leads.
    pub fn judged(&mut self) -> Result<(), String> {
        self.edges();
        let commanded = self.commanded.as_ref().map(|own| (own, self.is_done()));
        judged::judge(&self.judge, self.board.plant(), commanded, self.abrupt.is_some())
    }

    /// What was found so far is forgotten: it was seeded.
    pub fn forgive(&mut self) {
        let (profile, plant) = (&self.profile, Plant::new(self.board.plant().wiring()));
        self.judge = Judge::new(profile, &plant);
        self.commanded = None;
        *self.board.plant_mut() = plant;
    }

    /// Ticks since power-up, [`TICKS_PER_SECOND`] of them on every part.
    pub fn now(&self) -> u64 {
        self.board.cycles() / self.unit()
    }

    /// The emulator's ticks in one of the tests'.
    fn unit(&self) -> u64 {
        self.board.ticks_per_second() / TICKS_PER_SECOND
    }

    /// Every edge since the last call, at ticks as [`Lab::now`] has them.
    pub fn edges(&mut self) -> Vec<Edge> {
        let mut edges = self.board.take_edges();
        self.judge.take(&edges);
        let unit = self.unit();
        edges.iter_mut().for_each(|edge| edge.cycle /= unit);
        edges
    }

    /// Every step since the last call of this or [`Lab::edges`].
    pub fn steps(&mut self) -> Vec<Step> {
        let before = self.judge.steps().len();
        self.edges();
        self.judge.steps()[before..].to_vec()
    }

    /// Presses Start for [`PRESS_MS`].
    pub fn start(&mut self) {
        self.press(true, PRESS_MS);
    }

    /// Presses Start or Stop for some milliseconds.
    pub fn press(&mut self, start: bool, ms: u64) {
        let push = |board: &mut Board, on| {
            let plant = board.plant_mut();
            if start { plant.press_start(on) } else { plant.press_stop(on) }
        };
        push(&mut self.board, true);
        self.run_ms(ms);
        push(&mut self.board, false);
    }

    /// Lets time pass.
    pub fn run_ms(&mut self, ms: u64) {
        self.board.run_us(ms * 1_000);
    }

    /// Whether the program has come to its end.
    pub fn is_done(&self) -> bool {
        self.board.plant().output(DONE)
    }

    /// Sends a request and takes the reply, which must come within 100 ms.
    fn ask(&mut self, body: &[u8]) -> Vec<u8> {
        self.board.uart_take();
        let sent = self.board.uart_send(&framed(body));
        self.board.run_until(sent);
        let mut reply = Vec::new();
        let mut silence = 0;
        for _ in 0..100 {
            self.run_ms(1);
            let more = self.board.uart_take();
            silence = if more.is_empty() { silence + 1 } else { 0 };
            // Between two registers of a reply there may be a pass of the main loop: 2 ms at most, as `bench passes` has it.
            if silence > 1 && !reply.is_empty() {
                break;
            }
            reply.extend(more.into_iter().map(|(_, byte)| byte));
        }
        // A frame begins behind 3.5 characters of silence.
        self.run_ms(1);
        reply
    }

    /// Reads a holding register.
    pub fn read(&mut self, address: u16) -> u16 {
        let reply = self.ask(&read_body(address, 1));
        assert_eq!(reply.len(), 7, "reading {address} was answered by {reply:02X?}");
        u16::from_be_bytes([reply[3], reply[4]])
    }

    /// Machine positions as the board has them, steps.
    pub fn told(&mut self) -> [i64; 3] {
        let reply = self.ask(&read_body(MACHINE_POSITIONS, 6));
        assert_eq!(reply.len(), 17, "positions: {reply:02X?}");
        std::array::from_fn(|axis| {
            let word = |at: usize| u32::from(u16::from_be_bytes([reply[at], reply[at + 1]]));
            let low = 3 + 4 * axis;
            i64::from((word(low + 2) << 16 | word(low)).cast_signed())
        })
    }

    /// Writes a holding register; `false` when an exception came back.
    pub fn write(&mut self, address: u16, value: u16) -> bool {
        let reply = self.ask(&write_body(address, &[value]));
        assert!(reply.len() >= 5, "writing {address} was answered by {reply:02X?}");
        reply[1] & 0x80 == 0
    }

    /// Step pulses of all axes so far.
    pub fn pulses(&self) -> u64 {
        self.board.plant().motors.iter().map(|motor| motor.pulses).sum()
    }

    /// Lets time pass until no axis has stepped for some milliseconds.
    pub fn settle(&mut self, ms: u64) {
        for _ in 0..LONGEST_MS / ms {
            let before = self.pulses();
            self.run_ms(ms);
            if self.pulses() == before {
                return;
            }
        }
        panic!("the machine does not come to rest");
    }

    /// Runs the program; `meanwhile` plays the people around it until it returns, then the end is
    /// awaited.
    pub fn play(&mut self, meanwhile: impl FnOnce(&mut Lab)) -> Run {
        self.edges();
        let before = self.judge.steps().len();
        let began = self.now();
        self.start();
        meanwhile(self);
        for _ in 0..LONGEST_MS / 10 {
            if self.is_done() {
                break;
            }
            self.run_ms(10);
        }
        if !self.is_done() {
            let [state, fault] = [RUN_STATE, FAULT].map(|register| self.read(register));
            panic!("the program does not end: state {state}, fault {fault}");
        }
        // What is armed behind the end would be a step too many.
        self.run_ms(20);
        let edges = self.edges();
        let mut ends = edges.iter().filter(|e| e.signal == Signal::Out(DONE) && e.level);
        let ended = ends.next().expect("the end").cycle;
        Run { steps: self.judge.steps()[before..].to_vec(), edges, began, ended }
    }
}

impl Drop for Lab {
    fn drop(&mut self) {
        if !std::thread::panicking()
            && let Err(text) = self.judged()
        {
            panic!("{text}");
        }
    }
}

/// Random numbers that are the same each time (splitmix64).
pub struct Dice(pub u64);

impl Dice {
    /// A number below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % end.max(1)
    }
}
