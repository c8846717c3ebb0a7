//! Every message of a cell file, in the words that its author reads.

use cell::{Names, Port};

/// A machine that is not the default one: other names, no Z travel.
struct Placer;

impl Names for Placer {
    fn input(&self, name: &str) -> Option<u32> {
        ["part", "door", "held"]
            .iter()
            .position(|known| *known == name)
            .map(|index| index as u32 + 3)
    }
    fn output(&self, name: &str) -> Option<u32> {
        ["pump", "glue"].iter().position(|known| *known == name).map(|index| index as u32 + 3)
    }
    fn analog(&self, name: &str) -> Option<u32> {
        (name == "vacuum").then_some(1)
    }
    fn counter(&self, _: &str) -> Option<u32> {
        None
    }
    fn known(&self, port: Port) -> Vec<String> {
        let names: &[&str] = match port {
            Port::Input => &["part", "door", "held"],
            Port::Output => &["pump", "glue"],
            Port::Analog => &["vacuum"],
            Port::Counter => &[],
        };
        names.iter().map(|&name| name.to_owned()).collect()
    }
    fn profile(&self) -> &str {
        "placer"
    }
    fn has_analog(&self) -> bool {
        true
    }
    fn axes(&self) -> &str {
        "XYZ"
    }
}

/// The same machine with the smaller chip.
struct Small;

impl Names for Small {
    fn input(&self, name: &str) -> Option<u32> {
        Placer.input(name)
    }
    fn output(&self, name: &str) -> Option<u32> {
        Placer.output(name)
    }
    fn analog(&self, _: &str) -> Option<u32> {
        None
    }
    fn counter(&self, _: &str) -> Option<u32> {
        None
    }
    fn known(&self, port: Port) -> Vec<String> {
        Placer.known(port)
    }
    fn profile(&self) -> &str {
        "small"
    }
    fn has_analog(&self) -> bool {
        false
    }
    fn axes(&self) -> &str {
        "XYZ"
    }
}

fn travel(axis: char) -> Option<(f64, f64)> {
    match axis {
        'X' => Some((0.0, 300.0)),
        'Y' => Some((0.0, 200.0)),
        _ => None,
    }
}

fn files(name: &str) -> Result<String, String> {
    match name {
        "b.pos" => {
            Ok("# Ref Val Package PosX PosY Rot Side\nR1 10k R_0603 1 2 90 top\nR2 10k 3 4 0\n"
                .to_owned())
        }
        _ => Err(format!("file \"{name}\" cannot be read")),
    }
}

/// What is said of a file with `cell = 1` before these lines; one message for each.
fn said(lines: &str) -> Vec<String> {
    said_on(&Placer, &format!("cell = 1\n{lines}"))
}

fn said_on(names: &dyn Names, text: &str) -> Vec<String> {
    let problems = match cell::read(text, names, &travel, &files) {
        Ok((_, warnings)) => warnings,
        Err(problems) => problems,
    };
    problems
        .iter()
        .map(|problem| problem.render("c", text).trim_end().replace('\n', " /"))
        .collect()
}

/// A part "chip" of 8 x 8 x 4 mm.
const CHIP: &str = "part = [{ name = \"chip\", size = [8, 8, 4] }]\n";

