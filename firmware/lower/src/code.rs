//! Micro-code of functions: statements. [`value`] makes values, [`store`] puts them by, [`cond`] makes conditions,
//! [`branch`] and [`ways`] what follows of them, [`end`] ends, [`within`] what stands within other code, [`state`] keeps
//! what is known along the way, which is what makes it short.

mod branch;
mod cond;
mod end;
mod state;
mod store;
mod value;
mod ways;
mod within;

use std::collections::{BTreeMap, BTreeSet};

use crate::Refused;
use crate::leaf::Type;
use crate::ops::{Line, Op, routine};
use crate::tree::{
    Call, Cond, End, Expr, Function, Size, Stmt, Tried, Var, Vars, live, live_in_loop,
};
use branch::always;
use state::{Held, Record, State};

/// Where a word is made that bits are put into.
const WORD: [&str; 2] = ["TEMP", "TEMP+1"];

/// What r9 is when it is the axis's own record.
const OWN_RECORD: &str = "axis";

/// Why code cannot be made as it stands.
#[derive(Debug)]
enum Stop {
    /// Ways meet that have put a variable into different places.
    Lost(Var),
    /// It is not to be made.
    Refused(Refused),
}

type Made<T> = Result<T, Stop>;

/// A function while its code is made.
struct Writer<'a> {
    function: &'a Function,
    /// Those of the file.
    functions: &'a [Function],
    /// Where one ends whose code stands within this one.
    within: Option<String>,
    /// The file's name, in labels.
    file: &'a str,
    lines: Vec<Line>,
    labels: &'a mut usize,
    state: State,
    /// What is known on each way to a label.
    ways: BTreeMap<String, Vec<State>>,
    /// Where variables are put by.
    slots: BTreeMap<Var, String>,
    /// Places that were written: none is put by there any more.
    written: BTreeSet<String>,
    /// Ends with a fault.
    faults: BTreeMap<String, String>,
    /// Ends of jumps whose flag is the result.
    known: BTreeMap<bool, String>,
    /// The symbol of the parts that have what is made now.
    when: Option<String>,
    /// Where the next turn of each loop around is, and the variables that it needs.
    turns: Vec<(String, Vars)>,
}

/// The code of a function. With `zero` r12 is 0 when it begins.
///
/// # Errors
/// There is none.
pub fn write(
    function: &Function,
    functions: &[Function],
    file: &str,
    labels: &mut usize,
    zero: bool,
) -> Result<Vec<Line>, Refused> {
    let mut writer = Writer {
        function,
        functions,
        within: None,
        file,
        lines: Vec::new(),
        labels,
        state: State { zero, ..State::default() },
        ways: BTreeMap::new(),
        slots: BTreeMap::new(),
        written: BTreeSet::new(),
        faults: BTreeMap::new(),
        known: BTreeMap::new(),
        when: None,
        turns: Vec::new(),
    };
    match writer.all() {
        Ok(()) => Ok(writer.lines),
        Err(Stop::Refused(refused)) => Err(refused),
        Err(Stop::Lost(_)) => {
            Err(Refused { line: function.line, text: "a variable is in two places".into() })
        }
    }
}

impl<'a> Writer<'a> {
    fn refuse<T>(&self, text: impl AsRef<str>) -> Made<T> {
        let text = format!("{}: {}", self.function.name, text.as_ref());
        Err(Stop::Refused(Refused { line: self.function.line, text }))
    }

    /// The variables that statements need here, when behind them those of `out` are.
    fn live(&self, stmts: &[Stmt], out: &Vars) -> Vars {
        let none = Vars::new();
        live(stmts, out, self.turns.last().map_or(&none, |(_, needed)| needed))
    }

    fn label(&mut self) -> String {
        *self.labels += 1;
        format!(".L{}_{}", self.file, self.labels)
    }

    /// An operation that jumps nowhere.
    fn op(&mut self, text: &str) {
        self.put(Op::read(text));
    }

