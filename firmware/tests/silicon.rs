//! The images on silicon as it is: random shift registers, slow supplies and wires, spikes, clocks that
//! are off, hosts that go away.

mod slot;

use emulator::{Board, Config, Image, Part, Stop, WarningKind, Wiring};
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::part::{self, F5529, G2553, G2553_HANDLERS};
use lang::profile::{Profile, SafeState};
use lang::record::BoardRecord;
use lang::wire::{self, CRC_START, Control, RunState, crc16};

/// An image with its chip.
struct Build {
    name: &'static str,
    elf: &'static [u8],
    chip: Part,
    part: part::Part,
    /// Address of the watchdog's control register.
    watchdog: u16,
}

const BUILDS: [Build; 3] = [
    Build {
        name: "g2553",
        elf: include_bytes!("../image/pasapas-g2553.elf"),
        chip: Part::G2553,
        part: G2553,
        watchdog: 0x0120,
    },
    Build {
        name: "g2553-handlers",
        elf: include_bytes!("../image/pasapas-g2553-handlers.elf"),
        chip: Part::G2553,
        part: G2553_HANDLERS,
        watchdog: 0x0120,
    },
    Build {
        name: "f5529",
        elf: include_bytes!("../image/pasapas-f5529.elf"),
        chip: Part::F5529,
        part: F5529,
        watchdog: 0x015C,
    },
];

/// From reset to the main loop, a small program's check included.
const BOOT_US: u64 = 200_000;

fn profile(name: &str, more: &str) -> Profile {
    let (_, text) =
        lang::profile::BUILT_IN.iter().find(|(known, _)| *known == name).expect("built in");
    Profile::parse(&format!("{text}\n{more}")).expect("a profile")
}

/// A board with a profile and a program, still without power.
fn off(build: &Build, config: &Config, profile: &Profile, script: &str) -> Board {
    let wiring = match profile.wiring {
        lang::profile::Wiring::Direct => Wiring::Direct,
        lang::profile::Wiring::Chain => Wiring::Chain,
    };
    let config = Config { part: build.chip.clone(), wiring, ..config.clone() };
    let image = Image::parse(build.elf).expect("the shipped image");
    let mut board = Board::with_config(&config, &image);
    board.power_cut();
    let (source, _) = Source::decode("test", script.as_bytes());
    let (program, diags) = compile(&source, ProfileChoice::Given(Box::new(profile.clone())));
    let program = program.unwrap_or_else(|| panic!("{script}: {diags:?}"));
    let program = lang::back::compile(&program).expect("it fits").image;
    let mut put = |first: u16, bytes: &[u8]| {
        for (address, &byte) in (first..).zip(bytes) {
            board.poke8(address, byte);
        }
    };
    let (first, slot) = slot::slot(&build.part, &program);
    put(first, &slot);
    put(build.part.profiles[1], &BoardRecord::of(profile, 1).to_bytes());
    board
}

/// The same, come up.
fn on(build: &Build, config: &Config, profile: &Profile, script: &str) -> Board {
    let mut board = off(build, config, profile, script);
    board.power_up();
    board.run_us(BOOT_US);
    board
}

/// What the board replies to a request without its CRC.
fn ask(board: &mut Board, body: &[u8]) -> Vec<u8> {
    let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
    board.uart_take();
    let end = board.uart_send(&[body, &crc.to_le_bytes()].concat());
    board.run_until(end);
    board.run_us(20_000);
    let mut reply = board.uart_take();
    if reply.is_empty() {
        // A program is checked before it starts.
        board.run_us(200_000);
        reply = board.uart_take();
    }
    reply.into_iter().map(|(_, byte)| byte).collect()
}

fn read(board: &mut Board, register: u16) -> Option<u16> {
    read_by(board, 3, register)
}

fn read_by(board: &mut Board, function: u8, register: u16) -> Option<u16> {
    let [high, low] = register.to_be_bytes();
    let reply = ask(board, &[1, function, high, low, 0, 1]);
    let sound =
        reply.len() == 7 && reply.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte)) == 0;
    sound.then(|| u16::from_be_bytes([reply[3], reply[4]]))
}

