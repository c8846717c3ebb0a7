//! Quantities of a program, and what a part makes of it.

use lang::front::ProfileChoice;
use lang::part::{F5529, G2553};

use super::{MOST_POINTS, load, path};
use crate::plot::{Curve, Point, Style};

#[test]
fn quantities_have_labels_and_ranges() {
    let text = "DIM qty AT 3000 LABEL \"Pieces\" MIN 1 MAX 500\nKEEP wanted ' St\u{fc}ck, -5..50 in all\n\
                KEEP plain\nDIM own\nDIM way AS LENGTH AT 3002 ' Way of 3..1\nown = 1\nway = 1mm\n";
    let loaded = load(text, ProfileChoice::built_in()).expect("it compiles");
    let vars = loaded.variables();
    let of = |name: &str| {
        let list = vars.as_array().expect("a list");
        list.iter().find(|var| var["name"] == name).expect("the variable").clone()
    };
    let shown = |name: &str| {
        let var = of(name);
        (var["label"].as_str().map(str::to_owned), var["low"].as_i64(), var["high"].as_i64())
    };
    let all = (Some(i32::MIN.into()), Some(i32::MAX.into()));
    assert_eq!(shown("qty"), (Some("Pieces".to_owned()), Some(1), Some(500)));
    assert_eq!(shown("wanted"), (Some("St\u{fc}ck in all".to_owned()), Some(-5), Some(50)));
    assert_eq!(shown("plain"), (Some("plain".to_owned()), all.0, all.1));
    assert_eq!(shown("way"), (Some("Way of 3..1".to_owned()), all.0, all.1));
    assert_eq!(shown("own"), (None, None, None));
    let cell = |name: &str| of(name)["cell"].as_u64().expect("a cell") as u16;
    for operator in [true, false] {
        let may_set = |cell, value| loaded.may_set(cell, value, operator);
        assert_eq!(may_set(cell("qty"), 500), Ok(()));
        assert_eq!(may_set(cell("qty"), 501), Err("Pieces: 1 to 500".to_owned()));
        assert_eq!(may_set(cell("own"), 1).is_err(), operator);
    }
    assert!(loaded.may_set(4000, 1, true).is_err());
}

#[test]
fn arcs_are_drawn_for_firmware_that_has_none() {
    let of = |text: &str| load(text, ProfileChoice::built_in()).expect("it compiles");
    let arc = "G91 G2 X2 I1 F600\n";
    assert_eq!(of(arc).for_part(&G2553).lack(&G2553), None);
    assert_eq!(of(arc).for_part(&F5529).crc, of(arc).crc);
    let open = "G2 X2 I1 F600\n";
    assert!(of(open).for_part(&G2553).lack(&G2553).is_some());
}

#[test]
fn a_path_that_is_too_long_for_a_page_is_said_to_be() {
    let point = Point { us: 1_500_000.0, at: [0.0; 3], rate: 0.0 };
    let curve = |line, count| Curve {
        style: Style::Cut,
        line,
        points: vec![point; count],
        axes: [true, false, false],
        home: false,
        arc: false,
        power: None,
    };
    let bytes = |(bytes, note): (Vec<u8>, Option<String>)| (bytes.len(), note);
    let (fits, note) = bytes(path(1, &[curve(1, 2), curve(2, MOST_POINTS - 2)]));
    assert_eq!((fits, note), (4 + 20 * MOST_POINTS, None));
    let (cut, note) = bytes(path(1, &[curve(1, 2), curve(2, MOST_POINTS - 1)]));
    let note = note.expect("it is said");
    assert!(cut == 4 + 40 && note.contains("up to 1.5 s, line 2"), "{cut} {note}");
}
