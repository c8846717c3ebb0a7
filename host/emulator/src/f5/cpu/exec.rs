//! Execution of decoded instructions.

use super::CpuX;
use super::decode::{ADDRESS, Act, Op, Repeat, Size, Src};
use super::operand::Place;
use crate::cpu::decode::{Condition, Kind};
use crate::cpu::flags::{self, C, N, V, Width, Z};
use crate::cpu::{PC, SP};
use crate::f5::bus::Bus;
use crate::warn::Kind as Warning;

impl CpuX {
    #[inline(always)]
    pub(super) fn execute(&mut self, bus: &mut Bus, op: &Op) {
        // Each width has its own copy of what follows, with its masks as constants.
        match (op.repeat, op.size) {
            (Repeat::Times(1), Size::Word) => self.once(bus, op, Size::Word),
            (Repeat::Times(1), Size::Byte) => self.once(bus, op, Size::Byte),
            (Repeat::Times(1), Size::Address) => self.once_address(bus, op),
            _ => self.many(bus, op),
        }
    }

    fn once_address(&mut self, bus: &mut Bus, op: &Op) {
        self.once(bus, op, Size::Address);
    }

    /// Repetitions, and registers of PUSHM and POPM.
    fn many(&mut self, bus: &mut Bus, op: &Op) {
        let times = match op.repeat {
            Repeat::Times(n) => n,
            Repeat::Register(reg) => (self.r[usize::from(reg & 15)] & 15) as u8 + 1,
        };
        if !matches!(op.act, Act::Core(_)) {
            // Their cycles count the repetitions already.
            return self.address_group(bus, op, times);
        }
        bus.now += bus.cycle * u64::from(times - 1);
        for _ in 0..times {
            self.once(bus, op, op.size);
        }
    }

    #[inline(always)]
    fn once(&mut self, bus: &mut Bus, op: &Op, size: Size) {
        let Act::Core(kind) = op.act else { return self.address_group(bus, op, 1) };
        let w = size.width();
        let carry = |cpu: &CpuX| if op.zero_carry { 0 } else { u32::from(cpu.sr() & C) };
        match kind {
            Kind::Jump => {
                if self.holds(op.condition)
                    && let Src::Constant(target) = op.src
                {
                    self.r[PC] = target;
                }
            }
            Kind::Mov => {
                let value = self.source(bus, op, size);
                let place = self.place(op.dst);
                if let (Src::Increment(1), Place::Reg(reg)) = (op.src, place) {
                    // POP of a word into a register that holds a pointer.
                    self.check_pointer(bus, op, size, reg);
                }
                self.store(bus, place, value, size);
            }
            Kind::Add => self.arithmetic(bus, op, size, 0, 0),
            Kind::Addc => self.arithmetic(bus, op, size, 0, carry(self)),
            Kind::Sub => self.arithmetic(bus, op, size, w.mask, 1),
            Kind::Subc => self.arithmetic(bus, op, size, w.mask, carry(self)),
            Kind::Cmp => {
                let (src, dst, _) = self.operands(bus, op, size);
                self.set_flags(flags::add(dst, !src, 1, w, self.sr()).1);
            }
            Kind::Dadd => {
                let (src, dst, place) = self.operands(bus, op, size);
                let sr = if op.zero_carry { self.sr() & !C } else { self.sr() };
                let (result, sr) = flags::dadd(dst, src, w, sr);
                self.set_flags(sr);
                self.store(bus, place, result, size);
            }
            Kind::Bit => {
                let (src, dst, _) = self.operands(bus, op, size);
                self.set_flags(flags::logic(src & dst, w, self.sr()));
            }
            Kind::Bic => {
                let (src, dst, place) = self.operands(bus, op, size);
                self.store(bus, place, dst & !src, size);
            }
            Kind::Bis => {
                let (src, dst, place) = self.operands(bus, op, size);
                self.store(bus, place, dst | src, size);
            }
            Kind::Xor => {
                let (src, dst, place) = self.operands(bus, op, size);
                let result = src ^ dst;
                self.set_flags(flags::xor(src, dst, result, w, self.sr()));
                self.store(bus, place, result, size);
            }
            Kind::And => {
                let (src, dst, place) = self.operands(bus, op, size);
                self.set_flags(flags::logic(src & dst, w, self.sr()));
                self.store(bus, place, src & dst, size);
            }
            _ => self.single(bus, op, kind),
        }
    }