fn write(board: &mut Board, register: u16, value: u16) {
    let ([a, b], [c, d]) = (register.to_be_bytes(), value.to_be_bytes());
    let request = [1, 6, a, b, c, d];
    let reply = ask(board, &request);
    assert_eq!(reply.get(..6), Some(&request[..]), "register {register}");
}

fn state(board: &mut Board) -> Option<u16> {
    read(board, wire::RUN_STATE)
}

/// Lets time pass; every state of the outputs that comes by.
fn outputs_of(board: &mut Board, us: u64) -> Vec<u16> {
    board.plant_mut().stop_at_output = true;
    let end = board.cycles() + us * (board.ticks_per_second() / 1_000_000);
    let mut seen = vec![board.plant().outputs()];
    while board.run_until(end) == Stop::Output {
        seen.push(board.plant().outputs());
    }
    board.plant_mut().stop_at_output = false;
    seen.dedup();
    seen
}

/// The built-in profile of a wiring, with the outputs' polarity; output 2 of the direct one on at reset.
fn wired(direct: bool, invert: bool) -> Profile {
    let mut profile = profile("mill", "");
    if direct {
        profile.wiring = lang::profile::Wiring::Direct;
    }
    let named = profile.outputs.clone();
    profile.outputs = (1..=profile.wiring.outputs())
        .map(|n| {
            let mut output = named[0].clone();
            (output.n, output.invert, output.role, output.name) = (n, invert, None, None);
            output.reset = SafeState::Off;
            output
        })
        .collect();
    profile
}

#[test]
fn no_output_is_on_from_reset_to_the_first_exchange() {
    let script = "SetOut 1, ON\nSetOut 2, ON\nWait 9s\n";
    for build in &BUILDS {
        for (direct, invert) in [(false, false), (false, true), (true, false), (true, true)] {
            let profile = wired(direct, invert);
            let all: u16 = if direct { 0b11 } else { 0xFFFF };
            // What no resistor and no register may show but when it is off.
            let rests = if invert { all } else { 0 };
            for seed in 1..3 {
                let config = Config { seed, ..Config::default() };
                let name = format!("{} direct {direct} invert {invert} seed {seed}", build.name);
                let mut board = off(build, &config, &profile, script);
                if invert && direct {
                    board.plant_mut().pull_outputs_up();
                }
                // In the chain 0 is also what disabled registers show: the relays' resistors decide.
                let off = |seen: &[u16]| seen.iter().all(|o| *o == rests || !direct && *o == 0);
                board.power_up();
                let seen = outputs_of(&mut board, BOOT_US);
                assert!(off(&seen), "{name}: power-up {seen:04X?}");
                assert_eq!(board.plant().outputs(), rests, "{name}: driven at last");
                for cause in ["pin", "watchdog"] {
                    board.plant_mut().press_start(true);
                    board.run_us(100_000);
                    board.plant_mut().press_start(false);
                    board.run_us(30_000);
                    assert_eq!((board.plant().outputs() ^ rests) & 3, 3, "{name}: two are on");
                    if cause == "pin" {
                        board.reset_pin();
                    } else {
                        // A write without its password.
                        board.bus_write16(build.watchdog, 0);
                        board.step();
                    }
                    let seen = outputs_of(&mut board, BOOT_US);
                    assert!(off(&seen[1..]), "{name}: {cause} {seen:04X?}");
                    assert_eq!(board.plant().outputs(), rests, "{name}: {cause}");
                    // The fault of the run that was broken off is acknowledged.
                    board.plant_mut().press_start(true);
                    board.run_us(100_000);
                    board.plant_mut().press_start(false);
                    board.run_us(100_000);
                }
                let warned: Vec<_> = board.warnings().iter().map(|w| w.kind).collect();
                assert!(warned.iter().all(|kind| *kind == WarningKind::Key), "{name}: {warned:?}");
            }
        }
    }
}

