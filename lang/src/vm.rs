//! The virtual machine: runs the code of a verified image.
//!
//! It owns no memory and knows no hardware. The caller brings the image, one slice for cells,
//! expression stack and call stack, and a [`State`]; it calls [`Vm::run`], does what the returned
//! [`Exit`] asks for, and calls again. The chips have cores in assembly with a layout of their own; tests
//! compare them with this one.
//!
//! The pool: cells from its start, four bytes each, least byte first; after them the expression
//! stack, growing upward; the call stack from the end of [`Header::pool_bytes`] downward.

mod calls;
pub mod effects;
pub mod encode;
pub mod math;

use crate::effect::Effect;
use crate::fault::Fault;
use crate::image::{self, Header, Image};
use crate::isa::{self, Class, Op};
use crate::trig;

/// Why the VM came back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// The instruction at `pc` is an effect; its arguments are on the stack. Go on with
    /// [`Vm::complete`] or [`Vm::fault`].
    Effect,
    /// The slice is used up; call again.
    Budget,
    /// A course may begin whose slow points have this data offset; `pc` is behind the instruction.
    Course(usize),
    /// An event handler or an error handler was left; [`State::flags`] says which are still open.
    HandlerEnd,
    /// The instruction at `pc` failed; go on with [`Vm::fault`].
    Fault(Fault),
    /// The run has ended.
    End,
}

/// Bits of [`State::flags`].
pub mod flag {
    /// An event handler is open.
    pub const EVENT: u8 = 1;
    /// An error handler is open.
    pub const ERROR: u8 = 1 << 1;
    /// The next effect does not end its statement.
    pub const MORE: u8 = 1 << 2;
    /// The last effect did not end its statement.
    pub const WITHIN: u8 = 1 << 3;
}

/// Kinds of entries of the call stack, four bits: above the address, in the part's way
/// ([`Part::call_bytes`](crate::part::Part::call_bytes)). An entry of a FUNCTION has [`entry::FUNC`] set and, below it, the depth of the
/// expression that calls it.
pub mod entry {
    /// GOSUB
    pub const GOSUB: u8 = 0;
    /// SUB
    pub const SUB: u8 = 2;
    /// Event handler.
    pub const EVENT: u8 = 3;
    /// Error handler; the address is that of the failing instruction.
    pub const ERROR: u8 = 4;
    /// Error handler; the address is that of the statement to go on with.
    pub const ERROR_BETWEEN: u8 = 5;
    /// FUNCTION, with bits 0..2 the depth.
    pub const FUNC: u8 = 8;
}

/// No error handler.
pub const NO_HANDLER: usize = usize::MAX;

/// Registers of the VM.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct State {
    /// Address of the next instruction; at an effect or a fault, of that instruction.
    pub pc: usize,
    /// Values on the expression stack.
    pub sp: u8,
    /// How many of them belong to callers of the open FUNCTIONs.
    pub base: u8,
    /// Entries on the call stack.
    pub calls: u8,
    /// [`flag`] bits.
    pub flags: u8,
    /// Address of the error handler, or [`NO_HANDLER`].
    pub handler: usize,
    /// Number of the last fault, 0 before one: ERR.
    pub fault: u8,
    /// Where it happened.
    pub fault_pc: usize,
}

impl State {
    /// The state in which a run begins.
    pub const fn new(header: &Header) -> State {
        State {
            pc: header.entry,
            sp: 0,
            base: 0,
            calls: 0,
            flags: 0,
            handler: NO_HANDLER,
            fault: 0,
            fault_pc: 0,
        }
    }
}

/// The virtual machine on its memory.
#[derive(Debug)]
pub struct Vm<'a, 'm> {
    image: Image<'a>,
    /// Its registers.
    pub state: &'m mut State,
    pool: &'m mut [u8],
}

/// Why an instruction did not simply lead to the next.
enum Stop {
    Fault(Fault),
    Exit(Exit),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Stop {
        Stop::Fault(fault)
    }
}

/// What a verified image never does: the memory was given too small, or another program's state.
const BROKEN: Fault = Fault::ImageRefused;

