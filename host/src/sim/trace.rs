//! The trace: JSON lines, one per effect, the same from every engine and from a board.
//!
//! Positions are absolute machine steps. Only `us` may differ between engines.

use std::io::{self, BufRead, Write};

use lang::axis::Axis;
use lang::fault::Fault;
use serde::{Deserialize, Serialize};

/// A value for each axis of the profile; axes that the machine lacks are absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PerAxis {
    /// X
    #[serde(rename = "X", default, skip_serializing_if = "Option::is_none")]
    pub x: Option<i32>,
    /// Y
    #[serde(rename = "Y", default, skip_serializing_if = "Option::is_none")]
    pub y: Option<i32>,
    /// Z
    #[serde(rename = "Z", default, skip_serializing_if = "Option::is_none")]
    pub z: Option<i32>,
}

impl PerAxis {
    /// Values in the order X, Y, Z.
    pub const fn new(values: [Option<i32>; 3]) -> PerAxis {
        PerAxis { x: values[0], y: values[1], z: values[2] }
    }

    /// The values in the order X, Y, Z.
    pub const fn values(&self) -> [Option<i32>; 3] {
        [self.x, self.y, self.z]
    }

    /// The axis's value.
    pub const fn get(&self, axis: Axis) -> Option<i32> {
        self.values()[axis.index()]
    }
}

/// An axis by its letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisLetter(#[serde(with = "letter")] pub Axis);

mod letter {
    use lang::axis::Axis;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde calls")]
    pub fn serialize<S: Serializer>(axis: &Axis, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_char(axis.letter())
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Axis, D::Error> {
        let letter = char::deserialize(from)?;
        Axis::from_letter(letter)
            .ok_or_else(|| D::Error::custom(format_args!("`{letter}` is no axis; X, Y, Z are")))
    }
}

/// What kind of statement moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MoveKind {
    /// MoveAxe, MoveRel.
    Axe,
    /// G0
    Rapid,
    /// G1
    Line,
    /// G2, G3
    Arc,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// END, or the text's end.
    Done,
    /// By Stop, by the limit, or because nothing could happen any more.
    Stopped,
    /// By a fault.
    Fault,
}

/// One line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Event {
    /// What happened.
    #[serde(flatten)]
    pub what: What,
    /// Simulated time, us; engines leave it out when it is not asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub us: Option<u64>,
}

/// What a line tells. `line` is the statement's, from 1.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "ev", rename_all = "lowercase")]
pub enum What {
    /// Home and `Home?`, when the outcome is known.
    Home {
        /// Line.
        line: u32,
        /// Axis.
        axis: AxisLetter,
        /// Found and left its switch.
        ok: bool,
        /// Where it rests, steps.
        pos: i32,
    },
    /// A move, when it begins.
    Move {
        /// Line.
        line: u32,
        /// Kind.
        kind: MoveKind,
        /// Commanded targets of all axes, steps.
        to: PerAxis,
    },
    /// An output is set.
    Out {
        /// Line.
        line: u32,
        /// Output number, from 1.
        n: i32,
        /// 1 or 0.
        v: u8,
        /// By SYNC, on the way of a path.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        sync: bool,
        /// The places at that moment, of one by SYNC.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pos: Option<PerAxis>,
    },
    /// An analog output gets a value.
    Aout {
        /// Line.
        line: u32,
        /// Number of the output, from 1.
        n: i32,
        /// Its value in mV, where the profile counts in these.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        mv: Option<i32>,
        /// Its value in steps of a share, where the profile counts in these.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        share: Option<i32>,
        /// By SYNC, on the way of a path.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        sync: bool,
        /// The places at that moment, of one by SYNC.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pos: Option<PerAxis>,
    },
    /// Wait, G4 and dwells, when they begin.
    Wait {
        /// Line.
        line: u32,
        /// Milliseconds.
        ms: i32,
    },
    /// WaitIn, when its outcome is known.
    WaitIn {
        /// Line.
        line: u32,
        /// Input number, from 1.
        n: i32,
        /// Wanted: 1 for ON and RISE, 0 for OFF and FALL.
        v: u8,
        /// Came in time.
        ok: bool,
    },
    /// Probe, when its outcome is known.
    Probe {
        /// Line.
        line: u32,
        /// Axis.
        axis: AxisLetter,
        /// The sensor answered.
        ok: bool,
        /// The position caught, or where the axis rests after a miss, steps.
        pos: i32,
    },
    /// PRINT
    Print {
        /// Line.
        line: u32,
        /// The whole line.
        text: String,
    },
    /// Send
    Send {
        /// Line.
        line: u32,
        /// Character.
        c: i32,
    },
    /// WaitChar, when its outcome is known.
    WaitChar {
        /// Line.
        line: u32,
        /// Character.
        c: i32,
        /// Came in time.
        ok: bool,
    },
    /// WaitStart, when Start was pressed.
    WaitStart {
        /// Line.
        line: u32,
    },
    /// MoveSpeed
    Speed {
        /// Line.
        line: u32,
        /// Axis.
        axis: AxisLetter,
        /// Signed, steps/s.
        v: i32,
    },
    /// StopAxe; StopAll writes one for each axis of the machine.
    Stop {
        /// Line.
        line: u32,
        /// Axis.
        axis: AxisLetter,
    },
    /// RUN, when the other program begins: what follows has that one's lines.
    Run {
        /// Line.
        line: u32,
        /// Name of the program, as it is called itself.
        program: String,
    },
    /// The last line.
    End {
        /// How.
        status: Status,
        /// Fault code such as `F07`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        fault: Option<String>,
        /// The fault's text.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        text: Option<String>,
        /// END's line or the last, the failing statement's, or that of the one interrupted.
        line: u32,
        /// Where the axes rest, steps.
        pos: PerAxis,
    },
}

