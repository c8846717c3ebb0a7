//! What the assembly takes from `lang`'s tables, by name.

// rustc sorts the pieces of assembly by their items' numbers as text, and what needs symbols must come behind
// them: with a thousand items in front of the first piece all numbers have four digits.
macro_rules! tenfold {
    ($($item:item)*) => { $($item $item $item $item $item $item $item $item $item $item)* };
}
macro_rules! hundredfold {
    ($($item:item)*) => { $(tenfold! { $item $item $item $item $item $item $item $item $item $item })* };
}
hundredfold! {
    const _: () = (); const _: () = (); const _: () = (); const _: () = (); const _: () = ();
    const _: () = (); const _: () = (); const _: () = (); const _: () = (); const _: () = ();
}

/// Makes assembler symbols of constants, all of them in one piece.
macro_rules! constants {
    ($($name:ident = $value:expr;)*) => {
        core::arch::global_asm!(
            "",
            $(concat!(".set ", stringify!($name), ", {}"),)*
            $(const $value as u16,)*
        );
    };
}
pub(crate) use constants;

use crate::{pins, vm};
use core::mem::offset_of;
use lang::fault::Fault;
use lang::image::HEADER;
use lang::record::{AxisRecord, BoardRecord, MachineRecord};
use lang::wire::{End, Exception, RunState, TraceKind};

