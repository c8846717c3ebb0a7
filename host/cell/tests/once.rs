//! A key with a wrong value is there: one message is about its value, and none says that the key is missing.

use cell::{Names, Port};

/// Ports by number alone.
struct Plain;

impl Names for Plain {
    fn input(&self, _: &str) -> Option<u32> {
        None
    }
    fn output(&self, _: &str) -> Option<u32> {
        None
    }
    fn analog(&self, _: &str) -> Option<u32> {
        None
    }
    fn counter(&self, _: &str) -> Option<u32> {
        None
    }
    fn known(&self, _: Port) -> Vec<String> {
        Vec::new()
    }
    fn profile(&self) -> &str {
        "plain"
    }
    fn with_role(&self, _: Port, _: &str) -> Option<u32> {
        None
    }
    fn has_analog(&self) -> bool {
        true
    }
    fn has(&self, port: Port, n: u32) -> bool {
        port != Port::Counter && (port != Port::Analog || n < 5)
    }
    fn axes(&self) -> &str {
        "XYZ"
    }
}

fn said(lines: &str) -> Vec<String> {
    let text = format!("cell = 1\npart = [{{ name = \"chip\", size = [8, 8, 4] }}]\n{lines}\n");
    match cell::read(&text, &Plain, &|_| None, &|_| Err("none".to_owned())) {
        Ok(_) => Vec::new(),
        Err(problems) => problems.iter().map(|problem| problem.render("c", &text)).collect(),
    }
}

#[test]
fn a_wrong_value_is_told_once_and_not_as_missing() {
    for lines in [
        "sensor = [{ name = \"w\", kind = \"switch\", axis = \"Y\", place = 1e19, input = 5 }]",
        "sensor = [{ name = \"w\", kind = \"switch\", axis = \"Q\", place = 10, input = 5 }]",
        "sensor = [{ name = \"w\", kind = \"beam\", from = [0, 0], to = [1, 2, 3], input = 5 }]",
        "sensor = [{ name = \"w\", kind = \"box\", at = [0, 0, 0], size = [0, 1, 1], input = 5 }]",
        "conveyor = [{ name = \"b\", at = [0, 0, 0], size = [9, 9, 9], mm_s = 1e19 }]",
        "conveyor = [{ name = \"b\", at = [0, 0, 0], size = [9, 9, 9], drive = \"Q\" }]",
        "conveyor = [{ name = \"b\", at = [0, 0, 0], size = [9, 9, 9], mm_s = 9, feeds = \"chip\", gap = 1e19 }]",
        "fixture = [{ name = \"f\", at = [0, 0], size = [9, 9, 9] }]",
        "fixture = [{ name = \"f\", at = [0, 0, 0], size = [9, 9, 9], opens_by = 3, open_at = [1, 2] }]",
        "person = [{ does = \"start\", at_s = 1e19 }]",
        "person = [{ does = \"input\", at_s = 1, input = \"none\" }]",
        "expect = [{ what = \"beads\", count = 0.5 }]",
        "expect = [{ what = \"holes\", at = 3 }]",
        "vary = [{ key = \"part.chip.at\", sigma = 1e19 }]",
        "vary = [{ fault = \"fly\" }]",
        "vary = [{ fault = \"late\", up_to_ms = 1e19 }]",
    ] {
        let said = said(lines);
        assert_eq!(said.len(), 1, "{lines}: {said:?}");
        assert!(!said[0].contains("missing `"), "{lines}: {said:?}");
    }
    // What is really not there is named alone.
    let said = said("sensor = [{ name = \"w\", kind = \"switch\", place = 10, input = 5 }]");
    assert!(said[0].contains("missing `axis` of sensor \"w\", a switch"), "{said:?}");
}