#[test]
fn start_up_waits_for_the_supply() {
    // The handlers leave no room for looking at it: they wait 60 ms in all.
    for (build, rises) in
        [(&BUILDS[0], &[0, 1_000, 20_000, 90_000][..]), (&BUILDS[1], &[0, 1_000, 45_000])]
    {
        for &supply_rise_us in rises {
            let config = Config { supply_rise_us, ..Config::default() };
            let mut board = off(build, &config, &profile("mill", ""), "Wait 1s\n");
            board.power_up();
            board.run_us(BOOT_US + supply_rise_us);
            assert_eq!(board.warnings(), &[], "{} in {supply_rise_us} us", build.name);
            assert_eq!(state(&mut board), Some(RunState::Ready as u16), "{}", build.name);
        }
    }
    // One that stays too low is waited for, and the watchdog is kicked meanwhile.
    let config = Config { vcc: 2_800, ..Config::default() };
    let mut board = on(&BUILDS[0], &config, &profile("mill", ""), "Wait 1s\n");
    board.run_us(1_000_000);
    assert_eq!((board.warnings(), board.last_reset()), (&[][..], emulator::Reset::Power));
    assert_eq!(state(&mut board), None);
    board.set_supply(3_300);
    board.run_us(BOOT_US);
    assert_eq!((state(&mut board), board.warnings()), (Some(RunState::Ready as u16), &[][..]));
}

#[test]
fn a_long_cable_at_stop_is_no_stop() {
    let mut other = profile("mill", "");
    other.link.rate = 19_200;
    for build in &BUILDS[..2] {
        // 50 kOhm, the weakest pull-up, and 100 nF up to three quarters of the supply: 7 ms.
        let config = Config { pull_up_us: 7_000, ..Config::default() };
        let mut board = on(build, &config, &other, "Wait 1s\n");
        board.set_uart_format(emulator::Format { baud: 19_200, ..Default::default() });
        assert_eq!(read(&mut board, wire::VERSION), Some(wire::WIRE_VERSION), "{}", build.name);
    }
}

#[test]
fn without_a_cable_the_receive_pin_is_pulled_up() {
    for build in &BUILDS {
        let mut board = off(build, &Config::default(), &profile("mill", ""), "Wait 1s\n");
        board.plant_mut().unplug(true);
        board.power_up();
        board.run_us(BOOT_US);
        assert_eq!(board.warnings(), &[], "{}", build.name);
        board.plant_mut().unplug(false);
        assert_eq!(state(&mut board), Some(RunState::Ready as u16), "{}", build.name);
    }
}

#[test]
fn spikes_at_emergency_stops_stop_nothing() {
    let more = [2, 3].map(|n| format!("[[input]]\nn = {n}\nrole = \"emergency_stop\"\n"));
    for build in &BUILDS {
        let text = more.concat();
        let mut profile = profile("mill", "");
        profile.wiring = lang::profile::Wiring::Direct;
        let chain =
            Profile::parse(&format!("{}\n{text}", lang::profile::BUILT_IN[0].1)).expect("roles");
        profile.inputs.extend(chain.inputs.into_iter().filter(|input| [2, 3].contains(&input.n)));
        let mut board = on(build, &Config::default(), &profile, "Wait 9s\n");
        write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
        for k in 0..200u64 {
            board.spike(2 + (k & 1) as u8);
            board.run_us(50 + 7 * k);
        }
        assert_eq!(state(&mut board), Some(RunState::Running as u16), "{}", build.name);
        for n in [3, 2] {
            board.plant_mut().set_input(n, true);
            board.run_us(2_000);
            assert_eq!(read(&mut board, wire::FAULT), Some(14), "{} input {n}", build.name);
            assert_eq!(read(&mut board, wire::FAULT_INPUT), Some(n.into()), "{}", build.name);
            board.plant_mut().set_input(n, false);
            board.run_us(50_000);
            write(&mut board, wire::RUN_CONTROL, Control::Acknowledge as u16);
            write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
            assert_eq!(state(&mut board), Some(RunState::Running as u16), "{}", build.name);
        }
    }
}

