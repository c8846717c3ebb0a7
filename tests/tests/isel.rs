//! Every instruction that a charlyrobot card stores, by its steps: what each program moves and
//! switches was worked out by hand from the card's protocol table.

use import::{Imported, import};
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::sim::trace::{Event, What};
use pasapas::sim::world::World;
use pasapas::sim::{Engine, Options, run_traced};

fn letter(axis: &impl std::fmt::Debug) -> char {
    let name = format!("{axis:?}");
    name.chars().find(|c| matches!(c, 'X' | 'Y' | 'Z')).unwrap_or('?')
}

/// One event in a few words; positions are `X,Y,Z` in steps.
fn short(event: &Event) -> String {
    let place = |to: &pasapas::sim::trace::PerAxis| {
        to.values().map(|at| at.map_or("-".to_owned(), |at| at.to_string())).join(",")
    };
    match &event.what {
        What::Move { kind, to, .. } => format!("{kind:?} {}", place(to)).to_lowercase(),
        What::Home { axis, pos, .. } => format!("home {} {pos}", letter(axis)),
        What::Out { n, v, .. } => format!("out {n} {v}"),
        What::Wait { ms, .. } => format!("wait {ms}"),
        What::Send { c, .. } => format!("send {c}"),
        What::WaitChar { c, ok, .. } => format!("waitchar {c} {ok}"),
        What::WaitStart { .. } => "waitstart".to_owned(),
        What::Probe { axis, ok, pos, .. } => format!("probe {} {ok} {pos}", letter(axis)),
        What::WaitIn { n, v, .. } => format!("waitin {n} {v}"),
        What::Print { text, .. } => format!("print {text}"),
        What::End { pos, .. } => format!("end {}", place(pos)),
        other => format!("{other:?}"),
    }
}

/// What a stored program does, on both host engines.
fn does(mask: &str, program: &str, world: &str) -> Vec<String> {
    let text = format!("@0{mask}\n@0i\n{program}\n9\n@0S\n");
    let script = match import("a.isel", text.as_bytes(), &import::Options::default()) {
        Ok(Imported { script, .. }) => script,
        Err(diags) => panic!("{}", diags.iter().map(|d| d.render("a.isel")).collect::<String>()),
    };
    let source = Source::new("made", script.clone());
    let (checked, diags) = compile(&source, ProfileChoice::built_in());
    let checked = checked.unwrap_or_else(|| panic!("{script}\n{}", diags.render(&source)));
    let world = World::parse("world", world).expect("a world");
    let options = Options { times: false, ..Options::default() };
    let mut lists = [Engine::Rhai, Engine::Vm].map(|engine| {
        let (_, events) = run_traced(&checked, engine, &world, &options).expect("it runs");
        events.iter().map(short).collect::<Vec<_>>()
    });
    assert_eq!(lists[0], lists[1], "{script}");
    std::mem::take(&mut lists[0])
}

/// Lines of instructions separated by ` / `, and what they do, separated by ` | `.
#[track_caller]
fn check(mask: &str, program: &str, world: &str, wanted: &str) {
    let got = does(mask, &program.replace(" / ", "\n"), world).join(" | ");
    assert_eq!(got, wanted, "@0{mask} {program}");
}

#[test]
fn relative_moves_take_x_and_y_together_then_the_first_z_then_the_second() {
    check(
        "7",
        "0 100,500,200,500,30,500,-10,400",
        "",
        "line 100,200,0 | axe 100,200,30 | axe 100,200,20 | end 100,200,20",
    );
    check("7", "0 0,21,200,500,0,21,0,21", "", "axe 0,200,0 | end 0,200,0");
    check("7", "0 -50,500,0,21,0,21,7,500", "", "axe -50,0,0 | axe -50,0,7 | end -50,0,7");
    check("1", "0 100,500 / 0100,500", "", "axe 100,0,0 | axe 200,0,0 | end 200,0,0");
    check("3", "0 100,500,50,500", "", "line 100,50,0 | end 100,50,0");
    check(
        "5",
        "0 100,500,30,500,-30,400",
        "",
        "axe 100,0,0 | axe 100,0,30 | axe 100,0,0 | end 100,0,0",
    );
}

#[test]
fn absolute_moves_count_from_the_zero_that_n_sets() {
    check(
        "7",
        "m 100,500,200,500,30,500,0,21 / m50,500,200,500,30,500,0,21",
        "",
        "line 100,200,0 | axe 100,200,30 | line 50,200,30 | end 50,200,30",
    );
    // n3 makes the place of X and Y their zero, Z keeps its own.
    check(
        "7",
        "0 100,500,200,500,30,500,0,21 / n3 / m 10,500,-20,500,40,500,0,21",
        "",
        "line 100,200,0 | axe 100,200,30 | line 110,180,30 | axe 110,180,40 | end 110,180,40",
    );
    check(
        "7",
        "0 0,21,0,21,30,500,0,21 / n4 / m 0,500,0,500,5,500,0,21 / m 0,500,0,500,0,500,0,21",
        "",
        "axe 0,0,30 | axe 0,0,35 | axe 0,0,30 | end 0,0,30",
    );
}

