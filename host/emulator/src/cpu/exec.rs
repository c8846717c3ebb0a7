//! Execution of decoded instructions.

use super::decode::{Condition, Dst, Kind, Op, Src};
use super::flags::{self, C, N, V, Width, Z};
use super::{Cpu, PC, SP, SR};
use crate::bus::Bus;
use crate::warn::Kind as Warning;

/// Where a result goes.
#[derive(Clone, Copy)]
enum Place {
    Reg(u8),
    Mem(u16),
    /// Constants and immediates of one-operand instructions have no place to write to.
    None,
}

#[inline(always)]
fn load(bus: &mut Bus, addr: u16, byte: bool) -> u16 {
    if byte { u16::from(bus.read8(addr)) } else { bus.read16(addr) }
}

impl Cpu {
    #[inline(always)]
    pub(super) fn execute(&mut self, bus: &mut Bus, op: &Op) {
        let w = Width::of(op.byte);
        match op.kind {
            Kind::Jump => {
                if self.holds(op.condition)
                    && let Src::Constant(target) = op.src
                {
                    self.r[PC] = target;
                }
            }
            Kind::Mov => {
                let value = self.source(bus, op);
                let place = self.place(op.dst);
                self.store(bus, place, value, op.byte);
            }
            Kind::Add => self.arithmetic(bus, op, w, 0, 0),
            Kind::Addc => self.arithmetic(bus, op, w, 0, self.r[SR] & C),
            Kind::Sub => self.arithmetic(bus, op, w, 0xFFFF, 1),
            Kind::Subc => self.arithmetic(bus, op, w, 0xFFFF, self.r[SR] & C),
            Kind::Cmp => {
                let (src, dst, _) = self.operands(bus, op);
                self.r[SR] = flags::add(dst.into(), (!src).into(), 1, w, self.r[SR]).1;
            }
            Kind::Dadd => {
                let (src, dst, place) = self.operands(bus, op);
                let (result, sr) = flags::dadd(dst.into(), src.into(), w, self.r[SR]);
                self.r[SR] = sr;
                self.store(bus, place, result as u16, op.byte);
            }
            Kind::Bit => {
                let (src, dst, _) = self.operands(bus, op);
                self.r[SR] = flags::logic(u32::from(src & dst) & w.mask, w, self.r[SR]);
            }
            Kind::Bic => {
                let (src, dst, place) = self.operands(bus, op);
                self.store(bus, place, dst & !src, op.byte);
            }
            Kind::Bis => {
                let (src, dst, place) = self.operands(bus, op);
                self.store(bus, place, dst | src, op.byte);
            }
            Kind::Xor => {
                let (src, dst, place) = self.operands(bus, op);
                let result = u32::from(src ^ dst) & w.mask;
                self.r[SR] = flags::xor(src.into(), dst.into(), result, w, self.r[SR]);
                self.store(bus, place, result as u16, op.byte);
            }
            Kind::And => {
                let (src, dst, place) = self.operands(bus, op);
                let result = u32::from(src & dst) & w.mask;
                self.r[SR] = flags::logic(result, w, self.r[SR]);
                self.store(bus, place, result as u16, op.byte);
            }
            _ => self.single(bus, op, w),
        }
    }

    fn single(&mut self, bus: &mut Bus, op: &Op, w: Width) {
        match op.kind {
            Kind::Rra | Kind::Rrc => {
                let (value, place) = self.operand(bus, op);
                let value = u32::from(value) & w.mask;
                let top = if op.kind == Kind::Rra {
                    value & w.msb
                } else if self.r[SR] & C != 0 {
                    w.msb
                } else {
                    0
                };
                let result = value >> 1 | top;
                self.r[SR] = flags::shifted(result, value, w, self.r[SR]);
                self.store(bus, place, result as u16, op.byte);
            }
            Kind::Swpb => {
                let (value, place) = self.operand(bus, op);
                self.store(bus, place, value.swap_bytes(), false);
            }
            Kind::Sxt => {
                let (value, place) = self.operand(bus, op);
                let result = value as u8 as i8 as u16;
                self.r[SR] = flags::logic(result.into(), w, self.r[SR]);
                self.store(bus, place, result, false);
            }
            Kind::Push => {
                let value = self.source(bus, op);
                self.r[SP] = self.r[SP].wrapping_sub(2);
                self.stats.stack(self.r[SP]);
                bus.check_stack(self.r[SP]);
                self.store(bus, Place::Mem(self.r[SP]), value, op.byte);
            }
            Kind::Call => {
                let target = self.source(bus, op);
                let back = self.r[PC];
                self.push(bus, back);
                self.r[PC] = target & !1;
            }
            Kind::Reti => {
                let sr = bus.read16(self.r[SP]);
                let pc = bus.read16(self.r[SP].wrapping_add(2));
                self.r[SP] = self.r[SP].wrapping_add(4);
                self.write_sr(bus, sr);
                // A pending interrupt is accepted straight after RETI.
                self.shadow = false;
                self.r[PC] = pc & !1;
                bus.attention = true;
                self.stats.leave(bus.now);
            }
            _ => bus.warn(Warning::IllegalInstruction, bus.pc),
        }
    }

