//! What a file says and no run would heed: a key that its table's word does not read, a name that nothing has, a tool that
//! nothing switches. Each gets a message by name, with the remedy.

use cell::{Names, Port};

/// A machine with a spindle at output 1 and, if asked, a door at input 6.
struct Mill(bool);

impl Names for Mill {
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
        "mill"
    }
    fn has_analog(&self) -> bool {
        true
    }
    fn has(&self, _: Port, _: u32) -> bool {
        true
    }
    fn axes(&self) -> &str {
        "XYZ"
    }
    fn with_role(&self, port: Port, role: &str) -> Option<u32> {
        match (port, role) {
            (Port::Output, "spindle") => Some(1),
            (Port::Input, "door") if self.0 => Some(6),
            _ => None,
        }
    }
}

const THINGS: &str = r#"cell = 1
part = [{ name = "chip", size = [4, 4, 2], at = [50, 50, 0] }]
feeder = [{ name = "tray", part = "chip", at = [20, 20, 4], count = [2, 1], pitch = [10, 0] }]
place = [{ name = "box", at = [60, 20, 0], size = [20, 20, 10] }]
"#;

fn said(machine: &Mill, line: &str) -> Vec<String> {
    let text = format!("{THINGS}{line}\n");
    let told = |problems: Vec<cell::problem::Problem>| {
        problems.iter().map(|problem| problem.render("c", &text)).collect()
    };
    match cell::read(&text, machine, &|_| None, &|_| Err("none".to_owned())) {
        Ok((_, problems)) | Err(problems) => told(problems),
    }
}

/// A line of a file, and what is said about it.
const ROWS: &[(&str, &str)] = &[
    (
        "expect = [{ what = \"no_collision\", within = 3 }]",
        "c:5:45: warning[C016]: `within` has no effect: expect no_collision does not read it\n  hint: it is for in_place, holes, bead, engraved, no_drop\n",
    ),
    (
        "expect = [{ what = \"time\", below_s = 3, count = 2 }]",
        "`count` has no effect: expect time does not read it\n  hint: it is for in_place, beads, prints\n",
    ),
    (
        "person = [{ does = \"start\", at_s = 1, value = 1 }]",
        "`value` has no effect: person start does not read it\n  hint: it is for at\n",
    ),
    (
        "vary = [{ fault = \"pause\", chance = 1, within_s = 2, steps = 4 }]",
        "`steps` has no effect: vary pause does not read it\n  hint: it is for stall\n",
    ),
    (
        "vary = [{ fault = \"missing\", of = \"tray\", chance = 1, sigma = 4 }]",
        "`sigma` has no effect beside `fault`: it is for a `key`\n  hint: leave it out\n",
    ),
    (
        "vary = [{ key = \"tray.at\", sigma = 1, chance = 0.5 }]",
        "`chance` has no effect beside `key`: it is for a `fault`\n",
    ),
    (
        "sensor = [{ name = \"eye\", kind = \"beam\", from = [1, 1, 1], to = [2, 1, 1], input = 4, axis = \"X\" }]",
        "`axis` has no effect: sensor beam does not read it\n  hint: it is for switch\n",
    ),
    (
        "person = [{ does = \"take\", thing = \"tray.9\", at_s = 1 }]",
        "error[C011]: person \"somebody\" names thing \"tray.9\"; \"tray.1\" is meant?\n",
    ),
    (
        "person = [{ does = \"take\", thing = \"tray\", at_s = 1 }]",
        "error[C011]: person \"somebody\" names thing \"tray\"; \"tray.1\" is meant?\n",
    ),
    (
        "person = [{ name = \"bob\", does = \"start\", when = \"bax full\" }]",
        "error[C011]: person \"bob\" waits for place \"bax\"; \"box\" is meant?\n",
    ),
    (
        "tool = [{ name = \"nozzle\", kind = \"vacuum\" }]",
        "warning[C016]: tool \"nozzle\" is never on: it has no `output`; write `output`\n",
    ),
    (
        "tool = [{ name = \"beam\", kind = \"pen\", flow_mg_s = 1 }]",
        "tool \"beam\" is never on: it has no `output`; write `output`\n",
    ),
    (
        "stop_on = [\"wrong\"]",
        "`stop_on` \"wrong\" has no effect: only a collision is known before the end\n",
    ),
    (
        "vary = [{ fault = \"door\", chance = 1, within_s = 2 }]",
        "c:5:19: error[C011]: fault door strikes nothing: the profile \"mill\" has no door; an input with role = \"door\" is one\n",
    ),
];

#[test]
fn what_no_run_heeds_is_told() {
    for (line, wanted) in ROWS {
        let said = said(&Mill(false), line);
        assert!(said.len() == 1 && said[0].contains(wanted), "{line}: {said:#?}");
    }
}

#[test]
fn what_a_run_heeds_is_not() {
    for line in [
        "vary = [{ fault = \"door\", chance = 1, within_s = 2, up_to_ms = 300 }]",
        "tool = [{ kind = \"drill\", diameter = 1 }]",
        "tool = [{ kind = \"laser\", flow_mg_s = 1 }]",
        "tool = [{ kind = \"none\" }]",
        "person = [{ does = \"take\", thing = \"chip\", when = \"print box full\" }]",
        "person = [{ does = \"put\", thing = \"tray.2\", when = \"box full\" }]",
        "stop_on = [\"collision\"]",
    ] {
        let said = said(&Mill(true), line);
        assert!(said.is_empty(), "{line}: {said:#?}");
    }
}

#[test]
fn a_tool_without_an_output_has_the_one_of_its_role() {
    let text = "cell = 1\ntool = [{ kind = \"drill\", diameter = 1 }]\n";
    let read = cell::read(text, &Mill(false), &|_| None, &|_| Err("none".to_owned()));
    assert_eq!(read.unwrap().0.tools[0].output, Some(1));
}