impl<'a, 'm> Vm<'a, 'm> {
    /// A VM on `state` and `pool`, which holds at least [`Header::pool_bytes`]. For a new run the
    /// pool is zero but for its KEEP cells and the state is [`State::new`].
    pub const fn new(image: Image<'a>, state: &'m mut State, pool: &'m mut [u8]) -> Vm<'a, 'm> {
        Vm { image, state, pool }
    }

    /// The value of a cell; 0 for one that the program does not have.
    pub fn cell(&self, n: u8) -> i32 {
        self.slot(usize::from(n)).unwrap_or(0)
    }

    /// Changes a cell; nothing happens when the program does not have it.
    pub fn set_cell(&mut self, n: u8, value: i32) {
        if u16::from(n) < self.image.header.cells {
            self.set_slot(usize::from(n), value).unwrap_or_default();
        }
    }

    fn slot(&self, n: usize) -> Result<i32, Fault> {
        let bytes = self.pool.get(4 * n..).and_then(|rest| rest.first_chunk::<4>());
        bytes.map(|bytes| i32::from_le_bytes(*bytes)).ok_or(BROKEN)
    }

    fn set_slot(&mut self, n: usize, value: i32) -> Result<(), Fault> {
        let bytes = self.pool.get_mut(4 * n..).and_then(|rest| rest.first_chunk_mut::<4>());
        *bytes.ok_or(BROKEN)? = value.to_le_bytes();
        Ok(())
    }

    fn push(&mut self, value: i32) -> Result<(), Fault> {
        let header = &self.image.header;
        if self.state.sp >= header.stack {
            return Err(BROKEN);
        }
        self.set_slot(usize::from(header.cells) + usize::from(self.state.sp), value)?;
        self.state.sp += 1;
        Ok(())
    }

    fn pop(&mut self) -> Result<i32, Fault> {
        self.state.sp = self.state.sp.checked_sub(1).ok_or(BROKEN)?;
        self.slot(usize::from(self.image.header.cells) + usize::from(self.state.sp))
    }

    fn byte(&self, at: usize) -> u8 {
        self.image.code.get(at).copied().unwrap_or(0)
    }

    fn address(&self, at: usize) -> Result<usize, Fault> {
        image::address(self.image.code, at, self.image.header.wide()).ok_or(BROKEN)
    }

    /// Executes up to `budget` instructions.
    pub fn run(&mut self, budget: u16) -> Exit {
        for _ in 0..budget {
            if let Some(exit) = self.step() {
                return exit;
            }
        }
        Exit::Budget
    }

    /// Executes one instruction; `None` when the next one follows.
    pub fn step(&mut self) -> Option<Exit> {
        let pc = self.state.pc;
        match self.execute() {
            Ok(next) => {
                self.state.pc = next;
                None
            }
            Err(Stop::Fault(fault)) => {
                self.state.pc = pc;
                Some(Exit::Fault(fault))
            }
            Err(Stop::Exit(exit)) => Some(exit),
        }
    }

    /// The effect at [`Exit::Effect`]. Its arguments stay on the stack until it is complete.
    pub fn effect(&self) -> Option<Effect> {
        let pc = self.state.pc;
        let code = self.byte(pc);
        let mut arguments = [0; effects::MAX_ARGUMENTS];
        if let Some(inline) = isa::inline(code) {
            let values = usize::from(inline.values);
            for (i, argument) in arguments.iter_mut().enumerate().take(values) {
                *argument = i32::from(self.byte(pc + 1 + i).cast_signed()) * 1000;
            }
            return effects::decode(inline.code, self.operands(pc + 1 + values), arguments);
        }
        let operands = self.operands(pc + 1);
        let count = isa::shape(code)?.pops() + isa::arguments(code, operands[0], operands[1]);
        let first = self.state.sp.checked_sub(count)?;
        let bottom = usize::from(self.image.header.cells) + usize::from(first);
        for (i, argument) in arguments.iter_mut().enumerate().take(usize::from(count)) {
            *argument = self.slot(bottom + i).ok()?;
        }
        effects::decode(code, operands, arguments)
    }

    fn operands(&self, at: usize) -> [u8; 3] {
        [self.byte(at), self.byte(at + 1), self.byte(at + 2)]
    }

