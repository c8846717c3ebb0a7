//! Messages between page and server: JSON objects of one name and its values.

use import::pattern::Pattern;
use import::pattern::table::Row;
use lang::axis::Axis;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::programs::Holds;
use super::setup::TrialWish;
use crate::helm::{Entry, Picture};
use crate::sim::trace::AxisLetter;
use crate::trial::pulses::Pulse;

/// What a page says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FromPage {
    /// Comes back with the answer.
    #[serde(default)]
    pub ask: u32,
    /// What it wants.
    #[serde(rename = "do")]
    pub wish: Wish,
}

/// What a page wants.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Wish {
    /// The answer to the challenge; the first message.
    Hello {
        /// [`super::gate::proof`].
        proof: String,
    },
    /// To have the helm, or to give it up.
    Helm(bool),
    /// Stop everything; anybody may.
    Stop,
    /// A request or notification of the Language Server Protocol.
    Lsp(Value),
    /// The script's text, made from the one with number `base`.
    Text {
        /// Number of the text that it was made from.
        base: u64,
        /// All of it.
        text: String,
    },
    /// Write the script to its file, or to this one beside it.
    Save(Option<String>),
    /// Open another script of the folder.
    Open(String),
    /// Take the file's text although this one is newer (true), or keep this one (false).
    Reload(bool),
    /// Write a text to a new script of the folder, and open it.
    New {
        /// Its file's name.
        name: String,
        /// All of it.
        text: String,
    },
    /// Take a file that the page brings as a new script; of other systems' programs one is made.
    Take {
        /// Its name.
        name: String,
        /// All of it.
        text: String,
    },
    /// Where the resting machine stands, in its own steps.
    Place,
    /// The tables of places in the text.
    Tables,
    /// What to write so that the text has this table of places.
    Table(TableWish),
    /// Read the places of a file: a list, positions of parts, or a drill file.
    Points {
        /// The file's name.
        name: String,
        /// All of it.
        text: String,
    },
    /// Write a pattern as a script, or as a piece of this one.
    Pattern {
        /// What is to be written.
        pattern: Box<Pattern>,
        /// A piece of the text.
        into: bool,
    },
    /// Simulate the text for a moment, and show the first turns of an endless loop.
    Simulate,
    /// Simulate the text as long as that is bearable, and show all of it.
    SimulateAll,
    /// The pulses of inputs that are drawn in the simulation now, all of them.
    Pulses(Vec<Pulse>),
    /// Compile the text and bring it to the board.
    Upload,
    /// Compile the text and feed it to the board, piece by piece.
    Stream,
    /// The same from a line on. Without `way` nothing moves, and the answer says how the board comes there.
    StreamFrom {
        /// From 1.
        line: u32,
        /// The way as the page has shown it; the board goes no other one.
        #[serde(default)]
        way: Option<String>,
    },
    /// Compile another script of the folder and bring it to the board.
    Bring(String),
    /// The programs that the board holds.
    Library,
    /// Start runs the program of this number from now on.
    Choose(u8),
    /// Erase the program of this number.
    Erase(u8),
    /// Give the board the script's machine.
    Profile,
    /// Start the stored program, release WaitStart, or acknowledge a fault.
    Start,
    /// The same; what begins is the program that the page shows, or nothing.
    Run(Shown),
    /// Start it and follow it effect by effect.
    Debug {
        /// Lines to halt at.
        breaks: Vec<u32>,
        /// Halt at the first effect.
        step: bool,
    },
    /// Go on from a halt: to the next effect, or to the next breakpoint.
    Go {
        /// To the next effect.
        step: bool,
    },
    /// Other breakpoints.
    Breaks(Vec<u32>),
    /// Pause the run.
    Pause,
    /// Go on with a paused run.
    Resume,
    /// Override of feeds and rapid moves, per cent.
    Override([u16; 2]),
    /// Set a variable of the stored program.
    Set {
        /// Its first cell, or that of an array's element.
        cell: u16,
        /// The value.
        value: i32,
    },
    /// Begin a held jog.
    Hold(HoldWish),
    /// Keep it alive.
    Keep {
        /// Its number.
        id: u64,
        /// Number of the newest state that the page has drawn.
        echo: u64,
    },
    /// End it.
    Release(u64),
    /// Move an axis by a distance, um.
    Jog(MoveWish),
    /// Move an axis to a work position, um.
    GoTo(MoveWish),
    /// The axis's present place becomes its work position 0.
    Zero(AxisLetter),
    /// Reference axes one after the other; without any the machine's order.
    Home(Vec<AxisLetter>),
    /// Probe along an axis by at most a distance, um.
    Probe(MoveWish),
    /// Switch an output.
    Output(u16, bool),
    /// Close or open an input's contact (virtual), or force it; null sets it free.
    Input(u16, Option<bool>),
    /// Press a button of the virtual board.
    Press {
        /// Stop instead of Start.
        stop: bool,
        /// Pressed.
        down: bool,
    },
    /// The set-up of a machine.
    Setup(SetupWish),
    /// End the tool.
    Quit,
}

