//! What happened in a cell, in order: the cell log.

use super::scene::V3;

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// When, us.
    pub us: u64,
    /// What.
    pub what: What,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A tool took a thing.
    Take {
        /// Its name.
        thing: String,
        /// The tool's.
        by: String,
    },
    /// A tool let a thing go: it fell so far.
    Drop {
        /// Its name.
        thing: String,
        /// mm.
        mm: f64,
    },
    /// A thing came to rest on something.
    Rest {
        /// Its name.
        thing: String,
        /// Place, fixture, thing, or `table`.
        on: String,
    },
    /// A thing was lost on the way, or fell where nothing is.
    Lost {
        /// Its name.
        thing: String,
        /// Why.
        why: &'static str,
    },
    /// More than half of a thing stands over an edge.
    Unstable {
        /// Its name.
        thing: String,
    },
    /// A drill left a hole.
    Hole {
        /// X, Y in mm.
        at: [f64; 2],
        /// mm.
        depth: f64,
    },
    /// A dispenser, laser or pen drew.
    Bead {
        /// Where it began and ended.
        from: V3,
        /// See `from`.
        to: V3,
        /// Its way, mm.
        mm: f64,
        /// Its mass.
        mg: f64,
    },
    /// It was too high above the surface.
    Drip {
        /// Where.
        at: V3,
        /// mm above the surface.
        mm: f64,
    },
    /// A collision: the first of each pair.
    Hit {
        /// What moved: a tool or a held part.
        thing: String,
        /// What stood.
        with: String,
        /// Where the tip was, mm.
        pos: V3,
        /// The script's line.
        line: u32,
    },
    /// A drill broke.
    Broke {
        /// The tool.
        tool: String,
        /// Why.
        why: &'static str,
        /// Where its tip was.
        pos: V3,
        /// The script's line.
        line: u32,
    },
    /// A sensor changed.
    Sense {
        /// Its name.
        name: String,
        /// On or off.
        v: bool,
    },
}

/// A number with at most three decimals, as JSON.
fn short(number: f64) -> String {
    let rounded = (number * 1000.0).round() / 1000.0;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

fn list(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(|&number| short(number)).collect::<Vec<_>>().join(","))
}

impl Event {
    /// The event as a line of JSON. Names have no character that JSON would escape.
    #[must_use]
    pub fn json(&self) -> String {
        let rest = match &self.what {
            What::Take { thing, by } => format!(r#""ev":"take","thing":"{thing}","by":"{by}""#),
            What::Drop { thing, mm } => {
                format!(r#""ev":"drop","thing":"{thing}","mm":{}"#, short(*mm))
            }
            What::Rest { thing, on } => format!(r#""ev":"rest","thing":"{thing}","in":"{on}""#),
            What::Lost { thing, why } => format!(r#""ev":"lost","thing":"{thing}","why":"{why}""#),
            What::Unstable { thing } => format!(r#""ev":"unstable","thing":"{thing}""#),
            What::Hole { at, depth } => {
                format!(r#""ev":"hole","at":{},"depth":{}"#, list(at), short(*depth))
            }
            What::Bead { from, to, mm, mg } => {
                format!(
                    r#""ev":"bead","from":{},"to":{},"mm":{},"mg":{}"#,
                    list(from),
                    list(to),
                    short(*mm),
                    short(*mg)
                )
            }
            What::Drip { at, mm } => {
                format!(r#""ev":"drip","at":{},"mm":{}"#, list(at), short(*mm))
            }
            What::Hit { thing, with, pos, line } => {
                format!(
                    r#""ev":"hit","thing":"{thing}","with":"{with}","pos":{},"line":{line}"#,
                    list(pos)
                )
            }
            What::Broke { tool, why, pos, line } => {
                format!(
                    r#""ev":"broke","thing":"{tool}","why":"{why}","pos":{},"line":{line}"#,
                    list(pos)
                )
            }
            What::Sense { name, v } => {
                format!(r#""ev":"sense","name":"{name}","v":{}"#, u8::from(*v))
            }
        };
        format!(r#"{{"us":{},{rest}}}"#, self.us)
    }

    /// Whether it is a collision in the words of the outcomes.
    #[must_use]
    pub fn is_collision(&self) -> bool {
        matches!(self.what, What::Hit { .. } | What::Broke { .. })
    }
}
