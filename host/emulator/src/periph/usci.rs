//! What the USCI modules have in common: their registers, by name, as each family places them.

/// Receive flag of a module in its flag register.
pub const RX: u8 = 0x01;
/// Transmit flag of a module in its flag register.
pub const TX: u8 = 0x02;

/// A register of a USCI module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Register {
    /// UCxCTL0
    Ctl0,
    /// UCxCTL1
    Ctl1,
    /// UCxBR0
    Br0,
    /// UCxBR1
    Br1,
    /// UCAxMCTL; UCBxI2CIE
    Mctl,
    /// UCxSTAT
    Stat,
    /// UCxRXBUF
    RxBuf,
    /// UCxTXBUF
    TxBuf,
    /// One of the registers for IrDA and automatic rates, stored only.
    Other(u8),
}

impl Register {
    /// The register of an MSP430x2xx module at `offset` from UCxCTL0, whose other registers lie in
    /// front of it.
    pub fn of_2xx(offset: i16) -> Register {
        match offset {
            0 => Register::Ctl0,
            1 => Register::Ctl1,
            2 => Register::Br0,
            3 => Register::Br1,
            4 => Register::Mctl,
            5 => Register::Stat,
            6 => Register::RxBuf,
            7 => Register::TxBuf,
            _ => Register::Other((offset + 3).clamp(0, 2) as u8),
        }
    }

    /// The register of an MSP430x5xx module at `offset` from UCxCTL1 (SLAU208, tables 36-4 and
    /// 37-3), `None` where there is none.
    pub fn of_5xx(offset: u16) -> Option<Register> {
        Some(match offset {
            0x00 => Register::Ctl1,
            0x01 => Register::Ctl0,
            0x06 => Register::Br0,
            0x07 => Register::Br1,
            0x08 => Register::Mctl,
            0x0A => Register::Stat,
            0x0C => Register::RxBuf,
            0x0E => Register::TxBuf,
            0x10 => Register::Other(0),
            0x12 => Register::Other(1),
            0x13 => Register::Other(2),
            _ => return None,
        })
    }
}