/// The board's program as a page shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// Length of its image.
    pub bytes: u16,
    /// CRC of its image.
    pub crc: u16,
}

/// A wish of a set-up.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum SetupWish {
    /// How far it is, or with what one can begin.
    Look,
    /// Take one up again, or begin it.
    Open {
        /// The machine's name.
        name: String,
        /// The machine that a new one is like.
        base: Option<String>,
    },
    /// Leave it; it can be taken up again.
    Close,
    /// A JSON merge patch of the profile.
    Change(Value),
    /// A length that was asked for and measured, um.
    Scale {
        /// The axis.
        axis: AxisLetter,
        /// What was asked for.
        asked_um: i64,
        /// What was measured.
        measured_um: i64,
    },
    /// A step is done; of the emergency stop the board must say so.
    Done {
        /// Its name.
        step: String,
        /// What was found.
        words: String,
    },
    /// Bring the machine to the board.
    Apply,
    /// Try a rate and a ramp.
    Trial(TrialWish),
    /// Write profile and report.
    Finish {
        /// The day, as the person writes it.
        when: String,
        /// Also where the emergency stop was not tried.
        #[serde(default)]
        untried_stop: bool,
    },
}

/// A held jog.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HoldWish {
    /// Its number, larger than that of each before.
    pub id: u64,
    /// The axis.
    pub axis: AxisLetter,
    /// Toward larger positions.
    pub positive: bool,
    /// um/s.
    pub speed: u32,
    /// Machine position that it does not go beyond, steps.
    #[serde(default)]
    pub to: Option<i32>,
}

/// A table of places as it shall be.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableWish {
    /// Its name.
    pub name: String,
    /// Columns, 1 to 3.
    pub columns: usize,
    /// The comment on its first line.
    #[serde(default)]
    pub remark: String,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// A move of one axis.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MoveWish {
    /// The axis.
    pub axis: AxisLetter,
    /// Distance or place, um.
    pub um: i32,
    /// um/s.
    pub speed: u32,
}

impl MoveWish {
    /// The axis.
    pub const fn axis(&self) -> Axis {
        self.axis.0
    }
}

/// What the server says.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ToPage {
    /// Prove that you know the secret.
    Challenge(String),
    /// What does not change.
    Welcome(Box<Welcome>),
    /// Something was done; what comes of it shows in the state.
    Done {
        /// The wish's number.
        ask: u32,
        /// What there is to say.
        #[serde(skip_serializing_if = "Option::is_none")]
        words: Option<String>,
    },
    /// What was asked for.
    Answer {
        /// The wish's number.
        ask: u32,
        /// It.
        value: Value,
    },
    /// Something was not done.
    Refused {
        /// The wish's number.
        ask: u32,
        /// Why, and what to do.
        words: String,
    },
    /// How far something is, 0 to 1.
    Progress {
        /// The wish's number.
        ask: u32,
        /// How far.
        part: f32,
    },
    /// How things stand.
    State(Box<State>),
    /// What happened.
    Log(Vec<Entry>),
    /// The script's text, which is not the one that this page has.
    Text(Text),
    /// A message of the Language Server Protocol.
    Lsp(Value),
    /// How far a simulation is.
    Simulating {
        /// Number of its text.
        number: u64,
        /// The furthest line that it came to, and how many the text has.
        line: u32,
        /// See `line`.
        lines: usize,
        /// Simulated time, us.
        us: u64,
    },
    /// What came of a simulation; its path is the next message, in bytes.
    Simulated(Value),
    /// Names and places of the stored program's variables.
    Program(Value),
    /// A held jog is over.
    Ended {
        /// Its number.
        id: u64,
        /// Why.
        words: String,
    },
    /// The tool ends.
    Bye,
}