    fn single(&mut self, bus: &mut Bus, op: &Op, kind: Kind) {
        let (size, w) = (op.size, op.size.width());
        match kind {
            Kind::Rra | Kind::Rrc => {
                let (value, place) = self.operand(bus, op, op.size);
                let value = value & w.mask;
                let top = if kind == Kind::Rra {
                    value & w.msb
                } else if self.sr() & C != 0 && !op.zero_carry {
                    w.msb
                } else {
                    0
                };
                let result = value >> 1 | top;
                self.set_flags(flags::shifted(result, value, w, self.sr()));
                self.store(bus, place, result, op.size);
            }
            Kind::Swpb => {
                let (value, place) = self.operand(bus, op, op.size);
                let swapped = u32::from((value as u16).swap_bytes()) | value & !0xFFFF;
                self.store(bus, place, swapped, op.size);
            }
            Kind::Sxt => {
                let (value, place) = self.operand(bus, op, op.size);
                let result = i32::from(value as u8 as i8).cast_unsigned() & ADDRESS;
                self.set_flags(flags::logic(result & w.mask, w, self.sr()));
                // In a register the sign goes up to bit 19 whatever the width.
                let size = if matches!(place, Place::Reg(_)) { Size::Address } else { size };
                self.store(bus, place, result, size);
            }
            Kind::Push => {
                if let Src::Reg(reg) = op.src {
                    self.check_pointer(bus, op, op.size, reg);
                }
                let value = self.source(bus, op, op.size);
                match op.size {
                    Size::Address => self.push_address(bus, value),
                    Size::Word => self.push(bus, value as u16),
                    Size::Byte => {
                        self.r[SP] = self.r[SP].wrapping_sub(2) & ADDRESS;
                        self.stats.stack(self.r[SP] as u16);
                        bus.check_stack(self.r[SP]);
                        bus.write8(self.r[SP], value as u8);
                    }
                }
            }
            Kind::Call => {
                let target = self.source(bus, op, op.size);
                let back = self.r[PC] as u16;
                self.push(bus, back);
                self.r[PC] = target & !1;
            }
            Kind::Reti => {
                let sr = self.pop(bus);
                let pc = self.pop(bus);
                self.write_sr(bus, sr & 0x0FFF);
                // A pending interrupt is accepted straight after RETI.
                self.shadow = false;
                bus.returned();
                self.r[PC] = (u32::from(sr & 0xF000) << 4 | u32::from(pc)) & !1;
                bus.attention = true;
                self.stats.leave(bus.now);
                bus.in_handler = !self.stats.nesting.is_empty();
            }
            _ => bus.warn(Warning::IllegalInstruction, bus.pc),
        }
    }

    /// MOVA and its kin, shifts by a number, CALLA, PUSHM, POPM.
    fn address_group(&mut self, bus: &mut Bus, op: &Op, times: u8) {
        match op.act {
            Act::Mova => {
                let value = self.source(bus, op, op.size);
                let place = self.place(op.dst);
                self.store(bus, place, value, Size::Address);
            }
            Act::Cmpa => {
                let (src, dst, _) = self.operands(bus, op, op.size);
                self.set_flags(flags::add(dst, !src, 1, Width::ADDRESS, self.sr()).1);
            }
            Act::Adda => self.arithmetic(bus, op, Size::Address, 0, 0),
            Act::Suba => self.arithmetic(bus, op, Size::Address, ADDRESS, 1),
            Act::Rrcm | Act::Rram | Act::Rlam | Act::Rrum => self.shift(bus, op, times),
            Act::Calla => {
                // A call through the stack pointer takes its target before it pushes.
                let target = self.source(bus, op, op.size);
                let back = self.r[PC];
                self.push_address(bus, back);
                self.r[PC] = target & !1;
            }
            Act::Pushm => {
                let Src::Reg(first) = op.src else { return };
                for reg in (0..=first).rev().take(usize::from(times)) {
                    let value = self.r[usize::from(reg)];
                    if op.size == Size::Address {
                        self.push_address(bus, value);
                    } else {
                        self.check_pointer(bus, op, op.size, reg);
                        self.push(bus, value as u16);
                    }
                }
            }
            Act::Popm => {
                let Src::Reg(first) = op.src else { return };
                for reg in (first..16).take(usize::from(times)) {
                    if op.size == Size::Address {
                        let value = self.pop_address(bus);
                        self.write_reg(bus, reg, value);
                    } else {
                        self.check_pointer(bus, op, op.size, reg);
                        let value = self.pop(bus);
                        self.write_reg(bus, reg, u32::from(value));
                    }
                }
            }
            Act::Core(_) | Act::Reserved => {
                bus.warn(Warning::IllegalInstruction, bus.pc);
            }
        }
    }

    /// RRCM, RRAM, RLAM, RRUM.
    fn shift(&mut self, bus: &mut Bus, op: &Op, times: u8) {
        let w = op.size.width();
        let (value, place) = self.operand(bus, op, op.size);
        let mut value = value & w.mask;
        for _ in 0..times {
            let carry = self.sr() & C != 0;
            let (result, out) = match op.act {
                Act::Rlam => (value << 1 & w.mask, u32::from(value & w.msb != 0)),
                Act::Rram => (value >> 1 | value & w.msb, value & 1),
                Act::Rrcm if carry => (value >> 1 | w.msb, value & 1),
                _ => (value >> 1, value & 1),
            };
            self.set_flags(flags::shifted(result, out, w, self.sr()));
            value = result;
        }
        self.store(bus, place, value, op.size);
    }

    /// `dst + (src ^ invert) + carry` with flags and store: ADD, ADDC, SUB, SUBC and the 20-bit ones.
    #[inline(always)]
    fn arithmetic(&mut self, bus: &mut Bus, op: &Op, size: Size, invert: u32, carry: u32) {
        let w = size.width();
        let (src, dst, place) = self.operands(bus, op, size);
        let (result, sr) = flags::add(dst, src ^ invert, carry, w, self.sr());
        self.set_flags(sr);
        self.store(bus, place, result, size);
    }

    #[inline(always)]
    fn holds(&self, condition: Condition) -> bool {
        let sr = self.sr();
        let less = (sr & N != 0) != (sr & V != 0);
        match condition {
            Condition::NotZero => sr & Z == 0,
            Condition::Zero => sr & Z != 0,
            Condition::NoCarry => sr & C == 0,
            Condition::Carry => sr & C != 0,
            Condition::Negative => sr & N != 0,
            Condition::GreaterOrEqual => !less,
            Condition::Less => less,
            Condition::Always => true,
        }
    }
}
