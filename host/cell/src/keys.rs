//! The keys of a cell file: one table, from which the reader checks a file and the manual is printed.

/// What a value of a key may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A text.
    Text,
    /// A name: letters, digits, `_` and `-`, unique in the file.
    Name,
    /// `true` or `false`.
    Flag,
    /// A number within these bounds, both included.
    Number(f64, f64),
    /// A whole number within these bounds, both included.
    Count(i64, i64),
    /// `[x, y]` in mm.
    Point2,
    /// `[x, y, z]` in mm.
    Point3,
    /// `[x, y, z]` or `[x, y, z, a]`.
    Start,
    /// `[width, depth, height]` in mm, each above 0.
    Size,
    /// `[least, greatest]`.
    Range,
    /// `[columns, rows]`.
    Grid,
    /// A list of whole numbers from 1.
    Numbers,
    /// A list of texts.
    Texts,
    /// A list of points `[x, y]`.
    Points,
    /// An input, by number or name.
    Input,
    /// An output, by number or name.
    Output,
    /// An output, or an axis by its letter.
    Drive,
    /// An analog input, by number or name.
    Analog,
    /// A counter, by number or name.
    Counter,
    /// An axis by its letter.
    Axis,
    /// One of these words.
    Word(&'static [&'static str]),
    /// A list of `{ at, size }`, from the tip.
    Boxes,
    /// An advance of a conveyor's drive: any table.
    Colour,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Name of the key.
    pub name: &'static str,
    /// What its value may be.
    pub kind: Kind,
    /// `must`, `none`, or the value that holds when the key is left out, as the manual prints it.
    pub default: &'static str,
    /// What it means, with its unit.
    pub about: &'static str,
}

/// A table of the file.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// `tool` for `[[tool]]`; empty for the top of the file.
    pub name: &'static str,
    /// The word of `kind` or `shape` for which these keys are, empty for all.
    pub variant: &'static str,
    /// Whether it is a list, `[[name]]`.
    pub list: bool,
    /// Its keys.
    pub keys: &'static [Key],
}

const fn key(name: &'static str, kind: Kind, default: &'static str, about: &'static str) -> Key {
    Key { name, kind, default, about }
}

use Kind::{
    Analog, Axis, Boxes, Colour, Count, Counter, Drive, Flag, Grid, Input, Name, Number, Numbers,
    Output, Point2, Point3, Points, Range, Size, Start, Text, Texts, Word,
};

/// Far beyond every machine, mm.
const FAR: f64 = 10_000.0;
/// Times in ms: up to an hour.
const MS: Kind = Number(0.0, 3_600_000.0);
const MM: Kind = Number(0.0, FAR);
const ANY_MM: Kind = Number(-FAR, FAR);
const KPA: Kind = Number(0.0, 101.0);
const DEG: Kind = Number(-360.0, 360.0);

/// What a tool may be.
pub const TOOLS: &[&str] =
    &["vacuum", "gripper", "drill", "dispenser", "laser", "probe", "pen", "none"];
/// What a feeder may be.
pub const FEEDERS: &[&str] = &["tray", "tape", "tube", "bowl", "list"];
/// What a sensor may be.
pub const SENSORS: &[&str] = &["beam", "box", "switch", "distance", "colour"];
/// What a person may do.
pub const DEEDS: &[&str] = &["start", "stop", "estop", "input", "take", "put", "at"];
/// What may be expected.
pub const EXPECTATIONS: &[&str] = &[
    "in_place",
    "holes",
    "beads",
    "bead",
    "engraved",
    "order",
    "no_collision",
    "no_drop",
    "nothing_held",
    "nothing_on",
    "time",
    "prints",
    "ends",
    "never",
];
/// Faults that a variation may bring.
pub const FAULTS: &[&str] = &[
    "missing", "stuck", "lost", "double", "turned", "slow", "bounce", "dead_on", "dead_off",
    "stall", "pause", "stop", "estop", "door", "power", "late", "gone",
];
/// Classes of an outcome, the first that fits.
pub const OUTCOMES: &[&str] =
    &["collision", "unsafe", "hang", "fault", "wrong", "handled", "passed"];