#[test]
fn each_of_several_stops_holds_and_doors_works() {
    let roles = [
        ("emergency_stop", 5),
        ("emergency_stop", 1),
        ("emergency_stop", 17),
        ("emergency_stop", 16),
        ("hold", 2),
        ("hold", 3),
        ("door", 4),
        ("door", 6),
        ("stop", 7),
        ("stop", 8),
    ];
    let text = roles.map(|(role, n)| format!("[[input]]\nn = {n}\nrole = \"{role}\"\n")).concat();
    let machine = profile("mill", &text);
    for build in &BUILDS {
        let mut board = on(build, &Config::default(), &machine, "Wait 99s\n");
        for (role, n) in roles {
            let name = format!("{role} at {n} on {}", build.name);
            write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
            assert_eq!(state(&mut board), Some(RunState::Running as u16), "{name}");
            board.plant_mut().set_input(n, true);
            board.run_us(50_000);
            let stops = role == "emergency_stop";
            let wanted = if stops { RunState::Fault } else { RunState::Paused };
            assert_eq!(state(&mut board), Some(wanted as u16), "{name}");
            assert_eq!(read(&mut board, wire::BLOCKING_INPUT), Some(n.into()), "{name}");
            let bits = read_by(&mut board, 4, wire::CNC_STATE).expect("a reply");
            assert_eq!((bits >> 6 & 1 != 0, bits >> 8 & 1 != 0), (role == "door", stops), "{name}");
            if stops {
                assert_eq!(
                    read(&mut board, wire::FAULT),
                    Some(Fault::EmergencyStop.number().into())
                );
                assert_eq!(read(&mut board, wire::FAULT_INPUT), Some(n.into()), "{name}");
            }
            board.plant_mut().set_input(n, false);
            board.run_us(50_000);
            let code = if stops { Control::Acknowledge } else { Control::Stop };
            write(&mut board, wire::RUN_CONTROL, code as u16);
            board.run_us(50_000);
            assert_eq!(state(&mut board), Some(RunState::Ready as u16), "{name}");
        }
    }
}

#[test]
fn link_and_motion_hold_with_a_clock_3_percent_off() {
    let script = "MoveAxe X, 5mm\nG1 X0 Y3 F600\nSetOut 1, ON\n";
    for build in &BUILDS {
        for (dco_ppm, vlo_hz) in [(30_000, 4_000), (-30_000, 20_000), (30_000, 20_000)] {
            for baud in [9_600, 115_200] {
                let name = format!("{} at {dco_ppm} ppm, {baud}", build.name);
                let mut machine = profile("mill", "");
                machine.link.rate = baud;
                let config = Config { dco_ppm, vlo_hz, ..Config::default() };
                let mut board = on(build, &config, &machine, script);
                board.set_uart_format(emulator::Format { baud, ..Default::default() });
                let far = |axis, above| emulator::plant::Contact {
                    axis,
                    position: if above { 1 << 20 } else { -1 << 20 },
                    above,
                };
                board.plant_mut().switches =
                    [Some(far(0, false)), Some(far(1, false)), Some(far(2, true))];
                write(&mut board, wire::RUN_CONTROL, Control::Start as u16);
                for step in 0..60 {
                    assert!(read(&mut board, wire::RUN_STATE).is_some(), "{name}: request {step}");
                    // It drifts by a hundredth of a percent at a time.
                    board.set_dco_ppm(dco_ppm - dco_ppm.signum() * 100 * step);
                }
                let steps = [0, 1].map(|n| board.plant().motors[n].position);
                let scale = machine.x.as_ref().expect("an axis").scale;
                let want = 3_000 * i64::from(scale.steps) / i64::from(scale.um);
                assert_eq!(steps, [0, want], "{name}");
                assert_eq!(board.plant().violations(), &[], "{name}");
                assert_eq!(board.warnings(), &[], "{name}");
            }
        }
    }
}

/// Starts in trace mode; where the program waits before its first effect it is let go.
fn start_traced(board: &mut Board) {
    write(board, wire::TRACE_MODE, 1);
    write(board, wire::RUN_CONTROL, Control::Start as u16);
    read(board, wire::TRACE_ODD);
    board.run_us(2_200);
}

/// A traced run whose host has gone, an event untold.
fn abandoned(build: &Build) -> Board {
    let script = "KEEP n\nn = n + 1\nSetOut 2, ON\nSetOut 3, ON\nWait 99s\n";
    let mut board = on(build, &Config::default(), &profile("mill", ""), script);
    start_traced(&mut board);
    assert_eq!(board.plant().outputs(), 0b10, "{}: the first event fills the slot", build.name);
    board
}