    /// One that may jump.
    fn jump(&mut self, text: &str, label: &str) {
        if self.state.dead {
            return;
        }
        let mut way = self.state.on_way();
        way.equal = match text {
            "IF_EQUAL" => Some(true),
            "IF_NOT_EQUAL" => Some(false),
            _ => None,
        };
        self.ways.entry(label.to_owned()).or_default().push(way);
        self.put(Op::read(text).to(label));
    }

    fn put(&mut self, mut op: Op) {
        if !self.state.dead {
            self.state.after(&op);
            op.when.clone_from(&self.when);
            self.lines.push(Line::Op(op));
        }
    }

    /// Ways meet; behind it `out` are needed.
    fn place(&mut self, label: &str, out: &Vars) -> Made<()> {
        self.lines.push(Line::Label(label.to_owned(), false));
        let mut ways = self.ways.remove(label).unwrap_or_default();
        if !self.state.dead {
            ways.push(self.state.on_way());
        }
        let Some(first) = ways.pop() else {
            self.state.dead = true;
            return Ok(());
        };
        let met = ways.iter().fold(first, State::meet);
        self.state = met;
        self.kept(out)
    }

    /// Variables of `out` can be had.
    fn kept(&self, out: &Vars) -> Made<()> {
        for &var in out {
            let kind = self.function.vars[var];
            if matches!(kind, Type::Byte | Type::Long) && !self.state.has(var) {
                return Err(Stop::Lost(var));
            }
        }
        Ok(())
    }

    /// Where a variable is put by.
    fn slot(&mut self, var: Var, out: &Vars) -> Made<String> {
        if let Some(slot) = self.slots.get(&var) {
            return Ok(slot.clone());
        }
        let function = self.function;
        let places = match function.vars[var] {
            Type::Byte => &function.bytes,
            _ => &function.longs,
        };
        let taken = self.slots.iter().filter(|(other, _)| out.contains(other));
        let taken = taken.map(|(_, slot)| slot).collect::<BTreeSet<_>>();
        let Some(slot) = places.iter().find(|slot| !taken.contains(slot)).cloned() else {
            return self.refuse("no room for a variable: micro(longs = .., bytes = ..)");
        };
        self.slots.insert(var, slot.clone());
        Ok(slot)
    }

    /// The variable in the accumulator is put by.
    fn put_by(&mut self, var: Var, out: &Vars) -> Made<()> {
        let slot = self.slot(var, out)?;
        if self.written.contains(&slot) {
            return self
                .refuse(format!("a variable is put by in {slot}, which the function has written"));
        }
        for other in self.slots.iter().filter(|(other, at)| **at == slot && **other != var) {
            self.state.stored.remove(other.0);
        }
        self.state.forget(&slot);
        if self.function.vars[var] == Type::Byte {
            self.op(&format!("PUT {slot}"));
        } else {
            self.op(&format!("F store {slot}"));
        }
        self.state.stored.insert(var);
        Ok(())
    }

    /// The accumulator is about to change: variables of `out` that are nowhere else are put by.
    fn clobber(&mut self, out: &Vars) -> Made<()> {
        if self.state.dead {
            return Ok(());
        }
        for var in self.state.alone() {
            if out.contains(&var) {
                self.put_by(var, out)?;
            }
        }
        Ok(())
    }

    /// The same where a value is about to be read: no other takes its place.
    fn clobber_but(&mut self, value: &Expr, out: &Vars) -> Made<()> {
        let mut kept = out.clone();
        if self.state.alone().iter().any(|var| out.contains(var)) {
            value.vars(&mut kept);
        }
        self.clobber(&kept)
    }

