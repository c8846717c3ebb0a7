//! Places of the axes: conversion, targets, soft limits.

use std::cell::RefCell;

use firmware::motion::math::mul_div;
use lang::fault::Fault;
use lang::record::{AxisRecord, MachineRecord};
use proptest::prelude::*;

use crate::chip::Chip;
use crate::machine::{install, mill, scale};

/// What a routine leaves in r12 when it ends with a fault.
pub use micro::isa::FAULTED;

/// um to steps or back by a record, half away from zero; `None` is F01.
pub fn converted(axis: &AxisRecord, value: i32, to_steps: bool) -> Option<i32> {
    let (times, over) = if to_steps { (axis.steps, axis.um) } else { (axis.um, axis.steps) };
    let twice = mul_div(value.unsigned_abs(), 2 * u32::from(times), over.into());
    let half = i32::try_from(twice.checked_add(1)? / 2).ok()?;
    Some(if value < 0 { -half } else { half })
}

/// Any axis.
pub fn axis() -> impl Strategy<Value = AxisRecord> {
    // A travel is below 2^31 um: 2 km.
    let end = -(1i32 << 30)..1i32 << 30;
    (1u16.., 1u16.., end.clone(), end, any::<bool>()).prop_map(|(steps, um, a, b, present)| {
        AxisRecord {
            flags: if present { AxisRecord::PRESENT } else { 0 },
            min: a.min(b),
            max: a.max(b),
            ..scale(steps, um)
        }
    })
}

/// A place or way, often near.
pub fn value() -> impl Strategy<Value = i32> {
    prop_oneof![-100_000i32..100_000, any::<i32>()]
}

#[test]
fn conversion_is_the_twins() {
    let chip = RefCell::new(Chip::new());
    proptest!(|(axes in [axis(), axis(), axis()], n in 0u16..3, value in value(), to: bool)| {
        let mut chip = chip.borrow_mut();
        install(&mut chip, &MachineRecord { axes, ..mill() });
        let bits = value as u32;
        chip.call("axis_select", &[(12, n)]);
        chip.set_byte("FRAME_OF", if to { 0 } else { 4 });
        chip.call("to_other", &[(12, bits as u16), (13, (bits >> 16) as u16)]);
        let carry = chip.reg(2) & 1 != 0;
        let result = (!carry).then(|| chip.result() as i32);
        prop_assert_eq!(result, converted(&axes[usize::from(n)], value, to));
    });
}

#[derive(Debug, Clone, Copy)]
struct State {
    um: i32,
    steps: i32,
    offset: i32,
    homed: bool,
    demands: bool,
}

fn state() -> impl Strategy<Value = State> {
    (value(), value(), value(), any::<bool>(), any::<bool>())
        .prop_map(|(um, steps, offset, homed, demands)| State { um, steps, offset, homed, demands })
}

/// The board's rules for a target: um and steps of the machine, or a fault.
fn aimed(
    axis: &AxisRecord,
    state: &State,
    value: i32,
    frame: u16,
    in_steps: bool,
) -> Result<(i32, i32), Fault> {
    if axis.flags & AxisRecord::PRESENT == 0 {
        return Err(Fault::ValueRange);
    }
    let base = match (frame, in_steps) {
        (2, true) => state.steps,
        (2, false) => state.um,
        (0, false) => state.offset,
        _ => 0,
    };
    let place = base.checked_add(value).ok_or(Fault::Overflow)?;
    let other = converted(axis, place, !in_steps).ok_or(Fault::Overflow)?;
    let (um, steps) = if in_steps { (other, place) } else { (place, other) };
    if state.homed && !(axis.min..=axis.max).contains(&um) {
        return Err(Fault::SoftLimit);
    }
    if !state.homed && frame != 2 && state.demands {
        return Err(Fault::NotHomed);
    }
    Ok((um, steps))
}

