//! Slow points: a program's whole path seen ahead, for chips that see one block ahead.
//!
//! Where nothing that a program does hangs on the outside, its path can be followed on the host to
//! its end ([`tour`]). Braking works backward from each place that must be slow, so the squared speed
//! that is allowed at a place is the least of what each slow place ahead allows, itself plus what the
//! blocks up to it brake by. These are parallel lines: which of them binds changes only where one is
//! passed. So the chip needs one number of state, what it may have here, less what its blocks brake
//! by, and an instruction that raises it behind a slow point ([`points`]): two for 1000 chords.
//!
//! A program that looks at inputs, times or KEEP values may go another way than the one followed: it
//! gets none, and runs with the chip's own look-ahead. A streamed job gets them piece by piece, up to where
//! it asks the board for something ([`ahead`]).

pub mod ahead;
mod points;
mod tour;

pub use points::operand;

use crate::client::identity::Identity;
use crate::stream::feed::{Feed, Step};
use lang::back::{self, Compiled, Excess, Room, SlowPoints};
use lang::effect::Effect;
use lang::hir::{Program, Storage};
use lang::image::Image;
use lang::record::{MachineRecord, feature};

/// Compiles a checked program for a place with slow points, for parts that take them.
///
/// # Errors
/// As [`back::compile`].
pub fn compile(program: &Program, room: Room) -> Result<Compiled, Vec<Excess>> {
    let plain = back::compile_for(program, room)?;
    let slow = slow_points(program, &plain);
    if slow.is_empty() { Ok(plain) } else { back::compile_with(program, room, &slow) }
}

/// What a firmware with these [`feature`] bits is given of a compiled program: with slow points where
/// it takes them and they leave the image within `room` bytes, otherwise as it is.
pub fn fitted(program: &Program, plain: Compiled, features: u16, room: usize) -> Compiled {
    if features & feature::SLOW == 0 {
        return plain;
    }
    let slow = slow_points(program, &plain);
    if slow.is_empty() {
        return plain;
    }
    match back::compile_with(program, Room::Device, &slow) {
        Ok(planned) if planned.image.len() <= room || plain.image.len() > room => planned,
        _ => plain,
    }
}

/// The same for the board that says this of itself.
pub fn fitted_to(board: &Identity, program: &Program, plain: Compiled) -> Compiled {
    let room = usize::from(board.area_bytes).saturating_sub(lang::part::SLOT_HEAD);
    fitted(program, plain, board.features, room)
}

/// What slow points say before each G0 to G3 that a compiled program executes, in this order: the
/// bits of the planner's scaled number, 0 for nothing. For engines that run no image.
pub fn raises(compiled: &Compiled) -> Vec<u32> {
    let mut raises = Vec::new();
    let Ok(mut feed) = Feed::new(compiled) else { return raises };
    let mut ahead = 0;
    while raises.len() < tour::MOST_EFFECTS {
        match feed.step() {
            Step::Effect(Effect::Slow(bits), _) => ahead = bits,
            Step::Effect(Effect::Linear { .. } | Effect::Arc { .. }, _) => {
                raises.push(std::mem::take(&mut ahead));
            }
            // Only programs that look at nothing have slow points.
            Step::Effect(..) => {}
            _ => break,
        }
        feed.complete(0);
    }
    raises
}

/// Slow points of a compiled program, none where its path hangs on the outside.
fn slow_points(program: &Program, plain: &Compiled) -> SlowPoints {
    let outside = |var: &lang::hir::Var| matches!(var.storage, Storage::At(_) | Storage::Keep(_));
    let handled = |image: Image<'_>| image.header.has(feature::EVENTS | feature::LINES);
    if program.vars.iter().any(outside) || Image::new(&plain.image).is_ok_and(handled) {
        return SlowPoints::new();
    }
    let record = MachineRecord::of(&program.profile);
    match tour::follow(program, plain) {
        Some(stops) => points::find(&stops, record.corner),
        None => SlowPoints::new(),
    }
}

#[cfg(test)]
mod tests;
