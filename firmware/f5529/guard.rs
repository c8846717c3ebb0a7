//! Pins that stop the step engine by themselves: the emergency stop, and reference switches
//! as limit switches of the direct wiring.
//!
//! The main loop reads its inputs once in a millisecond and may be planning a chord meanwhile, so interrupts
//! empty the engine: the port's interrupt at the pin's edge, and the millisecond's, which reads the
//! chain as long as something there may stop the machine. The step that is already armed is made, whole, because
//! it was counted; none follows. The consequences (faults, outputs, homed axes) are the main loop's:
//! until it has called [`release`] the engine takes no segment and counts as running.
//!
//! A pin that does not answer any more when the interrupt reads it, a disturbance of 1 us or so,
//! stops nothing. The port's interrupt takes 126 cycles; that of the millisecond lets others come between.

use core::arch::global_asm;
use core::mem::{offset_of, size_of};

use firmware::motion::Segment;
use firmware::motion::queue::SLOTS;

use crate::chip::ports;
use crate::step::{PathSlot, SingleState};

/// What the interrupts share with the main loop; the assembly knows its layout.
#[repr(C)]
struct Guard {
    /// Inputs of the chain that stop the engine, and those of them that have.
    inputs: u16,
    answered: u16,
    /// Inputs of the chain that are on when low.
    invert: u16,
    /// What the chain was sent last.
    outputs: u16,
    /// Pins that have answered, [`CHAIN`] for inputs of the chain, 0 for none.
    tripped: u8,
}

/// Places of [`Guard::inputs`] and [`Guard::tripped`], for who looks while flash is busy.
#[cfg(feature = "f5529")]
pub const INPUTS_AT: usize = offset_of!(Guard, inputs);
/// See [`INPUTS_AT`].
#[cfg(feature = "f5529")]
pub const TRIPPED_AT: usize = offset_of!(Guard, tripped);

/// Interrupts may come, in the status register.
const GIE: u16 = 1 << 3;

/// [`Guard::tripped`]: none of the pins of inputs.
const CHAIN: u8 = 1;

#[unsafe(no_mangle)]
static mut PASAPAS_GUARD: Guard =
    Guard { inputs: 0, answered: 0, invert: 0, outputs: 0, tripped: 0 };

global_asm!(
    crate::chip::handlers!("guard"),
    r#"
    .set GUARD_IN, {pins_in}
    .set GUARD_IFG, {pins_ifg}
    .set GUARD_IES, {pins_ies}
    .set GUARD_IE, {pins_ie}
    .set LATCH_OUT, {latch_out}
    .set SPI_STAT, {spi_stat}
    .set SPI_RXBUF, {spi_rxbuf}
    .set SPI_TXBUF, {spi_txbuf}
    /* fields of Guard */
    .set INPUTS, PASAPAS_GUARD+{inputs}
    .set ANSWERED, PASAPAS_GUARD+{answered}
    .set INVERT, PASAPAS_GUARD+{invert}
    .set OUTPUTS, PASAPAS_GUARD+{outputs}
    .set TRIPPED, PASAPAS_GUARD+{tripped}

module.guard:
    .global pasapas_pins
pasapas_pins:
    push r15
    clr.b &GUARD_IFG
    mov.b &GUARD_IN, r15
    xor.b &GUARD_IES, r15
    and.b &GUARD_IE, r15
    jeq guard_exit
guard_trips:
    mov.b r15, &TRIPPED
    clr &{pwm}
    clr &{aout}
    clr.b &GUARD_IE
    clr &INPUTS
    /* the slots of a path, then what each single axis plays and has next */
    .set AT, PASAPAS_PLAY+{events}
    .rept {slots}
    clr &AT
    .set AT, AT+{slot}
    .endr
    .set AT, PASAPAS_PLAY+{events}
    .rept 3
    clr &AT
    clr &AT+{next}
    .set AT, AT+{single}
    .endr
guard_exit:
    pop r15
    reti

    /* The millisecond's interrupt goes on here. The registers of the outputs are sent what they hold. */
    .global pasapas_guard_chain
pasapas_guard_chain:
    push r15
    mov #{gie}, r15
    jmp 1f
    /* and here while flash is busy, where no interrupt may come between */
    .global pasapas_guard_alone
pasapas_guard_alone:
    push r15
    clr r15
1:  push r13
    push r14
    /* behind a flash operation milliseconds come one upon the other: the next finds the chain lent */
    mov &INPUTS, r13
    clr &INPUTS
    bis r15, r2
    bic.b #{latch}, &LATCH_OUT
    bis.b #{latch}, &LATCH_OUT
    mov.b &OUTPUTS+1, &SPI_TXBUF
1:  bit.b #1, &SPI_STAT
    jne 1b
    mov.b &SPI_RXBUF, r15
    mov.b &OUTPUTS, &SPI_TXBUF
1:  bit.b #1, &SPI_STAT
    jne 1b
    mov.b &SPI_RXBUF, r14
    swpb r14
    bis r14, r15
    pop r14
    dint
    xor &INVERT, r15
    and r13, r15
    tst.b &TRIPPED
    jne 2f
    mov r13, &INPUTS
    tst r15
    jne 3f
2:  clr r15
3:  pop r13
    tst r15
    jeq guard_exit
    mov r15, &ANSWERED
    mov.b #{chain}, r15
    jmp guard_trips
    "#,
    inputs = const offset_of!(Guard, inputs),
    answered = const offset_of!(Guard, answered),
    invert = const offset_of!(Guard, invert),
    outputs = const offset_of!(Guard, outputs),
    tripped = const offset_of!(Guard, tripped),
    events = const offset_of!(Segment, events),
    next = const offset_of!(SingleState, next),
    single = const size_of::<SingleState>(),
    slots = const SLOTS,
    slot = const size_of::<PathSlot>(),
    pins_in = const ports::IN,
    pins_ifg = const ports::IFG,
    pins_ies = const ports::IES,
    pins_ie = const ports::IE,
    latch_out = const ports::LATCH_OUT,
    spi_stat = const ports::SPI_STAT,
    spi_rxbuf = const ports::SPI_RXBUF,
    spi_txbuf = const ports::SPI_TXBUF,
    latch = const ports::LATCH,
    chain = const CHAIN,
    pwm = const crate::chip::pwm::CCTL,
    aout = const crate::chip::aout::CCTL,
    gie = const GIE,
);