#[test]
fn targets_are_found_and_refused_as_the_board_does() {
    let chip = RefCell::new(Chip::new());
    let place = (value(), 0u16..3, any::<bool>());
    proptest!(|(axis in axis(), n in 0u16..3, state in state(), (value, frame, steps) in place)| {
        let mut chip = chip.borrow_mut();
        let mut machine = mill();
        machine.axes[usize::from(n)] = axis;
        machine.flags = if state.demands { MachineRecord::REQUIRE_HOMING } else { 0 };
        install(&mut chip, &machine);
        chip.set_long("UM", 4 * n, state.um as u32);
        chip.set_long("STEPS", 4 * n, state.steps as u32);
        chip.set_long("OFFSET", 4 * n, state.offset as u32);
        chip.set_byte("HOMED", u8::from(state.homed) << n);
        chip.call("axis_select", &[(12, n)]);
        let bits = value as u32;
        let (low, high) = (bits as u16, (bits >> 16) as u16);
        chip.set_byte("FRAME_OF", (frame << 3) as u8 | u8::from(steps) << 2);
        chip.call("aim", &[(12, low), (13, high)]);
        let result = match chip.reg(12) {
            0 => Ok((chip.long("NEW_UM", 4 * n) as i32, chip.long("NEW_STEPS", 4 * n) as i32)),
            fault => Err(fault),
        };
        let expected = aimed(&axis, &state, value, frame, steps);
        prop_assert_eq!(result, expected.map_err(|fault| FAULTED | u16::from(fault.number())));
    });
}

#[test]
fn an_axis_that_no_machine_has_is_refused() {
    let mut chip = Chip::new();
    install(&mut chip, &mill());
    chip.call("axis_select", &[(12, 3)]);
    chip.call("aim", &[(12, 0), (13, 0)]);
    assert_eq!(chip.reg(12), FAULTED | u16::from(Fault::ValueRange.number()));
}

#[test]
fn a_run_begins_where_the_axes_stand() {
    let chip = RefCell::new(Chip::new());
    proptest!(|(axes in [axis(), axis(), axis()], actual in [value(), value(), value()])| {
        let mut chip = chip.borrow_mut();
        install(&mut chip, &MachineRecord { axes, ..mill() });
        for n in 0..3 {
            chip.set_long("OFFSET", 4 * n, 77);
            chip.set_long("ACTUAL", 4 * n, actual[usize::from(n)] as u32);
        }
        chip.call("motion_reset", &[]);
        for n in 0..3u16 {
            let i = usize::from(n);
            prop_assert_eq!(chip.long("OFFSET", 4 * n), 0);
            prop_assert_eq!(chip.long("STEPS", 4 * n) as i32, actual[i]);
            let um = converted(&axes[i], actual[i], false).unwrap_or(0);
            prop_assert_eq!(chip.long("UM", 4 * n) as i32, um);
        }
    });
}

#[test]
fn the_work_position_is_the_machine_position_less_the_offset() {
    let chip = RefCell::new(Chip::new());
    proptest!(|(axis in axis(), actual in value(), offset in value())| {
        let mut chip = chip.borrow_mut();
        install(&mut chip, &MachineRecord { axes: [axis; 3], ..mill() });
        chip.set_long("ACTUAL", 4, actual as u32);
        chip.set_long("OFFSET", 4, offset as u32);
        chip.call("work_steps", &[(12, 1)]);
        let offset = converted(&axis, offset, true).unwrap_or(0);
        prop_assert_eq!(chip.result() as i32, actual.wrapping_sub(offset));
    });
}

#[test]
fn without_a_program_an_axis_has_no_limits() {
    let mut chip = Chip::new();
    chip.call("axis_select", &[(12, 2)]);
    chip.set_byte("HOMED", 4);
    chip.set_byte("FRAME_OF", 4);
    chip.call("aim", &[(12, 0x1234), (13, 0x3FFF)]);
    assert_eq!(chip.reg(12), 0);
    assert_eq!(chip.long("NEW_UM", 8), 0x3FFF_1234);
}
