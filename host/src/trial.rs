//! Preview run: simulates at each pause in typing and returns what a page needs to show the run.

pub mod budget;
pub mod lines;
pub mod pulses;
mod statements;

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;

use lang::axis::Axis;
use lang::back::Compiled;
use lang::fault::Fault;
use lang::front::source::Source;
use lang::front::words::{Func, Kw};
use lang::front::{ProfileChoice, compile};
use lang::hir::{Limits, Program, Storage, Var};
use lang::image::{Image, crc_in};
use lang::part::Part;
use lang::profile::Profile;
use lang::record::feature;
use serde_json::{Value, json};

use self::budget::{Budget, Counter};
use crate::chords;
use crate::course;
use crate::plot::{Curve, Plot, Style};
use crate::sim::record::StopReason;
use crate::sim::trace::{Event, What};
use crate::sim::world::World;
use crate::sim::{self, Engine, Outcome, SimError};

/// Points of a path that are sent; a longer path is shown up to there.
const MOST_POINTS: usize = 600_000;
/// Events that are sent.
const MOST_EVENTS: usize = 20_000;
/// Changes of variables that are sent.
const MOST_CHANGES: usize = 50_000;

/// A text that compiles.
pub struct Loaded {
    /// The checked script.
    pub program: Program,
    /// Its image and what belongs to it.
    pub compiled: Compiled,
    /// CRC of the image.
    pub crc: u16,
    /// The script's lines, for names that its comments give.
    pub text: String,
}

impl Loaded {
    /// Whether it is what a board holds that tells these.
    pub fn is(&self, bytes: u16, crc: u16) -> bool {
        (self.compiled.image.len(), self.crc) == (usize::from(bytes), crc)
    }

    /// Line of an address in the code.
    pub fn line_of(&self, pc: u16) -> u32 {
        self.compiled.sidecar.at(usize::from(pc)).map_or(0, |mark| mark.line)
    }

    /// Names, cells and units of the variables; those with AT or KEEP are an operator's, with their
    /// label and range.
    pub fn variables(&self) -> Value {
        let mut places: Vec<_> = self.compiled.vars.iter().collect();
        places.sort_by_key(|place| place.var);
        let listed = places.into_iter().filter_map(|place| {
            let var = self.program.var(place.var);
            if matches!(var.storage, Storage::Local(_)) || var.name.contains(' ') {
                return None;
            }
            let quantity = self.quantity(var);
            Some(json!({
                "name": var.name,
                "cell": place.cell,
                "len": place.len,
                "array": var.array,
                "unit": var.kind.unit().suffix(),
                "operator": quantity.is_some(),
                "before": matches!(var.storage, Storage::At(_)),
                "label": quantity.as_ref().map(|own| own.label.as_str()),
                "low": quantity.as_ref().map(|own| own.limits.least),
                "high": quantity.as_ref().map(|own| own.limits.greatest),
            }))
        });
        Value::Array(listed.collect())
    }

    /// What an operator may do with a variable: LABEL, MIN and MAX say it, or else the comment behind
    /// the declaration, `Pieces, 1..50`.
    fn quantity(&self, var: &Var) -> Option<Quantity> {
        if !matches!(var.storage, Storage::At(_) | Storage::Keep(_)) {
            return None;
        }
        let (words, range) = self.remark(var.span.start).map_or((String::new(), None), range_of);
        let named = var.panel.label.clone().or(Some(words)).filter(|label| !label.is_empty());
        let label = named.unwrap_or_else(|| var.name.clone());
        let given = var.panel.limits != Limits::default();
        let limits = if given { var.panel.limits } else { range.unwrap_or_default() };
        Some(Quantity { label, limits })
    }