#[test]
fn loops_repeat_the_last_instructions_in_all_n_times() {
    check(
        "1",
        "0 10,500 / 3 4,-1",
        "",
        "axe 10,0,0 | axe 20,0,0 | axe 30,0,0 | axe 40,0,0 | end 40,0,0",
    );
    // The inner loop runs twice in each of two rounds of the outer one.
    check(
        "1",
        "0 100,500 / 0 1,500 / 3 2,-1 / 3 2,-3",
        "",
        "axe 100,0,0 | axe 101,0,0 | axe 102,0,0 | axe 202,0,0 | axe 203,0,0 | axe 204,0,0 | end 204,0,0",
    );
    // Three deep, twice each: eight steps.
    let steps: String = (1..=8).map(|x| format!("axe {x},0,0 | ")).collect();
    check("1", "0 1,500 / 32,-1 / 32,-2 / 32,-3", "", &(steps + "end 8,0,0"));
}

#[test]
fn jumps_count_from_themselves_and_may_leave_a_loop() {
    check(
        "1",
        "0 1,500 / 3 0,3 / 0 10,500 / 0 100,500 / 0 1000,500",
        "",
        "axe 1,0,0 | axe 1001,0,0 | end 1001,0,0",
    );
    check(
        "1",
        "0 10,500 / 3 0,3 / 0 999,500 / 3 9,-3 / 0 1,500",
        "",
        "axe 10,0,0 | axe 11,0,0 | end 11,0,0",
    );
    // The partner lets the loop go round twice, then its next character leads out of it.
    let world =
        "at(2000, || send_char(66)); at(4000, || send_char(66)); at(6000, || send_char(67));";
    check(
        "1",
        "0 10,500 / 2 66,3 / 3 5,-2 / 0 999,500 / 0 1,500",
        world,
        "axe 10,0,0 | axe 20,0,0 | axe 30,0,0 | axe 31,0,0 | end 31,0,0",
    );
}

#[test]
fn characters_pulses_and_times() {
    check("1", "1 90 / 5 7 / 53", "", "send 90 | wait 700 | wait 300 | end 0,0,0");
    check("1", "4 1 / 4 2 / 4 3", "", "out 1 1 | out 1 0 | out 1 1 | out 1 0 | end 0,0,0");
    check("1", "4 4", "at(1000, || press_start());", "waitstart | end 0,0,0");
    // 8 tells another card what to do: nothing moves here, and the import says so.
    let told = import("a.isel", b"@01\n@0i\n8 0S\n5 1\n9\n@0S\n", &import::Options::default());
    let told = told.expect("a script");
    assert!(!told.notes.is_empty() && told.script.contains("Wait 100ms"), "{}", told.script);
}

#[test]
fn references_and_an_impulse() {
    check("7", "7 7", "", "home Z 0 | home Y 0 | home X 0 | end 0,0,0");
    check("7", "74", "", "home Z 0 | end 0,0,0");
    check("7", "71", "", "home X 0 | end 0,0,0");
    check("7", "6 0,21,0,21,500,300,0,21", "probe_at(\"Z\", 40);", "probe Z true 40 | end 0,0,40");
    check("7", "6 0,21,0,21,500,300,0,21", "", "probe Z false 500 | end 0,0,500");
}

#[test]
fn planes_and_three_dimensions() {
    // e1: X and Z make the plane, e2: Y and Z; the axis that stands on it follows, then the second Z.
    check("7", "e1 / 0 100,500,0,21,40,500,0,21", "", "line 100,0,40 | end 100,0,40");
    check("7", "e2 / 0 0,21,100,500,40,500,0,21", "", "line 0,100,40 | end 0,100,40");
    check(
        "7",
        "e1 / e0 / 0 100,500,0,21,40,500,0,21",
        "",
        "axe 100,0,0 | axe 100,0,40 | end 100,0,40",
    );
    check(
        "7",
        "Z1 / 0 100,500,200,500,30,500,-30,500 / Z0 / 0 1,500,1,500,1,500,0,21",
        "",
        "line 100,200,30 | axe 100,200,0 | line 101,201,0 | axe 101,201,1 | end 101,201,1",
    );
}

#[test]
fn circles() {
    // From 1000 steps beside the centre to 1000 steps below it, a quarter whose arc is 2000 steps
    // of the card's algorithm.
    check("7", "F-1 / y 2000,1000,0,1000,0,-1,1", "", "arc -1000,1000,0 | end -1000,1000,0");
}

#[test]
fn ports() {
    check("7", "p65529,5,1 / p65529,5,0", "", "out 5 1 | out 5 0 | end 0,0,0");
    // 6 is bits 1 and 2: outputs 2 and 3.
    let outputs: String =
        (1..=8).map(|n| format!("out {n} {} | ", i32::from(n == 2 || n == 3))).collect();
    check("7", "p65529,0,6", "", &(outputs + "end 0,0,0"));
    check(
        "7",
        "o65531,3,0,2 / 0 999,500,0,21,0,21,0,21 / 0 10,500,0,21,0,21,0,21",
        "",
        "axe 10,0,0 | end 10,0,0",
    );
}