    /// `dst + (src ^ invert) + carry` with flags and store: ADD, ADDC, SUB, SUBC.
    #[inline(always)]
    fn arithmetic(&mut self, bus: &mut Bus, op: &Op, w: Width, invert: u16, carry: u16) {
        let (src, dst, place) = self.operands(bus, op);
        let (result, sr) =
            flags::add(dst.into(), (src ^ invert).into(), carry.into(), w, self.r[SR]);
        self.r[SR] = sr;
        self.store(bus, place, result as u16, op.byte);
    }

    #[inline(always)]
    fn holds(&self, condition: Condition) -> bool {
        let sr = self.r[SR];
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

    #[inline(always)]
    fn source(&mut self, bus: &mut Bus, op: &Op) -> u16 {
        match op.src {
            Src::Reg(reg) => self.r[usize::from(reg & 15)],
            Src::Constant(value) | Src::Immediate(value) => value,
            _ => {
                let addr = self.address(op);
                load(bus, addr, op.byte)
            }
        }
    }

    /// Address of a memory source; autoincrement happens here, before the destination is formed.
    #[inline(always)]
    fn address(&mut self, op: &Op) -> u16 {
        match op.src {
            Src::Indexed(reg, x) => self.r[usize::from(reg & 15)].wrapping_add(x),
            Src::Absolute(addr) | Src::NextWord(addr) => addr,
            Src::Indirect(reg) => self.r[usize::from(reg & 15)],
            Src::Increment(reg) => {
                let addr = self.r[usize::from(reg & 15)];
                // SP moves by words even in byte operations.
                let by = if op.byte && usize::from(reg) != SP { 1 } else { 2 };
                self.r[usize::from(reg & 15)] = addr.wrapping_add(by);
                addr
            }
            Src::Reg(_) | Src::Constant(_) | Src::Immediate(_) => 0,
        }
    }

    #[inline(always)]
    fn place(&self, dst: Dst) -> Place {
        match dst {
            Dst::Reg(reg) => Place::Reg(reg),
            Dst::Absolute(addr) => Place::Mem(addr),
            Dst::Indexed(reg, x) => Place::Mem(self.r[usize::from(reg & 15)].wrapping_add(x)),
        }
    }

    /// Source, destination and the place of the destination.
    #[inline(always)]
    fn operands(&mut self, bus: &mut Bus, op: &Op) -> (u16, u16, Place) {
        let src = self.source(bus, op);
        let place = self.place(op.dst);
        let dst = match place {
            Place::Reg(reg) => self.r[usize::from(reg & 15)],
            Place::Mem(addr) => load(bus, addr, op.byte),
            Place::None => 0,
        };
        (src, dst, place)
    }

    /// The operand of a one-operand instruction and its place.
    fn operand(&mut self, bus: &mut Bus, op: &Op) -> (u16, Place) {
        match op.src {
            Src::Reg(reg) => (self.r[usize::from(reg & 15)], Place::Reg(reg)),
            Src::Constant(value) | Src::Immediate(value) => (value, Place::None),
            _ => {
                let addr = self.address(op);
                (load(bus, addr, op.byte), Place::Mem(addr))
            }
        }
    }

    #[inline(always)]
    fn store(&mut self, bus: &mut Bus, place: Place, value: u16, byte: bool) {
        match place {
            Place::Reg(reg) => {
                self.write_reg(bus, reg, if byte { value & 0xFF } else { value });
            }
            Place::Mem(addr) if byte => bus.write8(addr, value as u8),
            Place::Mem(addr) => bus.write16(addr, value),
            Place::None => {}
        }
    }
}
