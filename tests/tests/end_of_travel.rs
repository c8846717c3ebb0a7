//! An axis that MoveSpeed runs to the end of its travel, where the program takes the fault: the axis stands where it stands,
//! and what was under way is done anew, on every engine alike.

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use pasapas::sim::trace::{Status, What};
use tests::on_every_engine;

const HANDLER: &str = "END\nh:\nPRINT \"F\"; ERR; \" line \"; ERL\nRESUME NEXT\n";

/// What a script prints on each engine, which must be the same, and X and Y of its end, steps; it must end by itself.
fn printed(machine: &str, script: &str) -> (Vec<String>, [Option<i32>; 2]) {
    let text = format!("PROFILE \"{machine}\"\nON ERROR GOTO h\n{script}{HANDLER}");
    let source = Source::new("t.bas", text);
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    let mut all = on_every_engine(&program, "").into_iter().map(|(name, outcome, events)| {
        assert_eq!(outcome.end.status, Status::Done, "{name}: {:?} {script}", outcome.end);
        assert!(outcome.failures.is_empty(), "{name}: {:?} {script}", outcome.failures);
        let mut lines = Vec::new();
        let mut rest = [None; 2];
        for event in events {
            match event.what {
                What::Print { text, .. } => lines.push(text),
                What::End { pos, .. } => rest = [pos.x, pos.y],
                _ => {}
            }
        }
        (name, (lines, rest))
    });
    let (_, first) = all.next().expect("an engine");
    for (name, own) in all {
        assert_eq!(own, first, "{name} {script}");
    }
    first
}

#[test]
fn what_follows_goes_on_from_where_the_axis_stands() {
    let to_the_end = "Home\nMoveAxe X, 20mm\nMoveSpeed X, -20mm/s\nWait 3s\nF600\n";
    for machine in ["mill", "picker"] {
        for (then, x, y) in [
            ("MoveRel X, 10mm\n", 1000, 0),
            ("G1 X30\n", 3000, 0),
            ("G1 X0\n", 0, 0),
            ("G1 X0 Y10\n", 0, 1000),
            ("G91 G1 X5 Y1\n", 500, 100),
            ("G2 X10 Y0 I5 J0\n", 1000, 0),
            ("SetPos X, 0mm\nG1 X5\n", 500, 0),
        ] {
            let script = format!("{to_the_end}{then}PRINT POSST(X); \" \"; POSST(Y)\n");
            let (lines, rest) = printed(machine, &script);
            assert_eq!(lines.last(), Some(&format!("{x}st {y}st")), "{machine}: {then}{lines:?}");
            assert_eq!(rest, [Some(x), Some(y)], "{machine}: {then}");
        }
    }
}

#[test]
fn the_statement_under_way_is_done_anew() {
    let begin = "PRINT \"begin\"\nHome\nMoveSpeed X, 50mm/s\n";
    for (wait, after) in [
        ("MoveAxe Y, 10mm, 0.5mm/s\n", "1000st"),
        ("MoveAxe Y, 10mm, 1mm/s\n", "1000st"),
        ("F60\nG1 Y10\n", "1000st"),
        ("Wait 9s\n", "0st"),
        ("WaitIn? 3, ON, 9s\n", "0st"),
    ] {
        let (lines, _) = printed("mill", &format!("{begin}{wait}PRINT POSST(Y)\n"));
        assert_eq!(lines.len(), 3, "{wait}{lines:?}");
        assert_eq!((&*lines[0], &*lines[2]), ("begin", after), "{wait}{lines:?}");
        assert!(lines[1].starts_with("F5 line "), "{wait}{lines:?}");
    }
}

/// A relative move that the handler begins while the axis still brakes counts from where the axis comes to rest: a tool that
/// plunges is lifted, and not sent on to the place that the fault broke off.
#[test]
fn a_relative_move_counts_from_where_a_fault_stopped_the_axis() {
    for (machine, begin, fault, to) in [
        ("mill", "START MoveAxe Y, 100mm, 50mm/s\nWait 300ms\n", "WaitIn 3, ON, 20ms\n", [5, 60]),
        ("mill", "MoveSpeed Y, 50mm/s\nWait 300ms\n", "n = 1 / n\n", [5, 60]),
        ("charly", "START MoveAxe Y, 100mm, 50mm/s\nWait 300ms\n", "n = 1 / n\n", [5, 60]),
        (
            "mill",
            "MoveAxe X, 290mm\nMoveSpeed X, 50mm/s\nSTART MoveAxe Y, 100mm, 20mm/s\n",
            "Wait 2s\n",
            [2, 30],
        ),
    ] {
        let script = format!(
            "DIM n, there AS LENGTH\nHome\n{begin}{fault}END\nh:\nMoveRel Y, 1mm\nthere = POS(Y)\nMoveRel Y, -1mm\n\
             PRINT there - POS(Y)\nRESUME NEXT\n"
        );
        let text = format!("PROFILE \"{machine}\"\nON ERROR GOTO h\n{script}");
        let source = Source::new("t.bas", text);
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
        for (name, outcome, events) in on_every_engine(&program, "") {
            assert_eq!(outcome.end.status, Status::Done, "{name}: {:?} {begin}", outcome.end);
            let told: Vec<_> = events
                .iter()
                .filter_map(|event| match &event.what {
                    What::Print { text, .. } => Some(text.as_str()),
                    _ => None,
                })
                .collect();
            assert_eq!(told, ["1000um"], "{name}: {begin}");
            let Some(What::End { pos, .. }) = events.last().map(|event| &event.what) else {
                panic!("{name}: no end")
            };
            let y = pos.y.expect("a place") / 100;
            assert!((to[0]..to[1]).contains(&y), "{name}: {begin} Y rests at {y} mm");
        }
    }
}

/// A line that waits for an axis that MoveSpeed runs to its end comes after the fault, not before it.
#[test]
fn a_line_that_waits_for_the_axis_is_never_lost() {
    let script = "DIM k, v AS SPEED\nHome X\nF600\nFOR k = 1 TO 6\nMoveAxe X, 295mm\nv = 20mm/s + k * 1.37mm/s\n\
                  MoveSpeed X, v\nG1 Y[k * 1mm]\nWaitMove\nPRINT POSST(Y)\nNEXT\n";
    let (lines, _) = printed("charly", script);
    let told: Vec<&String> = lines.iter().filter(|line| line.ends_with("st")).collect();
    assert_eq!(told, ["100st", "200st", "300st", "400st", "500st", "600st"], "{lines:?}");
}
