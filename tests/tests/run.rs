//! RUN on the MSP430F5529: one program of the library begins another.

use emulator::Config;
use lang::back;
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;
use lang::wire::{
    CHAR_OUT, Control, FAULT, FAULT_LINE, KEEPS, LAST_END, PROGRAM_NUMBER, RUN_STATE, RunState,
    SELECTED, UPLOAD_NAME, UPLOAD_NUMBER,
};
use pasapas::board::{DEFAULT, engine};
use pasapas::client::library::words_of;
use pasapas::sim::chain::Chain;
use pasapas::sim::record::StopReason;
use pasapas::sim::trace::{Status, to_text};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, Outcome, run_chain_traced};
use pasapas::torture::power::image;
use pasapas::torture::stand::{Answer, Stand};

fn program(name: &str, script: &str) -> Program {
    let source = Source::new(name, script.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{script}: {}", diags.render(&source)))
}

/// A board that holds these programs, numbered from 1, each with its name.
fn board(programs: &[(&str, &str)]) -> Stand {
    let mut stand = Stand::new(DEFAULT, &Config::default()).expect("the shipped image");
    for (number, (name, script)) in (1..).zip(programs) {
        bring(&mut stand, number, name, script);
    }
    stand
}

fn bring(stand: &mut Stand, number: u16, name: &str, script: &str) {
    assert!(matches!(stand.write(UPLOAD_NUMBER, &[number]), Answer::Reply(_)));
    assert!(matches!(stand.write(UPLOAD_NAME, &words_of(name)), Answer::Reply(_)));
    stand.upload(&image(script).expect("sound"), script.contains("KEEP")).expect("it is taken");
}

fn after(stand: &mut Stand, ms: u64) -> Option<RunState> {
    stand.board.run_us(1000 * ms);
    RunState::from_number(stand.read(RUN_STATE)?)
}

fn start(stand: &mut Stand, ms: u64) -> Option<RunState> {
    stand.control(Control::Start);
    after(stand, ms)
}

#[test]
fn a_program_begins_another_and_the_selection_stays() {
    let mut stand = board(&[
        ("first", "SetOut 3, ON\nSend 65\nRUN \"Second one\"\n"),
        ("SECOND ONE", "DIM n\nn = n + 66 + OUT(3)\nSend n\nRUN \"third\"\n"),
        ("third", "Send 67\n"),
    ]);
    for _ in 0..2 {
        assert_eq!(start(&mut stand, 300), Some(RunState::Ready));
        // Three characters in all, and the output was off as behind END.
        let sent = stand.read(CHAR_OUT).expect("it answers");
        assert_eq!(sent & 0xFF, 67);
        assert_eq!([stand.read(PROGRAM_NUMBER), stand.read(SELECTED)], [Some(3), Some(1)]);
    }
    assert_eq!(stand.read(CHAR_OUT), Some(6 << 8 | 67));
    assert!(stand.power_cycle());
    assert_eq!(stand.read(SELECTED), Some(1));
}

#[test]
fn the_other_begins_at_rest_where_the_first_came_to() {
    let mut stand = board(&[
        ("a", "SetOut 2, ON\nSTART MoveRel X, 2mm\nMoveRel Y, 1mm\nSetPos Y, 40mm\nRUN \"b\"\n"),
        ("b", "Send 65 + 2 * MOVING(X) + 4 * OUT(2) + (POS(X) = 2mm) + 8 * (POS(Y) = 1mm)\n"),
    ]);
    assert_eq!(start(&mut stand, 3000), Some(RunState::Ready));
    // The machine stands where it stood; the work zero is the new run's own.
    assert_eq!(stand.read(CHAR_OUT), Some(1 << 8 | 74));
}

#[test]
fn a_name_that_there_is_not_is_a_fault_at_its_line() {
    let head = "ON ERROR STOP\nSetOut 1, ON\nON ERROR GOTO failed\n";
    let tail =
        "RUN \"nowhere\"\nSend 66\nEND\nfailed:\nSend ERR + ERL + 32 * OUT(1)\nRESUME NEXT\n";
    for name in ["a", "nowher", "nowhere2"] {
        let mut stand = board(&[(name, &format!("{head}ON ERROR STOP\n{tail}"))]);
        assert_eq!(start(&mut stand, 300), Some(RunState::Fault), "{name}");
        let told = [FAULT, FAULT_LINE, LAST_END, CHAR_OUT].map(|at| stand.read(at));
        assert_eq!(told, [Some(21), Some(5), Some(3), Some(0)], "{name}");
        assert_eq!(stand.board.plant().outputs() & 1, 0);
    }
    // A handler may take it: nothing has changed then.
    let mut stand = board(&[("a", &format!("{head}{tail}"))]);
    assert_eq!(start(&mut stand, 20), Some(RunState::Ready));
    assert_eq!(stand.read(CHAR_OUT), Some(2 << 8 | 66));
}

#[test]
fn a_program_that_runs_itself_is_stopped_by_link_and_button() {
    let mut stand = board(&[("again", "DIM n\nn = n + 1\nSend 64 + n\nRUN \"again\"\n")]);
    assert_eq!(start(&mut stand, 500), Some(RunState::Running));
    let before = stand.read(CHAR_OUT).expect("it answers");
    assert_eq!(before & 0xFF, 65, "its variables begin at 0 each time");
    assert_eq!(after(&mut stand, 37), Some(RunState::Running));
    assert_ne!(stand.read(CHAR_OUT), Some(before), "it goes round");
    stand.board.plant_mut().press_stop(true);
    assert_eq!(after(&mut stand, 100), Some(RunState::Paused));
    stand.board.plant_mut().press_stop(false);
    after(&mut stand, 100);
    assert_eq!(start(&mut stand, 100), Some(RunState::Running), "it goes on");
    stand.control(Control::Stop);
    assert_eq!(after(&mut stand, 50), Some(RunState::Ready));
    assert_eq!(stand.read(LAST_END), Some(2));
}

#[test]
fn two_that_run_each_other_keep_their_own_values() {
    let mut stand = board(&[
        ("odd", "KEEP n\nn = n + 1\nWait 5ms\nIF n < 20 THEN RUN \"even\"\n"),
        ("even", "KEEP n, m\nm = m + 100\nWait 5ms\nRUN \"odd\"\n"),
    ]);
    assert_eq!(start(&mut stand, 3000), Some(RunState::Ready));
    assert_eq!(stand.read(KEEPS), Some(20));
    assert!(matches!(stand.write(SELECTED, &[2]), Answer::Reply(_)));
    assert_eq!([KEEPS, KEEPS + 2].map(|at| stand.read(at)), [Some(0), Some(1900)]);
    assert!(stand.power_cycle());
    assert_eq!(stand.read(KEEPS + 2), Some(1900));
}

/// A segment takes 10 000 erases for certain: a chain that wrote its values at every RUN would have used them up in an hour.
#[test]
fn a_chain_of_short_programs_writes_its_values_once_a_second() {
    let erases =
        |stand: &Stand| stand.board.wear().erases.values().map(|n| u64::from(*n)).sum::<u64>();
    let programs = [
        ("loop", "KEEP n\nn = n + 1\nRUN \"loop\"\n"),
        ("ping", "KEEP n\nn = n + 1\nRUN \"pong\"\n"),
        ("pong", "KEEP n\nn = n + 1\nRUN \"ping\"\n"),
        ("plain", "DIM i\nRUN \"loop\"\n"),
    ];
    for (number, least) in [(1, 1_000), (2, 500), (4, 1_000)] {
        let mut stand = board(&programs);
        assert!(matches!(stand.write(SELECTED, &[number]), Answer::Reply(_)));
        let before = erases(&stand);
        stand.control(Control::Start);
        stand.board.run_us(20_000_000);
        // A record of one value takes 8 of a segment's 512 bytes: one erase in a minute, and the first of each.
        let made = erases(&stand) - before;
        assert!(made <= 8, "{made} erases in 20 s from program {number}");
        stand.control(Control::Stop);
        stand.board.run_us(200_000);
        let kept = |stand: &mut Stand| stand.read_long(KEEPS).expect("a value");
        let first = if number == 4 { 1 } else { number };
        assert!(matches!(stand.write(SELECTED, &[first]), Answer::Reply(_)));
        let value = kept(&mut stand);
        assert!(value >= least, "{value} rounds of program {number}");
        // What the chain had at its end is what the next one begins with, whichever program was left.
        assert!(stand.power_cycle());
        assert_eq!(kept(&mut stand), value, "program {number}");
    }
}

/// What is lost with the power is no more than the last second.
#[test]
fn a_chain_that_loses_its_power_keeps_what_was_a_second_ago() {
    let mut stand = board(&[("loop", "KEEP n\nn = n + 1\nWait 20ms\nRUN \"loop\"\n")]);
    stand.control(Control::Start);
    stand.board.run_us(10_000_000);
    let value = stand.read_long(KEEPS).expect("a value");
    assert!(stand.power_cycle());
    let kept = stand.read_long(KEEPS).expect("a value");
    assert!((value - 80..=value).contains(&kept), "{kept} of {value}");
}

#[test]
fn handlers_and_calls_end_with_the_program() {
    let mut stand = board(&[
        ("a", "ON EVERY 20ms GOSUB tick\nDO\nWait 5ms\nLOOP\nSUB tick\nRUN \"b\"\nEND SUB\n"),
        ("b", "Wait 200ms\nON ERROR GOTO failed\nDIM n\nn = 1 / n\nfailed:\nRUN \"c\"\n"),
        ("c", "ON EVERY 20ms GOSUB tick\nWait 50ms\nEND\ntick:\nSend 64 + ERR\nRETURN\n"),
    ]);
    assert_eq!(start(&mut stand, 600), Some(RunState::Ready));
    assert_eq!(stand.read(CHAR_OUT), Some(2 << 8 | 64), "two ticks, and no fault before them");
}

/// Runs these programs, the first first, on all engines; the trace that they agree on, and how it ended.
fn on_every_engine(programs: &[(&str, &str)], world: &str) -> (String, Outcome) {
    let checked: Vec<_> = programs.iter().map(|(name, script)| program(name, script)).collect();
    let names = programs.iter().map(|(name, _)| (*name).to_owned());
    let chain = Chain::of(names.zip(&checked));
    let world = World::parse("world.rhai", world).expect("a world");
    let options = Options { times: false, ..Options::default() };
    let run = |engine| run_chain_traced(&chain, engine, &world, &options).expect("it runs");
    let (outcome, events) = run(Engine::Rhai);
    let wanted = to_text(&events);
    let (on_vm, events) = run(Engine::Vm);
    assert_eq!(to_text(&events), wanted, "vm");
    assert_eq!((on_vm.end, on_vm.program), (outcome.end, outcome.program));
    assert_eq!(on_vm.summary.program, outcome.summary.program);
    let compiled: Vec<_> = checked.iter().map(|own| back::compile(own).expect("it fits")).collect();
    let (board, events) =
        engine::run_chain_traced(DEFAULT, &chain, &compiled, &world, &options).expect("it runs");
    assert_eq!(to_text(&events), wanted, "board");
    assert_eq!((board.outcome.end, board.outcome.program), (outcome.end, outcome.program));
    assert_eq!(board.outcome.summary.program, outcome.summary.program);
    let failures = [&outcome.failures, &on_vm.failures, &board.outcome.failures];
    assert!(failures.iter().all(|list| list.is_empty()), "{failures:?}");
    (wanted, outcome)
}

#[test]
fn the_engines_agree_on_chains() {
    let list = [
        ("main", "SetOut 3, ON\nG0 X10\nSTART MoveRel Y, 2mm\n\nRUN \"Drill\"\nPRINT 1\n"),
        (
            "drill",
            "' One.\nPRINT POS(X); \" \"; POS(Y); \" \"; OUT(3)\nHome Z\nWait 100ms\nPRINT TIMER() / 50\nIF IN(2) THEN RUN \"last\"\nRUN \"drill\"\n",
        ),
        (
            "last",
            "KEEP n\nDIM at3 AT 3000\nn = n + 1\nPRINT n; at3; HOMED(Z)\nat3 = 7\nIF n < 3 THEN RUN \"LAST\"\nIF n < 5 THEN RUN \"back\"\nn = n / (at3 - 7)\n",
        ),
        ("back", "G1 X0 F600\nRUN \"last\"\n"),
    ];
    let world = "at(250, || set_in(2, true)); expect_out(3, false); switch_at(\"Z\", 100);";
    let (trace, outcome) = on_every_engine(&list, world);
    assert_eq!(outcome.end.fault, Some(Fault::DivisionByZero));
    assert_eq!((outcome.end.line, outcome.summary.program.as_deref()), (8, Some("last")));
    insta::assert_snapshot!(trace);
}

#[test]
fn a_chain_without_an_end_is_stopped_on_every_engine() {
    let list = [("a", "Wait 10ms\nRUN \"b\"\n"), ("b", "WaitIn 2, ON\n")];
    let (trace, outcome) = on_every_engine(&list, "");
    assert_eq!(outcome.end.status, Status::Stopped);
    assert!(trace.ends_with("\"line\":1,\"pos\":{\"X\":0,\"Y\":0,\"Z\":0}}\n"), "{trace}");
    let own = program("again", "RUN \"again\"\n");
    let chain = Chain::of([("again".to_owned(), &own)]);
    for engine in [Engine::Rhai, Engine::Vm] {
        let options = Options { statements: 1_000_000, ..Options::default() };
        let run = run_chain_traced(&chain, engine, &World::empty(), &options).expect("it runs");
        assert_eq!(run.0.summary.stopped, Some(StopReason::Statements));
        assert!((400..600).contains(&run.1.len()), "{}", run.1.len());
    }
    let compiled = [back::compile(&own).expect("it fits")];
    let options = Options { limit_us: 300_000, ..Options::default() };
    let run = engine::run_chain_traced(DEFAULT, &chain, &compiled, &World::empty(), &options);
    let (run, events) = run.expect("it runs");
    assert_eq!(run.outcome.summary.stopped, Some(StopReason::Limit));
    assert!(events.len() > 20, "{}", events.len());
}

#[test]
fn a_program_that_there_is_not_is_the_same_fault_everywhere() {
    let (trace, _) =
        on_every_engine(&[("a", "SetOut 1, ON\nRUN \"b\"\n")], "expect_out(1, false);");
    assert!(trace.contains("\"fault\":\"F21\",\"text\":\"no such program\",\"line\":2"), "{trace}");
    let script = "ON ERROR GOTO no\nRUN \"b\"\nPRINT 2\nEND\nno:\nPRINT ERR; ERL\nRESUME NEXT\n";
    let (trace, _) = on_every_engine(&[("a", script)], "");
    let printed: Vec<&str> =
        trace.lines().filter_map(|line| line.split("text\":").nth(1)).collect();
    assert_eq!(printed, ["\"212\"}", "\"2\"}"]);
}
