//! charlyrobot and isel interface cards 4.0/5.0: direct commands and stored instructions.
//!
//! Protocol: the charlyrobot binder, chapter 3, "Programmation". Reading gives a list of
//! [`instr::Item`]s in the order of execution; [`flow`] finds the loops that nest properly, and
//! [`emit`] writes the script. Charlysoft sources end in the same list.

pub(crate) mod answer;
mod arc;
pub mod card;
mod effects;
pub(crate) mod emit;
mod flow;
pub(crate) mod instr;
mod listing;
pub(crate) mod operands;
mod parse;

use super::Job;
use super::diag::Diags;
use super::script::Made;

/// Makes a script of a recorded text or a listing.
pub(crate) fn import(job: &Job<'_>, diags: &mut Diags) -> Made {
    let program = parse::read(&job.lines.numbered(diags), diags);
    if diags.has_errors() {
        return Made::default();
    }
    let source = emit::Source {
        what: "instructions of a charlyrobot or isel interface card",
        scales: [job.options.scale; 3],
        remarks: true,
    };
    emit::script(job, &program, &source, diags)
}
