//! Effects that move nothing, the trace slot and the print ring.

use crate::consts::constants;
use lang::isa::flags;
use lang::wire;

constants! {
    FLAG_LEVEL = flags::LEVEL;
    FLAG_TIMEOUT = flags::TIMEOUT;
    FLAG_WAIT_QUERY = flags::WAIT_QUERY;
    FLAG_INPUT_ON_STACK = flags::INPUT_ON_STACK;
    TRACE_ODD_AT = wire::TRACE_ODD - wire::TRACE_EVEN;
    TRACE_LENGTH = wire::TRACE_LENGTH;
    // A host listens when it took what was printed within this time, ms, a multiple of 256.
    LISTENS = 512;
}

core::arch::global_asm!(include_str!("effects/effects.s"), options(raw));
// Made of firmware/src/rules/effects.rs.
core::arch::global_asm!(include_str!("generated/effects.s"), options(raw));
core::arch::global_asm!(include_str!("effects/trace.s"), options(raw));
core::arch::global_asm!(include_str!("effects/print.s"), options(raw));

/// A row of the table of effects for each rule.
macro_rules! effects {
    ($module:ident { $($first:ident $last:ident $rule:ident($($with:ident)*);)* }) => {
        core::arch::global_asm!(
            $(concat!("EFFECT {}, fx_", stringify!($rule)),)*
            $(const lang::isa::first::$first as u16,)*
        );
    };
}
firmware::effect_rows!(effects);
firmware::move_rows!(effects);
firmware::probe_rows!(effects);
firmware::axis_rows!(effects);
firmware::line_rows!(effects);

// WaitIn's input stands in the two top bits of its flags, the want in the two lowest.
const _: () = assert!(flags::INPUT == 6 && flags::WAIT_QUERY & 3 == 0);
