//! Registers by their addresses (SLAS590, "Peripheral File Map"), named as in the user's guide SLAU208.
//!
//! The register crate for this chip needs an old version of the start-up crate, so it is not used.

use core::arch::asm;

/// A register of a byte.
#[derive(Clone, Copy)]
pub struct Byte(pub u16);

/// A register of a word.
#[derive(Clone, Copy)]
pub struct Word(pub u16);

impl Byte {
    /// The register so many addresses on.
    #[inline(always)]
    pub const fn after(self, bytes: u16) -> Byte {
        Byte(self.0 + bytes)
    }
}

impl Word {
    /// See [`Byte::after`].
    #[inline(always)]
    pub const fn after(self, bytes: u16) -> Word {
        Word(self.0 + bytes)
    }
}

// SAFETY (all accesses): each address is that of a register of this chip with this width, and a volatile
// access is one instruction.
impl Byte {
    #[inline(always)]
    pub fn get(self) -> u8 {
        unsafe { (self.0 as *const u8).read_volatile() }
    }

    #[inline(always)]
    pub fn set(self, value: u8) {
        unsafe { (self.0 as *mut u8).write_volatile(value) }
    }

    /// Sets bits by one instruction, as handlers change others of this register.
    #[inline(always)]
    pub fn raise(self, bits: u8) {
        unsafe { asm!("bis.b {0}, 0({1})", in(reg) bits, in(reg) self.0) }
    }

    /// Clears bits by one instruction.
    #[inline(always)]
    pub fn clear(self, bits: u8) {
        unsafe { asm!("bic.b {0}, 0({1})", in(reg) bits, in(reg) self.0) }
    }
}

// SAFETY: as above.
impl Word {
    #[inline(always)]
    pub fn get(self) -> u16 {
        unsafe { (self.0 as *const u16).read_volatile() }
    }

    #[inline(always)]
    pub fn set(self, value: u16) {
        unsafe { (self.0 as *mut u16).write_volatile(value) }
    }

    /// As [`Byte::raise`].
    #[inline(always)]
    pub fn raise(self, bits: u16) {
        unsafe { asm!("bis {0}, 0({1})", in(reg) bits, in(reg) self.0) }
    }
}

pub const SFRIE1: Word = Word(0x0100);
pub const SFRIFG1: Word = Word(0x0102);

pub const PMMCTL0: Word = Word(0x0120);
pub const PMMCTL0_L: Byte = Byte(0x0120);
pub const PMMCTL0_H: Byte = Byte(0x0121);
pub const SVSMHCTL: Word = Word(0x0124);
pub const SVSMLCTL: Word = Word(0x0126);
pub const PMMIFG: Word = Word(0x012C);
pub const PMMRIE: Word = Word(0x012E);

pub const FCTL1: Word = Word(0x0140);
pub const FCTL3: Word = Word(0x0144);

pub const WDTCTL: Word = Word(0x015C);

pub const UCSCTL0: Word = Word(0x0160);
pub const UCSCTL1: Word = Word(0x0162);
pub const UCSCTL2: Word = Word(0x0164);
pub const UCSCTL3: Word = Word(0x0166);
pub const UCSCTL4: Word = Word(0x0168);
pub const UCSCTL6: Word = Word(0x016C);
pub const UCSCTL7: Word = Word(0x016E);

pub const SYSRSTIV: Word = Word(0x019E);

pub const P1IN: Byte = Byte(0x0200);
pub const P2IN: Byte = Byte(0x0201);
pub const P1OUT: Byte = Byte(0x0202);
pub const P2OUT: Byte = Byte(0x0203);
pub const P1DIR: Byte = Byte(0x0204);
pub const P2DIR: Byte = Byte(0x0205);
pub const P1REN: Byte = Byte(0x0206);
pub const P2REN: Byte = Byte(0x0207);
pub const P1DS: Byte = Byte(0x0208);
pub const P1SEL: Byte = Byte(0x020A);
pub const P2SEL: Byte = Byte(0x020B);
pub const P2IES: Byte = Byte(0x0219);
pub const P2IE: Byte = Byte(0x021B);
pub const P2IFG: Byte = Byte(0x021D);
pub const P3OUT: Byte = Byte(0x0222);
pub const P4OUT: Byte = Byte(0x0223);
pub const P3DIR: Byte = Byte(0x0224);
pub const P4DIR: Byte = Byte(0x0225);
pub const P3REN: Byte = Byte(0x0226);
pub const P4REN: Byte = Byte(0x0227);
pub const P3SEL: Byte = Byte(0x022A);
pub const P4SEL: Byte = Byte(0x022B);
pub const P5OUT: Byte = Byte(0x0242);
pub const P6OUT: Byte = Byte(0x0243);
pub const P6DIR: Byte = Byte(0x0245);
pub const P5REN: Byte = Byte(0x0246);
pub const P6REN: Byte = Byte(0x0247);
pub const P6DS: Byte = Byte(0x0249);
pub const P5SEL: Byte = Byte(0x024A);
pub const P6SEL: Byte = Byte(0x024B);
pub const P7IN: Byte = Byte(0x0260);
pub const P7OUT: Byte = Byte(0x0262);
pub const P8OUT: Byte = Byte(0x0263);
pub const P8DIR: Byte = Byte(0x0265);
pub const P7REN: Byte = Byte(0x0266);
pub const P7SEL: Byte = Byte(0x026A);
pub const P8REN: Byte = Byte(0x0267);

