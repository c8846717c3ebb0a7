//! The commands of InterpCNC, written to holding register 2000 with their arguments after it.

/// An argument: what it is, and a value of an example.
#[cfg(any(test, feature = "compiler"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Argument {
    /// One register.
    Word(&'static str, u16),
    /// 32 bits with a sign, low word first.
    Long(&'static str, i32),
    /// A 32-bit IEEE 754 float, low word first.
    Float(&'static str, f32),
}

#[cfg(any(test, feature = "compiler"))]
impl Argument {
    /// What it is.
    pub const fn name(&self) -> &'static str {
        match self {
            Argument::Word(name, _) | Argument::Long(name, _) | Argument::Float(name, _) => name,
        }
    }

    /// The example's registers: the first one alone of a word.
    pub const fn registers(&self) -> (u16, Option<u16>) {
        let bits = match self {
            Argument::Word(_, value) => return (*value, None),
            Argument::Long(_, value) => value.cast_unsigned(),
            Argument::Float(_, value) => value.to_bits(),
        };
        (bits as u16, Some((bits >> 16) as u16))
    }
}

/// A command for documents and tests.
#[cfg(any(test, feature = "compiler"))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// What register 2000 takes.
    pub number: u16,
    /// What it does.
    pub meaning: &'static str,
    /// What stands from register 2001 on.
    pub arguments: &'static [Argument],
}

#[cfg(any(test, feature = "compiler"))]
impl Command {
    /// The registers of the example, from 2000 on.
    pub fn example(&self) -> Vec<u16> {
        let mut registers = vec![self.number];
        for argument in self.arguments {
            let (low, high) = argument.registers();
            registers.push(low);
            registers.extend(high);
        }
        registers
    }
}

macro_rules! commands {
    ($(
        $(#[doc = $doc:literal])+
        $name:ident = $number:literal: $($kind:ident $argument:literal = $value:literal),*;
    )*) => {
        $($(#[doc = $doc])+ pub const $name: u16 = $number;)*
        /// Every command.
        #[cfg(any(test, feature = "compiler"))]
        pub const ALL: &[Command] = &[$(Command {
            number: $number,
            meaning: concat!($($doc),+),
            arguments: &[$(Argument::$kind($argument, $value)),*],
        },)*];
    };
}

commands! {
    /// Stop one axis on its ramp; in a run, end the run.
    STOP_AXIS = 100: Word "axis, 1 to 3" = 1;
    /// Stop axes on their ramps; in a run, end the run.
    STOP_AXES = 101: Word "bit per axis" = 7;
    /// Run at a speed until stopped; ramps down 2 s after the last request.
    MOVE_SPEED = 102: Word "axis, 1 to 3" = 1, Long "ramp, st/s2" = 20_000,
        Long "speed with the direction's sign, st/s; 0 stops" = 1_000;
    /// Move to a work position.
    MOVE_TO = 103: Word "axis, 1 to 3" = 1, Long "ramp up, st/s2" = 20_000, Long "speed, st/s" = 2_000,
        Long "ramp down, st/s2" = 20_000, Long "work position, st" = 500;
    /// Move by a distance.
    MOVE_BY = 104: Word "axis, 1 to 3" = 1, Long "ramp up, st/s2" = 20_000, Long "speed, st/s" = 2_000,
        Long "ramp down, st/s2" = 20_000, Long "distance, st" = -500;
    /// The present place of a resting axis becomes this work position.
    SET_POSITION = 105: Word "axis, 1 to 3" = 1, Long "work position, st" = 0;
    /// Home with parameters.
    HOME = 106: Word "axis, 1 to 3" = 1, Word "0" = 0, Word "input from 0" = 8,
        Word "its state when closed" = 1, Word "1: switch at the positive end" = 0,
        Long "speed, st/s" = 2_000, Long "speed off the switch, st/s" = 400,
        Long "ramp up, st/s2" = 20_000, Long "ramp down, st/s2" = 20_000, Long "stroke, st" = 30_000,
        Word "rest, ms" = 50, Long "position where it opens, st" = 0,
        Long "clearance away from it, st" = 0;
    /// Probe by a distance until an input has the state.
    PROBE = 107: Word "axis, 1 to 3" = 3, Word "input from 0" = 16, Word "its state" = 1,
        Long "ramp up, st/s2" = 20_000, Long "speed, st/s" = 1_000, Long "ramp down, st/s2" = 20_000,
        Long "distance, st" = -300;
    /// Probe by a distance until ((inputs AND and) XOR xor) is not 0.
    PROBE_MASK = 108: Word "axis, 1 to 3" = 3, Long "and" = 0x1_0000, Long "xor" = 0,
        Long "ramp up, st/s2" = 20_000, Long "speed, st/s" = 1_000, Long "ramp down, st/s2" = 20_000,
        Long "distance, st" = -300;
    /// Force an input until it is freed or the board is reset; those with a role that stops the
    /// machine are refused.
    FORCE_INPUT = 110: Word "input from 0" = 0, Word "0 off, 1 on, 65535 free" = 65_535;
    /// Home an axis by the stored program's profile; there is none for all of them at once.
    HOME_PROFILE = 1110: Word "axis, 1 to 3" = 1;
    /// Move axes in a line, by the stored program's profile; ramps down 2 s after the last request.
    JOG = 1111: Word "bit per axis, and 64 for distances" = 65, Float "speed, mm/min" = 600.0,
        Float "position or distance, mm; one for each axis named, X first" = 1.0;
    /// Direct function.
    DIRECT = 1200: Word "its code" = 255;
}
