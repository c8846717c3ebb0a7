//! Things that the real part forbids, leaves undefined or does silently.

use std::fmt;

/// What kind of rule was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Read or write where the part has nothing.
    Unmapped,
    /// Word access at an odd address; the hardware rounds it down.
    Unaligned,
    /// Instruction fetch from the peripherals: the part resets.
    FetchFault,
    /// An encoding that is no instruction.
    IllegalInstruction,
    /// Byte access to a word register, or the reverse.
    RegisterWidth,
    /// Write to flash while LOCK is set, or without WRT or ERASE.
    FlashLocked,
    /// Flash timing generator outside 257 to 476 kHz.
    FlashClock,
    /// A flash word written more than twice between erases.
    FlashRewritten,
    /// A wrong key in a flash or watchdog register: the part resets.
    Key,
    /// The stack grew below its limit, into data.
    Stack,
    /// An open contact was read on a pin without pull resistor.
    FloatingInput,
    /// The chip samples data of the shift registers before they can be there.
    SpiSetup,
    /// The processor runs faster, or writes flash at a lower voltage, than the supply allows.
    Supply,
    /// The clock runs faster than the part allows, or at a rate that is emulated rounded.
    Clock,
    /// A word or byte operation cuts a register that holds more than 16 bits.
    PointerTruncated,
    /// Interrupts switched on and off again without an instruction between.
    InterruptsOnOff,
    /// Erratum CPU40: the word behind a jump makes the program counter go wrong.
    JumpErratum,
    /// The multiplier used both in a handler and, with interrupts on, outside of them.
    MultiplierShared,
    /// A result of the multiplier read before it was ready.
    MultiplierEarly,
    /// Flash read, fetched or written while an operation is under way.
    FlashBusy,
    /// Flash written with a supply or clock that is too low.
    FlashSupply,
    /// A row of flash under program voltage for more than 16 ms between erases.
    FlashRowTime,
    /// A flash mode that errata, the guide or an unknown of the silicon forbid here.
    FlashErratum,
    /// A write to a module that is closed.
    Closed,
    /// Core voltage raised by more than one level.
    CoreLevel,
    /// A pin's selected function does not exist.
    PinFunction,
    /// A mode that the emulator does not have.
    Unsupported,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Unmapped => "access to unmapped memory",
            Kind::Unaligned => "word access at an odd address",
            Kind::FetchFault => "instruction fetch from peripheral addresses",
            Kind::IllegalInstruction => "illegal instruction",
            Kind::RegisterWidth => "access of the wrong width to a register",
            Kind::FlashLocked => "write to locked flash",
            Kind::FlashClock => "flash clock outside 257 to 476 kHz",
            Kind::FlashRewritten => "flash word written more than twice without erase",
            Kind::Key => "wrong key in a protected register",
            Kind::Stack => "stack grew into data",
            Kind::FloatingInput => "open contact read without a pull resistor",
            Kind::SpiSetup => {
                "SPI faster than the shift registers' delay and the set-up time allow"
            }
            Kind::Supply => "supply too low for the processor's rate or for writing flash",
            Kind::Clock => "clock setting outside what the part or the emulator can do",
            Kind::PointerTruncated => "register with a 20-bit value cut to 16 bits",
            Kind::InterruptsOnOff => {
                "interrupts switched on and off without an instruction between"
            }
            Kind::JumpErratum => "jump in front of a word 0x?40 or 0x?50 (erratum CPU40)",
            Kind::MultiplierShared => "multiplier used where an interrupt may disturb it",
            Kind::MultiplierEarly => "multiplier result read before it was ready",
            Kind::FlashBusy => "flash accessed while it is busy",
            Kind::FlashSupply => "flash written with supply or clock too low",
            Kind::FlashRowTime => "flash row programmed for more than 16 ms between erases",
            Kind::FlashErratum => "flash mode that is forbidden here",
            Kind::Closed => "write to a closed module",
            Kind::CoreLevel => "core voltage raised by more than one level",
            Kind::PinFunction => "selected function that the pin does not have",
            Kind::Unsupported => "mode that the emulator does not have",
        })
    }
}

/// One broken rule, reported once for each place in the program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// When, in ticks of the board since power-up.
    pub cycle: u64,
    /// Address of the instruction.
    pub pc: u32,
    /// Address that was accessed.
    pub addr: u32,
    /// Which rule.
    pub kind: Kind,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Warning { cycle, pc, addr, kind } = self;
        write!(f, "{kind}: {addr:#06x} by the instruction at {pc:#06x}, cycle {cycle}")
    }
}

/// A bounded list of warnings, one for each kind and instruction.
#[derive(Debug, Clone, Default)]
pub struct Warnings {
    list: Vec<Warning>,
    seen: std::collections::HashSet<(Kind, u32)>,
}

/// More places than this are not remembered.
const LIMIT: usize = 1000;

impl Warnings {
    /// Adds a warning unless the same instruction broke the same rule before.
    pub fn add(&mut self, warning: Warning) {
        if self.list.len() < LIMIT && self.seen.insert((warning.kind, warning.pc)) {
            self.list.push(warning);
        }
    }

    /// All warnings in order of their first occurrence.
    #[must_use]
    pub fn list(&self) -> &[Warning] {
        &self.list
    }

    /// Forgets them.
    pub fn clear(&mut self) {
        self.list.clear();
        self.seen.clear();
    }
}