/// All tables of a cell file, in the order of the manual.
pub const SECTIONS: &[Section] = &[
    Section {
        name: "",
        variant: "",
        list: false,
        keys: &[
            key("cell", Count(1, i64::MAX), "must", "version of this format: 1"),
            key("name", Text, "none", "a title for reports"),
            key("profile", Text, "none", "the machine, when the script names none"),
            key(
                "start",
                Start,
                "none",
                "where the head stands at power-up; 20 mm off each switch for a script that homes before it moves, else 0",
            ),
            key(
                "table",
                ANY_MM,
                "none",
                "height of the table, mm; without it a part that falls is gone",
            ),
            key("include", Texts, "none", "further cell files whose things are added"),
            key("stop_on", Texts, "[]", "`[\"collision\"]`: the first one ends the run"),
        ],
    },
    Section {
        name: "tool",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "none", "must if there are several tools"),
            key("kind", Word(TOOLS), "must", "what it is"),
            key(
                "number",
                Count(0, 99),
                "0",
                "number of the `T` word that brings it; 0: always there",
            ),
            key("tip", Point3, "[0, 0, 0]", "where its tip is from the head, mm"),
            key("body", Boxes, "[]", "boxes of its body, `at` from the tip"),
            key("output", Output, "none", "what switches it; without it the output with the role"),
            key("turn", Axis, "none", "the axis that turns it"),
        ],
    },
    Section {
        name: "tool",
        variant: "vacuum",
        list: true,
        keys: &[
            key(
                "sealed_kpa",
                KPA,
                "60",
                "pressure below ambient toward which a sealed nozzle goes",
            ),
            key("open_kpa", KPA, "8", "the same of an open nozzle"),
            key("hold_kpa", KPA, "20", "least pressure that holds a part"),
            key("build_ms", MS, "60", "time constant of the build-up"),
            key("vent_ms", MS, "15", "time constant after switching off"),
            key("leak_kpa_s", Number(0.0, 1000.0), "0", "what a held part loses in a second"),
            key("reach", MM, "1", "sideways distance from the part's middle that still seals, mm"),
            key("gap", MM, "0.2", "height above the part's top that still seals, mm"),
            key("press", MM, "1", "depth below the part's top that the nozzle gives way, mm"),
            key("hold_n", Number(0.0, 1000.0), "none", "a part is lost above this force, N"),
            key("input", Input, "none", "its pressure switch"),
            key("on_kpa", KPA, "30", "where the switch closes"),
            key("off_kpa", KPA, "25", "where it opens"),
            key("analog", Analog, "none", "its pressure sensor"),
            key("volts", Range, "[0.5, 4.5]", "the sensor's voltage at the two pressures of `kpa`"),
            key("kpa", Range, "[0, 100]", "pressures for `volts`"),
        ],
    },
    Section {
        name: "tool",
        variant: "gripper",
        list: true,
        keys: &[
            key("opens", MM, "must", "width of the open jaws, mm"),
            key("grips", Range, "must", "widths that it can hold, mm"),
            key("along", Word(&["x", "y"]), "\"x\"", "direction in which the jaws close"),
            key("open_ms", MS, "100", "time to open"),
            key("close_ms", MS, "100", "time to close"),
            key("input_closed", Input, "none", "on while the jaws have met"),
            key("input_gripped", Input, "none", "on while a part is held"),
        ],
    },
    Section {
        name: "tool",
        variant: "drill",
        list: true,
        keys: &[
            key("diameter", Number(0.01, 1000.0), "must", "mm"),
            key("flute", MM, "none", "length that cuts, mm"),
            key("spin_ms", MS, "0", "time until it turns at full speed"),
            key("plunge_max_mm_min", Number(0.0, 1e6), "none", "it breaks when plunged faster"),
        ],
    },
    Section { name: "tool", variant: "dispenser", list: true, keys: FLOW },
    Section { name: "tool", variant: "laser", list: true, keys: FLOW },
    Section { name: "tool", variant: "pen", list: true, keys: FLOW },
    Section {
        name: "tool",
        variant: "probe",
        list: true,
        keys: &[
            key("input", Input, "none", "its contact; without it the input with the role probe"),
            key("diameter", MM, "0", "of its ball, mm"),
            key("delay_us", Number(0.0, 1e6), "0", "from touch to signal"),
        ],
    },
    Section { name: "tool", variant: "none", list: true, keys: &[] },
    Section {
        name: "part",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "must", ""),
            key("shape", Word(&["box", "cylinder"]), "\"box\"", "a cylinder stands upright"),
            key("size", Size, "must", "mm"),
            key("at", Point3, "none", "middle of its bottom; without it only a kind for feeders"),
            key("corner", Point3, "none", "least X, Y, Z instead of `at`"),
            key("turn_deg", DEG, "0", "counter-clockwise"),
            key("mass_g", Number(0.0, 1e6), "1", ""),
            key("colour", Colour, "\"#b0b8c0\"", "in the picture, and for a colour sensor"),
            key("metal", Flag, "true", "for a reader: no sensor asks for it yet"),
        ],
    },
    Section {
        name: "feeder",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "must", ""),
            key("part", Text, "must", "what it holds: the name of a part"),
            key("kind", Word(FEEDERS), "\"tray\"", ""),
            key(
                "at",
                Point3,
                "none",
                "place of its first part: middle of the bottom; must but for a list",
            ),
            key("turn_deg", DEG, "0", "how its parts lie"),
            key("pitch", Point2, "[0, 0]", "from a part to the next in X and in Y, mm"),
            key("count", Grid, "[1, 1]", "columns and rows of a tray"),
            key("empty", Numbers, "[]", "pockets without a part, row by row from 1"),
            key("output", Output, "none", "what advances a tape, a tube or a bowl"),
            key("advance_ms", MS, "100", "time of an advance"),
            key("input", Input, "none", "on while a part is ready"),
            key("length", Count(0, 1_000_000), "none", "parts in it; without it endless"),
            key("spread", MM, "0", "a bowl's parts lie within this of the place, mm"),
            key("spread_deg", Number(0.0, 180.0), "0", "and are turned by up to this"),
            key("file", Text, "none", "a list: Ref Val Package PosX PosY Rot Side"),
            key("offset", Point2, "[0, 0]", "added to the places of the file, mm"),
        ],
    },
    Section {
        name: "place",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "must", ""),
            key("at", Point3, "must", "middle of its bottom"),
            key("size", Size, "must", "mm"),
            key("room", Count(0, 1_000_000), "1", "parts that it takes; 0: any number"),
            key("reject", Flag, "false", "whether what lies here was rejected on purpose"),
        ],
    },
    Section {
        name: "fixture",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "must", ""),
            key("size", Size, "must", "mm"),
            key("at", Point3, "none", "middle of its bottom"),
            key("corner", Point3, "none", "least X, Y, Z instead of `at`"),
            key("shape", Word(&["box", "cylinder"]), "\"box\"", ""),
            key("turn_deg", DEG, "0", "a turned box is tested as `slices`"),
            key(
                "slices",
                Count(1, 64),
                "8",
                "boxes along X that a turned or round fixture is cut into",
            ),
            key("solid", Flag, "true", "whether running into it is a collision"),
            key("opens_by", Output, "none", "a door or clamp: the output that opens it"),
            key("open_at", Point3, "none", "where it stands when open"),
            key("move_ms", MS, "0", "time that this takes"),
        ],
    },
    Section {
        name: "stock",
        variant: "",
        list: false,
        keys: &[
            key("at", Point3, "must", "middle of its bottom"),
            key("size", Size, "must", "mm"),
            key("grid", Number(0.01, 100.0), "0.5", "of the picture, mm"),
            key("tilt", Point2, "[0, 0]", "slope of its top: dz/dx, dz/dy"),
            key("heights", Text, "none", "a file of x y z instead of `tilt`"),
            key("touch", Input, "none", "on while a probe or tool touches it"),
        ],
    },
    Section {
        name: "conveyor",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "must", ""),
            key("at", Point3, "must", "middle of its bottom"),
            key("size", Size, "must", "mm"),
            key("along", Word(&["x", "y", "-x", "-y"]), "\"x\"", "direction in which it carries"),
            key("drive", Drive, "none", "an output, or an axis; without it it always runs"),
            key("mm_s", Number(-FAR, FAR), "none", "speed while its output is on"),
            key("ramp_ms", MS, "0", "time to that speed"),
            key("counter", Counter, "none", "its encoder"),
            key("counts_mm", Number(0.001, 1e6), "none", "counts of the encoder in a mm"),
            key("feeds", Text, "none", "name of the part that comes onto it"),
            key("every_ms", MS, "none", "a part each so many ms of running"),
            key("gap", MM, "none", "or a part each so many mm"),
            key("takes", Text, "none", "name of the place behind its end"),
        ],
    },
    Section {
        name: "sensor",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "must", ""),
            key("kind", Word(SENSORS), "must", ""),
            key("from", Point3, "none", "beam, distance: where it begins"),
            key("to", Point3, "none", "beam, distance: where it ends"),
            key("at", Point3, "none", "box: middle of its bottom; colour: where it looks"),
            key("size", Size, "none", "box"),
            key("axis", Axis, "none", "switch: the axis"),
            key("place", ANY_MM, "none", "switch: where it closes, mm"),
            key("side", Count(-1, 1), "1", "switch: 1 closed above the place, -1 below"),
            key("colour", Colour, "none", "colour: what it answers to"),
            key("input", Input, "none", "what it drives"),
            key("analog", Analog, "none", "distance: what it drives"),
            key("volts", Range, "[0, 3]", "distance: voltage at the begin and at the end"),
            key("sees", Texts, "[\"part\"]", "part, tool, held"),
            key("on_ms", MS, "0", "delay when it comes on"),
            key("off_ms", MS, "0", "delay when it goes off"),
            key("bounce_ms", MS, "0", "it bounces so long at each change"),
            key("invert", Flag, "false", "on while it sees nothing"),
        ],
    },
    Section {
        name: "person",
        variant: "",
        list: true,
        keys: &[
            key("name", Name, "none", ""),
            key("does", Word(DEEDS), "must", ""),
            key("at_s", Number(0.0, 1e7), "none", "at this time of the run"),
            key("when", Text, "none", "or at this: wait_start, PLACE full, print TEXT"),
            key("after_s", Number(0.0, 1e6), "0", "so long after it"),
            key("hold_ms", MS, "100", "how long a button or input is held"),
            key("input", Input, "none", "does = input"),
            key("thing", Text, "none", "does = take, put"),
            key("register", Count(3000, 65534), "none", "does = at: register of an AT variable"),
            key("value", Number(-2_147_483_648.0, 2_147_483_647.0), "0", "does = at"),
            key("times", Count(1, 1_000_000), "1", "how often"),
        ],
    },
    Section {
        name: "expect",
        variant: "",
        list: true,
        keys: &[
            key("what", Word(EXPECTATIONS), "must", ""),
            key("name", Text, "none", "in the report; made from `what` when left out"),
            key("within", Number(0.0, FAR), "none", "tolerance, mm"),
            key("place", Text, "none", "in_place: name of the place"),
            key("of", Text, "none", "in_place, order: feeder or part"),
            key("count", Count(0, 1_000_000), "none", "how many"),
            key("turn_within_deg", Number(0.0, 180.0), "none", "in_place: tolerance of the angle"),
            key("at", Points, "none", "holes: their places"),
            key("file", Text, "none", "holes, engraved: a file of what is wanted"),
            key("depth", MM, "none", "holes: least depth, mm"),
            key("diameter", MM, "none", "holes: of the drill, mm"),
            key("mg", Number(0.0, 1e6), "none", "beads: mass of each"),
            key("mg_within", Number(0.0, 1e6), "none", "beads: its tolerance"),
            key("from", Point2, "none", "bead: where it begins"),
            key("to", Point2, "none", "bead: where it ends"),
            key("mg_mm", Number(0.0, 1e6), "none", "bead: mass along the way"),
            key("places", Texts, "none", "order: the places in their order"),
            key("below_s", Number(0.0, 1e7), "none", "time: the longest allowed"),
            key("text", Text, "none", "prints: text; ends: done or a fault"),
            key("sensor", Text, "none", "never: a sensor that must not come on"),
        ],
    },
    Section {
        name: "vary",
        variant: "",
        list: true,
        keys: &[
            key("key", Text, "none", "the number that varies: `nozzle.build_ms`, `tray.at`"),
            key("sigma", Number(0.0, FAR), "none", "standard deviation, in the key's unit"),
            key("range", Range, "none", "or least and greatest difference"),
            key("share", Number(0.0, 10.0), "none", "or standard deviation as a part of the value"),
            key("each", Flag, "false", "every thing of a feeder by itself"),
            key("fault", Word(FAULTS), "none", "or an event"),
            key("of", Text, "none", "the thing that it strikes"),
            key("chance", Number(0.0, 1.0), "0", "for each thing, or each run"),
            key("up_to_ms", MS, "none", "stuck, slow, bounce, late"),
            key("steps", Count(-1_000_000, 1_000_000), "none", "stall: steps lost"),
            key(
                "within_s",
                Number(0.0, 1e6),
                "none",
                "pause, stop, estop, door, power, gone: drawn from this time",
            ),
        ],
    },
];