    /// First cells of the quantities that are set before a run (AT) and have a range, with label and
    /// range. What KEEP holds is the program's own until it runs.
    pub fn quantities(&self) -> Vec<(u16, String, Limits)> {
        let places = self.compiled.vars.iter().filter(|place| place.len <= 1);
        let found = places.filter_map(|place| {
            let var = self.program.var(place.var);
            let Quantity { label, limits } = self.quantity(var)?;
            if !matches!(var.storage, Storage::At(_)) {
                return None;
            }
            let cell = u16::try_from(place.cell).ok()?;
            (limits != Limits::default()).then_some((cell, label, limits))
        });
        found.collect()
    }

    /// Whether a cell may be given a value: by an `operator` none but those that the script gives
    /// him, by others any; in the range that the script says.
    ///
    /// # Errors
    /// It may not; in words.
    pub fn may_set(&self, cell: u16, value: i32, operator: bool) -> Result<(), String> {
        let here = |place: &&lang::back::VarPlace| {
            (place.cell..place.cell + place.len.max(1)).contains(&u32::from(cell))
        };
        let var = self.compiled.vars.iter().find(here).map(|place| self.program.var(place.var));
        let quantity = var.and_then(|var| self.quantity(var));
        let Some(Quantity { label, limits }) = quantity else {
            let other = "this variable is not one that an operator sets";
            return if operator { Err(other.to_owned()) } else { Ok(()) };
        };
        if (limits.least..=limits.greatest).contains(&value) {
            return Ok(());
        }
        Err(format!("{label}: {} to {}", limits.least, limits.greatest))
    }

    /// The comment at the end of the line of an offset.
    fn remark(&self, at: usize) -> Option<String> {
        let rest = self.text.get(at..)?;
        let line = rest.lines().next()?;
        let (_, remark) = line.split_once('\'')?;
        Some(remark.trim().to_owned()).filter(|remark| !remark.is_empty())
    }

    /// The same for a part: arcs that it lacks are chords, and lines have slow points where it takes them. Where an arc
    /// cannot become chords all stays as it is, and the part lacks arcs.
    #[must_use]
    pub fn for_part(self, part: &Part) -> Loaded {
        let wants =
            Image::new(&self.compiled.image).map_or(0, |image| image.header.features.into());
        let mut own = self;
        if wants & !part.features & feature::ARC != 0 {
            let Ok((program, _)) = chords::drawn(&own.program) else { return own };
            let Ok(compiled) = lang::back::compile(&program) else { return own };
            own = Loaded { program, compiled, ..own };
        }
        let compiled = course::put_into(own.compiled, &own.program, part);
        Loaded { crc: crc_in(&compiled.image), compiled, ..own }
    }

    /// Whether the program runs on a part, and if not, what that lacks.
    pub fn lack(&self, part: &Part) -> Option<String> {
        let image = Image::new(&self.compiled.image).ok()?;
        part.lacks(&image, &self.program.profile).map(|lack| lack.to_string())
    }
}

/// Checks and compiles a text for a machine.
///
/// # Errors
/// It does not compile; the language server says where and why, this the first of it.
pub fn load(text: &str, choice: ProfileChoice<'_>) -> Result<Loaded, String> {
    let (source, decoding) = Source::decode("script.bas", text.as_bytes());
    if let Some(diag) = decoding.iter().find(|diag| diag.is_error()) {
        return Err(diag.message.clone());
    }
    let (program, diags) = compile(&source, choice);
    let Some(program) = program else {
        let diags = diags.into_sorted();
        let first = diags.iter().find(|diag| diag.is_error());
        return Err(first.map_or_else(
            || "the script has errors".to_owned(),
            |diag| format!("line {}: {}", source.line(diag.span.start), diag.message),
        ));
    };
    let compiled = lang::back::compile(&program).map_err(|excesses| {
        let words = excesses.iter().map(|excess| {
            let lang::back::Excess { resource, used, available, .. } = excess;
            format!("{resource:?}: {used} wanted, {available} there")
        });
        let words: Vec<String> = words.collect();
        format!("the script needs more than a board has: {}", words.join("; "))
    })?;
    let crc = crc_in(&compiled.image);
    Ok(Loaded { program, compiled, crc, text: source.text().to_owned() })
}