    /// Goes on behind the effect at `pc`: its arguments leave the stack, and `result` comes on it
    /// if the effect has one.
    pub fn complete(&mut self, result: i32) {
        let code = self.byte(self.state.pc);
        let operands = self.operands(self.state.pc + 1);
        let Some(shape) = isa::shape(code) else { return };
        let count = shape.pops() + isa::arguments(code, operands[0], operands[1]);
        self.state.sp = self.state.sp.saturating_sub(count);
        if shape.pushes() != 0 {
            self.push(result).unwrap_or_default();
        }
        self.state.pc += 1 + shape.operands().len(self.image.header.wide());
    }

    /// Executes the instruction at `pc`; gives the address of the next.
    fn execute(&mut self) -> Result<usize, Stop> {
        let pc = self.state.pc;
        let code = *self.image.code.get(pc).ok_or(BROKEN)?;
        let (op, n) = Op::decode(code).ok_or(BROKEN)?;
        let wide = self.image.header.wide();
        let b = self.byte(pc + 1);
        let shape = isa::shape(code).ok_or(BROKEN)?;
        let class = shape.class();
        let next = pc + 1 + shape.operands().len(wide);
        let jump = |distance: u8| next.wrapping_add_signed(isize::from(distance.cast_signed()));
        match op {
            Op::Small => self.push(i32::from(n))?,
            Op::Byte => self.push(i32::from(b.cast_signed()))?,
            Op::Tens => self.push(i32::from(b) * 10)?,
            Op::Hundreds => self.push(i32::from(b.cast_signed()) * 100)?,
            Op::Thousands => self.push(i32::from(b.cast_signed()) * 1000)?,
            Op::Word => self.push(self.number(pc, 2))?,
            Op::WordTens => self.push(self.number(pc, 2) * 10)?,
            Op::Long => self.push(self.number(pc, 4))?,
            Op::Load => self.push(self.slot(usize::from(n))?)?,
            Op::LoadFar => self.push(self.slot(usize::from(b))?)?,
            Op::Store | Op::StoreFar => {
                let value = self.pop()?;
                self.set_slot(usize::from(if op == Op::Store { n } else { b }), value)?;
            }
            Op::LoadElem => {
                let cell = self.element(b, self.byte(pc + 2))?;
                self.push(self.slot(cell)?)?;
            }
            Op::StoreElem => {
                let value = self.pop()?;
                let cell = self.element(b, self.byte(pc + 2))?;
                self.set_slot(cell, value)?;
            }
            Op::IncShort => self.add_to(n, 1)?,
            Op::Inc => self.add_to(b, 1)?,
            Op::AddCell => {
                let left = self.pop()?;
                let right = self.slot(usize::from(b))?;
                self.push(math::binary(Op::Add, left, right)?)?;
            }
            Op::Drop => {
                self.pop()?;
            }
            Op::Dup => {
                let value = self.pop()?;
                self.push(value)?;
                self.push(value)?;
            }
            Op::Over => {
                let top = self.pop()?;
                let below = self.pop()?;
                self.push(below)?;
                self.push(top)?;
                self.push(below)?;
            }
            Op::Neg | Op::Abs | Op::Sqr | Op::Sin | Op::Cos => {
                let value = self.pop()?;
                self.push(math::unary(op, value)?)?;
            }
            Op::Jump => return Ok(jump(b)),
            Op::JumpFar => return Ok(self.address(pc + 1)?),
            Op::JumpZero | Op::JumpNonzero => {
                if (self.pop()? == 0) == (op == Op::JumpZero) {
                    return Ok(jump(b));
                }
            }
            Op::JumpEq | Op::JumpNe | Op::JumpLt | Op::JumpLe | Op::JumpGt | Op::JumpGe => {
                let right = self.pop()?;
                let left = self.pop()?;
                if math::binary(op, left, right)? != 0 {
                    return Ok(jump(b));
                }
            }
            Op::Zero => self.set_slot(usize::from(n), 0)?,
            Op::NextShort | Op::NextWord => {
                let (cell, limit) = match op {
                    Op::NextShort => (n, i32::from(b)),
                    _ => (b, i16::from_le_bytes([self.byte(pc + 2), self.byte(pc + 3)]).into()),
                };
                self.add_to(cell, 1)?;
                if self.slot(usize::from(cell))? <= limit {
                    return Ok(jump(self.byte(next - 1)));
                }
            }
            Op::ForStep | Op::NextStep => {
                if self.turn(op == Op::NextStep, b)? {
                    return Ok(jump(self.byte(next - 1)));
                }
            }
            Op::Call
            | Op::CallFar
            | Op::Func
            | Op::Gosub
            | Op::Return
            | Op::ExitSub
            | Op::Give
            | Op::Leave
            | Op::ResumeNext
            | Op::Resume => return self.transfer(op, pc, next),
            Op::OnError => self.state.handler = self.address(pc + 1)?,
            Op::OnErrorStop => self.state.handler = NO_HANDLER,
            Op::Err => self.push(i32::from(self.state.fault))?,
            Op::Erl => self.push(self.fault_line())?,
            Op::Table | Op::TableFar => {
                let offset = if op == Op::TableFar { self.address(pc + 1)? } else { b.into() };
                let row = self.pop()?;
                let column = self.image.column(offset).ok_or(BROKEN)?;
                self.push(column.get(row).ok_or(Fault::ArrayIndex)?)?;
            }
            Op::MulDiv => {
                let (over, times, value) = (self.pop()?, self.pop()?, self.pop()?);
                self.push(trig::mul_div(value, times, over, trig::wide)?)?;
            }
            Op::Check => {
                let index = self.pop()?;
                if !(0..i32::from(b)).contains(&index) {
                    return Err(Fault::ArrayIndex.into());
                }
                self.push(index)?;
            }
            Op::ToSteps | Op::ToLength => {
                let (steps, um) = self.image.scale(b).ok_or(BROKEN)?;
                let value = self.pop()?;
                let (times, over) = if op == Op::ToSteps { (steps, um) } else { (um, steps) };
                self.push(math::scale(value, times, over)?)?;
            }
            Op::Course => {
                let offset = self.address(pc + 1)?;
                self.state.pc = next;
                return Err(Stop::Exit(Exit::Course(offset)));
            }
            Op::More => self.state.flags |= flag::MORE,
            Op::End => return Err(Stop::Exit(Exit::End)),
            _ if class == Class::Effect => {
                let more = self.state.flags & flag::MORE != 0;
                self.state.flags &= !(flag::MORE | flag::WITHIN);
                if more {
                    self.state.flags |= flag::WITHIN;
                }
                return Err(Stop::Exit(Exit::Effect));
            }
            _ => {
                let right = self.pop()?;
                let left = self.pop()?;
                self.push(math::binary(op, left, right)?)?;
            }
        }
        Ok(next)
    }