impl What {
    /// Line of a statement that sets axes going.
    pub fn motion_line(&self) -> Option<u32> {
        match *self {
            What::Move { line, .. } | What::Speed { line, .. } => Some(line),
            _ => None,
        }
    }

    /// The end of a run.
    pub fn end(status: Status, fault: Option<Fault>, line: u32, pos: PerAxis) -> What {
        What::End {
            status,
            fault: fault.map(|fault| fault.to_string()),
            text: fault.map(|fault| fault.text().to_owned()),
            line,
            pos,
        }
    }

    /// The statement's line.
    pub const fn line(&self) -> u32 {
        match *self {
            What::Home { line, .. }
            | What::Move { line, .. }
            | What::Out { line, .. }
            | What::Aout { line, .. }
            | What::Wait { line, .. }
            | What::WaitIn { line, .. }
            | What::Probe { line, .. }
            | What::Print { line, .. }
            | What::Send { line, .. }
            | What::WaitChar { line, .. }
            | What::WaitStart { line, .. }
            | What::Speed { line, .. }
            | What::Stop { line, .. }
            | What::Run { line, .. }
            | What::End { line, .. } => line,
        }
    }
}

/// Writes one line.
///
/// # Errors
/// Whatever the writer reports.
pub fn write_line(to: &mut dyn Write, event: &Event) -> io::Result<()> {
    serde_json::to_writer(&mut *to, event)?;
    to.write_all(b"\n")
}

/// Reads a whole trace; empty lines are skipped.
///
/// # Errors
/// The reader fails, or a line is no event; the text names the line.
pub fn read(from: impl BufRead) -> io::Result<Vec<Event>> {
    let mut events = Vec::new();
    for (index, line) in from.lines().enumerate() {
        let line = line?;
        if line.trim().is_empty() {
            continue;
        }
        let event = serde_json::from_str(&line).map_err(|error| {
            let text = format!("line {} of the trace: {error}", index + 1);
            io::Error::new(io::ErrorKind::InvalidData, text)
        })?;
        events.push(event);
    }
    Ok(events)
}

/// The trace as text without times: what two engines must agree on.
pub fn to_text(events: &[Event]) -> String {
    let mut text = String::new();
    for event in events {
        let line = serde_json::to_string(&event.what).unwrap_or_else(|error| error.to_string());
        text.push_str(&line);
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{AxisLetter, Event, MoveKind, PerAxis, Status, What, read, write_line};
    use lang::axis::Axis;
    use lang::fault::Fault;

    /// The lines of the format's own description, byte for byte.
    const SPECIFIED: &str = r#"{"ev":"home","line":4,"axis":"Z","ok":true,"pos":0}
{"ev":"move","line":6,"kind":"line","to":{"X":2000,"Y":0,"Z":0}}
{"ev":"out","line":8,"n":1,"v":1}
{"ev":"wait","line":9,"ms":250}
{"ev":"waitin","line":10,"n":3,"v":1,"ok":true}
{"ev":"probe","line":12,"axis":"Z","ok":true,"pos":-1840}
{"ev":"print","line":13,"text":"hole 7"}
{"ev":"end","status":"done","line":20,"pos":{"X":0,"Y":0,"Z":0}}
"#;

    #[test]
    fn the_specified_lines_survive_reading_and_writing() {
        let events = read(SPECIFIED.as_bytes()).unwrap();
        assert_eq!(
            events[1].what,
            What::Move {
                line: 6,
                kind: MoveKind::Line,
                to: PerAxis::new([Some(2000), Some(0), Some(0)]),
            }
        );
        let mut bytes = Vec::new();
        for event in &events {
            write_line(&mut bytes, event).unwrap();
        }
        assert_eq!(String::from_utf8(bytes).unwrap(), SPECIFIED);
    }

    #[test]
    fn a_fault_carries_code_and_text_and_a_missing_axis_stays_missing() {
        let pos = PerAxis::new([Some(1), None, Some(-2)]);
        let event =
            Event { what: What::end(Status::Fault, Some(Fault::NotHomed), 7, pos), us: Some(40) };
        let mut bytes = Vec::new();
        write_line(&mut bytes, &event).unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "{\"ev\":\"end\",\"status\":\"fault\",\"fault\":\"F07\",\"text\":\"not homed\",\
             \"line\":7,\"pos\":{\"X\":1,\"Z\":-2},\"us\":40}\n"
        );
    }

    #[test]
    fn a_bad_line_is_named() {
        let error = read("\n{\"ev\":\"stop\",\"line\":1,\"axis\":\"Q\"}\n".as_bytes()).unwrap_err();
        assert!(error.to_string().starts_with("line 2 of the trace: `Q` is no axis"), "{error}");
        let letter = AxisLetter(Axis::Y);
        assert_eq!(serde_json::to_string(&letter).unwrap(), "\"Y\"");
    }
}
