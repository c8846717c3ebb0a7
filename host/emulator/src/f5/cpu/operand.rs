//! Operands: addresses, loads and stores of all three widths.

use super::CpuX;
use super::decode::{ADDRESS, Act, Dst, Op, Size, Src};
use crate::cpu::decode::Kind;
use crate::cpu::flags::Width;
use crate::cpu::{PC, SP};
use crate::f5::bus::Bus;
use crate::warn::Kind as Warning;

/// From here on a register holds a negative number of 16 bits, extended.
const NEGATIVE: u32 = 0xF_8000;

/// Where a result goes.
#[derive(Clone, Copy)]
pub enum Place {
    Reg(u8),
    Mem(u32),
    /// Constants and immediates of one-operand instructions have no place to write to.
    None,
}

impl Size {
    /// Bits that operands of this size have.
    #[inline(always)]
    pub fn width(self) -> Width {
        match self {
            Size::Byte => Width::of(true),
            Size::Word => Width::of(false),
            Size::Address => Width::ADDRESS,
        }
    }
}

/// `base + x`, by the rule of instructions with or without extension word.
#[inline(always)]
fn indexed(base: u32, near: bool, x: u32) -> u32 {
    let sum = base.wrapping_add(x);
    if near && base <= 0xFFFF { sum & 0xFFFF } else { sum & ADDRESS }
}

#[inline(always)]
pub fn load(bus: &mut Bus, addr: u32, size: Size) -> u32 {
    match size {
        Size::Byte => u32::from(bus.read8(addr)),
        Size::Word => u32::from(bus.read16(addr)),
        Size::Address => {
            let low = u32::from(bus.read16(addr));
            let high = u32::from(bus.read16((addr + 2) & ADDRESS));
            (low | high << 16) & ADDRESS
        }
    }
}

impl CpuX {
    #[inline(always)]
    pub(super) fn source(&mut self, bus: &mut Bus, op: &Op, size: Size) -> u32 {
        match op.src {
            Src::Reg(reg) => self.r[usize::from(reg & 15)] & size.width().mask,
            Src::Constant(value) | Src::Immediate(value) => value & size.width().mask,
            _ => {
                let addr = self.address(op, size);
                load(bus, addr, size)
            }
        }
    }

    /// Address of a memory source; autoincrement happens here, before the destination is formed.
    #[inline(always)]
    pub(super) fn address(&mut self, op: &Op, size: Size) -> u32 {
        match op.src {
            Src::Indexed { reg, near, x } => indexed(self.r[usize::from(reg & 15)], near, x),
            Src::Symbolic(addr) | Src::Absolute(addr) | Src::NextWord(addr) => addr,
            Src::Indirect(reg) => self.r[usize::from(reg & 15)],
            Src::Increment(reg) => {
                let addr = self.r[usize::from(reg & 15)];
                let by = match size {
                    // SP moves by words even in byte operations.
                    Size::Byte if usize::from(reg) != SP => 1,
                    Size::Byte | Size::Word => 2,
                    Size::Address => 4,
                };
                self.r[usize::from(reg & 15)] = (addr + by) & ADDRESS;
                addr
            }
            Src::Reg(_) | Src::Constant(_) | Src::Immediate(_) => 0,
        }
    }

    #[inline(always)]
    pub(super) fn place(&self, dst: Dst) -> Place {
        match dst {
            Dst::Reg(reg) => Place::Reg(reg),
            Dst::Symbolic(addr) | Dst::Absolute(addr) => Place::Mem(addr),
            Dst::Indexed { reg, near, x } => {
                Place::Mem(indexed(self.r[usize::from(reg & 15)], near, x))
            }
        }
    }

    /// Source, destination and the place of the destination.
    #[inline(always)]
    pub(super) fn operands(&mut self, bus: &mut Bus, op: &Op, size: Size) -> (u32, u32, Place) {
        let src = self.source(bus, op, size);
        let place = self.place(op.dst);
        let dst = match place {
            Place::Reg(reg) => {
                self.check_pointer(bus, op, size, reg);
                self.r[usize::from(reg & 15)] & size.width().mask
            }
            Place::Mem(addr) => load(bus, addr, size),
            Place::None => 0,
        };
        (src, dst, place)
    }

    /// The operand of a one-operand instruction and its place.
    pub(super) fn operand(&mut self, bus: &mut Bus, op: &Op, size: Size) -> (u32, Place) {
        match op.src {
            Src::Reg(reg) => {
                self.check_pointer(bus, op, size, reg);
                (self.r[usize::from(reg & 15)], Place::Reg(reg))
            }
            Src::Constant(value) | Src::Immediate(value) => (value, Place::None),
            _ => {
                let addr = self.address(op, size);
                (load(bus, addr, size), Place::Mem(addr))
            }
        }
    }

    /// A word or byte operation changes a register that holds more than 16 bits: the rest is lost.
    /// A plain move replaces it on purpose.
    #[inline(always)]
    pub(super) fn check_pointer(&mut self, bus: &mut Bus, op: &Op, size: Size, reg: u8) {
        let writes = !matches!(op.act, Act::Core(Kind::Cmp | Kind::Bit));
        if writes && size != Size::Address && self.r[usize::from(reg & 15)] > 0xFFFF {
            self.lost_pointer(bus, reg);
        }
    }

    #[cold]
    pub(super) fn lost_pointer(&mut self, bus: &mut Bus, reg: u8) {
        // SXT extends through bit 19: such a value is a negative number, and no pointer reaches there.
        let number = self.r[usize::from(reg & 15)] >= NEGATIVE;
        if usize::from(reg) != PC && !number {
            bus.warn(Warning::PointerTruncated, bus.pc);
        }
    }

    /// Stores a result, which has no more bits than the operation.
    #[inline(always)]
    pub(super) fn store(&mut self, bus: &mut Bus, place: Place, value: u32, size: Size) {
        match place {
            Place::Reg(reg) => self.write_reg(bus, reg, value & size.width().mask),
            Place::Mem(addr) => match size {
                Size::Byte => bus.write8(addr, value as u8),
                Size::Word => bus.write16(addr, value as u16),
                Size::Address => {
                    bus.write16(addr, value as u16);
                    bus.write16((addr + 2) & ADDRESS, (value >> 16) as u16 & 15);
                }
            },
            Place::None => {}
        }
    }
}
