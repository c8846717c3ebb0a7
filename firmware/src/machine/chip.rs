//! The hardware interface: what a chip provides to the machine. Everything else in this module is the same on every chip.
//!
//! A chip is given as a handle that is cloned freely. On the MSP430F5529 the handle has no size and each method is a
//! call of a function of the image (`firmware/f5529/port.rs`); on the desktop it refers to one simulated chip, so that
//! any number of machines live in one process. Addresses are those of the chip's 64 KB; times are in the
//! units that each method names.

use core::ops::Deref;

use crate::machine::vm::Vm;
use crate::motion::{PathSegment, Segment};
use lang::part::Part;
use lang::record::{BoardRecord, MachineRecord};
use lang::wire::Seen;

/// Memory by address: flash, and the RAM that programs and streamed pieces use.
pub trait Memory {
    /// The board's profile in place: a record of flash, or a copy of it that is decoded.
    type Profile: Deref<Target = BoardRecord> + Clone;
    /// The axes' part of a program's profile in place.
    type Axes: Deref<Target = MachineRecord> + Clone;

    /// The byte at an address.
    fn byte(&self, address: u16) -> u8;
    /// The word at an even address.
    fn word(&self, address: u16) -> u16;
    /// Changes a word of [`Memory::pool`] or [`Memory::frame`].
    fn set_word(&self, address: u16, word: u16);
    /// The 32-bit value at an even address, low word first.
    fn long(&self, address: u16) -> i32;
    /// Changes a 32-bit value of [`Memory::pool`].
    fn set_long(&self, address: u16, value: i32);
    /// Copies words from one even address to another, between which they do not overlap.
    fn copy(&self, from: u16, to: u16, words: u16);
    /// Lets `read` look at `length` bytes from an address on.
    fn with_bytes<R>(&self, address: u16, length: u16, read: impl FnOnce(&[u8]) -> R) -> R;

    /// Address of the pool: [`MEMORY_WORDS`](crate::machine::pool::MEMORY_WORDS) words of RAM.
    fn pool(&self) -> u16;
    /// Address of the image of the streamed piece that runs: [`FRAME_WORDS`](crate::machine::stream::FRAME_WORDS)
    /// words of RAM.
    fn frame(&self) -> u16;
    /// Address of an END instruction that belongs to no program.
    fn nothing(&self) -> u16;

    /// Clears bits of a word of flash, in the program area or the information memory.
    fn write(&self, address: u16, word: u16);
    /// Erases the segment of flash at an address.
    fn erase(&self, address: u16);

    /// The profile at an address, which holds a whole record.
    fn profile_at(&self, address: u16) -> Self::Profile;
    /// The profile of a board that was never given one.
    fn default_profile(&self) -> Self::Profile;
    /// Where a profile lies.
    fn address_of(profile: &Self::Profile) -> u16;
    /// The axes' part of the profile at an even address.
    fn axes_at(&self, address: u16) -> Self::Axes;
    /// That of a board without a program: a command's own parameters decide.
    fn free_axes(&self) -> Self::Axes;
}

/// The axes' part of the profile where no program is stored.
pub const FREE: MachineRecord = MachineRecord {
    flags: 0,
    keeps: 0,
    corner: 20,
    default_feed: 0,
    axes: [lang::record::AxisRecord::FREE; 3],
};

/// What chips do in assembly: their arithmetic, the VM's core, the check of an image.
pub trait Core: Sized {
    /// `a * b / c`, rounded down; all ones if it does not fit.
    fn mul_div(a: u32, b: u32, c: u32) -> u32;
    /// One byte more into a CRC ([`lang::wire::crc16`]).
    fn crc(crc: u16, byte: u8) -> u16;
    /// Runs the VM to the next instruction that it leaves to the machine, and returns its code; or to a fault, whose
    /// number it returns plus 100 hexadecimal; or returns [`YIELD`](crate::machine::vm::YIELD) or
    /// [`HANDLER_END`](crate::machine::vm::HANDLER_END).
    fn run(&self, vm: &mut Vm<Self>) -> u16
    where
        Self: Chip;
    /// Checks the image at an address, whose CRC is right; `scratch` is the address of
    /// [`SCRATCH`](crate::machine::stream::SCRATCH) bytes of RAM. Returns 0, or a refusal.
    fn check(&self, image: u16, features: u8, scratch: u16) -> u8;
}

/// The step engine: plays the segments that the planners make.
pub trait Steps {
    /// Bits of the axes' DIR pins.
    const DIR: [u8; 3];

    /// Whether any axis has an event ahead. Also as long as nobody has looked into why a pin stopped it.
    fn is_running(&self) -> bool;
    /// The same of one axis; the path runs on that of the first.
    fn axis_is_running(&self, axis: usize) -> bool;
    /// Empties the engine, for the next motion of either kind. Nothing runs.
    fn clear(&self);
    /// Sets the DIR pins that are low for the positive direction. Nothing runs.
    fn set_invert(&self, invert: u8);

    /// Whether a segment of a path would be taken.
    fn path_has_room(&self) -> bool;
    /// Time that the segments after the playing one last ([`queue::time`](crate::motion::queue::time)).
    fn ahead(&self) -> u16;
    /// Takes a segment of a path with its power; there must be room. A resting engine starts.
    fn put_path(&self, segment: &PathSegment, power: u16);
    /// Power of the segment that plays.
    fn power(&self) -> u16;
    /// Powers of segments are compare values of the PWM from now on.
    fn shine_at_pwm(&self);

    /// Whether a segment of an axis of its own would be taken.
    fn axis_has_room(&self, axis: usize) -> bool;
    /// Takes a segment of one axis; there must be room. A resting axis starts.
    fn put_axis(&self, axis: usize, segment: &Segment, negative: bool);

