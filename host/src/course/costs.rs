//! Execution times of the VM's instructions on the chip that has slow points, as `pasapas bench costs` measures them.

use lang::isa::Op;

/// F, which is an effect of its own: a round of the main loop with a busy link, us.
pub const FEED_US: u32 = 500;

/// us that an instruction takes on the chip at most, between interrupts.
pub fn instruction_us(op: Op) -> u32 {
    match op {
        Op::Sqr => 640,
        Op::Div | Op::Mod => 50,
        Op::Mul => 30,
        Op::Shl | Op::Shr => 23,
        Op::Table | Op::TableFar => 20,
        Op::Thousands | Op::Hundreds => 10,
        Op::Tens | Op::WordTens => 7,
        // Beside the main loop's round, which a busy link makes longer.
        Op::ToSteps => 260,
        Op::Err => 180,
        Op::Erl | Op::ToLength => 210,
        Op::Course => 310,
        _ => 6,
    }
}

/// The same of a code.
pub fn code_us(code: u8) -> u32 {
    Op::decode(code).map_or(0, |(op, _)| instruction_us(op))
}