const FLOW: &[Key] = &[
    key("flow_mg_s", Number(0.0, 1e6), "must", "mass in a second while it is open"),
    key("open_ms", MS, "0", "delay of the valve when it opens"),
    key("close_ms", MS, "0", "the same when it closes"),
    key("reach", MM, "2", "height above the surface from which it drips, mm"),
    key("width", MM, "1", "in the picture, mm"),
];

/// The keys of a table: those of every variant, then those of this one.
pub fn keys_of<'a>(section: &'a str, variant: &'a str) -> impl Iterator<Item = &'static Key> + 'a {
    SECTIONS
        .iter()
        .filter(move |row| {
            row.name == section && (row.variant.is_empty() || row.variant == variant)
        })
        .flat_map(|row| row.keys)
}

/// The tables of a file: their names and whether each is a list.
pub fn tables() -> impl Iterator<Item = (&'static str, bool)> {
    SECTIONS
        .iter()
        .filter(|row| !row.name.is_empty() && row.variant.is_empty())
        .map(|row| (row.name, row.list))
}

/// The table of all keys as Markdown, for the manual.
#[must_use]
pub fn manual() -> String {
    let mut out = String::from("| table | key | default | meaning |\n|---|---|---|---|\n");
    for row in SECTIONS {
        let table = match (row.name, row.variant, row.list) {
            ("", _, _) => "top".to_owned(),
            (name, "", true) => format!("`[[{name}]]`"),
            (name, "", false) => format!("`[{name}]`"),
            (_, variant, _) => variant.to_owned(),
        };
        for key in row.keys {
            let default = match key.default {
                "must" | "none" => key.default.to_owned(),
                value => format!("`{value}`"),
            };
            out += &format!("| {table} | `{}` | {default} | {} |\n", key.name, key.about);
        }
    }
    out
}
