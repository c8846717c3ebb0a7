//! From the accumulator to places; words that bits are put into.

use super::state::Held;
use super::value::unwrapped;
use super::{Made, WORD, Writer};
use crate::tree::{Expr, Place, Size, Vars};

impl Writer<'_> {
    /// A place = a value.
    pub(super) fn store(&mut self, place: &Place, value: &Expr, out: &Vars) -> Made<()> {
        let symbol = place.symbol.clone();
        self.written.insert(symbol.clone());
        match (place.size, value) {
            (Size::Byte, Expr::Number(number)) if !self.is_held(value) => {
                let before = self.state.known.get(&symbol).copied();
                self.state.forget(&symbol);
                if number.value.is_some() && before.map(|n| n + 1) == number.value {
                    self.op(&format!("UP {symbol}"));
                } else {
                    self.op(&format!("LET {symbol}, {}", number.text));
                }
                self.state.known.extend(number.value.map(|value| (symbol, value)));
                return Ok(());
            }
            (Size::Byte, Expr::Low(inner)) => self.value(inner, out)?,
            (Size::Word, Expr::Number(zero)) if zero.value == Some(0) => {
                self.state.forget(&symbol);
                self.op(&format!("F clear {symbol}"));
                return Ok(());
            }
            _ => self.value(value, out)?,
        }
        self.pointers(place)?;
        self.state.forget(&symbol);
        let (_, name) = self.named(place);
        match place.size {
            Size::Byte => self.op(&format!("PUT {name}")),
            Size::Word => self.op(&format!("F put {name}")),
            Size::Long => self.op(&format!("F store {name}")),
        }
        if !matches!(value, Expr::Low(_)) {
            self.state.hold(Held::Place(place.clone()));
        }
        Ok(())
    }

    /// A word begins, where bits are put into it.
    pub(super) fn word(&mut self, value: &Expr, out: &Vars) -> Made<()> {
        let clear = format!("F clear {}", WORD[0]);
        match value {
            Expr::Number(zero) if zero.value == Some(0) => self.op(&clear),
            Expr::High(value) => {
                self.op(&clear);
                self.value(unwrapped(value), out)?;
                self.op(&format!("PUT {}", WORD[1]));
            }
            value => {
                self.value(unwrapped(value), out)?;
                self.op(&format!("F put {}", WORD[0]));
            }
        }
        Ok(())
    }

    /// Bits of a word.
    pub(super) fn or(&mut self, value: &Expr, out: &Vars) -> Made<()> {
        match value {
            Expr::Number(number) => {
                let Some(value) = number.value else { return self.refuse("bits that are known") };
                for (place, byte) in WORD.iter().zip(value.to_le_bytes()) {
                    if byte != 0 {
                        self.op(&format!("BITS_ON {place}, {byte:#x}"));
                    }
                }
            }
            Expr::High(value) => {
                self.value(unwrapped(value), out)?;
                self.op(&format!("AXIS_ON {}", WORD[1]));
            }
            value => {
                self.value(unwrapped(value), out)?;
                self.op(&format!("AXIS_ON {}", WORD[0]));
            }
        }
        Ok(())
    }
}