    fn all(&mut self) -> Made<()> {
        let function = self.function;
        self.lines.push(Line::Label(function.label.clone(), true));
        if function.entry {
            let begins = function.begins.iter().map(|text| format!("    {text}\n"));
            self.lines.push(Line::Check(begins.chain([String::from("    MICRO")]).collect()));
        }
        self.state.first = true;
        let row = routine(&function.label);
        let named = function.record.clone().filter(|name| name != OWN_RECORD);
        self.state.record = named.map(Record::Named);
        for &(var, kind) in &function.takes {
            match kind {
                Type::Axis => match row {
                    Some(row) if row.needs.is_empty() => {
                        self.op("DO axis_select");
                        self.state.axis = Some(var);
                        self.state.record = Some(Record::Axis(var));
                    }
                    row => {
                        if row.is_none_or(|row| row.needs.contains('a')) {
                            self.state.axis = Some(var);
                        }
                        let own = function.record.as_deref() == Some(OWN_RECORD);
                        if own || row.is_some_and(|row| row.needs.contains('r')) {
                            self.state.record = Some(Record::Axis(var));
                        }
                    }
                },
                Type::Bool => {}
                _ => {
                    self.state.held.insert(Held::Var(var));
                }
            }
        }
        self.block(&function.body, &Vars::new())?;
        if !self.state.dead {
            return self.refuse("an end is missing");
        }
        for (fault, label) in std::mem::take(&mut self.faults) {
            self.place(&label, &Vars::new())?;
            self.fail(&fault);
        }
        for (so, label) in std::mem::take(&mut self.known) {
            self.place(&label, &Vars::new())?;
            self.end_known(so)?;
        }
        Ok(())
    }

    fn block(&mut self, stmts: &[Stmt], out: &Vars) -> Made<()> {
        let gives_axis = self.function.gives == Type::Axis;
        let mut rest = stmts;
        while let Some((stmt, behind)) = rest.split_first() {
            if self.state.dead {
                break;
            }
            rest = behind;
            if let (Stmt::Word(_, Expr::Number(zero)), Some((next, behind))) =
                (stmt, rest.split_first())
                && zero.value == Some(0)
                && let Some((byte, mask, bit)) = first_bit(next)
            {
                // The byte's bit is the word's: it comes over as it is.
                self.same(mask, bit);
                self.op(&format!("GET {byte}"));
                self.op(&format!("ANDI {mask}"));
                self.op(&format!("F put {}", WORD[0]));
                rest = behind;
                continue;
            }
            if let (Stmt::Call(call, Tried::Ends), [Stmt::Return(End::Done)]) = (stmt, rest)
                && call.gives == Type::Fault
                && !call.sure
            {
                // What it returns is what is returned.
                return self.last_call(call);
            }
            if let (Stmt::Call(call, Tried::Never), [Stmt::Return(End::Value(Expr::Var(axis)))]) =
                (stmt, rest)
                && gives_axis
                && call.axis == Some(*axis)
                && self.keeps_pointers(call)
            {
                // The axis is where it was.
                return self.last_call(call);
            }
            if let (Stmt::If(cond, then, other), false) = (stmt, rest.is_empty())
                && let Some(call) = self.number_first(cond, then, other)
            {
                // The number stands in front of the jump, which then goes to the rule itself.
                let out = self.live(rest, out);
                self.again(&mut |writer| writer.goes_with(cond, call, &out), &out)?;
                continue;
            }
            let out = self.live(rest, out);
            self.again(&mut |writer| writer.stmt(stmt, &out), &out)?;
        }
        Ok(())
    }

    /// The assembler sees to it that a bit is what the leaf says.
    fn same(&mut self, mask: &str, bit: u16) {
        let check = format!("    .if {mask} != {bit}\n    .error \"a leaf's bit\"\n    .endif");
        self.lines.push(Line::Check(check));
    }

    /// Once more with a variable put by that the ways of it would put into different places.
    fn again(&mut self, make: &mut dyn FnMut(&mut Self) -> Made<()>, out: &Vars) -> Made<()> {
        loop {
            let before = (
                self.lines.len(),
                self.state.clone(),
                self.ways.clone(),
                self.slots.clone(),
                self.faults.clone(),
            );
            match make(self) {
                Err(Stop::Lost(var)) if before.1.held.contains(&Held::Var(var)) => {
                    self.lines.truncate(before.0);
                    (self.state, self.ways, self.slots, self.faults) =
                        (before.1, before.2, before.3, before.4);
                    let mut out = out.clone();
                    out.insert(var);
                    self.put_by(var, &out)?;
                }
                made => return made,
            }
        }
    }

