//! Loops and switches.

use super::state::{Held, State};
use super::{Made, Writer, is_byte};
use crate::ops::{HOLE, Line, Op, PLACE};
use crate::tree::{End, Expr, Number, Order, Size, Stmt, Var, Vars, live_in_loop};

impl Writer<'_> {
    pub(super) fn turn(&mut self, label: &str, needed: &Vars) -> Made<()> {
        self.clobber(needed)?;
        if !self.state.dead {
            self.put(Op::read("GOTO").to(label));
        }
        Ok(())
    }

    pub(super) fn axes(&mut self, order: Order, var: Var, body: &[Stmt], out: &Vars) -> Made<()> {
        let needed = live_in_loop(body, out);
        self.clobber(&needed)?;
        match order {
            Order::Down => self.op("DO micro_first_axis"),
            Order::Up => {
                self.value(&Expr::Number(Number::of(0)), &needed)?;
                self.op("DO axis_select");
            }
            Order::Four => ["LIT 3", "DO axis_select"].iter().for_each(|op| self.op(op)),
        }
        let next_one = if order == Order::Up { "UP_AXIS" } else { "NEXT_AXIS" };
        let (head, next) = (self.label(), self.label());
        self.lines.push(Line::Label(head.clone(), false));
        let stored = self.state.stored.clone();
        self.state = State { axis: Some(var), stored, ..State::default() };
        self.turns.push((next.clone(), needed.clone()));
        self.block(body, &needed)?;
        self.clobber(&needed)?;
        self.turns.pop();
        self.lines.push(Line::Label(next, false));
        self.state.dead = false;
        self.put(Op::read(next_one).to(&head));
        let stored = self.state.stored.clone();
        self.state = State { stored, ..State::default() };
        Ok(())
    }

    pub(super) fn choice(
        &mut self,
        value: &Expr,
        arms: &[(Number, Vec<Stmt>)],
        other: &[Stmt],
        out: &Vars,
    ) -> Made<()> {
        let mut needed = self.live(other, out);
        for (_, arm) in arms {
            needed.extend(self.live(arm, out));
        }
        let labels = arms.iter().map(|_| self.label()).collect::<Vec<_>>();
        let (otherwise, end) = (self.label(), self.label());
        let values = arms.iter().map(|(number, _)| number.value).collect::<Option<Vec<_>>>();
        let mut byte = None;
        // What the accumulator is on each of the ways, when it is known.
        let mut numbers = vec![None; arms.len()];
        if let (Expr::Place(place), Some(values)) = (value, &values)
            && place.size == Size::Word
        {
            let (Some(&first), Some(&last)) = (values.iter().min(), values.iter().max()) else {
                return self.refuse("a match of numbers");
            };
            // What is outside of them is looked at by how far it lies below the last one.
            self.value(&Expr::Number(Number::of(last)), &needed)?;
            self.formula("sub", value, &needed)?;
            let count = last - first + 1;
            if refused(other) {
                self.op(&format!("BELOW {count}"));
            } else {
                self.op(&format!("CMPI {count}"));
                self.jump("IF_CARRY", &otherwise);
            }
            let places = (first..=last).rev().map(|n| values.iter().position(|value| *value == n));
            self.op("DO micro_switch");
            self.places(places, &labels, &otherwise);
            numbers = values.iter().map(|value| Some(Number::of(last - value))).collect();
        } else {
            self.value(value, &needed)?;
            byte = self.state.held.iter().find_map(|held| match held {
                Held::Place(place) if is_byte(place.size) => Some(place.symbol.clone()),
                _ => None,
            });
            if let Some(values) = values {
                // Each value has its place; what is left between them, or the next one, is the last arm.
                self.clobber(&needed)?;
                let (Some(&first), Some(&last)) = (values.iter().min(), values.iter().max()) else {
                    return self.refuse("a match of numbers");
                };
                let full = (first..=last).all(|n| values.contains(&n));
                let places = (first..=last + u16::from(full))
                    .map(|n| values.iter().position(|value| *value == n));
                self.op("DO micro_switch");
                for _ in 0..first {
                    self.lines.push(Line::Op(Op::read(&format!("{HOLE} 0"))));
                }
                self.places(places, &labels, &otherwise);
            } else {
                for ((number, _), label) in arms.iter().zip(&labels) {
                    self.jump(&format!("CASE {}", number.text), label);
                }
                self.jump("GOTO", &otherwise);
            }
        }
        // The last arm, often the shortest, stands first: the places of a switch reach 127 bytes.
        self.place(&otherwise, &needed)?;
        self.block(other, out)?;
        self.jump("GOTO", &end);
        for (((number, arm), label), there) in arms.iter().zip(&labels).zip(numbers) {
            self.place(label, &needed)?;
            self.state.held.extend(there.map(Held::Number));
            if let (Some(byte), Some(value)) = (&byte, number.value) {
                self.state.known.insert(byte.clone(), value);
            }
            self.block(arm, out)?;
            self.jump("GOTO", &end);
        }
        self.place(&end, out)
    }

    /// The places of a switch: each the arm's or, of none, the other one.
    fn places(
        &mut self,
        places: impl Iterator<Item = Option<usize>>,
        labels: &[String],
        otherwise: &String,
    ) {
        let way = State { dead: false, ..self.state.on_way() };
        for at in places {
            let label = at.map_or(otherwise, |at| &labels[at]);
            self.lines.push(Line::Op(Op::read(PLACE).to(label)));
            self.ways.entry(label.clone()).or_default().push(way.clone());
        }
        self.lines.push(Line::Check(String::from("    PLACES_END")));
        self.state.dead = true;
    }
}

/// Whether statements refuse a value, which is an operation's end, too.
pub(super) fn refused(stmts: &[Stmt]) -> bool {
    matches!(stmts, [Stmt::Return(End::Fault(what))] if what == "EX_ILLEGAL_VALUE")
}