#[test]
fn each_message_names_thing_place_and_remedy() {
    let cases: &[(&str, &[&str])] = &[
        ("part = [", &["c:2:9: error[C001]: this is not TOML"]),
        (
            "[[tool]]\nkind = \"pen\"\nflow_mg_s = 1\nouput = 3\n",
            &[
                "c:5:1: error[C002]: unknown key `ouput`; `output` is meant? /  hint: [tool] of kind pen has name, kind,",
            ],
        ),
        ("table = 3\ntabel = 4\n", &["c:3:1: error[C002]: unknown key `tabel`; `table` is meant?"]),
        (
            "part = [{ name = \"chip\" }]\n",
            &["c:2:9: error[C003]: missing `size` of part \"chip\""],
        ),
        (
            "[[tool]]\nkind = \"vacuum\"\nreach = -1\n",
            &["c:4:9: error[C004]: `reach` of [tool] is -1; it must lie between 0 and 10000"],
        ),
        (
            "part = [{ name = \"chip\", size = [8, 0, 4] }]\n",
            &["c:2:33: error[C004]: `size` of [part] has 0; each must be above 0"],
        ),
        (
            "part = [{ name = \"chip\", size = [8, 8] }]\n",
            &["c:2:33: error[C004]: `size` of [part] has 2 numbers; it must have 3"],
        ),
        (
            "[[sensor]]\nname = \"eye\"\nkind = \"beem\"\n",
            &[
                "c:4:8: error[C004]: `kind` of [sensor]: \"beem\" is none of beam, box, switch, distance, colour; \"beam\" is meant?",
            ],
        ),
        (
            "part = [{ name = \"tray\", size = [8, 8, 4] }]\nfeeder = [{ name = \"tray\", part = \"tray\", at = [1, 2, 3] }]\n",
            &["c:3:20: error[C005]: two things are named \"tray\""],
        ),
        (
            "[[tool]]\nkind = \"vacuum\"\ninput = \"helt\"\n",
            &[
                "c:4:9: error[C006]: input \"helt\": the profile \"placer\" has inputs part, door, held; or a number /  hint: \"held\" is meant?",
            ],
        ),
        (
            "[[conveyor]]\nname = \"b\"\nat = [0, 0, 0]\nsize = [9, 9, 9]\ncounter = \"c\"\nmm_s = 1\n",
            &[
                "c:6:11: error[C006]: counter \"c\": the profile \"placer\" has no named counters; or a number",
            ],
        ),
        (
            "[[tool]]\nkind = \"pen\"\nflow_mg_s = 1\noutput = 0\n",
            &[
                "c:5:10: error[C006]: output is 0; it must lie between 1 and 99: a number from 1, or a name",
            ],
        ),
        (
            "tool = [{ name = \"nozzle\", kind = \"vacuum\", input = 3 }]\nsensor = [{ name = \"eye\", kind = \"beam\", from = [0, 0, 0], to = [9, 0, 0], input = \"part\" }]\n",
            &["c:3:20: error[C007]: input 3 is driven by tool \"nozzle\" and by sensor \"eye\""],
        ),
        (
            "place = [{ name = \"belt\", at = [150, 260, 0], size = [9, 9, 9] }]\n",
            &[
                "c:2:19: warning[C008]: place \"belt\" lies outside the travel: Y 260, the profile \"placer\" ends at 200",
            ],
        ),
        (
            "start = [100, 60, -30]\ntool = [{ name = \"nozzle\", kind = \"vacuum\", body = [{ at = [0, 0, 2], size = [12, 12, 40] }] }]\nfixture = [{ name = \"wall\", at = [100, 60, -60], size = [4, 120, 45] }]\n",
            &["c:4:21: error[C009]: tool \"nozzle\" stands inside fixture \"wall\" at the start"],
        ),
        (
            "part = [{ name = \"chip\", size = [8, 8, 4] }]\nfeeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, -26.4], count = [3, 1], pitch = [15, 0] }]\nfixture = [{ name = \"tray floor\", at = [35, 30, -30], size = [60, 75, 4] }]\n",
            &["c:3:20: error[C010]: part \"tray.1\" overlaps fixture \"tray floor\" by 0.4 mm"],
        ),
        (
            "expect = [{ what = \"in_place\", place = \"bely\" }]\nplace = [{ name = \"belt\", at = [150, 60, 0], size = [9, 9, 9] }]\n",
            &["c:2:40: error[C011]: expectation names place \"bely\"; \"belt\" is meant?"],
        ),
        (
            "tool = [{ name = \"nozzle\", kind = \"vacuum\" }]\nvary = [{ key = \"nozzle.build\", share = 0.1 }]\n",
            &["c:3:17: error[C012]: `vary` key \"nozzle.build\": no number; build_ms is meant?"],
        ),
        (
            "tool = [{ name = \"nozzle\", kind = \"vacuum\", build_ms = 20 }]\nvary = [{ key = \"nozzle.build_ms\", range = [-30, 5] }]\n",
            &[
                "c:3:17: error[C004]: `vary` of \"nozzle.build_ms\" leaves what is possible: 20 may become -10 to 25",
            ],
        ),
        (
            "part = [{ name = \"chip\", size = [8, 8, 4] }]\nfeeder = [{ name = \"reel\", part = \"chip\", kind = \"list\", file = \"b.pos\" }]\n",
            &["c:3:65: error[C015]: file \"b.pos\": line 3 has 5 columns, 7 are needed"],
        ),
        (
            "part = [{ name = \"chip\", size = [0.01, 8, 4] }]\n",
            &["c:2:33: warning[C004]: a size of 0.01: mm?"],
        ),
        (
            "person = [{ does = \"input\", at_s = 3 }]\n",
            &["c:2:11: error[C003]: missing `input` of person \"somebody\", who does input"],
        ),
        (
            "vary = [{ fault = \"missing\", of = \"tray\" }]\n",
            &["c:2:9: warning[C003]: fault missing never happens: its `chance` is 0"],
        ),
    ];
    for (lines, wanted) in cases {
        let said = said(lines);
        assert_eq!(said.len(), wanted.len(), "{lines}\n{said:#?}");
        for (said, wanted) in said.iter().zip(*wanted) {
            assert!(said.starts_with(wanted), "{lines}\nwanted {wanted}\nsaid   {said}");
        }
    }
}