constants! {
    // The bit of a state that says that a run was begun and has not ended.
    RUN_ACTIVE = RunState::Running;
    RUN_READY = RunState::Ready;
    RUN_RUNNING = RunState::Running;
    RUN_PAUSED = RunState::Paused;
    RUN_FAULT = RunState::Fault;
    RUN_WAIT_START = RunState::WaitStart;
    END_FAULT = End::Fault;
    TRACE_HOME = TraceKind::Home;
    TRACE_AXE = TraceKind::Axe;
    TRACE_RAPID = TraceKind::Rapid;
    TRACE_LINE = TraceKind::Line;
    TRACE_OUT = TraceKind::Out;
    TRACE_WAIT = TraceKind::Wait;
    TRACE_WAIT_IN = TraceKind::WaitIn;
    TRACE_PROBE = TraceKind::Probe;
    TRACE_PRINT = TraceKind::Print;
    TRACE_SEND = TraceKind::Send;
    TRACE_WAIT_CHAR = TraceKind::WaitChar;
    TRACE_WAIT_START = TraceKind::WaitStart;
    TRACE_STOP = TraceKind::Stop;
    TRACE_END = TraceKind::End;
    TRACE_OK = lang::wire::TRACE_OK;
    EX_ILLEGAL_VALUE = Exception::IllegalValue;
    EX_DEVICE_FAILURE = Exception::DeviceFailure;
    EX_BUSY = Exception::Busy;
    // Offsets in the board's part of the profile.
    B_FLAGS = offset_of!(BoardRecord, flags);
    B_ADDRESS = offset_of!(BoardRecord, address);
    B_RATE = offset_of!(BoardRecord, rate);
    B_PULSE = offset_of!(BoardRecord, pulse);
    B_FILTER = offset_of!(BoardRecord, filter);
    B_PROBE = offset_of!(BoardRecord, probe);
    B_INPUT_INVERT = offset_of!(BoardRecord, input_invert);
    B_INPUT_INVERT_HIGH = offset_of!(BoardRecord, input_invert_high);
    B_REFERENCE = offset_of!(BoardRecord, reference);
    B_STOPS = offset_of!(BoardRecord, stop);
    B_DOOR = offset_of!(BoardRecord, door);
    B_EMERGENCY = offset_of!(BoardRecord, emergency);
    B_END_OF_STOPS = offset_of!(BoardRecord, end_of_stops);
    B_EMERGENCY_PIN = offset_of!(BoardRecord, emergency_pin);
    B_EMERGENCY_FALLS = offset_of!(BoardRecord, emergency_falls);
    B_START = offset_of!(BoardRecord, start);
    B_OUTPUT_INVERT = offset_of!(BoardRecord, output_invert);
    B_RESET_ON = offset_of!(BoardRecord, reset_on);
    // Each of these three is a mask of outputs that keep their state, then one of those that go on.
    B_AT_PAUSE = offset_of!(BoardRecord, pause);
    B_AT_FAULT = offset_of!(BoardRecord, fault);
    B_AT_END = offset_of!(BoardRecord, end);
    B_LASER = offset_of!(BoardRecord, laser);
    B_LAMP = offset_of!(BoardRecord, lamp);
    B_ENABLE = offset_of!(BoardRecord, enable);
    B_SPINDLE = offset_of!(BoardRecord, spindle);
    B_SPIN_UP = offset_of!(BoardRecord, spin_up);
    B_LOCK = offset_of!(BoardRecord, lock);
    B_CRC = offset_of!(BoardRecord, crc);
    BOARD_SIZE = BoardRecord::SIZE;
    BOARD_CHAIN = BoardRecord::CHAIN;
    BOARD_AUTORUN = BoardRecord::AUTORUN;
    // Offsets in the axes' part, which precedes the code by MACHINE_SIZE.
    MACHINE_SIZE = MachineRecord::SIZE;
    MC_FLAGS = offset_of!(MachineRecord, flags);
    MC_KEEPS = offset_of!(MachineRecord, keeps);
    MC_FEED = offset_of!(MachineRecord, default_feed);
    MC_AXES = offset_of!(MachineRecord, axes);
    MC_REQUIRE_HOMING = MachineRecord::REQUIRE_HOMING;
    MC_RAPID_Z_APART = MachineRecord::RAPID_Z_APART;
    MC_COURSES = MachineRecord::COURSES;
    AXIS_SIZE = AxisRecord::SIZE;
    A_FLAGS = offset_of!(AxisRecord, flags);
    A_STEPS = offset_of!(AxisRecord, steps);
    A_UM = offset_of!(AxisRecord, um);
    A_START_RATE = offset_of!(AxisRecord, start_rate);
    A_HOME_FAST = offset_of!(AxisRecord, home_fast);
    A_HOME_SLOW = offset_of!(AxisRecord, home_slow);
    A_HOME_PAUSE = offset_of!(AxisRecord, home_pause);
    A_TOP_RATE = offset_of!(AxisRecord, top_rate);
    A_ACCEL = offset_of!(AxisRecord, accel);
    A_DECEL = offset_of!(AxisRecord, decel);
    A_MIN = offset_of!(AxisRecord, min);
    A_MAX = offset_of!(AxisRecord, max);
    A_HOME_STROKE = offset_of!(AxisRecord, home_stroke);
    A_HOME_POSITION = offset_of!(AxisRecord, home_position);
    A_HOME_CLEARANCE = offset_of!(AxisRecord, home_clearance);
    AXIS_PRESENT = AxisRecord::PRESENT;
    AXIS_INVERT = AxisRecord::INVERT;
    AXIS_HOME_POSITIVE = AxisRecord::HOME_POSITIVE;
    // Offsets in an image: header, MachineRecord, code.
    IMAGE_CODE = HEADER + MachineRecord::SIZE;
    F_OVERFLOW = Fault::Overflow.number();
    F_SOFT_LIMIT = Fault::SoftLimit.number();
    F_LIMIT_SWITCH = Fault::LimitSwitch.number();
    F_NOT_HOMED = Fault::NotHomed.number();
    F_SPEED_RANGE = Fault::SpeedRange.number();
    F_HOME_NOT_FOUND = Fault::HomeNotFound.number();
    F_HOME_STAYS_CLOSED = Fault::HomeStaysClosed.number();
    F_PROBE_MISSED = Fault::ProbeMissed.number();
    F_TIMED_OUT = Fault::TimedOut.number();
    F_EMERGENCY_STOP = Fault::EmergencyStop.number();
    F_IMAGE_REFUSED = Fault::ImageRefused.number();
    F_STACK = Fault::Stack.number();
    F_INPUT_ACTIVE = Fault::InputActive.number();
    F_VALUE_RANGE = Fault::ValueRange.number();
    P1_STOP = pins::P1_STOP;
    P1_START = pins::P1_START;
    P1_REF_X_OR_PROBE = pins::P1_REF_X_OR_PROBE;
    P1_REF_Y_OR_CLOCK = pins::P1_REF_Y_OR_CLOCK;
    P1_REF_Z_OR_MISO = pins::P1_REF_Z_OR_MISO;
    P1_PROBE_OR_MOSI = pins::P1_PROBE_OR_MOSI;
    P1_UART = pins::P1_UART;
    P2_STEP = pins::P2_STEP;
    P2_DIR_X = pins::P2_DIR[0];
    P2_DIR_Y = pins::P2_DIR[1];
    P2_DIR_Z = pins::P2_DIR[2];
    P2_OUT1_OR_LATCH = pins::P2_OUT1_OR_LATCH;
    P2_OUT2_OR_ENABLE = pins::P2_OUT2_OR_ENABLE;
    // What the build leaves out costs no byte: `.if HAS_...`, `.if AT_ROOM` in the sources.
    HAS_EVENTS = (vm::PART.features & lang::record::feature::EVENTS != 0);
    AT_ROOM = vm::PART.at_room;
    HAS_HALTS = vm::PART.halts;
    HAS_COURSES = (vm::PART.features & lang::record::feature::COURSE != 0);
    HAS_LINES = (vm::PART.features & lang::record::feature::LINES != 0);
}

// Lists that `first_on` (io.s) and command 110 walk.
const _: () = assert!(
    offset_of!(BoardRecord, stop) == offset_of!(BoardRecord, reference) + 3
        && offset_of!(BoardRecord, end_of_stops) == offset_of!(BoardRecord, emergency) + 4
        && BoardRecord::END_OF_STOPS & 0x80 != 0
);
