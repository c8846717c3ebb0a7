//! The pins of the LaunchPad: buttons, inputs, outputs, directions and shift registers.
//!
//! Which pin does what is the plan of `lang::part::pins`.

use super::clock::RATE;
use super::reg::{
    P1DIR, P1DS, P1IN, P1OUT, P1REN, P1SEL, P2DIR, P2IE, P2IES, P2IFG, P2IN, P2OUT, P2REN, P2SEL,
    P3DIR, P3OUT, P3REN, P3SEL, P4DIR, P4OUT, P4REN, P4SEL, P5OUT, P5REN, P5SEL, P6DIR, P6DS,
    P6OUT, P6REN, P6SEL, P7IN, P7OUT, P7REN, P7SEL, P8DIR, P8OUT, P8REN, UCB0BR0, UCB0BR1,
    UCB0CTL0, UCB0CTL1, UCB0RXBUF, UCB0STAT, UCB0TXBUF,
};
use core::arch::global_asm;
use core::mem::offset_of;
use lang::part::pins;
use lang::record::{BoardRecord, RECORD_VERSION};

const P1_STEP: u8 = pins::mask(&pins::STEP);
const P1_STOP: u8 = pins::STOP[0].mask();
const P2_START: u8 = pins::START[0].mask();
const P2_STOP: u8 = pins::STOP[1].mask();
const P7_START: u8 = pins::START[1].mask();
pub(super) const P3_CHAIN: u8 = pins::mask(&pins::CHAIN);
const P3_RS485: u8 = pins::mask(&pins::RS485);
const P3_RECEIVE: u8 = pins::RS485[1].mask();
/// Direction of the RS-485 line's transceiver, in its port.
pub const P4_DRIVE: u8 = pins::DRIVE.mask();
const P3_PWM: u8 = pins::PWM.mask();
const P3_AOUT: u8 = pins::ANALOG_OUT.mask();
const P3_PWM_OFF: u8 = pins::PWM_OFF.mask();
const P4_UART: u8 = pins::mask(&pins::LINK);
const P4_RECEIVE: u8 = pins::LINK[1].mask();
const P5_XT2: u8 = pins::mask(&pins::CRYSTAL);
/// LEDs of the board, which are off.
const P1_LED: u8 = pins::LEDS[0].mask();
const P4_LED: u8 = pins::LEDS[1].mask();

/// The first analog input's bit in port 6; the next two follow, the fourth is in port 7.
const P6_ANALOG: u32 = pins::ANALOG[0].bit as u32;
const P6_ANALOGS: u8 = pins::ANALOG[0].mask() | pins::ANALOG[1].mask() | pins::ANALOG[2].mask();
const P7_ANALOG: u8 = pins::ANALOG[3].mask();

/// The probe of the chain wiring among the [`inputs`].
pub const PROBE: u8 = pins::INPUTS[0].mask();
/// DIR of each axis, in the port of directions.
pub const DIR: [u8; 3] = [pins::DIR[0].mask(), pins::DIR[1].mask(), pins::DIR[2].mask()];
const DIRS: u8 = pins::mask(&pins::DIR);
/// Output 1, or the latch of the shift registers, in its port.
pub const LATCH: u8 = pins::LATCH.mask();
/// Output 2, or the output enable of the shift registers, in its port.
pub const ENABLE: u8 = pins::ENABLE.mask();

// The ports that this module writes are those of the plan; inputs 1 to 4 are the upper half of theirs.
const _: () = assert!(
    pins::STEP[0].port == 1
        && pins::STOP[0].port == 1
        && pins::START[0].port == 2
        && pins::STOP[1].port == 2
        && pins::START[1].port == 7
        && pins::CHAIN[0].port == 3
        && pins::RS485[0].port == 3
        && pins::PWM.port == 3
        && pins::ANALOG_OUT.port == 3
        && pins::PWM_OFF.port == 3
        && pins::DRIVE.port == 4
        && pins::LINK[0].port == 4
        && pins::CRYSTAL[0].port == 5
        && pins::DIR[0].port == 6
        && pins::LATCH.port == 1
        && pins::ENABLE.port == 6
        && pins::ANALOG[0].port == 6
        && P6_ANALOGS == 7 << P6_ANALOG
        && pins::ANALOG[3].port == 7
        && pins::INPUTS[0].port == 2
        && pins::mask(&pins::INPUTS) == 0xF0
);