#[test]
fn the_emergency_stop_switches_outputs_whatever_waits() {
    for build in &BUILDS {
        let mut board = abandoned(build);
        write(&mut board, wire::RUN_CONTROL, Control::EmergencyStop as u16);
        board.run_us(100);
        assert_eq!(board.plant().outputs(), 0, "{}", build.name);
    }
    let text = "[[input]]\nn = 6\nrole = \"emergency_stop\"\n";
    for build in &BUILDS {
        let script = "KEEP n\nn = n + 1\nSetOut 2, ON\nWait 99s\n";
        let mut board = on(build, &Config::default(), &profile("mill", text), script);
        start_traced(&mut board);
        assert_eq!(board.plant().outputs(), 0b10, "{}", build.name);
        board.plant_mut().set_input(6, true);
        // The chain is read once in a millisecond.
        board.run_us(2_200);
        assert_eq!(board.plant().outputs(), 0, "{}", build.name);
    }
}

#[test]
fn a_run_is_not_held_by_a_host_that_has_gone() {
    for build in &BUILDS {
        let mut board = abandoned(build);
        board.run_us(1_600_000);
        assert_eq!(board.plant().outputs(), 0b10, "{}: it may still come back", build.name);
        board.run_us(600_000);
        assert_eq!(board.plant().outputs(), 0b110, "{}: it goes on", build.name);
        assert_eq!(read(&mut board, wire::TRACE_MODE), Some(0), "{}", build.name);
    }
}

#[test]
fn stop_wins_over_a_trace_that_nobody_reads() {
    for build in &BUILDS {
        let name = build.name;
        let mut board = abandoned(build);
        board.plant_mut().press_stop(true);
        board.run_us(100_000);
        assert_eq!(state(&mut board), Some(RunState::Paused as u16), "{name}: Stop pauses");
        board.run_us(2_000_000);
        assert_eq!(board.plant().outputs(), 0, "{name}: Stop held switches off");
        board.plant_mut().press_stop(false);
        board.run_us(200_000);
        assert_eq!(state(&mut board), Some(RunState::Ready as u16), "{name}: and ends the run");
        let mut board = abandoned(build);
        write(&mut board, wire::RUN_CONTROL, Control::Stop as u16);
        board.run_us(5_000);
        assert_eq!(board.plant().outputs(), 0, "{name}: outputs do not wait");
        board.run_us(2_100_000);
        assert_eq!(
            state(&mut board),
            Some(RunState::Ready as u16),
            "{name}: the end does, for 2 s"
        );
    }
}

#[test]
fn a_host_that_reads_on_keeps_trace_mode() {
    for build in &BUILDS {
        let mut board = abandoned(build);
        for _ in 0..20 {
            // The slot that holds the event, as a debugger does at a breakpoint.
            assert_eq!(read(&mut board, wire::TRACE_ODD), Some(1), "{}", build.name);
            board.run_us(200_000);
        }
        assert_eq!(board.plant().outputs(), 0b10, "{}", build.name);
        assert_eq!(read(&mut board, wire::TRACE_MODE), Some(1), "{}", build.name);
    }
}

#[test]
fn each_millisecond_that_is_served_late_counts_once() {
    for build in &BUILDS {
        let mut board = on(build, &Config::default(), &profile("mill", ""), "Wait 9s\n");
        let name = if build.chip == Part::F5529 { "PASAPAS_MILLIS" } else { "MILLIS" };
        let millis = board.symbol(name).expect("a name");
        let mut before = read(&mut board, wire::MISSED_DEADLINES).expect("an answer");
        // As if the main loop had stood for so long: what lies behind it is served millisecond by millisecond.
        for stood in [1, 2, 3, 4, 20, 100] {
            board.poke16(millis, board.peek16(millis).wrapping_add(stood));
            board.run_us(50_000);
            let now = read(&mut board, wire::MISSED_DEADLINES).expect("an answer");
            // All but the last two, and those that pass meanwhile: as serving one takes at most an eighth of one (0.119 ms on
            // the F5529), n of them take n / 8, what passes in that time an eighth of it again, together n / 7.
            let least = stood - stood.min(2);
            let counted = now - before;
            println!("{}, {stood} ms: {counted}", build.name);
            let most = least + 1 + stood / 7;
            assert!((least..=most).contains(&counted), "{}, {stood} ms: {counted}", build.name);
            before = now;
        }
    }
}