    fn stmt(&mut self, stmt: &Stmt, out: &Vars) -> Made<()> {
        match stmt {
            Stmt::Set(var, value) => {
                let mut kept = out.clone();
                kept.remove(var);
                self.value(value, &kept)?;
                self.state.set(*var);
            }
            Stmt::Word(_, value) => self.word(value, out)?,
            Stmt::Or(_, value) => self.or(value, out)?,
            Stmt::Axis(var, value) => {
                self.value(value, out)?;
                if !matches!(value, Expr::Call(call) if call.gives == Type::Axis) {
                    self.op("DO axis_select");
                    self.state.record = Some(Record::Axis(*var));
                } else if self.state.record == Some(Record::New) {
                    self.state.record = Some(Record::Axis(*var));
                }
                self.state.axis = Some(*var);
            }
            Stmt::Put(place, value) => self.store(place, value, out)?,
            Stmt::Bit(byte, var, on) => {
                self.value(&Expr::Bit(*var), out)?;
                self.state.forget(byte);
                self.op(&format!("AXIS_{} {byte}", if *on { "ON" } else { "OFF" }));
            }
            Stmt::Call(call, _) if call.when.is_some() => {
                let with = Call { when: None, or: None, ..call.clone() };
                let symbol = call.when.as_deref().unwrap_or_default();
                self.only_when(symbol, out, |writer| writer.call(&with, out))?;
                if let Some(code) = &call.or {
                    let others = format!("!{symbol}");
                    self.only_when(&others, out, |writer| writer.code(code, &with, out))?;
                }
            }
            Stmt::Call(call, tried) => {
                if let Some(function) = self.stands_here(call) {
                    return self.stand(function, out);
                }
                self.call(call, out)?;
                if call.gives == Type::Fault && !call.sure && !self.ends_caller() {
                    match tried {
                        Tried::Never => {}
                        Tried::Ends => self.op("DO or_return"),
                        Tried::Refuses => self.op("BELOW 1"),
                    }
                    self.state.zero |= *tried != Tried::Never;
                }
            }
            Stmt::If(cond, then, other) => self.branch(cond, then, other, out)?,
            Stmt::Axes(order, var, body) => self.axes(*order, *var, body, out)?,
            Stmt::Loop(body) => {
                let needed = live_in_loop(body, out);
                self.clobber(&needed)?;
                let head = self.label();
                self.lines.push(Line::Label(head.clone(), false));
                self.state = State { stored: self.state.stored.clone(), ..State::default() };
                self.turns.push((head.clone(), needed.clone()));
                self.block(body, &needed)?;
                self.turns.pop();
                self.turn(&head, &needed)?;
            }
            Stmt::Continue => {
                let Some((label, needed)) = self.turns.last().cloned() else {
                    return self.refuse("no loop goes on");
                };
                self.turn(&label, &needed)?;
            }
            Stmt::Match(value, arms, other) => self.choice(value, arms, other, out)?,
            Stmt::Return(end) => self.end(end)?,
        }
        Ok(())
    }

    /// Whether the last operation ends the function itself when need be.
    fn ends_caller(&self) -> bool {
        matches!(self.lines.last(), Some(Line::Op(op)) if op.facts().ends_caller)
    }
}

/// `if` a byte's bit is set, the same one of the word.
fn first_bit(stmt: &Stmt) -> Option<(&str, &str, u16)> {
    let Stmt::If(Cond::Any(byte, mask, Some(bit)), then, other) = stmt else { return None };
    let [Stmt::Or(_, Expr::Number(number))] = &then[..] else { return None };
    (other.is_empty() && number.value == Some(*bit)).then_some((byte, mask, *bit))
}

/// Whether a place takes a byte.
const fn is_byte(size: Size) -> bool {
    matches!(size, Size::Byte)
}
