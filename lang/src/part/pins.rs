//! The pin plan of the MSP-EXP430F5529LP: what each pin does, and what pins without a use yet are kept for.
//!
//! The plan stands here once. The firmware takes its masks from it, the tables of `firmware/README.md` are made of it, and
//! with them the pictures of the book and the workbench's pages; the emulated board is tested against it.
//!
//! Erratum PORT16 (SLAZ314, 6.59): while the boot code runs that follows a brown-out reset, another edge at RST makes the chip
//! drive those pins low, for some 0.5 ms, that the smallest package of the family lacks: P3.5 to P3.7, P5.6, P5.7, P7 and
//! P8. What must not become low by itself has one of the other pins; [`Pin::in_every_package`] says which.

/// A pin of the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pin {
    /// Number of its port, 1 to 8.
    pub port: u8,
    /// Number in the port, 0 to 7.
    pub bit: u8,
    /// Where it is found: number of its header's pin, name of a part of the board, empty for what stays on the board.
    pub at: &'static str,
}

impl Pin {
    const fn new(port: u8, bit: u8, at: &'static str) -> Pin {
        Pin { port, bit, at }
    }

    /// Its bit in its port's registers.
    pub const fn mask(self) -> u8 {
        1 << self.bit
    }

    /// Whether the smallest package of the family has it, too: erratum PORT16 does not drive it.
    pub const fn in_every_package(self) -> bool {
        match self.port {
            3 => self.bit < 5,
            5 => self.bit < 6,
            port => port < 7,
        }
    }
}

/// Bits of several pins of one port in its registers.
pub const fn mask(pins: &[Pin]) -> u8 {
    let (mut n, mut bits) = (0, 0);
    while n < pins.len() {
        assert!(pins[n].port == pins[0].port, "pins of one port");
        bits |= pins[n].mask();
        n += 1;
    }
    bits
}

/// STEP of X, Y, Z: TA0.1 to TA0.3.
pub const STEP: [Pin; 3] = [Pin::new(1, 2, "35"), Pin::new(1, 3, "36"), Pin::new(1, 4, "37")];
/// DIR of X, Y, Z.
pub const DIR: [Pin; 3] = [Pin::new(6, 0, "23"), Pin::new(6, 1, "24"), Pin::new(6, 2, "25")];
/// Start: button of the board, contact at the header.
pub const START: [Pin; 2] = [Pin::new(2, 1, "button S1"), Pin::new(7, 4, "17")];
/// Stop: button of the board, contact at the header.
pub const STOP: [Pin; 2] = [Pin::new(1, 1, "button S2"), Pin::new(2, 0, "19")];
/// Inputs 1 to 4 of the direct wiring. The first one is the probe, input 17, of the chain wiring.
pub const INPUTS: [Pin; 4] =
    [Pin::new(2, 4, "39"), Pin::new(2, 5, "40"), Pin::new(2, 6, "13"), Pin::new(2, 7, "8")];
/// SPI of the chain wiring: out, in, clock (UCB0).
pub const CHAIN: [Pin; 3] = [Pin::new(3, 0, "15"), Pin::new(3, 1, "14"), Pin::new(3, 2, "7")];
/// Output 1 of the direct wiring, latch of the chain wiring.
pub const LATCH: Pin = Pin::new(1, 6, "5");
/// Output 2 of the direct wiring, output enable of the chain wiring, active low.
pub const ENABLE: Pin = Pin::new(6, 3, "26");
/// RS-485: transmit, receive (UCA0).
pub const RS485: [Pin; 2] = [Pin::new(3, 3, "4"), Pin::new(3, 4, "3")];
/// RS-485: high while the board drives the line.
pub const DRIVE: Pin = Pin::new(4, 0, "33");
/// PWM: TB0.5.
pub const PWM: Pin = Pin::new(3, 5, "30");
/// Analog output, a second PWM: TB0.6.
pub const ANALOG_OUT: Pin = Pin::new(3, 6, "29");
/// High: the outputs of TB0 are let go, without any software (TB0OUTH).
pub const PWM_OFF: Pin = Pin::new(3, 7, "32");
/// The back channel of the board's USB: transmit, receive (UCA1).
pub const LINK: [Pin; 2] = [Pin::new(4, 4, ""), Pin::new(4, 5, "")];
/// The crystal XT2.
pub const CRYSTAL: [Pin; 2] = [Pin::new(5, 2, ""), Pin::new(5, 3, "")];
/// LEDs of the board, in two ports.
pub const LEDS: [Pin; 2] = [Pin::new(1, 0, "LED1"), Pin::new(4, 7, "LED2")];

/// STEP of a fourth axis: TA0.4.
pub const STEP_A: Pin = Pin::new(1, 5, "38");
/// DIR of a fourth axis.
pub const DIR_A: Pin = Pin::new(8, 2, "31");
/// Analog inputs: channels A4, A5, A6 and A12 of the converter.
pub const ANALOG: [Pin; 4] =
    [Pin::new(6, 4, "27"), Pin::new(6, 5, "2"), Pin::new(6, 6, "6"), Pin::new(7, 0, "28")];
