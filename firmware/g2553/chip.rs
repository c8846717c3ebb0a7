//! Registers of the MSP430G2553 by their names (SLAS735, peripheral file map; SLAU144), and what is written there.

use crate::consts::constants;

/// Address of the watchdog's control register (SLAU144, 10.3.1).
pub const WATCHDOG: u16 = 0x0120;

/// Password, counter clear, from ACLK (VLO), over 512: 43 ms typical, 25 to 128 ms.
pub const WATCHDOG_KICK: u16 = 0x5A00 | 1 << 3 | 1 << 2 | 0b10;

/// FCTL3's locks, without its password.
const FLASH_LOCK: u16 = 1 << 4;

constants! {
    // Special function registers.
    IE2 = 0x01;
    IFG1 = 0x02;
    // Ports.
    P1IN = 0x20;
    P1OUT = 0x21;
    P1IFG = 0x23;
    P1IES = 0x24;
    P1IE = 0x25;
    P1SEL = 0x26;
    P1REN = 0x27;
    P1SEL2 = 0x41;
    P2OUT = 0x29;
    P2DIR = 0x2A;
    P2SEL = 0x2E;
    // Clocks, and what the factory has found for 16 MHz.
    BCSCTL3 = 0x53;
    DCOCTL = 0x56;
    BCSCTL1 = 0x57;
    CALDCO_16MHZ = 0x10F8;
    CALBC1_16MHZ = 0x10F9;
    // USCI_A0, the serial line.
    UCA0CTL0 = 0x60;
    UCA0CTL1 = 0x61;
    UCA0BR0 = 0x62;
    UCA0BR1 = 0x63;
    UCA0MCTL = 0x64;
    UCA0RXBUF = 0x66;
    UCA0TXBUF = 0x67;
    UCA0RXIE = 1;
    UCA0TXIE = 2;
    // USCI_B0, the chain.
    UCB0CTL0 = 0x68;
    UCB0CTL1 = 0x69;
    UCB0BR0 = 0x6A;
    UCB0STAT = 0x6D;
    UCB0RXBUF = 0x6E;
    UCB0TXBUF = 0x6F;
    // UCB0CTL1: from SMCLK, not held in reset as it is after one. UCB0CTL0: data captured on the first edge, most
    // significant bit first, master, synchronous. UCB0STAT: busy (SLAU144, 16.4).
    UCB_RUN = 0b10 << 6;
    UCB_MASTER = 1 << 7 | 1 << 5 | 1 << 3 | 1;
    UCB_BUSY = 1;
    WATCHDOG = WATCHDOG;
    KICK = WATCHDOG_KICK;
    // The same register: stopped, as it is from reset to the main loop.
    WATCHDOG_OFF = 0x5A00 | 1 << 7;
    // The flash controller: FCTL1 with its password (SLAU144, 7.4), the bits by which FCTL2 and FCTL3 differ from that.
    FCTL1 = 0x0128;
    FCTL2 = 0x012A;
    FCTL3 = 0x012C;
    FLASH_WRITE = 0xA500 | 1 << 6;
    FLASH_ERASE = 0xA500 | 1 << 1;
    FLASH_CLOCK = 1 << 6 | 39;
    FLASH_LOCK = FLASH_LOCK;
    // Timer0_A: the millisecond, in its ticks, and the silence of the link.
    TA0CTL = 0x0160;
    TA0CCTL0 = 0x0162;
    TA0CCTL1 = 0x0164;
    TA0R = 0x0170;
    TA0CCR0 = 0x0172;
    TA0CCR1 = 0x0174;
    TICKS_A_MS = 2000;
    // Timer1_A: the steps.
    TA1CTL = 0x0180;
    TA1CCTL0 = 0x0182;
    TA1CCTL1 = 0x0184;
    TA1CCTL2 = 0x0186;
    TA1R = 0x0190;
    TA1CCR0 = 0x0192;
    TA1CCR1 = 0x0194;
    TA1CCR2 = 0x0196;
    // Of either timer: a compare register interrupts.
    CCIE = 1 << 4;
    // The converter.
    ADC10CTL0 = 0x01B0;
    ADC10CTL1 = 0x01B2;
    ADC10MEM = 0x01B4;
    // The converter, which measures half the supply (channel 11), by its own clock over 8 (SLAU144, 22.3).
    ADC_HALF_SUPPLY = 11 << 12 | 7 << 5;
    // Against the reference, of 2.5 V and switched on, 64 clocks of sampling, converter on, begin.
    ADC_SAMPLE = 1 << 13 | 3 << 11 | 1 << 6 | 1 << 5 | 1 << 4 | 3;
    ADC_BUSY = 1;
    // 3.0 V. The reference is good for 6 %: a supply of 3.3 V less 3 % is always enough.
    SUPPLY_UP = 3000 / 2 * 1023 / 2500;
}

// For tests that take the main loop's place.
core::arch::global_asm!(".global P1OUT, P1REN, P2DIR, WATCHDOG, WATCHDOG_OFF");