    /// The signed number of `len` bytes behind the code at `pc`.
    fn number(&self, pc: usize, len: usize) -> i32 {
        let mut value: i32 = 0;
        for i in (1..=len).rev() {
            value = value << 8 | i32::from(self.byte(pc + i));
        }
        let unused = 32 - 8 * len as u32;
        value << unused >> unused
    }

    fn element(&mut self, first: u8, len: u8) -> Result<usize, Fault> {
        let index = self.pop()?;
        match u8::try_from(index) {
            Ok(index) if index < len => Ok(usize::from(first) + usize::from(index)),
            _ => Err(Fault::ArrayIndex),
        }
    }

    fn add_to(&mut self, cell: u8, value: i32) -> Result<(), Fault> {
        let cell = usize::from(cell);
        let sum = self.slot(cell)?.checked_add(value).ok_or(Fault::Overflow)?;
        self.set_slot(cell, sum)
    }

    /// The instructions at the ends of a loop with a step, `next` at its lower end: whether to jump.
    fn turn(&mut self, next: bool, cell: u8) -> Result<bool, Fault> {
        let step = self.pop()?;
        let limit = self.pop()?;
        if next {
            self.add_to(cell, step)?;
        } else if step == 0 {
            return Err(Fault::ValueRange);
        }
        let value = self.slot(usize::from(cell))?;
        let within = if step < 0 { value >= limit } else { value <= limit };
        Ok(within == next)
    }
}

#[cfg(feature = "compiler")]
mod frames;