#[test]
fn another_version_and_a_chip_without_analog_inputs_are_told() {
    assert_eq!(
        said_on(&Placer, "cell = 2\n"),
        ["c:1:8: error[C013]: this cell is of version 2; this program reads 1"]
    );
    assert_eq!(said_on(&Placer, ""), ["c:1:1: error[C003]: missing `cell` of the cell"]);
    let text = "cell = 1\n[[tool]]\nkind = \"vacuum\"\nanalog = \"vacuum\"\n";
    assert_eq!(said_on(&Small, text), ["c:4:10: error[C014]: analog inputs need part f5529"]);
    assert_eq!(said_on(&Placer, text), [""; 0]);
}

#[test]
fn neighbours_that_touch_are_no_overlap() {
    let feeder = "feeder = [{ name = \"tray\", part = \"chip\", at = [20, 30, 0], count = [3, 1], pitch = [8, 0] }]\n";
    assert_eq!(said(&format!("{CHIP}{feeder}")), [""; 0]);
    let closer = feeder.replace("[8, 0]", "[7.5, 0]");
    let said = said(&format!("{CHIP}{closer}"));
    assert!(said[0].contains("parts \"chip\" of 8 mm stand in one another"), "{said:?}");
}

/// The cell of the manual's first example.
const PICK_PLACE: &str = r#"cell = 1
table = -60
tool    = [{ name = "nozzle", kind = "vacuum", output = 3, input = 3, build_ms = 90, reach = 1.5, body = [{ at = [0, 0, 2], size = [12, 12, 40] }] }]
part    = [{ name = "chip", size = [8, 8, 4] }]
feeder  = [{ name = "tray", kind = "tray", part = "chip", at = [20, 30, -26], pitch = [15, 15], count = [3, 4], empty = [5] }]
fixture = [{ name = "tray floor", at = [35, 52.5, -30], size = [60, 75, 4] }, { name = "wall", at = [100, 60, -60], size = [4, 120, 45] }]
place   = [{ name = "belt", at = [150, 60, -16.5], size = [20, 20, 10], room = 0 }]
expect  = [{ what = "in_place", place = "belt", of = "tray" }, { what = "no_collision" }, { what = "no_drop", within = 25 }, { what = "time", below_s = 90 }]
vary    = [{ key = "tray.at", sigma = 0.4, each = true }, { key = "nozzle.build_ms", share = 0.25 }, { fault = "missing", of = "tray", chance = 0.01 },
           { fault = "stuck", of = "tray", chance = 0.01, up_to_ms = 900 }, { fault = "slow", of = "nozzle", up_to_ms = 40 }, { fault = "pause", chance = 0.2, within_s = 60 }]
"#;

#[test]
fn a_pick_and_place_is_read() {
    let (scene, warnings) = cell::read(PICK_PLACE, &Placer, &travel, &files).unwrap();
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(scene.feeders[0].pockets.len(), 12);
    assert_eq!(scene.feeders[0].pockets[4].0, [35.0, 45.0, -26.0], "row by row");
    assert_eq!(scene.feeders[0].empty, [4]);
    assert_eq!((scene.expects.len(), scene.varies.len()), (4, 6));
}

#[test]
fn ten_thousand_parts_and_any_bytes_end_well() {
    let many = format!(
        "cell = 1\n{CHIP}feeder = [{{ name = \"tray\", part = \"chip\", at = [0, 0, 0], pitch = [9, 9], count = [100, 100] }}]\n"
    );
    assert_eq!(said_on(&Placer, &many).len(), 1, "the travel alone");
    proptest::proptest!(|(from in 0usize..900, to in 0usize..900, byte in proptest::char::any())| {
        let cut = |at: usize| (0..=at.min(PICK_PLACE.len())).rev().find(|&at| PICK_PLACE.is_char_boundary(at)).unwrap_or(0);
        let text = format!("{}{byte}{}", &PICK_PLACE[..cut(from)], &PICK_PLACE[cut(to)..]);
        said_on(&Placer, &text);
    });
}
