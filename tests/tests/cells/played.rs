//! Traces of boards, played into cells.

use pasapas::scene::replay::replay;
use pasapas::sim::trace;
use pasapas::sim::world::World;

use super::{example, folder, native, read};

/// The trace of an example, as a board tells it, gives the same things in the same places as its run did.
#[test]
fn a_trace_of_each_example_is_judged_as_its_run() {
    for name in
        ["pick_place", "pcb_drill", "glue_dots", "cells/tape", "cells/sort", "cells/probed_holes"]
    {
        let program = example(name);
        let scene = read(&folder().join(format!("{name}.cell.toml")), &program);
        let (run, events) = native(&program, &World::unattended().with_scene(Some(scene.clone())));
        let own = run.outcome.cell.unwrap();
        // Without its times, as a board writes it.
        let text = trace::to_text(&events);
        let played = replay(&scene, &program.profile, &trace::read(text.as_bytes()).unwrap());
        assert_eq!(played.differences, [""; 0], "{name}");
        // Masses and times are those of the pace, not of the board.
        for (row, own) in played.report.rows.iter().zip(&own.rows) {
            if !matches!(row.what.as_str(), "time" | "beads" | "bead") {
                assert_eq!(
                    (&row.name, &row.was, row.holds),
                    (&own.name, &own.was, own.holds),
                    "{name}"
                );
            }
        }
    }
}

/// A board that found a part where the cell has none, and one that carried its part into the wall.
#[test]
fn where_board_and_cell_disagree_is_told() {
    let program = example("pick_place");
    let scene = read(&folder().join("pick_place.cell.toml"), &program);
    let (_, events) = native(&program, &World::unattended().with_scene(Some(scene.clone())));
    let text = trace::to_text(&events);
    // The empty pocket was full on the board.
    let full = text.replacen("\"n\":3,\"v\":1,\"ok\":false", "\"n\":3,\"v\":1,\"ok\":true", 1);
    assert_ne!(full, text);
    let played = replay(&scene, &program.profile, &trace::read(full.as_bytes()).unwrap());
    assert!(
        played.differences[0].contains("input 3 came on on the board, and not in the cell"),
        "{:?}",
        played.differences
    );
    // Z was lifted too little before the way over the wall.
    let lowered = |text: &str, from: &str| {
        let low = text.replacen(from, &from.replace("\"Z\":0", "\"Z\":-1400"), 1);
        assert_ne!(low, text, "{from}");
        low
    };
    let low = lowered(&text, "\"kind\":\"axe\",\"to\":{\"X\":2000,\"Y\":3000,\"Z\":0}");
    let low = lowered(&low, "\"kind\":\"rapid\",\"to\":{\"X\":15000,\"Y\":6000,\"Z\":0}");
    let played = replay(&scene, &program.profile, &trace::read(low.as_bytes()).unwrap());
    let table = played.report.table();
    assert!(table.contains("tray.1 hit wall at"), "{table}");
}
