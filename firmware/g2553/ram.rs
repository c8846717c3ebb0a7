//! The 512 bytes of RAM, byte for byte. Everything has a fixed address, so that one byte names any word of RAM
//! (formulas). The assembler's symbols, marks of modules (`pasapas size`) and flags are made here.

use core::mem::{offset_of, size_of};

use crate::consts::constants;
use crate::vm::{self, PART};
use lang::record::{AxisRecord, feature};

/// Where it begins.
const START: u16 = 0x0200;
/// Where it ends: the machine stack comes down from here.
pub const END: u16 = 0x0400;

/// Whether the part tells lines and handles errors.
const LINES: usize = (PART.features & feature::LINES != 0) as usize;
/// Whether it takes slow points.
const COURSES: usize = (PART.features & feature::COURSE != 0) as usize;
/// Bytes of the VM's registers.
const VM_SIZE: usize = size_of::<vm::State>();
/// Bytes of the print ring.
const PRINT_SIZE: usize = 16;
/// Longest request, bytes.
const FRAME_SIZE: usize = 52;
/// Bytes of it in which a reply's wait until they are sent: a power of two.
const RING_SIZE: usize = 32;
const _: () = assert!(RING_SIZE.is_power_of_two() && RING_SIZE <= FRAME_SIZE);

/// A segment as the step engine plays it.
#[repr(C)]
struct Segment {
    /// Ticks to the next event, and a fraction.
    interval: [u16; 2],
    /// What each event adds to that.
    change: [u16; 2],
    /// Events to come.
    events: u16,
    /// STEP pins of its axes; the top bit: a line of a course begins.
    mask: u16,
}
const SLOT_SIZE: usize = size_of::<Segment>();

/// The address of a variable.
macro_rules! at {
    ($name:ident) => {
        (START + offset_of!(Ram, $name) as u16)
    };
}