/// What an operator may do with a variable.
struct Quantity {
    label: String,
    limits: Limits,
}

/// A remark without its range, and that: `Pieces, 1..50`.
fn range_of(remark: String) -> (String, Option<Limits>) {
    let found = remark.split_once("..").and_then(|(left, right)| {
        let number = |c: char| c.is_ascii_digit() || c == '-';
        let (left, right) = (left.trim_end(), right.trim_start());
        let from = left.rfind(|c: char| !number(c)).map_or(0, |at| at + c_len(left, at));
        let to = right.find(|c: char| !number(c)).unwrap_or(right.len());
        let limits =
            Limits { least: left[from..].parse().ok()?, greatest: right[..to].parse().ok()? };
        let words = format!("{}{}", left[..from].trim().trim_end_matches(','), &right[to..]);
        (limits.least <= limits.greatest).then(|| (words.trim().to_owned(), limits))
    });
    match found {
        Some((words, limits)) => (words, Some(limits)),
        None => (remark, None),
    }
}

/// Bytes of the sign at a place.
fn c_len(text: &str, at: usize) -> usize {
    text[at..].chars().next().map_or(0, char::len_utf8)
}

/// A simulation as a page gets it.
pub struct Trial {
    /// Everything but the path.
    pub about: Value,
    /// The path: number of the text, then for each point time in s, X, Y, Z in mm as 32-bit floats,
    /// and a word: line in the low 24 bits, style in bits 24 to 27, bit 28: first point of a piece,
    /// bit 29: reference run. Little endian.
    pub path: Arc<Vec<u8>>,
}

/// Simulates text number `number`, or says why that cannot be. A run that the budget cuts is shown up to
/// there, or up to the end of the first turns of its outermost loop.
pub fn simulate<L: AsRef<Loaded>>(
    number: u64,
    loaded: &Result<L, String>,
    world: &World,
    part: &Part,
    budget: &Budget,
) -> Trial {
    let refused = |words: String| Trial {
        about: json!({ "number": number, "words": words }),
        path: Arc::new(number_bytes(number)),
    };
    let loaded = match loaded {
        Ok(loaded) => loaded.as_ref(),
        Err(words) => return refused(words.clone()),
    };
    let options = sim::Options { part: *part, ..sim::Options::default() };
    let nobody = World::unattended();
    let world = if world.is_empty() { &nobody } else { world };
    let counter = Counter::new(&loaded.program, &lines::with_effects(&loaded.compiled));
    let endless = counter.may_loop_for_ever();
    let (events, turns) = (Rc::new(RefCell::new(Vec::new())), Rc::new(Cell::new(None)));
    let (heard, found) = (events.clone(), turns.clone());
    let counter = RefCell::new(counter);
    let (all, told) = (budget.all, budget.told.clone());
    let sink = Box::new(move |event: &Event| {
        told(event.what.line(), event.us.unwrap_or(0));
        heard.borrow_mut().push(event.clone());
        if !all && found.get().is_none() {
            found.set(counter.borrow_mut().hear(event));
        }
    });
    let (enough, seen) = (budget.ended.clone(), turns.clone());
    let first = budget::within(Rc::new(move || seen.get().is_some() || enough(endless)), || {
        let (statements, interrupted) = (budget.statements, budget::is_over as fn() -> bool);
        let options = sim::Options { statements, interrupted, ..options };
        sim::run(&loaded.program, Engine::Vm, world, &options, sink)
    });
    let cut = |outcome: &Outcome| {
        let why = outcome.summary.stopped;
        matches!(why, Some(StopReason::Limit | StopReason::Statements | StopReason::Interrupted))
    };
    let turns = turns.get();
    let result = first.and_then(|outcome| match turns.filter(|_| cut(&outcome)) {
        // The same again up to the end of a turn.
        Some(turns) => {
            let options = sim::Options { limit_us: turns.us, ..options };
            sim::run_traced(&loaded.program, Engine::Vm, world, &options)
        }
        None => Ok((outcome, events.take())),
    });
    match result {
        Ok((outcome, events)) => {
            let plot = Plot {
                title: "script",
                source: &loaded.text,
                program: &loaded.program,
                outcome: &outcome,
            };
            let (path, shown) = path(number, &plot.curves());
            let mut about = about(number, loaded, &plot, &events, part);
            if let (Some(note), Some(notes)) = (shown, about["notes"].as_array_mut()) {
                notes.push(note.into());
            }
            about["turns"] = turns.map_or(Value::Null, |own| json!([own.turns, own.line]));
            about["all"] = budget.all.into();
            about["cut"] = (turns.is_some() || cut(&outcome)).into();
            Trial { about, path: Arc::new(path) }
        }
        Err(SimError::World(error)) => {
            refused(format!("{}:{}: {}", error.file, error.line, error.text))
        }
        Err(SimError::Engine(words)) => refused(words),
    }
}

