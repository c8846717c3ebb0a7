//! What a drill bears: its flute and its plunge, and what is expected of its holes.

mod machine;

use cell::judge::{End, judge};
use machine::Machine;

/// 8 mm of stock up to 0; the drill's tip is the head's place.
fn drilled(keys: &str, expect: &str, deep: f64, mm_s: f64) -> (Vec<String>, cell::judge::Row) {
    let text = format!(
        "cell = 1\ntool = [{{ name = \"drill\", kind = \"drill\", output = 1, diameter = 0.8{keys} }}]\n\
         stock = {{ at = [10, 10, -8], size = [10, 10, 8] }}\n\
         expect = [{{ what = \"holes\", at = [[10, 10]]{expect} }}]\n"
    );
    let mut machine = Machine::new(&text);
    machine.go([10.0, 10.0, 5.0], 100.0);
    machine.output(1, true);
    machine.go([10.0, 10.0, 0.5], 100.0);
    // In pieces, as a board tells each step.
    let steps = (deep * 10.0) as i32;
    for step in -4..=steps {
        machine.go([10.0, 10.0, f64::from(-step) / 10.0], mm_s);
    }
    machine.go([10.0, 10.0, 5.0], 100.0);
    machine.output(1, false);
    let rows = judge(&machine.cell, &End::default(), &|_| Err("none".to_owned()));
    let broke = machine.said().into_iter().filter(|line| line.contains("\"broke\""));
    (broke.collect(), rows[0].clone())
}

#[test]
fn a_plunge_may_be_too_fast() {
    // 120 mm/min are 2 mm/s.
    let (broke, _) = drilled(", plunge_max_mm_min = 120", "", 3.0, 2.0);
    assert!(broke.is_empty(), "{broke:?}");
    let (broke, _) = drilled(", plunge_max_mm_min = 120", "", 3.0, 2.1);
    assert!(broke.len() == 1 && broke[0].contains("plunged faster than it bears"), "{broke:?}");
    let (broke, _) = drilled("", "", 3.0, 50.0);
    assert!(broke.is_empty(), "{broke:?}");
}

#[test]
fn a_hole_may_be_deeper_than_the_flute() {
    let (broke, _) = drilled(", flute = 3", "", 3.0, 2.0);
    assert!(broke.is_empty(), "{broke:?}");
    let (broke, _) = drilled(", flute = 3", "", 3.1, 2.0);
    assert!(broke.len() == 1 && broke[0].contains("deeper than its flute"), "{broke:?}");
}

#[test]
fn holes_are_as_wide_as_the_drill() {
    let (_, row) = drilled("", ", diameter = 0.8, depth = 3", 3.0, 2.0);
    assert!(row.holds, "{row:?}");
    assert_eq!(row.wanted, "1 holes within 0.05 mm, 0.8 mm wide");
    let (_, row) = drilled("", ", diameter = 1", 3.0, 2.0);
    assert!(!row.holds && row.was.ends_with("worst 0.000 mm, 0.8 mm wide"), "{row:?}");
}
