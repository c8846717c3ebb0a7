//! Reset causes, watchdog, interrupt priorities, vectors in RAM.

use emulator::{Board, Reset, WarningKind};

use crate::{CODE, IDLE, WDTCTL, board, full_speed};

const SYSRSTIV: u32 = 0x019E;

/// All causes, highest first.
fn causes(b: &mut Board) -> Vec<u16> {
    std::iter::from_fn(|| Some(b.bus_read16(SYSRSTIV)).filter(|cause| *cause != 0)).collect()
}

fn fresh() -> Board {
    let mut b = board(&IDLE);
    causes(&mut b);
    b
}

#[test]
fn every_cause_has_its_number() {
    type Act<'a> = &'a dyn Fn(&mut Board);
    let rows: [(Act<'_>, Reset, u16); 8] = [
        (&|b| b.brown_out(), Reset::Power, 0x02),
        (&|b| b.reset_pin(), Reset::Pin, 0x04),
        (
            &|b| (b.bus_write8(0x0121, 0xA5), b.bus_write16(0x0120, 0xA504)).1,
            Reset::SoftwareBrownOut,
            0x06,
        ),
        (&|b| b.bus_write16(0x0120, 0xA508), Reset::SoftwarePowerOn, 0x14),
        (&|b| b.bus_write16(WDTCTL, 0x0000), Reset::WatchdogKey, 0x18),
        (&|b| b.bus_write16(0x0140, 0x0040), Reset::FlashKey, 0x1A),
        (&|b| b.set_reg(0, 0x0200), Reset::Fetch, 0x1E),
        (&|b| b.bus_write16(0x0120, 0x1203), Reset::PowerKey, 0x20),
    ];
    for (act, reset, number) in rows {
        let mut b = fresh();
        act(&mut b);
        b.step();
        b.step();
        assert_eq!((b.last_reset(), causes(&mut b)), (reset, vec![number]));
    }
}

#[test]
fn causes_add_up_until_they_are_read() {
    let mut b = fresh();
    b.bus_write16(WDTCTL, 0);
    b.step();
    b.bus_write16(0x0140, 0);
    b.step();
    assert_eq!(causes(&mut b), [0x18, 0x1A]);
    assert_eq!(causes(&mut b), [] as [u16; 0]);
}

#[test]
fn a_byte_write_to_the_watchdog_resets_and_is_named() {
    let mut b = fresh();
    b.bus_write8(WDTCTL, 0x80);
    b.step();
    assert_eq!(b.last_reset(), Reset::WatchdogKey);
    assert!(b.warnings().iter().any(|w| w.kind == WarningKind::Key));
}

#[test]
fn the_watchdog_runs_out_after_each_of_its_intervals() {
    // Low byte of WDTCTL: ACLK from REFO, interval; microseconds.
    for (ctl, us) in [(0x5A2F, 1_953u64), (0x5A2E, 15_625), (0x5A2D, 250_000), (0x5A2C, 1_000_000)]
    {
        let mut b = fresh();
        b.bus_write16(WDTCTL, ctl);
        b.run_us(us * 99 / 100);
        assert_eq!(causes(&mut b), [] as [u16; 0], "{ctl:x}");
        b.run_us(us * 2 / 100 + 10);
        assert_eq!(causes(&mut b), [0x16], "{ctl:x}");
    }
    // Behind a reset: 32 768 cycles of SMCLK.
    let mut b = fresh();
    b.run_us(40_000);
    b.bus_write16(WDTCTL, 0x5A0C);
    b.run_us(31_000);
    assert_eq!(causes(&mut b), [] as [u16; 0]);
    b.run_us(500);
    assert_eq!(causes(&mut b), [0x16]);
}

#[test]
fn ram_outlives_resets() {
    let mut b = fresh();
    b.poke16(0x3456, 0x789A);
    b.bus_write16(0x0120, 0xA508);
    b.step();
    b.reset_pin();
    assert_eq!(b.peek16(0x3456), 0x789A);
}

/// Vector addresses of interrupts that are pending and enabled together, highest first.
#[test]
fn interrupts_are_served_in_the_order_of_their_vectors() {
    let mut b = board(&IDLE);
    // CCIE and CCIFG of TB0CCR0, TA0CCR0, TA0CCR1, TA1CCR0, TA2CCR0; transmit of A0 and A1; ports.
    for at in [0x03C2u32, 0x0342, 0x0344, 0x0382, 0x0402] {
        b.bus_write16(at, 0x0011);
    }
    b.bus_write8(0x05DC, 2);
    b.bus_write8(0x061C, 2);
    for port in 0..2u32 {
        b.bus_write8(0x021A + port, 1);
        b.bus_write8(0x021C + port, 1);
    }
    b.bus_write16(WDTCTL, 0x5A90);
    b.bus_write16(0x0100, 1);
    b.bus_write16(0x0102, 1);
    let order = [0xFFF6u32, 0xFFF2, 0xFFF0, 0xFFEA, 0xFFE8, 0xFFE2, 0xFFDE, 0xFFDC, 0xFFD8, 0xFFD4];
    for (n, vector) in order.iter().enumerate() {
        b.poke16(*vector, 0x6000 + 0x10 * n as u16);
    }
    for (n, vector) in order.into_iter().enumerate() {
        b.set_reg(1, 0x4400);
        b.set_reg(0, CODE);
        b.set_reg(2, 8);
        b.step();
        assert_eq!(b.reg(0), 0x6000 + 0x10 * n as u16, "{vector:04x}");
        // Flags that acceptance does not clear.
        let clear: &[(u32, u16)] = match vector {
            0xFFF0 => &[(0x05DC, 0)],
            0xFFE8 => &[(0x0344, 0)],
            0xFFDE => &[(0x021A, 0x0100)],
            0xFFDC => &[(0x061C, 0)],
            _ => &[],
        };
        for (at, value) in clear {
            b.bus_write16(*at, *value);
        }
    }
}

#[test]
fn vectors_can_stand_at_the_top_of_ram() {
    let mut b = board(&IDLE);
    b.poke16(0xFFEA, 0x6000);
    b.poke16(0x43EA, 0x3000);
    b.bus_write16(0x0342, 0x0011);
    b.bus_write16(0x0180, 1);
    b.set_reg(1, 0x4300);
    b.set_reg(2, 8);
    b.step();
    assert_eq!(b.reg(0), 0x3000);
}

#[test]
fn vacant_and_protected_memory_reads_as_a_jump() {
    let mut b = board(&IDLE);
    assert_eq!(b.bus_read16(0x2_4400), 0x3FFF);
    assert_ne!(b.bus_read16(0x0102) & 8, 0, "VMAIFG");
    assert_eq!(b.bus_read16(0x1200), 0x3FFF);
    assert_eq!((b.bus_read8(0x1A04), b.bus_read8(0x1A05)), (0x55, 0x29));
    b.bus_write16(0x1C00, 0x1234);
    assert_eq!(b.bus_read16(0x1C00), 0x1234, "USB RAM");
}

#[test]
fn sleep_ends_with_an_interrupt_and_time_passes() {
    let mut b = board(&[0xD032, 0x0018, 0x5316, 0x3FFC]);
    full_speed(&mut b);
    b.poke16(0xFFE2, 0x5000);
    // BIC #10h,0(SP); RETI: the sleeper goes on.
    for (n, word) in [0xC0B1u16, 0x0010, 0x0000, 0x1300].into_iter().enumerate() {
        b.poke16(0x5000 + 2 * n as u32, word);
    }
    b.bus_write16(0x0392, 24_999);
    b.bus_write16(0x0382, 0x0010);
    b.bus_write16(0x0380, 0x0214);
    b.set_reg(6, 0);
    b.run_us(10_500);
    assert_eq!(b.reg(6), 10, "a millisecond each");
}