fn number_bytes(number: u64) -> Vec<u8> {
    (number as u32).to_le_bytes().to_vec()
}

/// The path as a page takes it, and what there is to say when it is too long to be shown whole.
fn path(number: u64, curves: &[Curve]) -> (Vec<u8>, Option<String>) {
    let mut bytes = number_bytes(number);
    let mut points = 0;
    for curve in curves {
        points += curve.points.len();
        if points > MOST_POINTS {
            let from = curve.points.first().map_or(0.0, |point| point.us) / 1e6;
            let note = format!(
                "the picture shows the path up to {from:.1} s, line {}: a page takes {MOST_POINTS} points of it; the \
                 times and sums are of the whole run",
                curve.line
            );
            return (bytes, Some(note));
        }
        let style = Style::ALL.iter().position(|style| *style == curve.style).unwrap_or(0) as u32;
        // A laser's power in fourteenths and one more; 0 without a laser.
        let power = curve.power.map_or(0, |part| 1 + (part.clamp(0.0, 1.0) * 14.0).round() as u32);
        let word = (curve.line & 0xFF_FFFF)
            | style << 24
            | (power & 3) << 26
            | u32::from(curve.home) << 29
            | (power >> 2) << 30;
        for (i, point) in curve.points.iter().enumerate() {
            bytes.extend(((point.us / 1e6) as f32).to_le_bytes());
            point.at.iter().for_each(|at| bytes.extend((*at as f32).to_le_bytes()));
            bytes.extend((word | u32::from(i == 0) << 28).to_le_bytes());
        }
    }
    (bytes, None)
}

/// Axes of a machine with their travel, its inputs and outputs, as pages show them: with the names
/// that a program gives them.
pub fn machine(profile: &Profile, program: Option<&Program>) -> Value {
    let axes = profile.axes().map(|(axis, own)| {
        let mm = f64::from(own.scale.um) / f64::from(own.scale.steps) / 1000.0;
        json!({
            "axis": axis.letter(),
            "step_mm": mm,
            "low": f64::from(own.min_um) / 1000.0,
            "high": f64::from(own.max_um) / 1000.0,
            "top": f64::from(own.top_rate) * mm,
            "switch": profile.reference_input(axis),
            "home_low": own.home.direction == lang::profile::Direction::Negative,
        })
    });
    let axes: Vec<Value> = axes.collect();
    let named = |n: i32, inputs: bool| -> (Option<String>, Option<String>) {
        let name = program.and_then(|program| program.port_name(!inputs, n)).map(str::to_owned);
        if inputs {
            let own = profile.inputs.iter().find(|input| input.n == n);
            let reference = Axis::ALL
                .into_iter()
                .find(|axis| profile.axis(*axis).is_some() && profile.reference_input(*axis) == n)
                .map(|axis| format!("reference {}", axis.letter()));
            let probe = (profile.probe_input() == n).then(|| "probe".to_owned());
            let given = own.and_then(|own| own.role.as_ref()).map(role_words);
            (name.or_else(|| own?.name.clone()), given.or(reference).or(probe))
        } else {
            let own = profile.outputs.iter().find(|output| output.n == n);
            let given = own.and_then(|own| own.role.as_ref()).map(role_words);
            (name.or_else(|| own?.name.clone()), given)
        }
    };
    let list = |count: i32, inputs: bool| -> Vec<Value> {
        let rows = (1..=count).map(|n| {
            let (name, role) = named(n, inputs);
            json!({ "n": n, "name": name, "role": role })
        });
        rows.collect()
    };
    json!({
        "name": profile.name,
        "axes": axes,
        "inputs": list(profile.wiring.inputs(), true),
        "outputs": list(profile.wiring.outputs(), false),
    })
}

