//! Port mapping of P4 (SLAU208, chapter 13; SLAS590, "Port Mapping, Mnemonics and Functions").

/// What opens the registers.
const KEY: u16 = 0x2D52;
const READ_KEY: u16 = 0x96A5;
const LOCKED: u16 = 0x01;
const RECONFIGURE: u16 = 0x02;

/// Functions behind a reset.
const DEFAULT: [u8; 8] = [13, 15, 14, 16, 12, 11, 0, 0];

/// A function that a mapped pin can have; what the emulator does not drive is not named.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// Nothing, or what is not modelled.
    None,
    /// Output and capture input of a channel of TB0.
    Tb0(u8),
    /// High level switches all outputs of TB0 off.
    Tb0OutH,
    /// Receive pin of USCI_A1.
    Uca1Rx,
    /// Transmit pin of USCI_A1.
    Uca1Tx,
    /// Data to USCI_B1.
    Ucb1Somi,
    /// Data from USCI_B1.
    Ucb1Simo,
    /// Clock of USCI_B1.
    Ucb1Clk,
}

/// Registers.
#[derive(Debug, Clone)]
pub struct Pmap {
    open: bool,
    /// It was open once since the reset.
    used: bool,
    reconfigure: bool,
    map: [u8; 8],
}

impl Default for Pmap {
    fn default() -> Self {
        Pmap { open: false, used: false, reconfigure: false, map: DEFAULT }
    }
}

impl Pmap {
    /// Reads PMAPKEYID or PMAPCTL.
    pub fn read(&self, addr: u16) -> u16 {
        if addr == 0x1C0 {
            return READ_KEY;
        }
        let locked = if self.open { 0 } else { LOCKED };
        locked | if self.reconfigure { RECONFIGURE } else { 0 }
    }

    /// Writes PMAPKEYID or PMAPCTL.
    pub fn write(&mut self, addr: u16, value: u16) {
        if addr == 0x1C0 {
            let may = self.open || !self.used || self.reconfigure;
            self.open = value == KEY && may;
            self.used |= self.open;
        } else if self.open {
            self.reconfigure = value & RECONFIGURE != 0;
        }
    }

    /// P4MAPn
    pub fn map(&self, n: usize) -> u8 {
        self.map[n & 7]
    }

    /// Writes P4MAPn. False when the registers are closed.
    pub fn set(&mut self, n: usize, value: u8) -> bool {
        if self.open {
            self.map[n & 7] = value;
        }
        self.open
    }

    /// Function of P4.n while it is selected.
    pub fn function(&self, n: usize) -> Function {
        match self.map[n & 7] {
            3 => Function::Tb0OutH,
            channel @ 4..=10 => Function::Tb0(channel - 4),
            11 => Function::Uca1Rx,
            12 => Function::Uca1Tx,
            14 => Function::Ucb1Somi,
            15 => Function::Ucb1Simo,
            16 => Function::Ucb1Clk,
            _ => Function::None,
        }
    }
}