/// For the handlers: levels of the inputs, flags of their edges, which edges, which of them answer.
pub const IN: u16 = P2IN.0;
/// See [`IN`].
pub const IFG: u16 = P2IFG.0;
/// See [`IN`].
pub const IES: u16 = P2IES.0;
/// See [`IN`].
pub const IE: u16 = super::reg::P2IE.0;
/// The port of directions, and that of the latch.
pub const DIR_OUT: u16 = P6OUT.0;
/// See [`DIR_OUT`].
pub const LATCH_OUT: u16 = P1OUT.0;
/// The port of [`ENABLE`].
pub const ENABLE_OUT: u16 = P6OUT.0;
/// See [`P4_DRIVE`].
pub const DRIVE_OUT: u16 = P4OUT.0;
/// The chain's SPI: status, received and sent byte.
pub const SPI_STAT: u16 = UCB0STAT.0;
/// See [`SPI_STAT`].
pub const SPI_RXBUF: u16 = UCB0RXBUF.0;
/// See [`SPI_STAT`].
pub const SPI_TXBUF: u16 = UCB0TXBUF.0;

// What `Reset` begins with, before it has touched RAM: STEP and DIR are driven, at full strength and at rest, within some
// thirty instructions; until then they float at whatever their resistors make of them. Full strength gives the 10 to 16 mA
// that optocouplers of drivers want (SLAS590, "Outputs - General Purpose I/O (Full Drive Strength)"). The copies of the
// profile say which level of STEP is at rest. Where they differ in it, as one may be older than a change, or cut short,
// STEP is not driven before the profile is known that holds: its resistor keeps it at rest. Without one of a copy, which is
// whole when its last word was written, nobody has said how the board is wired, and neither STEP nor DIR is driven.
global_asm!(
    r#"
    .section .text.ports,"ax",@progbits
module.chip.ports:
    .global pasapas_hold_steps
pasapas_hold_steps:
    mov.b #{step_strength}, &{p1ds}
    mov.b #{dir_strength}, &{p6ds}
    clr.b &{p6out}
    mov.b #{stop}, &{p1out}
    /* bit 0: active high, bit 1: active low; 0: no profile */
    clr r12
    .irp copy, {first}, {second}
    cmp #{version}, &\copy+{version_at}
    jne 2f
    cmp #-1, &\copy+{last_at}
    jeq 2f
    bit #{unwired}, &\copy+{flags_at}
    jne 2f
    bit #{step_low}, &\copy+{flags_at}
    jne 1f
    bis #1, r12
    jmp 2f
1:  bis #2, r12
2:
    .endr
    tst r12
    jeq 4f
    mov.b #{dirs}, &{p6dir}
    cmp #3, r12
    jeq 4f
    cmp #2, r12
    jne 3f
    bis.b #{step}, &{p1out}
3:  mov.b #{step}, &{p1dir}
4:  ret
    "#,
    step_strength = const P1_STEP | LATCH,
    dir_strength = const DIRS | ENABLE,
    stop = const P1_STOP,
    first = const super::PART.profiles[0],
    second = const super::PART.profiles[1],
    version = const RECORD_VERSION,
    version_at = const offset_of!(BoardRecord, version),
    flags_at = const offset_of!(BoardRecord, flags),
    last_at = const offset_of!(BoardRecord, crc),
    unwired = const BoardRecord::UNWIRED,
    step_low = const BoardRecord::STEP_LOW,
    step = const P1_STEP,
    dirs = const DIRS,
    p1ds = const P1DS.0,
    p6ds = const P6DS.0,
    p1out = const P1OUT.0,
    p1dir = const P1DIR.0,
    p6out = const P6OUT.0,
    p6dir = const P6DIR.0,
);

/// Every pin to its state of rest. Outputs of the machine stay as their resistors have them until the first
/// exchange; contacts, and the receive pin of a cable that is off, are pulled up; pins without a use down.
pub(super) fn open() {
    let floating = P1_STEP | P1_LED | LATCH;
    // STEP and DIR stay as `Reset` has left them.
    P1SEL.set(0);
    P1DIR.set(P1_LED | P1DIR.get() & P1_STEP);
    P1REN.set(!floating);
    P2OUT.set(0xFF);
    P2SEL.set(0);
    P2DIR.set(0);
    P2REN.set(0xFF);
    P3OUT.set(0);
    P3REN.set(0xFF);
    P4OUT.set(P4_RECEIVE);
    P4SEL.set(P4_UART);
    P4DIR.set(P4_LED);
    P4REN.set(!P4_LED);
    P5OUT.set(0);
    P5SEL.set(P5_XT2);
    P5REN.set(!P5_XT2);
    P6OUT.set(0);
    P6SEL.set(0);
    P6DIR.set(P6DIR.get() & DIRS);
    P6REN.set(!(DIRS | ENABLE));
    P7OUT.set(P7_START);
    P7REN.set(0xFF);
    P8OUT.set(0);
    P8DIR.set(0);
    P8REN.set(0xFF);
}

/// Levels of the port of inputs: bits 4 to 7 are inputs 1 to 4 of the direct wiring, low when closed.
#[inline(always)]
pub fn inputs() -> u8 {
    P2IN.get()
}