/// What does not change while the tool runs.
#[derive(Clone, Debug, Serialize)]
pub struct Welcome {
    /// Version of the tool.
    pub version: &'static str,
    /// The board is a virtual one: its inputs can be clicked.
    pub virtual_board: bool,
    /// Only what a person at the machine needs.
    pub operator: bool,
    /// Port, or the part that is emulated.
    pub board: String,
    /// Reserved words by class: `words`, `functions`.
    pub words: Value,
    /// Capabilities of the language server.
    pub lsp: Value,
    /// The machine for scripts that name none.
    pub machine: Value,
    /// Scripts of the folder.
    pub files: Vec<String>,
    /// The newest simulation, if there is one.
    pub text: Text,
}

/// The script.
#[derive(Clone, Debug, Serialize)]
pub struct Text {
    /// Counts its changes.
    pub number: u64,
    /// Name of its file; none yet for a new one.
    pub file: Option<String>,
    /// All of it.
    pub text: String,
    /// It differs from its file.
    pub dirty: bool,
    /// The file was changed by another program meanwhile.
    pub conflict: bool,
    /// It is too long to be changed by a page.
    pub fixed: bool,
}

/// How things stand.
#[derive(Clone, Debug, Serialize)]
pub struct State {
    /// Number of this message for this page.
    pub n: u64,
    /// The board.
    pub picture: Picture,
    /// Line that runs, where the stored program is known.
    pub line: Option<u32>,
    /// This page has the helm.
    pub mine: bool,
    /// Another page has it.
    pub taken: bool,
    /// Pages that look on.
    pub pages: usize,
    /// Inputs whose contact a hand has closed on the virtual board.
    pub closed: Vec<u16>,
    /// The stored program is the present text's.
    pub current: bool,
    /// Which program the board holds, if it holds one.
    pub holds: Option<Holds>,
    /// The trial of a set-up that is under way, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial: Option<String>,
    /// The job that is fed to the board.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stream: Option<super::streamed::Shown>,
}

/// A message as it goes over the line.
pub fn text(message: &ToPage) -> String {
    serde_json::to_string(message).unwrap_or_else(|error| {
        // Only a value without a JSON form could do that, and none of ours lacks one.
        format!("{{\"refused\":{{\"ask\":0,\"words\":\"{error}\"}}}}")
    })
}

#[cfg(test)]
mod tests {
    use super::{FromPage, Wish};

    #[test]
    fn messages_are_read_strictly() {
        let read = |text: &str| serde_json::from_str::<FromPage>(text);
        let stop = read(r#"{"ask":3,"do":"stop"}"#).expect("a message");
        assert!(matches!((stop.ask, stop.wish), (3, Wish::Stop)));
        let hold = r#"{"do":{"hold":{"id":1,"axis":"X","positive":true,"speed":5000}}}"#;
        assert!(matches!(read(hold).expect("a message").wish, Wish::Hold(_)));
        for wrong in [
            "",
            "null",
            r#"{"do":"stopp"}"#,
            r#"{"do":"stop","and":1}"#,
            r#"{"do":{"hold":{"id":1,"axis":"W","positive":true,"speed":5}}}"#,
            r#"{"do":{"hold":{"id":-1,"axis":"X","positive":true,"speed":5}}}"#,
            r#"{"do":{"hold":{"id":1,"axis":"X","positive":true,"speed":5,"x":0}}}"#,
            r#"{"do":{"output":[1]}}"#,
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
