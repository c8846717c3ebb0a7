//! Values: into the accumulator, from there to places; calls.

use super::state::{Held, Record};
use super::{Made, OWN_RECORD, WORD, Writer, is_byte};
use crate::leaf::{Holds, Type};
use crate::ops::{Op, is_numbered, routine};
use crate::tree::{Call, Cond, Expr, Pair, Place, Size, Var, Vars};

impl Writer<'_> {
    /// r8 is this axis.
    pub(super) fn need_axis(&mut self, axis: Option<Var>) -> Made<()> {
        if self.state.dead || axis.is_some() && self.state.axis == axis {
            return Ok(());
        }
        self.refuse("r8 is no longer the axis: one axis at a time")
    }

    /// r9 is this record, the axis's own unless it has a name.
    pub(super) fn need_record(&mut self, axis: Option<Var>, name: Option<&String>) -> Made<()> {
        let wanted = match (axis, name) {
            (_, Some(name)) if name != OWN_RECORD => Record::Named(name.clone()),
            (Some(axis), _) => Record::Axis(axis),
            (None, _) => return self.refuse("a record of no axis"),
        };
        if self.state.dead || self.state.record.as_ref() == Some(&wanted) {
            return Ok(());
        }
        if matches!(wanted, Record::Named(_)) {
            return self.refuse("r9 is no longer that record");
        }
        self.need_axis(axis)?;
        self.op("DO axis_at");
        Ok(())
    }

    /// How a formula names a value: its name's beginning and its operands.
    fn operand(&mut self, value: &Expr) -> Option<(&'static str, String)> {
        match value {
            Expr::Place(place) if !is_byte(place.size) => Some(self.named(place)),
            Expr::Var(var)
                if self.function.vars[*var] == Type::Long && self.state.stored.contains(var) =>
            {
                Some(("F", self.slots[var].clone()))
            }
            Expr::Of("new", value) if is_whole(value) => {
                let (formula, operand) = self.operand(unwrapped(value))?;
                Some((formula, format!("{operand}, NEW")))
            }
            _ => None,
        }
    }

    pub(super) fn named(&self, place: &Place) -> (&'static str, String) {
        match &place.record {
            Some((short, _)) => {
                ("FR", format!("{}, {}", place.symbol, if *short { "SHORT" } else { "LONG" }))
            }
            None if place.axis.is_some() => ("F", format!("{}, AXIS", place.symbol)),
            None => ("F", place.symbol.clone()),
        }
    }

    /// The pointers that a place is named by.
    pub(super) fn pointers(&mut self, place: &Place) -> Made<()> {
        match &place.record {
            Some((_, name)) => self.need_record(place.axis, name.as_ref()),
            None if place.axis.is_some() => self.need_axis(place.axis),
            None => Ok(()),
        }
    }

    /// What is there already.
    pub(super) fn is_held(&self, value: &Expr) -> bool {
        let state = &self.state;
        match value {
            Expr::Number(number) => {
                number.value == Some(0) && state.zero
                    || state.held.contains(&Held::Number(number.clone()))
            }
            Expr::Var(var) => state.held.contains(&Held::Var(*var)),
            Expr::Place(place) => state.held.contains(&Held::Place(place.clone())),
            Expr::Bit(axis) => state.held.contains(&Held::Bit(*axis)),
            _ => false,
        }
    }

    /// Whether a value needs nothing of what the accumulator was before.
    fn is_pure(&self, value: &Expr) -> bool {
        match value {
            Expr::Number(_) => true,
            Expr::Var(var) => self.state.stored.contains(var),
            Expr::Place(place) => place.record.is_none() && place.axis.is_none(),
            Expr::Wide(inner) => {
                matches!(&**inner, Expr::Place(place) if is_byte(place.size)) && self.is_pure(inner)
            }
            _ => false,
        }
    }

    /// The accumulator = a value; behind it variables of `out` are needed.
    pub(super) fn value(&mut self, value: &Expr, out: &Vars) -> Made<()> {
        if self.state.dead || self.is_held(value) {
            return Ok(());
        }
        match value {
            Expr::Number(number) => {
                self.clobber(out)?;
                let wide = number.value.is_some_and(|value| value > 0xFF);
                self.op(&format!("{} {}", if wide { "LIT16" } else { "LIT" }, number.text));
                self.state.hold(Held::Number(number.clone()));
            }
            Expr::Var(var) => {
                if self.function.vars[*var] == Type::Word {
                    self.clobber(out)?;
                    self.op(&format!("F word {}", WORD[0]));
                    return Ok(());
                }
                if !self.state.stored.contains(var) {
                    return self.refuse("a variable has no value on this way");
                }
                self.clobber_but(value, out)?;
                let slot = self.slots[var].clone();
                if self.function.vars[*var] == Type::Byte {
                    self.op(&format!("GET {slot}"));
                } else {
                    self.op(&format!("F load {slot}"));
                }
                self.state.hold(Held::Var(*var));
            }
            Expr::Place(place) => {
                self.pointers(place)?;
                self.clobber(out)?;
                let (formula, name) = self.named(place);
                match (&place.load, place.size) {
                    (Some(load), _) => self.op(load),
                    (None, Size::Byte) => self.op(&format!("GET {name}")),
                    (None, Size::Word) => self.op(&format!("{formula} word {name}")),
                    (None, Size::Long) => self.op(&format!("{formula} load {name}")),
                }
                self.state.hold(Held::Place(place.clone()));
            }
            Expr::Most => {
                self.clobber(out)?;
                self.op("DO scaled_most");
            }
            Expr::Bit(axis) => {
                self.need_axis(Some(*axis))?;
                self.clobber(out)?;
                self.op("DO axis_bit");
                self.state.hold(Held::Bit(*axis));
            }
            Expr::Call(call) => {
                if matches!(call.gives, Type::Bool | Type::Nothing) {
                    return self.refuse("a call without a number as a value");
                }
                self.call(call, out)?;
            }
            Expr::Pair(op, a, b) => self.pair(*op, a, b, false, out)?,
            Expr::Of("new", a)
                if is_whole(a) && self.operand(value).is_some() && !self.is_held(a) =>
            {
                self.formula("load", value, out)?;
            }
            Expr::Of(routine, a) => {
                self.value(a, out)?;
                self.clobber(out)?;
                self.op(&format!("DO {routine}"));
            }
            Expr::Shifted(a, by) => {
                self.value(a, out)?;
                self.clobber(out)?;
                self.op(&format!("SHIFT {by}"));
            }
            Expr::Wide(a) => match &**a {
                // Of a record 16 bits come as 32.
                Expr::Place(place) if place.record.is_some() => {
                    let place = Place { size: Size::Long, ..place.clone() };
                    self.value(&Expr::Place(place), out)?;
                }
                Expr::Number(_) if self.is_held(a) && !self.state.wide => {
                    self.clobber(out)?;
                    self.state.held.clear();
                    self.state.zero = false;
                    self.value(a, out)?;
                }
                a => {
                    self.value(a, out)?;
                    let word = self.function.gives == Type::Word;
                    if !self.state.wide && !word {
                        return self.refuse("r13 is not 0: a byte that has no wider form here");
                    }
                }
            },
            Expr::Low(a) => {
                self.value(a, out)?;
                self.clobber(out)?;
                self.op("ANDI 0xff");
            }
            Expr::High(_) => return self.refuse("a high byte stands in a word alone"),
            Expr::OrZero(a) => {
                self.value(a, out)?;
                if flag_of_nothing(a) != Some(Holds::Carry) {
                    return self.refuse("nothing says that there is no value");
                }
                self.op("DO zero_if_carry");
            }
            Expr::OrFault(a, fault) => {
                match &**a {
                    Expr::Pair(op, x, y) => self.pair(*op, x, y, true, out)?,
                    a => self.value(a, out)?,
                }
                let jump = match flag_of_nothing(a) {
                    Some(Holds::Carry) => "IF_CARRY",
                    Some(Holds::Overflow) => "IF_OVERFLOW",
                    _ => return self.refuse("nothing says that there is no value"),
                };
                let label = match self.faults.get(fault) {
                    Some(label) => label.clone(),
                    None => self.label(),
                };
                self.faults.insert(fault.clone(), label.clone());
                let held = self.state.held.clone();
                self.jump(jump, &label);
                self.state.held = held;
            }
            Expr::If(cond, a, b) if self.is_pure(a) && self.is_pure(b) && looks_at_bytes(cond) => {
                // The one is there; the other takes its place.
                let end = self.label();
                self.value(b, out)?;
                self.unless(cond, &end, out)?;
                self.value(a, out)?;
                self.place(&end, out)?;
            }
            Expr::If(cond, a, b) => {
                let (otherwise, end) = (self.label(), self.label());
                let mut both = out.clone();
                a.vars(&mut both);
                b.vars(&mut both);
                self.unless(cond, &otherwise, &both)?;
                self.value(a, out)?;
                self.jump("GOTO", &end);
                let mut behind = out.clone();
                b.vars(&mut behind);
                self.place(&otherwise, &behind)?;
                self.value(b, out)?;
                self.place(&end, out)?;
            }
        }
        Ok(())
    }

    /// Of two values; `exact` when flags of the result are looked at.
    pub(super) fn pair(
        &mut self,
        op: Pair,
        a: &Expr,
        b: &Expr,
        exact: bool,
        out: &Vars,
    ) -> Made<()> {
        if let (Pair::Add, Expr::Number(_), true) = (op, b, self.is_long(a)) {
            // A long in memory is added to the number.
            let number = Expr::Wide(Box::new(b.clone()));
            return self.pair(op, &number, a, exact, out);
        }
        if let Expr::Number(number) = b {
            if self.is_long(a) {
                return self.refuse("a number with a byte, or the low one of a word");
            }
            if let Some(bit) = number.value.filter(|bit| number.text != bit.to_string()) {
                self.same(&number.text, bit);
            }
            // Sums of bytes take no more than that.
            let a = match (op, a) {
                (Pair::Add | Pair::Sub | Pair::And, Expr::Low(inner)) => inner,
                _ => a,
            };
            self.value(a, out)?;
            self.clobber(out)?;
            match (op, number.value) {
                (Pair::And, _) => self.op(&format!("ANDI {}", number.text)),
                (Pair::Add, _) => self.op(&format!("ADDI {}", number.text)),
                (Pair::Sub, _) => self.op(&format!("ADDI -{}", number.text)),
                (Pair::Half, Some(n)) => (0..n).for_each(|_| self.op("DO half")),
                _ => return self.refuse("a shift by a number"),
            }
            return Ok(());
        }
        let name = match op {
            Pair::Add => "add",
            Pair::Sub => "sub",
            Pair::Plus => "plus",
            Pair::Minus => "minus",
            Pair::Times => "times",
            Pair::Over => "over",
            Pair::Least => "least",
            Pair::Most => "most",
            _ => return self.refuse("& and >> with a number"),
        };
        let (mut a, mut b) = (a, b);
        let held = |writer: &Self, value: &Expr| writer.is_held(value);
        // The one that is there already goes first.
        let commutes =
            matches!(op, Pair::Add | Pair::Plus | Pair::Times | Pair::Least | Pair::Most);
        let first = !held(self, a) && (held(self, b) || self.operand(b).is_none());
        if commutes && first && self.operand(a).is_some() {
            (a, b) = (b, a);
        }
        let mut kept = out.clone();
        b.vars(&mut kept);
        if let Expr::Var(var) = b
            && (exact || a == b)
            && self.operand(b).is_none()
            && held(self, b)
        {
            self.put_by(*var, &kept)?;
        }
        if self.operand(b).is_none() && op == Pair::Sub && !exact && self.operand(a).is_some() {
            self.value(b, out)?;
            self.formula(name, a, out)?;
            self.op("DO negate");
            return Ok(());
        }
        self.value(a, &kept)?;
        if let Expr::Var(var) = b
            && self.operand(b).is_none()
        {
            return self.refuse(format!("variable {var} is not in memory"));
        }
        self.formula(name, b, out)
    }

    pub(super) fn formula(&mut self, name: &str, x: &Expr, out: &Vars) -> Made<()> {
        let place = if let Expr::Of("new", inner) = x { unwrapped(inner) } else { x };
        if let Expr::Place(place) = place {
            self.pointers(place)?;
        }
        let Some((formula, operand)) = self.operand(x) else {
            return self.refuse("the second value of two is a place or a variable in memory");
        };
        self.clobber_but(x, out)?;
        self.op(&format!("{formula} {name} {operand}"));
        Ok(())
    }

    /// A call, whose result is in the accumulator or a flag.
    pub(super) fn call(&mut self, call: &Call, out: &Vars) -> Made<()> {
        if let Some(value) = &call.value {
            self.value(value, out)?;
        }
        let code = match &call.rule {
            None => call.code.clone(),
            Some(rule) if is_numbered(rule) => vec![format!("DO {rule}")],
            Some(rule) => vec![format!("CALL {rule}")],
        };
        self.code(&code, call, out)
    }

    pub(super) fn code(&mut self, code: &[String], call: &Call, out: &Vars) -> Made<()> {
        let ops = code.iter().map(|op| Op::read(op)).collect::<Vec<_>>();
        let (mut axis, mut record) = (false, false);
        for op in &ops {
            let facts = op.facts();
            let indexed = op.operands.iter().any(|one| one == "AXIS") && op.name != "FR";
            if (facts.needs.contains('a') || indexed) && !axis {
                self.need_axis(call.axis)?;
            }
            if (facts.needs.contains('r') || op.name.starts_with("FR ")) && !record {
                self.need_record(call.axis, call.record.as_ref())?;
            }
            axis |= facts.sets.contains('a');
            record |= facts.sets.contains('r');
        }
        if let Some(rule) = &call.rule
            && routine(rule).is_none()
            && call.axis.is_some()
        {
            self.need_axis(call.axis)?;
            if call.record.is_some() {
                self.need_record(call.axis, call.record.as_ref())?;
            }
        }
        if ops.iter().any(|op| op.facts().gives != micro::isa::Gives::Kept) {
            self.clobber(out)?;
        }
        for (op, text) in ops.iter().zip(code) {
            if call.changes {
                match op.name.as_str() {
                    "BITS_ON" | "BITS_OFF" | "LET" | "PUT" | "UP" => self.state.forget(op.first()),
                    _ => self.state.forget_all(),
                }
            }
            self.op(text);
        }
        // A byte that comes as a long has its high half at 0.
        let long = ops.last().is_some_and(|op| op.facts().gives == micro::isa::Gives::Long);
        self.state.wide |= long && matches!(call.gives, Type::Byte | Type::ByteOrFault);
        if let Some(instructions) = &call.ends {
            self.put(Op::leave(instructions));
        }
        if call.zero {
            self.state.zero = true;
        }
        if let Some(name) = &call.sets_record {
            self.state.record = Some(Record::Named(name.clone()));
        }
        Ok(())
    }
}

/// Whether a formula that makes a scaled number of a value reads no more than that.
fn is_whole(value: &Expr) -> bool {
    match value {
        Expr::Place(place) => {
            place.load.is_none() && (place.record.is_some() || place.size == Size::Long)
        }
        Expr::Var(_) => true,
        Expr::Wide(inner) => matches!(&**inner, Expr::Place(place) if place.record.is_some()),
        _ => false,
    }
}

/// Whether a condition leaves the accumulator.
pub(super) fn looks_at_bytes(cond: &Cond) -> bool {
    match cond {
        Cond::Not(inner) => looks_at_bytes(inner),
        cond => matches!(cond, Cond::Any(..) | Cond::Is(..)),
    }
}

/// The byte itself: a word's half takes no more.
pub(super) fn unwrapped(value: &Expr) -> &Expr {
    match value {
        Expr::Wide(inner) => inner,
        value => value,
    }
}

/// The flag that says that a value is none.
fn flag_of_nothing(value: &Expr) -> Option<Holds> {
    match value {
        Expr::Call(call) if call.gives == Type::Maybe => call.holds,
        Expr::Pair(Pair::Add | Pair::Sub, ..) => Some(Holds::Overflow),
        _ => None,
    }
}