macro_rules! ram {
    ($($(#[doc = $about:literal])* $mark:ident = $module:literal {
        $($name:ident: $size:expr, $doc:literal;)*
    })*) => {
        /// The variables, in the order of their addresses; a mark stands where a module's begin.
        #[repr(C)]
        #[allow(non_snake_case)]
        struct Ram {
            $($(#[doc = $about])* $mark: [u8; 0], $(#[doc = $doc] $name: [u8; $size],)*)*
        }

        // The same rows for the assembler, without an item for each: see `constants`. What the part has not has no symbol: it
        // would be that of what follows.
        core::arch::global_asm!(
            ".set LINES, {lines}",
            ".set COURSES, {courses}",
            ".set PRINT_SIZE, {print}",
            ".set SLOT_SIZE, {slot}",
            ".set FRAME_SIZE, {frame}",
            ".set VM_SIZE, {vm}",
            ".set HERE, {start}",
            $(
                concat!(".set ram.", $module, ", HERE"),
                $(concat!(
                    ".if ", stringify!($size), "\n.set ", stringify!($name), ", HERE\n.global ", stringify!($name),
                    "\n.endif\n.set HERE, HERE + ", stringify!($size)
                ),)*
            )*
            ".if HERE != {end}",
            ".error \"the struct and the symbols differ\"",
            ".endif",
            lines = const LINES,
            courses = const COURSES,
            print = const PRINT_SIZE,
            slot = const SLOT_SIZE,
            frame = const FRAME_SIZE,
            vm = const VM_SIZE,
            start = const START,
            end = const POOL,
        );
    };
}

ram! {
    /// Survive a reset that is no power-up.
    boot = "boot" {
        RUNNING: 2, "RUNS_MARK while a program runs.";
    }
    /// Deadlines (ticks.s, step.s).
    session_missed = "session$missed" {
        MISSED: 2, "Milliseconds served more than 2 ms late; high byte: low byte of RUNS when a line of a course came too late.";
        RUNS: 2, "Runs begun since reset.";
    }
    /// Of the link, beyond the bytes that one byte names.
    link_silence = "link$silence" {
        SILENCE_TICKS: 2, "From a character's end to the frame's end, 0.5 us.";
    }
    /// Step engine (step.s).
    motion_step = "motion.step" {
        STEP_SLOT: 2, "The slot that plays: 0, or SLOT1-SLOT0.";
        STEP_FRAC: 2, "Fraction of the compare registers.";
        WIDTH: 2, "Ticks of a long pulse, 0 for a short one.";
        SLOT0: SLOT_SIZE, "A segment (Segment).";
        SLOT1: SLOT_SIZE, "The other one.";
        COUNT: 6, "Low halves of the positions, negated in negative direction.";
        INC: 12, "What an event adds to each accumulator.";
        ACC: 12, "Accumulators; a carry is a step.";
    }
    /// Planner (rules/planner.rs, rules/segments.rs). Scaled numbers but for LEFT. From V to NOMINAL2 targets lie while a statement looks at
    /// its axes (coords.s).
    motion_ramp = "motion.ramp" {
        V2: 4, "Square of the present speed.";
        V: 4, "Its root.";
        LEFT: 4, "Events that no segment has taken yet.";
        CAUGHT: 4, "Count of axis N when a watched input answered, homing uses it too; else the speed that overrides act on.";
        ACCEL2: 4, "Growth of the square over one event.";
        DECEL2: 4, "Its decline while braking.";
        NOMINAL2: 4, "Square of the speed to run at.";
        START2: 4, "Square of the speed from and to rest.";
        TICK: 4, "Interval at speed 1, ticks.";
        WATCH: 1, "Inputs of port 1 that catch, or TRIPPED.";
        IDLE: 1, "Their levels at rest; WATCH_ENDS: the step that is caught is the last.";
        HIT: 1, "What answered, 0 for nothing yet; where nothing is watched 1 in a rapid move, LONE in that of a single axis, else 0.";
        REFUSAL: 1, "Refusal of the last upload.";
        MOVING: 1, "Bit per axis that the motion under way moves.";
        NEGATIVE: 1, "Bit per axis: last moved in negative direction.";
        MOTION: 1, "M_ flags.";
        HOMED: 1, "Bit per axis.";
    }
    /// at rest, where the pool holds variables: slot_check forgets LEFT again.
    micro = "micro" {
        TEMP: 12, "Scratch of one routine, never across a pass of the main loop.";
    }
    /// Positions, 3 x 32 bits each.
    moves = "moves" {
        UM: 12, "Commanded machine positions, um.";
        STEPS: 12, "The same in steps.";
        OFFSET: 12, "Work offsets: machine less work position, um.";
        ACTUAL: 12, "Machine positions at this instant, steps.";
        PROBED: 12, "Where the probe answered, steps.";
        PROBE_OK: 1, "Bit per axis: its last probe answered.";
        HOMING_ERROR: 1, "Bit per axis: homing by command failed.";
        PROBE_ERROR: 1, "Bit per axis: its last probe failed.";
        CAUSE: 1, "IFG1 at reset.";
    }
    /// Link (uart.s, modbus.s).
    link = "link" {
        FRAME: FRAME_SIZE, "Request, then ring of the reply.";
        HEAD: 1, "Receiving: bytes so far; sending: where the next byte goes.";
        TAIL: 1, "Sending: the next byte to go out.";
        LINE_STATE: 1, "What the line does (uart.s).";
        FUNCTION: 1, "Reading function whose data is being sent, 0 for none.";
        SLACK_TICKS: 2, "Between two characters of a frame.";
        NEXT_REGISTER: 2, "Of a reading function.";
        REGISTERS_LEFT: 2, "Of the request.";
        REPLY_CRC: 2, "CRC of the reply so far.";
        COMMAND_HEAD: 4, "A command's number and first argument, the others in COMMAND.";
    }
    /// Run state (session.s, ticks.s).
    session = "session" {
        EFFECT_PC: 2, "Address of the effect's instruction, or of the next one.";
        FEED: 4, "F: um/s, negative steps/s, 0 none yet.";
        MILLIS: 2, "Milliseconds since reset.";
        HELD: 2, "Milliseconds for which Stop must still be held to end a run.";
        UNHEARD: 2, "Milliseconds since a host took what was printed, or found nothing.";
        RUN: 1, "RunState, without WaitStart.";
        CHAR_IN: 1, "Character for WaitChar.";
    }
    /// Inputs and outputs (io.s).
    io = "io" {
        INPUT: 2, "Filtered inputs 1 to 16.";
        INPUT_LOW: 2, "Bits of their counters.";
        INPUT_HIGH: 2, "See INPUT_LOW.";
        RAW: 2, "Inputs before the filter.";
        BUTTON: 1, "P1_STOP, P1_START: pressed; filtered; the other bits of P1 too.";
        ADDRESS: 1, "The link's.";
        BUTTON_LOW: 1, "Counters 2 and 4 bytes behind, as those of INPUT.";
        TICKS_DONE: 1, "Low byte of the millisecond handled last.";
        BUTTON_HIGH: 1, "See BUTTON_LOW.";
        RUN_FLAGS: 1, "R_ flags.";
        OVERRIDE: 2, "Percent: of feeds and single axes, of rapid moves.";
        FORCED: 2, "Inputs that keep the level that command 110 gave them.";
        OUTPUT: 2, "Outputs 1 to 16.";
        RESUME_OUTPUT: 2, "Outputs as they were before a pause.";
        BOARD: 2, "Address of the board's profile in flash.";
    }
    /// Store (store.s).
    store = "store" {
        STORED: 2, "Address of the current slot, 0 for none.";
    }
    /// Characters and print (effects.s, print.s).
    effects_print = "effects.print" {
        CHAR_OUT: 2, "Character, count of them.";
        PRINT_TAIL: 2, "Number of the first byte that waits.";
        PRINT_READY: 1, "Bytes that wait and that the host may take.";
        TRACING: 1, "T_ flags.";
        PRINT: PRINT_SIZE, "Ring of what waits.";
    }
    /// VM (vm.rs, State).
    vm = "vm" {
        VM_STATE: VM_SIZE, "Registers of the VM, and how the run ends.";
        PLACED: 1, "Bit per axis: SetPos has said where it is, in this run.";
        LAST_END: 1, "End of the last run, 0 in a run.";
    }
    /// Lines of a course (line.s).
    motion_line = "motion.line" {
        JOINS: COURSES, "Axes of lines of a course that are joined to the next one, less than 0.";
        JOINED: COURSES, "What JOINS becomes with each line that is begun.";
    }
    /// The effect under way (effects.s).
    effects = "effects" {
        EFFECT: 1, "Its opcode, 0 for none, EFFECT_END at the end of a run.";
        PHASE: 1, "What it has come to, 0 at its beginning.";
        N: 1, "Input, output, axis, character.";
        BITS: 1, "Flags of the instruction.";
        TIME: 4, "Milliseconds to go, negative for ever; or whatever it needs; the high half is 0 at its beginning.";
    }
    /// Trace (trace.s), in the order of the slot's registers.
    effects_trace = "effects.trace" {
        TRACE_NUMBER: 2, "Number of the last event.";
        TRACE_KIND: 1, "Its kind.";
        TRACE_ARGUMENT: 1, "Its argument.";
        TRACE_PC: 2, "Where it comes from.";
        TRACE_VALUE: 4, "Its value.";
    }
    session_run = "session$run" {
        TIMER_MS: 4, "Milliseconds of the run.";
        SPIN_APART: 2 * LINES, "Milliseconds until motion goes on after a pause, where it has a place of its own.";
        PRINT_OPEN: 1, "Bytes of the line that is being put.";
        FILTER: 1, "Four times the milliseconds since the last sample of inputs.";
        OPEN: 2, "Address of the slot that an upload fills, 0 for none.";
        UPLOAD: 2, "Announced length, bit 15 KEEP.";
    }
}

/// The address of a register of the VM.
const fn vm_at(offset: usize) -> u16 {
    at!(VM_STATE) + offset as u16
}

/// The program's pool follows: call stack upward, cells, expression stack downward from its end. Without a run its
/// end holds the command buffer; cells of AT variables in front of that live on.
const POOL: u16 = START + size_of::<Ram>() as u16;
const POOL_END: u16 = POOL + vm::POOL as u16;
/// The command buffer: 21 registers, the first two of them in COMMAND_HEAD.
const COMMAND: u16 = POOL_END - 2 * 21;
/// The arguments of 106 as a record of an axis.
const HOME_RECORD: u16 = COMMAND - 4;
/// In a run of a program with courses its end is theirs.
const COURSE: u16 = POOL_END - PART.course_pool;

/// What command 106 brings, from COMMAND on (`rules/commands.rs`): made a record of the axis, with its stroke, place and
/// clearance where that wants them, speed and ramps stay here.
#[repr(C)]
struct HomeCommand {
    before: [u16; 6],
    speed: [u16; 2],
    slow_speed: [u16; 2],
    up: [u16; 2],
    down: [u16; 2],
    stroke: [u16; 2],
    wait: u16,
    place: [u16; 2],
    clearance: [u16; 2],
}
const _: () = assert!(
    HOME_RECORD + offset_of!(AxisRecord, home_clearance) as u16
        == COMMAND + offset_of!(HomeCommand, clearance) as u16
        && HOME_RECORD >= POOL,
    "command 106 and AxisRecord differ"
);

/// Bytes of a statement or command that begins, at rest.
#[repr(C)]
struct Locals {
    /// The instruction's flags.
    flags: u8,
    /// Its second byte of them; bits of axes that have steps to make.
    ramps: u8,
    /// What `rate` takes; an operation code.
    unit: u8,
    /// What a target's number is of: bits F_.
    frame: u8,
}
/// Where they are.
const LOCALS: u16 = at!(TICK);

/// Where the VM's core keeps the machine stack's address: a word of TEMP, from the VM's registers.
pub const FRAME_AT: i16 = at!(TEMP) as i16 + 8 - at!(VM_STATE) as i16;

const _: () = assert!((at!(VM_STATE) | POOL) & 1 == 0, "words stand at even addresses");
const _: () = assert!(PART.course_pool == 0 || PART.course_pool == 28, "COURSE_LINES is the end");
const _: () = assert!(at!(JOINS) & 1 == 0, "JOINS and JOINED are a word");
const _: () = assert!(
    at!(INC) == at!(COUNT) + 6 && at!(NOMINAL2) == at!(V) + 20 && at!(ACCEL2) == at!(V) + 12,
    "COUNT and INC change at once; six numbers in a row hold targets"
);
// Its deepest is 46 bytes (budget.toml).
const _: () = assert!(END - POOL_END >= 46 + 20, "the machine stack has 20 bytes to spare");
const _: () = assert!(
    PART.at_room == 0
        || PART.at_room == HOME_RECORD - POOL
            && (at!(WATCH) - at!(INC)) as usize >= crate::check::SCRATCH,
    "the part's room for AT variables, and the check's scratch memory"
);

/// The lowest bit of a count of quarters of a second.
const QUARTER: u16 = 16;

constants! {
    RAM_END = END;
    // From here on RAM is cleared at reset.
    CLEARED = at!(MISSED);
    // From here to the pool's end it is cleared when a run begins.
    RUN_CLEARED = vm_at(offset_of!(vm::State, handler));
    VM_PC = vm_at(offset_of!(vm::State, pc));
    VM_SP = vm_at(offset_of!(vm::State, sp));
    VM_TOP = vm_at(offset_of!(vm::State, top));
    VM_CODE = vm_at(offset_of!(vm::State, code));
    VM_CELLS = vm_at(offset_of!(vm::State, cells));
    VM_CALLS = vm_at(offset_of!(vm::State, calls));
    VM_BASE = vm_at(offset_of!(vm::State, base));
    VM_DATA = vm_at(offset_of!(vm::State, data));
    VM_HANDLER = vm_at(offset_of!(vm::State, handler));
    VM_FAULT_PC = vm_at(offset_of!(vm::State, fault_pc));
    VM_FAULT = vm_at(offset_of!(vm::State, fault));
    FAULT_IN = vm_at(offset_of!(vm::State, fault_input));
    VM_POLL = vm_at(offset_of!(vm::State, poll));
    VM_FLAGS = vm_at(offset_of!(vm::State, flags));
    VM_CELL_COUNT = vm_at(offset_of!(vm::State, cell_count));
    ENDING = vm_at(offset_of!(vm::State, ending));
    POOL = POOL;
    POOL_END = POOL_END;
    COMMAND = COMMAND;
    // What changes as the next line of a course begins: NEGATIVE, DIR pins; COUNT, INC.
    NEXT_DIRS = COURSE;
    NEXT_COUNT = COURSE + 2;
    NEXT_INC = COURSE + 8;
    // Square of the speed at which the line under way may end, scaled.
    EXIT2 = COURSE + 20;
    // The entry of slow points that comes next, and what is left of the one before: its first byte.
    COURSE_AT = COURSE + 24;
    COURSE_LINES = COURSE + 26;
    COURSE = COURSE;
    HOME_RECORD = HOME_RECORD;
    LOCALS = LOCALS;
    FLAGS = LOCALS + offset_of!(Locals, flags) as u16;
    RAMPS = LOCALS + offset_of!(Locals, ramps) as u16;
    UNIT = LOCALS + offset_of!(Locals, unit) as u16;
    FRAME_OF = LOCALS + offset_of!(Locals, frame) as u16;
    INTERVAL = offset_of!(Segment, interval);
    CHANGE = offset_of!(Segment, change);
    EVENTS = offset_of!(Segment, events);
    MASK = offset_of!(Segment, mask);
    RING_SIZE = RING_SIZE;
    HOME_SPEED = COMMAND + offset_of!(HomeCommand, speed) as u16;
    HOME_SLOW_SPEED = COMMAND + offset_of!(HomeCommand, slow_speed) as u16;
    HOME_UP = COMMAND + offset_of!(HomeCommand, up) as u16;
    HOME_DOWN = COMMAND + offset_of!(HomeCommand, down) as u16;
    HOME_STROKE = COMMAND + offset_of!(HomeCommand, stroke) as u16;
    HOME_WAIT = COMMAND + offset_of!(HomeCommand, wait) as u16;
    HOME_CLEARANCE = COMMAND + offset_of!(HomeCommand, clearance) as u16;
    // Of a probe: inputs 1 to 16 that count, and those of them that must be off.
    PROBE_AND = at!(TIME);
    PROBE_XOR = at!(TIME) + 2;
    // Without handlers nothing else is there.
    SPIN = (if LINES == 1 { at!(SPIN_APART) } else { vm_at(offset_of!(vm::State, handler)) });
    // A run gives an upload up: F while an error handler is open lies in its place.
    FEED_ASIDE = at!(OPEN);
    // At rest, where the pool holds variables: slot_check forgets LEFT again.
    CHECK_SCRATCH = (if PART.at_room == 0 { POOL } else { at!(INC) });
    // MOTION: how the motion under way goes on.
    // Brake to a pause, or rest in one.
    M_PAUSE = 1;
    // Lines of a course are left.
    M_COURSE = 2;
    // The line ends at speed, EXIT2: the next one is planned while its last segments play.
    M_THROUGH = 4;
    // That one waits for its first segment to begin: NEXT_ is what changes then.
    M_NEXT = 8;
    // Brake, then forget the rest.
    M_STOP = 16;
    // The commanded places will be where it ends.
    M_SETTLE = 64;
    // Brake when the host falls silent; the link's bit for it.
    M_JOG = 32;
    // WATCH: no more steps are made.
    WATCH_ENDS = 1;
    // RUN_FLAGS.
    // WaitStart, and Start was not pressed yet.
    R_WAITING = 1;
    // Half a second has passed since reset.
    R_BOOTED = 2;
    // TIMEDOUT.
    R_TIMED_OUT = 4;
    // A host has spoken since reset.
    R_HOST = 8;
    // The low word of a lock code was given.
    R_HALF = 16;
    // A word of a lock code was wrong: none is taken until reset.
    R_WRONG = 32;
    // The courses of this run are taken: not once a host traced where one might have begun, as lines of it may have
    // passed.
    R_COURSES = 64;
    // Reset the chip once the reply is out; its sign.
    R_RESTART = 128;
    // TRACING.
    // Trace mode.
    T_ON = 1;
    // The slot holds an event that was not received.
    T_FULL = 2;
    // The host knows of the line that is being printed.
    T_ANNOUNCED = 4;
    // The line that is being put does not fit.
    T_DROPPED = 8;
    // A quarter of a second, of those left until trace mode ends:
    T_QUARTER = QUARTER;
    T_HEARD = 7 * QUARTER;
    // Program and profile are locked; its sign.
    T_LOCKED = 128;
    // EFFECT.
    // No opcode of this part.
    EFFECT_END = 0xff;
    // What an effect returns in r12, besides FAULTED + fault number.
    DONE = 0;
}

// HIT: a single axis. WATCH: no more steps, as an emergency stop has answered at its pin. Both with their sign.
core::arch::global_asm!(
    ".set LONE, {lone}",
    ".set TRIPPED, {tripped}",
    ".set ram.pool, POOL",
    ".set ram.stack, POOL_END",
    ".global POOL, POOL_END, VM_PC, VM_SP, VM_TOP, VM_CODE, VM_CELLS, VM_CALLS, VM_BASE, VM_DATA, VM_HANDLER",
    ".global T_ON, T_HEARD, T_FULL",
    ".global VM_FAULT_PC, VM_FAULT, FAULT_IN, VM_POLL, VM_FLAGS, VM_CELL_COUNT, ENDING",
    lone = const -1i16,
    tripped = const -1i16,
);