    /// Drops everything that is planned and waits for rest.
    fn halt(&self);
    /// The same of one axis that moves on its own; the others go on.
    fn halt_axis(&self, axis: usize);

    /// Adds the steps made since the last call to a position; at least every 32 767 steps.
    fn fold(&self, axis: usize, position: &mut i32);
    /// Makes the position of a resting axis known to the engine.
    fn set_count(&self, axis: usize, position: i32);

    /// Watches pins of inputs at every event: `pins` answer when they differ from `idle`. With `halt` the engine
    /// drops everything at that step, else it only notes the counts. No pins: not at all.
    fn watch(&self, pins: u8, idle: u8, halt: bool);
    /// The pins that answered, 0 for none.
    fn hit(&self) -> u8;
    /// Where an axis was when the pins answered, given its present position.
    fn caught(&self, axis: usize, position: i32) -> i32;
    /// Events that came late since reset, as they could not be armed in time. None of them lost a step or shortened a pulse.
    fn late(&self) -> u16;
    /// Has a spare timer measure at the pins for a self-test; `mode` as [`lang::wire::MEASURE`]. `false`: there is no such
    /// mode.
    fn measure(&self, mode: u16) -> bool;
    /// The mode in which it measures, 0 for none.
    fn measures(&self) -> u16;
    /// Register `n` of [`lang::wire::MEASURED`], from 0.
    fn measured(&self, n: u16) -> u16;
    /// Hardware revision of the chip.
    fn revision(&self) -> u16;
}

/// Pins that stop the step engine by themselves, between two passes of the main loop.
pub trait Guard {
    /// What stops the engine from now on: pins of the inputs' port, and inputs of the chain, input n in bit n - 1.
    fn guard(&self, pins: u8, inputs: u16);
    /// The pins that have answered, 1 for inputs of the chain, 0 for none.
    fn tripped(&self) -> u8;
    /// The inputs of the chain that have answered.
    fn answered(&self) -> u16;
}

/// Inputs, outputs, the PWM and the analog output.
pub trait Pins {
    /// Bit of the probe's pin in the inputs' port.
    const PROBE: u8;

    /// Sends the levels of outputs 1 to 16 to the chain and brings those of its inputs, number n in bit n - 1.
    fn exchange(&self, outputs: u16) -> u16;
    /// The same of the direct wiring: outputs 1 and 2, inputs 1 to 4, on when closed to ground.
    fn pins(&self, outputs: u16) -> u16;
    /// Level of the probe's pin: on when closed to ground.
    fn probe(&self) -> bool;
    /// Buttons: bit 0 Stop, bit 1 Start.
    fn buttons(&self) -> u16;
    /// The sum of four conversions of analog input `n`, from 0, in the last millisecond ([`crate::analog`]).
    fn analog(&self, n: u8) -> u16;
    /// Begins the next four conversions of each analog input.
    fn convert_analog(&self);
    /// Gives analog inputs their pins: bit n for input n, from 0.
    fn open_analog(&self, inputs: u8);
    /// Levels that the outputs get if an emergency stop comes while flash is busy.
    fn remember_stop(&self, outputs: u16);

    /// Starts the PWM with `hz` periods in a second, its pin low. Returns how far its timer counts, and its ticks in
    /// a millisecond.
    fn open_pwm(&self, hz: u16) -> (u16, u16);
    /// Sets the compare value from the next period on.
    fn set_pwm(&self, compare: u16);
    /// Lets the PWM's pin follow, or puts it low at once.
    fn gate_pwm(&self, on: bool);
    /// Starts the analog output's PWM with `hz` periods in a second, its pin low. Both PWMs have one timer. Returns how far it
    /// counts.
    fn open_aout(&self, hz: u16) -> u16;
    /// Lets the analog output's pin follow, high from this compare value to the period's end.
    fn set_aout(&self, compare: u16);
    /// Puts the analog output's pin low at once.
    fn darken_aout(&self);
}

/// Time, and what outlasts a reset.
pub trait Clock {
    /// Ticks of [`Clock::now`] in a millisecond.
    const PER_MS: u16;
    /// Rate of the step engine's timer, Hz.
    const RATE: u32;

    /// Milliseconds since reset, modulo 65536.
    fn millis(&self) -> u16;
    /// Called once in each millisecond: what a clock does by the way, such as to go back to a crystal that is good again.
    fn look_after_clock(&self);
    /// Time in ticks, modulo 65536.
    fn now(&self) -> u16;
    /// Bits that a failed crystal adds to the cause of the last reset.
    fn clock_fault(&self) -> u8;
    /// Remembers over any reset but power-up whether a program runs.
    fn mark(&self, runs: bool);
    /// What [`Clock::mark`] was given last.
    fn is_marked(&self) -> bool;
    /// Bytes of RAM that the stack has never reached since reset.
    fn stack_free(&self) -> u16;
}

/// Who observes the machine from outside, without being waited for.
pub trait Observed {
    /// An event of the trace ([`TraceKind`](lang::wire::TraceKind)), with the commanded places, steps, and the address
    /// of its statement in the code.
    fn event(&self, kind: u8, argument: u8, value: i32, commanded: &[i32; 3], pc: u16);
    /// Something that is no event; `byte` belongs to [`Seen::Byte`].
    fn beside(&self, what: Seen, byte: u8, pc: u16);
}

/// A chip.
pub trait Chip: Clone + Memory + Core + Steps + Guard + Pins + Clock + Observed {
    /// The part that it is.
    const PART: Part;
    /// Start of the program area.
    const AREA: u16;
    /// First address of the segment of the information memory for faults and selections.
    const LOG: u16;
}
