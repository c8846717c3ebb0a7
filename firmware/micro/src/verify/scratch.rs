//! Which temporary bytes an operation reads and writes.

use crate::decode::{Code, Kind, Op};
use crate::isa::{Formula, Own, Scratch};

/// Where they lie: address, bytes, the first one's bit.
pub struct Places(Vec<(u16, u8, u32)>);

impl Places {
    /// Those of an image.
    pub fn of(code: &dyn Code) -> Places {
        let mut bit = 0;
        let places = Scratch::PLACES.iter().filter_map(|(name, bytes)| {
            let first = bit;
            bit += u32::from(*bytes);
            Some((code.symbol(name)?, *bytes, first))
        });
        Places(places.collect())
    }

    fn bytes(&self, first: u16, count: u16) -> Scratch {
        let mut bits = 0;
        for at in first..first + count {
            for &(place, bytes, bit) in &self.0 {
                if (place..place + u16::from(bytes)).contains(&at) {
                    bits |= 1 << (bit + u32::from(at - place));
                }
            }
        }
        Scratch(bits)
    }

    /// Those that a formula names; of an operand by axis none, as no temporary is.
    fn named(&self, op: &Op) -> Scratch {
        match op.kind {
            Kind::Formula(formula, place) if !place.record && !place.axis => {
                self.bytes(place.at, if formula.is_word() { 2 } else { 4 })
            }
            Kind::Own(_) if self.takes_byte(op) => self.bytes(op.operands[0], 1),
            _ => Scratch::NONE,
        }
    }

    fn takes_byte(&self, op: &Op) -> bool {
        op.row().is_some_and(|row| row.operands.first() == Some(&crate::isa::Operand::Byte))
    }

    /// Those that it writes.
    pub fn written(&self, op: &Op) -> Scratch {
        let writes = match op.kind {
            Kind::Formula(formula, _) => formula.writes(),
            Kind::Own(own) => matches!(
                own,
                Own::Put
                    | Own::Let
                    | Own::BitsOn
                    | Own::BitsOff
                    | Own::Up
                    | Own::AxisOn
                    | Own::AxisOff
            ),
            Kind::Routine(_) => false,
        };
        if writes { self.named(op) } else { Scratch::NONE }
    }

    /// Those that it reads.
    pub fn read(&self, op: &Op) -> Scratch {
        let reads = match op.kind {
            Kind::Formula(formula, _) => formula.reads() || formula == Formula::Bound,
            Kind::Own(own) => !matches!(own, Own::Put | Own::Let),
            Kind::Routine(_) => false,
        };
        if reads { self.named(op) } else { Scratch::NONE }
    }
}