/// A role's name as profiles write it, with blanks.
fn role_words(role: &impl serde::Serialize) -> String {
    let name = serde_json::to_value(role).ok();
    name.as_ref().and_then(Value::as_str).unwrap_or_default().replace('_', " ")
}

fn about(number: u64, loaded: &Loaded, plot: &Plot<'_>, events: &[Event], part: &Part) -> Value {
    let Outcome { end, summary, record, .. } = plot.outcome;
    let lines = events.iter().take(MOST_EVENTS).map(|event| {
        let text = match &event.what {
            What::Print { text, .. } => Some(text.as_str()),
            _ => None,
        };
        json!([event.us, event.what.line(), text])
    });
    let rows = plot.rows().into_iter().map(|row| json!([row.name, row.output, row.on, row.n]));
    let stopped = summary.stopped.map(StopReason::text);
    let room = part.room_for(loaded.compiled.keeps > 0);
    let last = record.changes.last().filter(|_| record.truncated);
    let told = record.changes.get(MOST_CHANGES).or(last).map(|change| change.us);
    json!({
        "number": number,
        "machine": machine(&loaded.program.profile, Some(&loaded.program)),
        "end": {
            "status": end.status,
            "line": end.line,
            "fault": end.fault.map(|fault| fault.to_string()),
            "text": end.fault.map(Fault::text),
            "cause": end.fault.map(Fault::cause),
            "remedy": end.fault.map(Fault::remedy),
            "stopped": stopped,
            "why": summary.stopped,
            "onward": plot.outcome.onward,
        },
        "us": summary.us,
        "statements": summary.statements,
        "steps": summary.steps,
        "travel_um": summary.travel_um,
        "effects": lines::with_effects(&loaded.compiled),
        "bytes": loaded.compiled.image.len(),
        "room": room,
        "part": part.name,
        "lack": loaded.lack(part),
        "events": lines.collect::<Vec<_>>(),
        "rows": rows.collect::<Vec<_>>(),
        "vars": loaded.variables(),
        "changes": record.changes.iter().take(MOST_CHANGES)
            .map(|change| json!([change.us, change.cell, change.value])).collect::<Vec<_>>(),
        // Times up to which all changes and all events are there; null: to the end.
        "told_us": told,
        "heard_us": events.get(MOST_EVENTS).map(|event| event.us),
        "failures": plot.outcome.failures,
        "notes": plot.outcome.unattended.notes(&loaded.program, |line| line),
        "truncated": record.truncated,
    })
}

/// The reserved words by class, for the colours that must be there with the key, and what faults mean.
pub fn words() -> Value {
    let kw: Vec<&str> = Kw::ALL.iter().map(|kw| kw.entry().text).collect();
    let functions: Vec<&str> = Func::ALL.iter().map(|func| func.text()).collect();
    let faults: Vec<Value> = Fault::ALL
        .iter()
        .map(|fault| {
            json!({
                "code": fault.to_string(), "text": fault.text(),
                "cause": fault.cause(), "remedy": fault.remedy(),
            })
        })
        .collect();
    json!({ "words": kw, "functions": functions, "faults": faults, "statements": statements::listed() })
}

#[cfg(test)]
mod tests;
