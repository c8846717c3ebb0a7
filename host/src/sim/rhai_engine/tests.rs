use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::hir::Program;

use crate::sim::chain::Chain;
use crate::sim::trace::{Event, to_text};
use crate::sim::world::World;
use crate::sim::{Engine, Options, Outcome, Rules, run_chain_traced, run_traced};

fn program(text: &str) -> Program {
    let source = Source::new("t.bas", text.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    program.unwrap_or_else(|| panic!("{text}\n{diags:?}"))
}

/// The run on both engines, each by the model's rules and by the firmware's: it is the same four times.
fn both(text: &str, world: &str) -> (Outcome, Vec<Event>) {
    let program = program(text);
    let world = World::parse("w.rhai", world).unwrap();
    let run = |engine: Engine, rules: Rules| {
        let options = Options { limit_us: 100_000_000, rules, ..Options::default() };
        run_traced(&program, engine, &world, &options).unwrap()
    };
    let first = run(Engine::Rhai, Rules::Model);
    let others = [
        (Engine::Vm, Rules::Model),
        (Engine::Rhai, Rules::Firmware),
        (Engine::Vm, Rules::Firmware),
    ];
    for (engine, rules) in others {
        let other = run(engine, rules);
        let which = format!("{engine:?} {rules:?}: {text}\n{}", super::source(&program));
        assert_eq!(to_text(&first.1), to_text(&other.1), "{which}");
        assert_eq!(first.0.end, other.0.end, "{which}");
        assert_eq!(first.0.vars, other.0.vars, "{which}");
    }
    first
}

/// Lines that PRINT wrote.
fn prints(text: &str) -> Vec<String> {
    prints_in(text, "")
}

fn prints_in(text: &str, world: &str) -> Vec<String> {
    both(text, world)
        .1
        .into_iter()
        .filter_map(|event| match event.what {
            crate::sim::trace::What::Print { text, .. } => Some(text),
            _ => None,
        })
        .collect()
}

#[test]
fn expressions_and_calls() {
    let text = "\
DIM a, b(3)
a = 7
b(1) = f(a) + f(f(2)) * 3
PRINT b(1); \" \"; a MOD 4; \" \"; -a / 2; \" \"; 1 << 5
PRINT a > 3 ANDALSO f(1) = 2; \" \"; a < 3 ORELSE f(1) = 3
PRINT 2540um; \" \"; NOT 0; \" \"; ABS(-5)
FUNCTION f(p)
  DIM q
  q = p + 1
  RETURN q
END FUNCTION
";
    assert_eq!(prints(text), ["20 3 -3 32", "1 0", "2540um -1 5"]);
}

#[test]
fn control_flow() {
    let text = "\
DIM i, n
FOR i = 1 TO 10 STEP 3
  IF i = 4 THEN CONTINUE FOR
  n = n + i
NEXT
PRINT i; \" \"; n
WHILE n > 0
  n = n - 5
  IF n < 5 THEN EXIT WHILE
WEND
DO
  n = n + 1
LOOP UNTIL n > 9
REPEAT 3
  n = n * 2
END REPEAT
SELECT CASE n
CASE 1, 2
  PRINT \"low\"
CASE 70 TO 90
  PRINT \"right \"; n
CASE ELSE
  PRINT \"else\"
END SELECT
GOSUB there
PRINT \"back\"
END
there:
PRINT \"there\"
RETURN
";
    assert_eq!(prints(text), ["13 18", "right 80", "there", "back"]);
}

#[test]
fn faults_are_handled_and_gone_on_with() {
    let text = "\
DIM a, b(2)
ON ERROR GOTO oops
a = 1 / a
PRINT \"behind\"
b(2 + a) = 5
a = 2147483647
a = a + 1
helper
END
oops:
PRINT ERR; \" in \"; ERL
RESUME NEXT
SUB helper
  DIM c
  c = 5 MOD c
  PRINT \"in helper\"
END SUB
";
    let lines = prints(text);
    assert_eq!(lines, ["2 in 3", "behind", "3 in 5", "1 in 7", "2 in 15", "in helper"]);
}

#[test]
fn events_are_served_between_statements_and_during_waits() {
    let text = "\
DIM n
ON IN 3 RISE GOSUB edge
ON EVERY 100ms GOSUB tick
Wait 350ms
ON EVERY OFF
PRINT n
WaitIn? 5, ON, 200ms
PRINT TIMEDOUT
END
edge:
PRINT \"edge\"
RETURN
SUB tick
  n = n + 1
END SUB
";
    let lines = prints_in(
        text,
        "at(50, || set_in(3, true)); at(400, || set_in(3, false)); at(450, || set_in(3, true));",
    );
    assert_eq!(lines, ["edge", "3", "edge", "1"]);
}

#[test]
fn a_world_writes_and_reads_at_variables() {
    let text = "\
DIM wanted AT 3000 LABEL \"Pieces\" MIN 1 MAX 50, row(2) AS LENGTH AT 3004, done AT 3008
DIM n
PRINT wanted; \" \"; row(1)
row(0) = row(1) + 1mm
WHILE done < wanted
  done = done + 1
  Wait 100ms
  FOR n = 1 TO 3
    done = done + n - n
  NEXT
WEND
FOR done = 1 TO 2
NEXT
PRINT done; \" \"; wanted; \" \"; row(0)
";
    let world = "\
set_at(3000, 20);
set_at(3006, 4000);
at(250, || {
    if at_value(3008) == 3 && at_value(3004) == 5000 { set_at(3000, 4); }
    if at_value(3000) == 4 { set_at(3004, 7000); }
});
";
    assert_eq!(prints_in(text, world), ["20 4000um", "3 4 7000um"]);
}

#[test]
fn a_world_writes_only_what_the_program_has_and_allows() {
    let refusal = |world: &str| {
        let program = program("DIM wanted AT 3000 MIN -1 MAX 50\nPRINT wanted\n");
        let world = World::parse("w.rhai", world).unwrap();
        let run = run_traced(&program, Engine::Vm, &world, &Options::default());
        run.unwrap_err().to_string()
    };
    assert!(refusal("set_at(3000, 51);").contains("`wanted` is -1 to 50, not 51"));
    for other in [3001, 3002, 0, -1, 70_000] {
        let text = refusal(&format!("set_at({other}, 1);"));
        assert!(text.contains("the program has 3000 wanted"), "{text}");
    }
    assert!(refusal("at_value(4000);").contains("no variable stands AT 4000"));
}

/// Where nobody has put the reference switches they are put when an axis is homed, which is once its path is over. RUN waits
/// for a path, too.
#[test]
fn what_waits_for_a_path_without_asking_for_anything_lets_time_go_on() {
    let first = program("G1 X50 F3000\nG1 X10\nHome X\nG1 X5 F3000\nRUN \"other\"\n");
    let other = program("G1 X20 F3000\nPRINT 1\n");
    let chain = Chain::of([("first".to_owned(), &first), ("other".to_owned(), &other)]);
    let run = |engine, rules| {
        let options = Options { rules, limit_us: 60_000_000, ..Options::default() };
        let run = run_chain_traced(&chain, engine, &World::unattended(), &options);
        let (run, events) = run.unwrap();
        (run.unattended.switches, to_text(&events))
    };
    let wanted = run(Engine::Vm, Rules::Model);
    assert!(wanted.1.contains("\"ev\":\"print\""), "{}", wanted.1);
    for engine in [Engine::Vm, Engine::Rhai] {
        assert_eq!(run(engine, Rules::Firmware), wanted, "{engine:?}");
    }
}

/// The firmware's machine is the F5529's: who wants another part's times gets no others in their place.
#[test]
fn the_firmwares_rules_are_refused_for_another_part() {
    let program = program("SetOut 1, ON\n");
    let world = World::parse("w.rhai", "").unwrap();
    for part in lang::part::PARTS {
        for engine in [Engine::Rhai, Engine::Vm] {
            let options = Options { part: *part, rules: Rules::Firmware, ..Options::default() };
            let run = run_traced(&program, engine, &world, &options);
            match run {
                Ok(_) => assert_eq!(part.name, "f5529"),
                Err(error) => {
                    assert_ne!(part.name, "f5529");
                    let text = error.to_string();
                    assert!(text.contains(part.name) && text.contains("f5529"), "{text}");
                    assert!(text.contains("--engine board"), "{text}");
                }
            }
        }
    }
}
