//! Every message of a cell file, in the words that its author reads.

use cell::check::strikes;
use cell::vary::Deviation;
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
    fn has(&self, port: Port, n: u32) -> bool {
        port != Port::Counter && (port != Port::Analog || n < 5)
    }
    fn axes(&self) -> &str {
        "XYZ"
    }
    fn with_role(&self, port: Port, role: &str) -> Option<u32> {
        (port == Port::Input && role == "door").then_some(4)
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
    fn has(&self, port: Port, n: u32) -> bool {
        port != Port::Counter && (port != Port::Analog || n < 5)
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
        (
            "include = [\"other.cell.toml\"]\n",
            &[
                "c:2:12: error[C015]: include \"other.cell.toml\": file \"other.cell.toml\" cannot be read /  hint: names of files",
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
            &["c:6:11: error[C014]: no part has counters yet"],
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
            "part = [{ name = \"chip\", size = [8, 8, 4] }]\nfeeder = [{ name = \"tray\", kind = \"tray\", part = \"chip\", at = [20, 30, -26.4], count = [200, 100], pitch = [15, 15] }]\n",
            &[
                "c:3:88: error[C004]: `count` of feeder \"tray\" makes 20000 parts of the scene; it has at most 10000",
            ],
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
            &[
                "c:2:9: warning[C003]: fault missing never happens: its `chance` is 0",
                "c:2:35: error[C011]: fault missing names no feeder, belt, thing of these or part with `at`: \"tray\"; there is none",
            ],
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
    let text = "cell = 1\n[[tool]]\nkind = \"vacuum\"\nanalog = \"vacuum\"\noutput = 3\n";
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

/// Two feeders, a part that stands by itself, a tool without an input, a sensor and a person.
const AROUND: &str = r#"
tool = [{ name = "nozzle", kind = "vacuum", output = 3 }]
part = [{ name = "chip", size = [8, 8, 4] }, { name = "lid", size = [8, 8, 4], at = [200, 100, 0] }]
feeder = [{ name = "tray", part = "chip", kind = "tray", at = [20, 30, 0], pitch = [15, 15], count = [2, 2], empty = [4] }, { name = "reel", part = "chip", kind = "tape", at = [90, 90, 0] }]
sensor = [{ name = "eye", kind = "beam", from = [0, 0, 0], to = [9, 9, 0], input = 3 }]
person = [{ name = "ann", does = "start", when = "wait_start" }]
"#;

fn scene(lines: &str) -> cell::scene::Scene {
    cell::read(&format!("cell = 1\n{lines}"), &Placer, &travel, &files).unwrap().0
}

/// What is said of a row of `vary`, without the place.
fn of(row: &str) -> Vec<String> {
    let lines = said(&format!("{AROUND}vary = [{{ {row} }}]\n"));
    lines.into_iter().map(|line| line.split_once(' ').unwrap().1.to_owned()).collect()
}

#[test]
fn a_fault_names_its_time_and_its_size() {
    for fault in ["pause", "stop", "estop", "door"] {
        let row = format!("fault = \"{fault}\", chance = 1");
        assert_eq!(
            of(&row),
            [format!(
                "error[C003]: missing `within_s` of fault {fault} /  hint: write the length of the run: it comes at some time of it"
            )]
        );
        assert_eq!(of(&format!("{row}, within_s = 0.5")), [""; 0]);
        let zero = of(&format!("{row}, within_s = 0"));
        assert!(zero[0].starts_with("error[C004]: `within_s` of fault"), "{zero:?}");
    }
    for (row, key) in [
        ("fault = \"slow\", of = \"nozzle\"", "up_to_ms"),
        ("fault = \"late\", of = \"ann\"", "up_to_ms"),
        ("fault = \"bounce\", of = \"eye\", chance = 1", "up_to_ms"),
        ("fault = \"stall\", of = \"X\", chance = 1, within_s = 1", "steps"),
        ("fault = \"stall\", of = \"X\", chance = 1, steps = 3", "within_s"),
    ] {
        let said = of(row);
        let wanted = format!("error[C003]: missing `{key}` of fault ");
        assert!(said.len() == 1 && said[0].starts_with(&wanted), "{row}: {said:?}");
    }
}

#[test]
fn a_fault_that_strikes_nobody_is_told() {
    for (row, wanted) in [
        (
            "fault = \"late\", of = \"anna\", up_to_ms = 9",
            "error[C011]: fault late names no person: \"anna\"; \"ann\" is meant?",
        ),
        (
            "fault = \"slow\", of = \"nozle\", up_to_ms = 9",
            "error[C011]: fault slow names no tool, sensor or feeder: \"nozle\"; \"nozzle\" is meant?",
        ),
        (
            "fault = \"missing\", of = \"nozzle\", chance = 1",
            "error[C011]: fault missing names no feeder,",
        ),
        (
            "fault = \"stuck\", of = \"chip\", chance = 1",
            "error[C011]: fault stuck names no feeder,",
        ),
        (
            "fault = \"lost\", of = \"tray.4\", chance = 1",
            "error[C011]: fault lost names no feeder,",
        ),
        (
            "fault = \"turned\", of = \"tray.5\", chance = 1",
            "error[C011]: fault turned names no feeder,",
        ),
        ("fault = \"stuck\", chance = 1", "error[C003]: missing `of` of fault stuck: a feeder,"),
        (
            "fault = \"dead_on\", of = \"nozzle\", chance = 1",
            "error[C011]: fault dead_on names no sensor or tool with an input: \"nozzle\"",
        ),
        (
            "fault = \"stall\", of = \"A\", chance = 1, steps = 3, within_s = 1",
            "error[C011]: fault stall names no axis of the profile: \"A\"",
        ),
        (
            "fault = \"missing\", of = \"tray\", chance = 0",
            "warning[C003]: fault missing never happens: its `chance` is 0",
        ),
        (
            "key = \"tray.at\", sigma = 0",
            "warning[C016]: `vary` of \"tray.at\" changes by 0: it has no effect",
        ),
        (
            "key = \"nozzle.build_ms\", sigma = 1, each = true",
            "warning[C016]: `each` of \"nozzle.build_ms\" has no effect: \"nozzle\" is no feeder",
        ),
        (
            "key = \"tray.at\", share = 0.1",
            "error[C004]: `share` of \"tray.at\" is a part of nothing",
        ),
        (
            "key = \"nozzle.leak_kpa_s\", share = 0.1",
            "error[C004]: `share` of \"nozzle.leak_kpa_s\" is a part of nothing",
        ),
        (
            "key = \"nozzle.sealed_kpa\", sigma = 10000",
            "error[C004]: `vary` of \"nozzle.sealed_kpa\" leaves what is possible: 60 may become 0 to 40060",
        ),
        (
            "key = \"nozzle.sealed_kpa\", share = 1",
            "error[C004]: `vary` of \"nozzle.sealed_kpa\" leaves what is possible: 60 may become 0 to 300",
        ),
        ("key = \"eye.at\", sigma = 1", "warning[C016]: `vary` of \"eye.at\" has no effect yet"),
    ] {
        let said = of(row);
        assert!(
            said.len() == 1 && said[0].starts_with(wanted),
            "{row}\nwanted {wanted}\nsaid   {said:?}"
        );
    }
    for row in [
        "fault = \"missing\", of = \"tray.2\", chance = 1",
        "fault = \"missing\", of = \"lid\", chance = 1",
        "fault = \"slow\", of = \"reel\", up_to_ms = 9",
        "fault = \"stall\", of = \"Y\", chance = 1, steps = -3, within_s = 1",
        "key = \"nozzle.build_ms\", share = 0.8",
    ] {
        assert_eq!(of(row), [""; 0], "{row}");
    }
}

#[test]
fn a_deviation_that_strikes_nobody_is_refused() {
    let scene = scene(AROUND);
    let told = |text: &str| strikes::deviation(&scene, &Placer, &Deviation::parse(text).unwrap());
    for (text, wanted) in [
        ("pause", "`pause` needs a time: write \"pause at 12.5s\""),
        ("stuck trey.1 9ms", "fault stuck names no "),
        ("missing tray.4", "fault missing names no "),
        ("late bob 9ms", "fault late names no person: \"bob\""),
        ("slow nozzle", "`slow` needs a delay: write \"slow nozzle 40ms\""),
        ("stall X at 1s", "`stall` needs the steps lost"),
        ("stall Q 3st at 1s", "fault stall names no axis of the profile"),
        ("nozle.build_ms 3", "`nozle.build_ms` is no number of the cell that varies"),
        ("tray.at reel.1 3", "`tray.at`: \"reel.1\" is no thing of \"tray\""),
        ("tray.at tray.1 0 0", "`tray.at` changes by nothing"),
    ] {
        let error = told(text).unwrap_err();
        assert!(error.starts_with(wanted), "{text}: {error}");
    }
    for text in [
        "pause at 0s",
        "stuck tray.1 813ms",
        "missing lid",
        "tray.at tray.3 0.31 -0.2",
        "nozzle.build_ms -3",
        "stall X 300st at 5.3s",
    ] {
        assert_eq!(told(text), Ok(()), "{text}");
    }
}

/// A feeder that is slow is one, not each of its parts.
#[test]
fn a_slow_feeder_is_slow() {
    let scene =
        scene(&format!("{AROUND}vary = [{{ fault = \"slow\", of = \"reel\", up_to_ms = 9 }}]\n"));
    let drawn = cell::vary::draw(&scene, 3);
    assert_eq!(drawn[0].of, "reel");
    let after = cell::vary::applied(scene.clone(), &drawn);
    assert!(after.feeders[1].advance_us > scene.feeders[1].advance_us);
}

/// A part in less than a millisecond is a slip, and a run with it never comes to its end.
#[test]
fn a_conveyor_has_a_least_gap_and_a_direction() {
    let belt = |keys: &str| {
        said(&format!(
            "part = [{{ name = \"chip\", size = [8, 8, 4] }}]\nconveyor = [{{ name = \"b\", at = [9, 9, 0], size = [9, 9, 1], feeds = \"chip\", {keys} }}]\n"
        ))
    };
    for (keys, wanted) in [
        ("mm_s = 1e4, every_ms = 0.001", "`every_ms` of conveyor \"b\" must be 1 or more"),
        (
            "mm_s = 1e4, gap = 0.01",
            "`gap` of conveyor \"b\" is 0.01: at 10000 mm/s it must be 10 or more, a part each ms",
        ),
        (
            "mm_s = -5, gap = 20",
            "`mm_s` of conveyor \"b\" is -5; it must be above 0: `along` is the direction",
        ),
        ("mm_s = 0, gap = 20", "`mm_s` of conveyor \"b\" is 0; it must be above 0"),
    ] {
        let said = belt(keys);
        assert!(said.len() == 1 && said[0].contains(wanted), "{keys}: {said:?}");
    }
    assert_eq!(belt("mm_s = 50, every_ms = 1000"), [""; 0]);
}
