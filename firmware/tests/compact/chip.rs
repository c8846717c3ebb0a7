//! Calls single routines of the image: registers and RAM in, registers and RAM out.

use emulator::{Board, Config, Image, Part, Stop, TICKS_PER_SECOND, Wiring};
use firmware::motion::scaled::Scaled;

/// Rate of the step timer, for the planner.
pub const CLOCK: Scaled = Scaled::constant(lang::part::G2553.clock);

const IMAGE: &[u8] = include_bytes!("../../image/pasapas-whole.elf");
/// Where a routine returns to: nothing runs there.
pub const BACK: u16 = 0xFDFE;
/// From reset to the main loop, without a program: the supply has been waited for.
pub const BOOT_US: u64 = 100_000;
/// The machine stack's end.
pub const STACK: u16 = 0x0400;

/// The chip of [`firmware::WHOLE`].
fn chip() -> Part {
    Part { name: firmware::WHOLE.chip.name, flash: 0x8000..=0xFFFF, ..Part::G2553 }
}

/// A chip that has just been reset and does nothing on its own.
#[derive(Clone)]
pub struct Chip {
    /// The emulated board.
    pub board: Board,
}

impl Chip {
    /// A chip at reset, RAM all 0, watchdog off, interrupts off.
    pub fn new() -> Chip {
        Chip::wired(Wiring::Chain)
    }

    /// The same with this wiring.
    pub fn wired(wiring: Wiring) -> Chip {
        let image = Image::parse(IMAGE).expect("the shipped image is an ELF file");
        let mut board =
            Board::with_config(&Config { part: chip(), wiring, ..Config::default() }, &image);
        board.set_breakpoint(BACK);
        let mut chip = Chip { board };
        chip.quiet();
        chip
    }

    /// Power off and on: RAM all 0, watchdog off.
    pub fn restart(&mut self) {
        self.board.power_cut();
        self.board.power_up();
        self.quiet();
    }

    fn quiet(&mut self) {
        let board = &mut self.board;
        for address in (0x0200..STACK).step_by(2) {
            board.poke16(address, 0);
        }
        // 16 MHz from the factory calibration, as the flash controller wants it.
        let (range, step) = (board.peek8(0x10F9), board.peek8(0x10F8));
        board.bus_write8(0x0057, range);
        board.bus_write8(0x0056, step);
        // ACLK from the VLO: a routine may set the watchdog to it (SLAU144, 5.3.4).
        board.bus_write8(0x0053, 0x20);
        board.bus_write16(0x0120, 0x5A80);
    }

    /// The address of a symbol of the assembly.
    pub fn at(&self, symbol: &str) -> u16 {
        self.board.symbol(symbol).unwrap_or_else(|| panic!("the image has no {symbol}"))
    }

    /// The 32-bit value at a symbol plus an offset.
    pub fn long(&self, symbol: &str, offset: u16) -> u32 {
        let at = self.at(symbol) + offset;
        u32::from(self.board.peek16(at + 2)) << 16 | u32::from(self.board.peek16(at))
    }

    /// Writes a 32-bit value at a symbol plus an offset.
    pub fn set_long(&mut self, symbol: &str, offset: u16, value: u32) {
        let at = self.at(symbol) + offset;
        self.board.poke16(at, value as u16);
        self.board.poke16(at + 2, (value >> 16) as u16);
    }

    /// The word at a symbol.
    pub fn word(&self, symbol: &str) -> u16 {
        self.board.peek16(self.at(symbol))
    }

    /// Writes the word at a symbol.
    pub fn set_word(&mut self, symbol: &str, value: u16) {
        let at = self.at(symbol);
        self.board.poke16(at, value);
    }

    /// The byte at a symbol.
    pub fn byte(&self, symbol: &str) -> u8 {
        self.board.peek8(self.at(symbol))
    }

    /// Writes the byte at a symbol.
    pub fn set_byte(&mut self, symbol: &str, value: u8) {
        let at = self.at(symbol);
        self.board.poke8(at, value);
    }

    /// Calls a routine with these registers set; returns the cycles that it took.
    ///
    /// # Panics
    /// It hangs, or the machine stack is not what it was.
    pub fn call(&mut self, routine: &str, registers: &[(usize, u16)]) -> u64 {
        self.call_at(self.at(routine), routine, registers)
    }

    /// As [`Chip::call`], of code at an address; at an odd one of micro-code.
    ///
    /// # Panics
    /// As [`Chip::call`].
    pub fn call_at(&mut self, address: u16, routine: &str, registers: &[(usize, u16)]) -> u64 {
        self.try_at(address, routine, registers)
            .unwrap_or_else(|| panic!("power fails in {routine}"))
    }

    /// As [`Chip::call`]; `None` when power failed on the way.
    ///
    /// # Panics
    /// As [`Chip::call`].
    pub fn try_call(&mut self, routine: &str, registers: &[(usize, u16)]) -> Option<u64> {
        self.try_at(self.at(routine), routine, registers)
    }

    fn try_at(&mut self, address: u16, routine: &str, registers: &[(usize, u16)]) -> Option<u64> {
        self.board.poke16(STACK - 2, BACK);
        for &(register, value) in registers {
            self.board.set_reg(register, value);
        }
        self.board.set_reg(2, 0);
        self.board.set_reg(1, STACK - 2);
        if address & 1 == 1 {
            self.board.set_reg(11, address);
            self.board.set_reg(0, self.at("micro_enter"));
        } else {
            self.board.set_reg(0, address);
        }
        let start = self.board.cycles();
        let stop = self.board.run_until(start + TICKS_PER_SECOND);
        if stop == Stop::NoPower {
            return None;
        }
        assert_eq!(stop, Stop::Breakpoint(BACK.into()), "{routine} hangs");
        assert_eq!(self.board.reg(1), STACK, "{routine} leaves the machine stack in disorder");
        Some(self.board.cycles() - start)
    }

    /// A register.
    pub fn reg(&self, n: usize) -> u16 {
        self.board.reg(n)
    }

    /// r13:r12.
    pub fn result(&self) -> u32 {
        u32::from(self.reg(13)) << 16 | u32::from(self.reg(12))
    }
}