fn guard() -> *mut Guard {
    &raw mut PASAPAS_GUARD
}

/// Says which edge of a pin answers, `falling` for those that answer when they go low, and which
/// inputs of the chain are on when low.
pub fn open(falling: u8, invert: u16) {
    ports::set_edges(falling);
    // SAFETY: interrupts are still off.
    unsafe { (*guard()).invert = invert };
}

/// What stops the engine from now on: pins of the inputs' port and inputs of the chain.
pub fn watch(pins: u8, inputs: u16) {
    ports::watch_edges(pins);
    // SAFETY: a single word.
    unsafe { (&raw mut (*guard()).inputs).write_volatile(inputs) };
}

/// The chain is the main loop's, which sends it `outputs`, until [`watch`].
pub fn lend_chain(outputs: u16) {
    // SAFETY: single words; the interrupt reads the second one only while the first is not 0.
    unsafe {
        (&raw mut (*guard()).inputs).write_volatile(0);
        (&raw mut (*guard()).outputs).write_volatile(outputs);
    }
}

/// The pins that have answered, 1 for inputs of the chain, 0 for none.
#[inline(always)]
pub fn tripped() -> u8 {
    // SAFETY: a byte.
    unsafe { (&raw const (*guard()).tripped).read_volatile() }
}

/// The inputs of the chain that have answered.
pub fn answered() -> u16 {
    if tripped() != CHAIN {
        return 0;
    }
    // SAFETY: a single word, written before `tripped` was set and not again before `watch`.
    unsafe { (&raw const (*guard()).answered).read_volatile() }
}

/// The engine rests and may take segments again.
pub fn release() {
    // SAFETY: a byte; the interrupts that write it are off since they did.
    unsafe { (&raw mut (*guard()).tripped).write_volatile(0) };
}

/// Makes a slot of the engine known to its interrupt by giving it its `events`, unless something has
/// answered: the engine stays empty then.
pub fn arm(slot: *mut u16, events: u16) {
    msp430::interrupt::disable();
    if tripped() == 0 {
        // SAFETY: the caller's slot, whose other fields are set.
        unsafe { slot.write_volatile(events) };
    }
    // SAFETY: only the main loop calls this, with interrupts on.
    unsafe { msp430::interrupt::enable() };
}