/// Counters: the clock of TA2, and TA2.0 by capture. Both have port interrupts.
pub const COUNTERS: [Pin; 2] = [Pin::new(2, 2, "18"), Pin::new(2, 3, "12")];
/// A quadrature pair of the chain wiring; with port interrupts.
pub const QUADRATURE: [Pin; 2] = [Pin::new(2, 6, "13"), Pin::new(2, 7, "8")];
/// A flash memory: data out, data in, clock, which UCB1 gets by port mapping, and select.
pub const FLASH: [Pin; 4] =
    [Pin::new(4, 1, "10"), Pin::new(4, 2, "9"), Pin::new(4, 3, "34"), Pin::new(8, 1, "11")];

/// A row of the manual's tables.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The pins, in the order of the words.
    pub pins: &'static [Pin],
    /// What they do in the direct wiring.
    pub direct: &'static str,
    /// What they do in the chain wiring: [`SAME`] as above, or empty for nothing.
    pub chain: &'static str,
}

/// [`Row::chain`]: as in the direct wiring.
pub const SAME: &str = "the same";

const fn row(pins: &'static [Pin], direct: &'static str, chain: &'static str) -> Row {
    Row { pins, direct, chain }
}

/// Pins in use.
pub const ROWS: &[Row] = &[
    row(&STEP, "STEP X, Y, Z", SAME),
    row(&DIR, "DIR X, Y, Z", SAME),
    row(&START, "Start", SAME),
    row(&STOP, "Stop", SAME),
    row(&[INPUTS[0]], "reference X, input 1", "probe, input 17"),
    row(&[INPUTS[1]], "reference Y, input 2", ""),
    row(&[INPUTS[2]], "reference Z, input 3", ""),
    row(&[INPUTS[3]], "probe, input 4", ""),
    row(&CHAIN, "", "SPI out, in, clock"),
    row(&[LATCH], "output 1", "latch of both registers"),
    row(&[ENABLE], "output 2", "output enable of the 74HC595, low"),
    row(&RS485, "RS-485 transmit, receive", SAME),
    row(&[DRIVE], "RS-485: high while it drives", SAME),
    row(&[PWM], "PWM of a [laser, spindle or servo](../host/profiles.md#the-pwm-pwm)", SAME),
    row(&[ANALOG_OUT], "analog output 1 of [`SetAout`](../lang/README.md#the-analog-output)", SAME),
    row(
        &ANALOG,
        "analog inputs 1 to 4 of [`AIN`](../lang/README.md#analog-inputs), 0 to 3.3 V",
        SAME,
    ),
    row(&[PWM_OFF], "high lets go of the pins of PWM and analog output", SAME),
    row(&LINK, "UART transmit, receive: the back channel of the board's USB", SAME),
];

/// Pins that the firmware pulls down and does not use yet. Whoever wires something else to them will have to move it.
pub const RESERVED: &[Row] = &[
    row(&[STEP_A], "kept for STEP A (TA0.4)", SAME),
    row(&[DIR_A], "kept for DIR A", SAME),
    row(&[COUNTERS[0]], "kept for counter 1 (TA2CLK) and the self-test", SAME),
    row(
        &[COUNTERS[1]],
        "kept for counter 2 (TA2.0) or reference A, and the self-test",
        "kept for counter 2 (TA2.0) and the self-test",
    ),
    row(&QUADRATURE, "", "kept for quadrature A, B"),
    row(&FLASH, "kept for flash SIMO, SOMI, CLK, select", SAME),
];

/// What must not be driven low by erratum PORT16.
const NEVER_LOW: [Pin; 5] = [LATCH, ENABLE, STEP[0], STEP[1], STEP[2]];
const _: () = {
    let mut n = 0;
    while n < NEVER_LOW.len() {
        assert!(NEVER_LOW[n].in_every_package());
        n += 1;
    }
};

/// The manual's table of some rows, with the head of its first column.
#[cfg(feature = "compiler")]
pub fn table(rows: &[Row], first: &str) -> String {
    let mut text =
        format!("| {first} | `direct` wiring | `chain` wiring (default) |\n|---|---|---|\n");
    for row in rows {
        let names: Vec<String> =
            row.pins.iter().map(|pin| format!("P{}.{}", pin.port, pin.bit)).collect();
        let places: Vec<&str> =
            row.pins.iter().map(|pin| pin.at).filter(|at| !at.is_empty()).collect();
        let places =
            if places.is_empty() { String::new() } else { format!(" ({})", places.join(", ")) };
        text += &format!("| {}{places} | {} | {} |\n", names.join(", "), row.direct, row.chain);
    }
    text.replace("|  |", "| |")
}