pub const TA0CTL: Word = Word(0x0340);
pub const TA0CCTL0: Word = Word(0x0342);
pub const TA0R: Word = Word(0x0350);
pub const TA0CCR0: Word = Word(0x0352);
pub const TA0IV: Word = Word(0x036E);
pub const TA1CTL: Word = Word(0x0380);
pub const TA1CCTL0: Word = Word(0x0382);
pub const TA1CCTL1: Word = Word(0x0384);
pub const TA1CCTL2: Word = Word(0x0386);
pub const TA1R: Word = Word(0x0390);
pub const TA1CCR0: Word = Word(0x0392);
pub const TA1CCR1: Word = Word(0x0394);
pub const TA1CCR2: Word = Word(0x0396);

pub const TB0CTL: Word = Word(0x03C0);
pub const TB0R: Word = Word(0x03D0);
pub const TB0CCTL5: Word = Word(0x03CC);
pub const TB0CCTL6: Word = Word(0x03CE);
pub const TB0CCR0: Word = Word(0x03D2);
pub const TB0CCR5: Word = Word(0x03DC);
pub const TB0CCR6: Word = Word(0x03DE);

pub const TA2CTL: Word = Word(0x0400);
pub const TA2CCTL0: Word = Word(0x0402);
pub const TA2CCTL1: Word = Word(0x0404);
pub const TA2R: Word = Word(0x0410);
pub const TA2CCR0: Word = Word(0x0412);
pub const TA2CCR1: Word = Word(0x0414);

pub const UCA0CTL1: Byte = Byte(0x05C0);
pub const UCA0CTL0: Byte = Byte(0x05C1);
pub const UCA0BR0: Byte = Byte(0x05C6);
pub const UCA0BR1: Byte = Byte(0x05C7);
pub const UCA0MCTL: Byte = Byte(0x05C8);
pub const UCA0STAT: Byte = Byte(0x05CA);
pub const UCA0RXBUF: Byte = Byte(0x05CC);
pub const UCA0TXBUF: Byte = Byte(0x05CE);
pub const UCA0IE: Byte = Byte(0x05DC);

pub const UCB0CTL1: Byte = Byte(0x05E0);
pub const UCB0CTL0: Byte = Byte(0x05E1);
pub const UCB0BR0: Byte = Byte(0x05E6);
pub const UCB0BR1: Byte = Byte(0x05E7);
pub const UCB0STAT: Byte = Byte(0x05EA);
pub const UCB0RXBUF: Byte = Byte(0x05EC);
pub const UCB0TXBUF: Byte = Byte(0x05EE);

pub const UCA1CTL1: Byte = Byte(0x0600);
pub const UCA1CTL0: Byte = Byte(0x0601);
pub const UCA1BR0: Byte = Byte(0x0606);
pub const UCA1BR1: Byte = Byte(0x0607);
pub const UCA1MCTL: Byte = Byte(0x0608);
pub const UCA1STAT: Byte = Byte(0x060A);
pub const UCA1RXBUF: Byte = Byte(0x060C);
pub const UCA1TXBUF: Byte = Byte(0x060E);
pub const UCA1IE: Byte = Byte(0x061C);
pub const UCA1IFG: Byte = Byte(0x061D);

pub const ADC12CTL0: Word = Word(0x0700);
pub const ADC12CTL1: Word = Word(0x0702);
pub const ADC12CTL2: Word = Word(0x0704);
/// Control bytes of the 16 memories.
pub const ADC12MCTL: Byte = Byte(0x0710);
/// The 16 memories.
pub const ADC12MEM: Word = Word(0x0720);