/// Bit 0 Stop, bit 1 Start, on when closed to ground.
pub fn buttons() -> u16 {
    let (one, two, seven) = (!P1IN.get(), !P2IN.get(), !P7IN.get());
    let stop = one & P1_STOP | two & P2_STOP != 0;
    let start = two & P2_START | seven & P7_START != 0;
    u16::from(stop) | u16::from(start) << 1
}

/// Direct wiring: levels of the two outputs, which are driven as soon as they have them.
#[inline(always)]
pub fn set_outputs(levels: u16) {
    for (bit, out, dir, pin) in [(1, P1OUT, P1DIR, LATCH), (2, P6OUT, P6DIR, ENABLE)] {
        if levels & bit != 0 {
            out.raise(pin);
        } else {
            out.clear(pin);
        }
        dir.raise(pin);
    }
}

/// Makes port 3 the SPI master of the chain: some 4 MHz, as the 74HC165 take their time, data valid at the
/// rising edge.
pub fn open_chain() {
    UCB0CTL1.set(0b10 << 6 | 1);
    UCB0CTL0.set(1 << 7 | 1 << 5 | 1 << 3 | 1);
    UCB0BR0.set((RATE / 4_000_000) as u8);
    UCB0BR1.set(0);
    UCB0CTL1.set(0b10 << 6);
    P3REN.clear(P3_CHAIN);
    P3SEL.raise(P3_CHAIN);
    // The outputs' enable stays high until the registers hold what the chip sends.
    P1OUT.raise(LATCH);
    P6OUT.raise(ENABLE);
    P1DIR.raise(LATCH);
    P6DIR.raise(ENABLE);
}

/// Gives the RS-485 line its pins; its transceiver listens.
pub fn open_rs485() {
    P4OUT.clear(P4_DRIVE);
    P4REN.clear(P4_DRIVE);
    P4DIR.raise(P4_DRIVE);
    // Pulled up while the transceiver gives no level.
    P3OUT.raise(P3_RECEIVE);
    P3SEL.raise(P3_RS485);
}

/// The RS-485 line's transceiver drives.
#[inline(always)]
pub fn drive_rs485() {
    P4OUT.raise(P4_DRIVE);
}

/// Gives the PWM its pin, and the one that lets it go, which the chip pulls down.
pub fn open_pwm() {
    P3SEL.raise(P3_PWM | P3_PWM_OFF);
    P3DIR.raise(P3_PWM);
}

/// The same of the analog output.
pub fn open_aout() {
    P3SEL.raise(P3_AOUT | P3_PWM_OFF);
    P3DIR.raise(P3_AOUT);
}

/// Gives analog inputs, bit 0 for A4, their pins, without resistors of the chip.
pub fn open_analog(inputs: u8) {
    let six = inputs << P6_ANALOG & P6_ANALOGS;
    P6REN.clear(six);
    P6SEL.raise(six);
    if inputs & 1 << 3 != 0 {
        P7REN.clear(P7_ANALOG);
        P7SEL.raise(P7_ANALOG);
    }
}

/// Sends a byte to the chain and brings the one that comes.
#[inline(always)]
pub fn chain_byte(out: u8) -> u8 {
    UCB0TXBUF.set(out);
    while UCB0STAT.get() & 1 != 0 {}
    UCB0RXBUF.get()
}

/// Takes the chain's inputs and shows its outputs.
#[inline(always)]
pub fn latch() {
    P1OUT.clear(LATCH);
    P1OUT.raise(LATCH);
}

/// The chain's outputs drive from now on.
#[inline(always)]
pub fn enable_chain() {
    P6OUT.clear(ENABLE);
}

/// Which edge of an input answers: `falling` those that go low.
pub fn set_edges(falling: u8) {
    P2IES.set(falling);
    // Another edge than before may be taken for one that has come.
    P2IFG.set(0);
}

/// Inputs whose edges answer.
#[inline(always)]
pub fn watch_edges(pins: u8) {
    P2IE.set(pins);
}

/// Drives DIR and gives the timer the STEP pins, whose outputs are at rest. `low`: STEP is active when low.
pub fn give_steps(low: bool) {
    P6DIR.raise(DIRS);
    if low {
        P1OUT.raise(P1_STEP);
    } else {
        P1OUT.clear(P1_STEP);
    }
    P1DIR.raise(P1_STEP);
    P1SEL.raise(P1_STEP);
}

/// STEP and DIR are left to their resistors.
pub fn leave_axes() {
    P1DIR.clear(P1_STEP);
    P6DIR.clear(DIRS);
}

/// Levels of the DIR pins.
#[inline(always)]
pub fn set_dirs(levels: u8) {
    P6OUT.clear(DIRS);
    P6OUT.raise(levels);
}
