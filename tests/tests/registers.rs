//! Every name of the register table on every image: a register that an image forgets would read 0,
//! without a word, as a gap inside a block does.

use std::collections::{BTreeMap, BTreeSet};

use emulator::Config;
use emulator::plant::Contact;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::wire::{
    BLOCKS, CHAR_IN, Control, NAMES, PRINT_COUNT, PRINT_LENGTH, TARGET_SPEEDS, Table,
};
use pasapas::board::{BUILDS, Build, F5529};
use pasapas::torture::stand::{Answer, Stand};

/// Each named register's value in each table that has its address; `None` where it is refused.
type Registers = BTreeMap<(&'static str, u8), Option<u16>>;

fn registers(stand: &mut Stand) -> Registers {
    let mut found = BTreeMap::new();
    for (name, address, _) in NAMES {
        let blocks = BLOCKS.iter().filter(|block| {
            let words = [Table::Holding as u8, Table::InputRegisters as u8];
            words.contains(&block.table)
                && (block.first..block.first + block.count).contains(address)
        });
        for block in blocks {
            let [high, low] = address.to_be_bytes();
            let value = match stand.ask(&[1, block.table, high, low, 0, 1]) {
                Answer::Reply(reply) => Some(u16::from_be_bytes([reply[3], reply[4]])),
                Answer::Exception(2) => None,
                other => panic!("{name}: {other:?}"),
            };
            found.insert((*name, block.table), value);
        }
    }
    found
}

/// What each part has of its own: sizes, features, places in its memory, milliseconds that came late
/// because flash took its time.
const OWN: [&str; 7] = [
    "AREA_BYTES",
    "FREE_BYTES",
    "FEATURES",
    "POOL_WORDS_REGISTER",
    "STACK_FREE",
    "FAULT_PC",
    "MISSED_DEADLINES",
];
/// What goes on between two questions: places.
const UNDER_WAY: [&str; 4] = ["COMMANDED", "MACHINE_POSITIONS", "WORK_POSITIONS", "TARGETS"];
/// Where the first variable with AT is that a part without memory for it between runs reads as 0.
const FIRST_AT: (&str, u8) = ("COMMAND_ROOM", 3);
/// So many steps may two parts be apart there.
const APART: u16 = 200;
/// Written only on the small part: it counts the words that come.
const WRITTEN: [&str; 1] = ["UPLOAD_LENGTH"];
/// Nothing that the states below bring about shows in these.
const QUIET: [&str; 32] = [
    "ANALOG_INPUTS",
    "ANALOG_OUTPUT",
    "BLOCKING_INPUT",
    "FAULT_INPUT",
    "FAULT_LINE",
    "HOMING",
    "INPUTS_HIGH",
    "JOG_HOLD",
    "LATE_EVENTS",
    "LIMITS",
    "MEASURE",
    "MEASURED",
    "MISC_STATUS",
    "OPEN_CALLS",
    "PRINT_TAIL",
    "PROBE_ERROR",
    "PROBING",
    "RUN_CONTROL",
    "STREAM_ACCEPTED",
    "STREAM_BEGUN",
    "STREAM_CALL",
    "STREAM_CONTROL",
    "STREAM_DRY",
    "STREAM_RESULT",
    "STREAM_STARVED",
    "TRACE_EVEN",
    "TRACE_ODD",
    "TRACE_TAKEN",
    "UPLOAD_CONTROL",
    "UPLOAD_NAME",
    "UPLOAD_NUMBER",
    "WAITS",
];
/// What a part whose halts are not exact lacks.
const OF_HALTS: [&str; 3] = ["WAITS", "EFFECT_PLACE", "OPEN_CALLS"];
/// What a part with one program lacks.
const OF_LIBRARY: [&str; 4] = ["PROGRAM_NUMBER", "SELECTED", "UPLOAD_NAME", "UPLOAD_NUMBER"];
/// What a part without a queue of events lacks.
const OF_QUEUE: [&str; 2] = ["TRACE_ROOM", "TRACE_TAKEN"];
/// What a part whose chip has no device descriptor lacks.
const OF_CHIP: [&str; 1] = ["CHIP_REVISION"];
/// What no part with one block of status registers shows.
const OF_BLOCKS: [&str; 3] = ["ANALOG_INPUTS", "ANALOG_OUTPUT", "TARGET_SPEEDS"];
/// The same, where a good upload leaves 0 and nobody traces.
const GOOD: [&str; 2] = ["UPLOAD_RESULT", "TRACE_MODE"];

const SCRIPT: &str = "DIM a AT 3000\nKEEP k\na = 7\nk = 9\nSetOut 3, ON\nPRINT \"hole\"\nSend 65\n\
    Home X\nMoveAxe X, 12mm\nMoveAxe Y, 5mm\nMoveAxe Z, -3mm\nMoveAxe X, 200mm, 20mm/s\n";

/// What the registers hold fresh from power-up, in a run, stopped, and after an emergency stop.
fn states(build: &Build) -> Vec<Registers> {
    let source = Source::new("t.bas", SCRIPT.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
    let switch = Contact { axis: 0, position: -500, above: false };
    stand.board.plant_mut().switches[0] = Some(switch);
    assert!(stand.answers());
    let mut states = vec![registers(&mut stand)];
    stand.upload(&image, false).expect("it is taken");
    stand.board.plant_mut().set_input(3, true);
    stand.write(CHAR_IN, &[65]);
    stand.control(Control::Start);
    stand.board.run_us(4_000_000);
    states.push(registers(&mut stand));
    for (control, us) in [(Control::Stop, 1_000_000), (Control::EmergencyStop, 1_000_000)] {
        stand.control(control);
        stand.board.run_us(us);
        states.push(registers(&mut stand));
    }
    states
}

#[test]
fn every_image_has_every_named_register() {
    let all: Vec<_> = BUILDS.iter().map(|build| (build.part, states(build))).collect();
    let (_, whole) = all.last().expect("a part");
    for (part, states) in &all {
        for (n, (state, reference)) in states.iter().zip(whole).enumerate() {
            for ((name, table), value) in state {
                let wanted = reference[&(*name, *table)];
                if value.is_none() && !part.look_ahead && OF_BLOCKS.contains(name) {
                    continue;
                }
                let what = format!("{name} in table {table}, state {n}: {value:?}, not {wanted:?}");
                let (Some(value), Some(wanted)) = (*value, wanted) else {
                    panic!("{} refuses {what}", part.name);
                };
                let lacks = name.starts_with("STREAM")
                    || *name == "HELM"
                    || !part.halts && OF_HALTS.contains(name)
                    || part.programs == 1 && OF_LIBRARY.contains(name)
                    || OF_QUEUE.contains(name)
                    || !part.look_ahead && OF_CHIP.contains(name)
                    || WRITTEN.contains(name)
                    // A virtual F5529 comes with a profile; a G2553 without one has its own, which no CRC tells.
                    || *name == "PROFILE_HASH"
                    || (*name, *table) == FIRST_AT;
                let good = match name {
                    name if OWN.contains(name) => (value == 0) == (wanted == 0),
                    name if UNDER_WAY.contains(name) => value.abs_diff(wanted) <= APART,
                    _ => value == wanted || lacks && value == 0,
                };
                assert!(good, "{}: {what}", part.name);
            }
        }
    }
    let silent = whole[0].keys().filter(|key| whole.iter().all(|state| state[*key] == Some(0)));
    let silent: BTreeSet<&str> = silent.map(|(name, _)| *name).collect();
    let heard = |name: &&str| {
        whole.iter().any(|state| {
            [3, 4].iter().any(|table| state.get(&(*name, *table)).is_some_and(|v| *v != Some(0)))
        })
    };
    let unexpected: Vec<_> = silent
        .into_iter()
        .filter(|name| !heard(name) && !QUIET.contains(name) && !GOOD.contains(name))
        .collect();
    assert!(unexpected.is_empty(), "always 0: {unexpected:?}");
}

/// A master that watches a register which this board does not have must not be told 0 for ever.
#[test]
fn registers_that_do_not_exist_are_exception_2() {
    let everywhere = [1_084, 1_089, 1_098, 1_099, 1_100];
    let blocks = [1_027, 1_029, 1_054, 1_059];
    for build in BUILDS {
        let mut stand = Stand::new(build, &Config::default()).expect("the shipped image");
        assert!(stand.answers());
        let mut input = |address: u16, count: u8| {
            let [high, low] = address.to_be_bytes();
            stand.ask(&[1, 4, high, low, 0, count])
        };
        let holes: &[u16] =
            if build.part.look_ahead { &blocks } else { &[1_072, 1_083, 1_090, 1_097] };
        for &address in everywhere.iter().chain(holes) {
            let answer = input(address, 1);
            assert_eq!(answer, Answer::Exception(2), "{} {address}", build.part.name);
        }
        for (address, count) in [(1_000, 27), (1_030, 12), (1_042, 12), (1_060, 12), (1_016, 10)] {
            let answer = input(address, count);
            assert!(
                matches!(answer, Answer::Reply(_)),
                "{} {address}: {answer:?}",
                build.part.name
            );
        }
        for address in [2_161, 2_165] {
            let [high, low] = u16::to_be_bytes(address);
            let answer = stand.ask(&[1, 3, high, low, 0, 1]);
            assert_eq!(answer, Answer::Exception(2), "{} {address}", build.part.name);
            assert_eq!(stand.write(address, &[0]), Answer::Exception(2));
        }
    }
}

#[test]
fn the_length_of_the_print_and_the_speed_to_come_are_told() {
    let script = "PRINT \"twelve char\"\nMoveSpeed X, -10mm/s\nWait 1s\nStopAxe X\nMoveAxe X, 5mm, 20mm/s\nWait 1min\n";
    let source = Source::new("t.bas", script.to_owned());
    let (program, _) = compile(&source, ProfileChoice::built_in());
    let image = lang::back::compile(&program.expect("sound")).expect("it fits").image;
    let mut stand = Stand::new(&F5529, &Config::default()).expect("the shipped image");
    assert!(stand.answers());
    stand.upload(&image, false).expect("it is taken");
    let told = |stand: &mut Stand| {
        let mut long = |address: u16| {
            let [high, low] = address.to_be_bytes();
            match stand.ask(&[1, 4, high, low, 0, 2]) {
                Answer::Reply(reply) => {
                    let word =
                        |at: usize| u32::from(u16::from_be_bytes([reply[at], reply[at + 1]]));
                    (word(5) << 16 | word(3)).cast_signed()
                }
                other => panic!("{address}: {other:?}"),
            }
        };
        (long(TARGET_SPEEDS), long(TARGET_SPEEDS + 2))
    };
    assert_eq!(told(&mut stand), (0, 0));
    stand.control(Control::Start);
    stand.board.run_us(300_000);
    assert_eq!(told(&mut stand), (-1_000, 0));
    stand.control(Control::Pause);
    stand.board.run_us(500_000);
    assert_eq!(told(&mut stand), (0, 0));
    stand.control(Control::Resume);
    stand.board.run_us(900_000);
    assert_eq!(told(&mut stand), (2_000, 0));
    stand.board.run_us(2_000_000);
    assert_eq!(told(&mut stand), (0, 0));
    assert_eq!(stand.read(PRINT_COUNT), Some(12));
    let [high, low] = PRINT_LENGTH.to_be_bytes();
    assert_eq!(stand.ask(&[1, 4, high, low, 0, 1]), Answer::Reply(vec![1, 4, 2, 0, 12]));
}
