//! Effects that move nothing, the trace slot and the print ring.

use crate::consts::constants;
use lang::isa::{Op, flags};
use lang::wire;

constants! {
    OP_LINEAR = Op::Linear;
    OP_MOVE_TO = Op::MoveTo;
    OP_OUT_SHORT = Op::OutShort;
    OP_PRINT_END = Op::PrintEnd;
    OP_WAIT_START = Op::WaitStart;
    OP_SET_OUT = Op::SetOut;
    OP_PULSE = Op::Pulse;
    OP_WAIT_IN = Op::WaitIn;
    OP_MOTORS = Op::Motors;
    OP_WAIT_CHAR = Op::WaitChar;
    OP_WAIT = Op::Wait;
    OP_SEND = Op::Send;
    OP_SET_PORT = Op::SetPort;
    OP_FEED = Op::Feed;
    OP_PRINT_NUMBER = Op::PrintNumber;
    OP_PRINT_TEXT = Op::PrintText;
    OP_SET_POS = Op::SetPos;
    OP_IN_SHORT = Op::InShort;
    OP_TIMED_OUT = Op::TimedOut;
    OP_IN = Op::In;
    OP_OUT_STATE = Op::Out;
    OP_READ = Op::Read;
    OP_MOVE_SPEED = Op::MoveSpeed;
    OP_EVENT = Op::Event;
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
core::arch::global_asm!(include_str!("effects/trace.s"), options(raw));
core::arch::global_asm!(include_str!("effects/print.s"), options(raw));

// WaitIn's input stands in the two top bits of its flags, the want in the two lowest.
const _: () = assert!(flags::INPUT == 6 && flags::WAIT_QUERY & 3 == 0);
