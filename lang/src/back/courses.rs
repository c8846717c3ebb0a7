//! Slow points in an image ([`crate::image::course`]), which the host computes once it knows the image without them.

use crate::back::cells::Cells;
use crate::back::emit;
use crate::back::ir::{Item, TextId, Unit};
use crate::hir::Program;

/// Slow points for an image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Courses {
    /// Bytes of the program's memory that the chip wants for them, a multiple of 4
    /// ([`Part::course_pool`](crate::part::Part::course_pool)).
    pub pool: u16,
    /// Address of the effect that begins a course, in the image without any, and the record, without its length byte.
    pub records: Vec<(usize, Vec<u8>)>,
}

impl Courses {
    /// Puts them in front of their effects.
    pub(super) fn insert(&self, program: &Program, unit: &mut Unit, cells: &Cells) {
        if self.records.is_empty() {
            return;
        }
        let places = emit::places(program, unit, cells);
        for routine in &mut unit.routines {
            let Some(places) = places.get(&routine.id) else { continue };
            // From the last on, so that places in front of it stay.
            for (at, (address, size)) in places.iter().enumerate().rev() {
                let here = self.records.iter().find(|(effect, _)| effect == address && *size != 0);
                if let Some((_, record)) = here {
                    routine.items.insert(at, Item::Course(TextId(unit.texts.len() as u32)));
                    unit.texts.push(record.clone());
                }
            }
        }
    }
}
