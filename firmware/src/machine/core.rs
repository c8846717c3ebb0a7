//! The VM's core in Rust, for chips without an assembly core: the same registers and the same memory layout as
//! `firmware/shared/vm_core.rs`. Opcodes are those of [`lang::isa`], arithmetic is that of [`lang::vm::math`].

use crate::machine::chip::Chip;
use crate::machine::vm::{HANDLER_END, Vm, YIELD};
use crate::verify::CODE;
use lang::fault::Fault;
use lang::image;
use lang::isa::{self, Class, Op};
use lang::vm::{entry, flag, math};

/// What the core returns for a fault: its number and this.
const FAULT: u16 = 0x100;

/// Why an instruction did not simply lead to the next one.
enum Stop {
    Fault(Fault),
    /// The code that [`run`] returns. The next instruction is at `pc`.
    Exit(u16),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Stop {
        Stop::Fault(fault)
    }
}

/// Runs the VM: see [`Core::run`](crate::machine::chip::Core::run). `spend` is told the code of each instruction before
/// it runs; where it returns `true` the slice is used up, and the core returns at the next jump or call.
pub fn run<C: Chip>(vm: &mut Vm<C>, mut spend: impl FnMut(u8) -> bool) -> u16 {
    let mut over = false;
    loop {
        let pc = vm.pc;
        let code = vm.chip.byte(pc);
        over |= spend(code);
        match execute(vm) {
            Ok(next) => {
                let turns = next <= pc || is_call(code);
                vm.pc = next;
                if over && turns {
                    return YIELD;
                }
            }
            Err(Stop::Exit(code)) => return code,
            Err(Stop::Fault(fault)) => {
                // Whoever asks for the place takes one off.
                vm.pc = pc.wrapping_add(1);
                return FAULT | u16::from(fault.number());
            }
        }
    }
}

/// Whether a slice may end after this instruction, as after a jump backward.
fn is_call(code: u8) -> bool {
    matches!(
        Op::decode(code),
        Some((
            Op::Call
                | Op::CallFar
                | Op::Gosub
                | Op::Func
                | Op::JumpFar
                | Op::Return
                | Op::ExitSub
                | Op::Give,
            _
        ))
    )
}

impl<C: Chip> Vm<C> {
    fn byte_at(&self, address: u16) -> u8 {
        self.chip.byte(address)
    }

    fn word_at(&self, address: u16) -> u16 {
        u16::from_le_bytes([self.byte_at(address), self.byte_at(address.wrapping_add(1))])
    }

    fn add_to(&mut self, cell: u16, value: i32) -> Result<i32, Fault> {
        let sum = self.cell(cell).checked_add(value).ok_or(Fault::Overflow)?;
        self.set_cell(cell, sum);
        Ok(sum)
    }

    /// The cell of an array at the index on the stack.
    fn element(&mut self, first: u8, len: u8) -> Result<u16, Fault> {
        let index = self.pop();
        match u8::try_from(index) {
            Ok(index) if index < len => Ok(u16::from(first) + u16::from(index)),
            _ => Err(Fault::ArrayIndex),
        }
    }

    fn call(&mut self, kind: u8, next: u16, target: u16) -> Result<u16, Fault> {
        if !self.open(kind, next) {
            return Err(Fault::Stack);
        }
        Ok(self.code.wrapping_add(target))
    }

    /// Whether the pool has room for the deepest expression of a FUNCTION.
    fn has_room(&self) -> bool {
        let head = self.code.wrapping_sub(CODE);
        let of = |place: usize| self.byte_at(head + place as u16);
        let used = u16::from(of(image::at::FRAME)) + image::cells(of(image::at::CELLS));
        self.sp >= self.cells + 4 * used
    }

    /// Takes the newest entry off the call stack: address and kind.
    fn close(&mut self) -> Result<(u16, u8), Fault> {
        if self.calls == self.chip.pool() {
            return Err(Fault::Stack);
        }
        let (address, kind) = self.newest();
        self.calls -= u16::from(C::PART.call_bytes);
        Ok((self.code.wrapping_add(address), kind))
    }

    /// A value of the column of a table.
    fn look_up(&self, offset: u16, row: i32) -> Result<i32, Fault> {
        let start = self.code.wrapping_sub(CODE);
        let length = self.word_at(start + image::at::LEN as u16);
        self.chip.with_bytes(start, length, |bytes| {
            let image = image::Image::new(bytes).map_err(|_| Fault::ImageRefused)?;
            let column = image.column(offset.into()).ok_or(Fault::ImageRefused)?;
            column.get(row).ok_or(Fault::ArrayIndex)
        })
    }
}

/// Executes the instruction at `pc`; gives the address of the next.
fn execute<C: Chip>(vm: &mut Vm<C>) -> Result<u16, Stop> {
    let pc = vm.pc;
    let code = vm.byte_at(pc);
    let (Some((op, n)), Some(shape)) = (Op::decode(code), isa::shape(code)) else {
        return Err(Fault::ImageRefused.into());
    };
    let low = u16::from(n);
    let (first, operand) = (vm.byte_at(pc.wrapping_add(1)), vm.word_at(pc.wrapping_add(1)));
    let cell = u16::from(first);
    // Only data is wide; addresses in the code are words on every part with 32 KB of it.
    let next = pc.wrapping_add(1 + shape.operands().len(false) as u16);
    let jump = |distance: u8| next.wrapping_add_signed(i16::from(distance.cast_signed()));
    match op {
        Op::Small => vm.push(n.into()),
        Op::Byte => vm.push(first.cast_signed().into()),
        Op::Tens => vm.push(i32::from(first) * 10),
        Op::Hundreds => vm.push(i32::from(first.cast_signed()) * 100),
        Op::Thousands => vm.push(i32::from(first.cast_signed()) * 1000),
        Op::Word => vm.push(operand.cast_signed().into()),
        Op::WordTens => vm.push(i32::from(operand.cast_signed()) * 10),
        Op::Long => {
            let high = vm.word_at(pc.wrapping_add(3));
            vm.push((u32::from(operand) | u32::from(high) << 16).cast_signed());
        }
        Op::Load => vm.push(vm.cell(low)),
        Op::LoadFar => vm.push(vm.cell(cell)),
        Op::Store | Op::StoreFar => {
            let value = vm.pop();
            vm.set_cell(if op == Op::Store { low } else { cell }, value);
        }
        Op::LoadElem => {
            let of = vm.element(first, vm.byte_at(pc.wrapping_add(2)))?;
            vm.push(vm.cell(of));
        }
        Op::StoreElem => {
            let value = vm.pop();
            let of = vm.element(first, vm.byte_at(pc.wrapping_add(2)))?;
            vm.set_cell(of, value);
        }
        Op::IncShort => {
            vm.add_to(low, 1)?;
        }
        Op::Inc => {
            vm.add_to(cell, 1)?;
        }
        Op::AddCell => {
            let left = vm.pop();
            vm.push(math::binary(Op::Add, left, vm.cell(cell))?);
        }
        Op::Drop => {
            vm.pop();
        }
        Op::Dup => vm.push(vm.top),
        Op::Over => {
            let top = vm.pop();
            let below = vm.top;
            vm.push(top);
            vm.push(below);
        }
        Op::Neg | Op::Abs | Op::Sqr => {
            let value = vm.pop();
            vm.push(math::unary(op, value)?);
        }
        Op::Jump => return Ok(jump(first)),
        Op::JumpFar => return Ok(vm.code.wrapping_add(operand)),
        Op::JumpZero | Op::JumpNonzero => {
            if (vm.pop() == 0) == (op == Op::JumpZero) {
                return Ok(jump(first));
            }
        }
        Op::JumpEq | Op::JumpNe | Op::JumpLt | Op::JumpLe | Op::JumpGt | Op::JumpGe => {
            let right = vm.pop();
            let left = vm.pop();
            if math::binary(op, left, right)? != 0 {
                return Ok(jump(first));
            }
        }
        Op::Zero => {
            vm.set_cell(low, 0);
        }
        Op::NextShort | Op::NextWord => {
            let (of, limit) = match op {
                Op::NextShort => (low, i32::from(first)),
                _ => (cell, vm.word_at(pc.wrapping_add(2)).cast_signed().into()),
            };
            if vm.add_to(of, 1)? <= limit {
                return Ok(jump(vm.byte_at(next.wrapping_sub(1))));
            }
        }
        Op::ForStep | Op::NextStep => {
            let step = vm.pop();
            let limit = vm.pop();
            if op == Op::NextStep {
                vm.add_to(cell, step)?;
            } else if step == 0 {
                return Err(Fault::ValueRange.into());
            }
            let value = vm.cell(cell);
            let within = if step < 0 { value >= limit } else { value <= limit };
            if within == (op == Op::NextStep) {
                return Ok(jump(vm.byte_at(next.wrapping_sub(1))));
            }
        }
        Op::Call => return Ok(vm.call(entry::SUB, next, cell)?),
        Op::CallFar => return Ok(vm.call(entry::SUB, next, operand)?),
        Op::Gosub => return Ok(vm.call(entry::GOSUB, next, operand)?),
        Op::Func => {
            if !vm.has_room() {
                return Err(Fault::Stack.into());
            }
            let depth = (vm.base.wrapping_sub(vm.sp) / 4) as u8;
            let to = vm.call(entry::FUNC | depth, next, operand)?;
            vm.base = vm.sp;
            return Ok(to);
        }
        Op::Return | Op::ExitSub | Op::Give => return leave(vm, op),
        Op::Table | Op::TableFar => {
            let row = vm.pop();
            let offset = if op == Op::Table { cell } else { operand };
            vm.push(vm.look_up(offset, row)?);
        }
        Op::Check => {
            if !(0..i32::from(first)).contains(&vm.top) {
                return Err(Fault::ArrayIndex.into());
            }
        }
        Op::More => vm.flags |= flag::MORE,
        Op::End => {
            vm.pc = pc.wrapping_add(1);
            return Err(Stop::Exit(0));
        }
        _ if shape.class() == Class::Effect => {
            vm.pc = pc.wrapping_add(1);
            let Some(inline) = isa::inline(code) else { return Err(Stop::Exit(code.into())) };
            // Whole millimetres stand in the code.
            for _ in 0..inline.values {
                let mm = vm.operand().cast_signed();
                vm.push(i32::from(mm) * 1000);
            }
            return Err(Stop::Exit(inline.code.into()));
        }
        // What the machine does itself.
        Op::ToSteps
        | Op::ToLength
        | Op::Err
        | Op::Erl
        | Op::Leave
        | Op::OnError
        | Op::OnErrorStop
        | Op::ResumeNext
        | Op::Resume
        | Op::Sin
        | Op::Cos
        | Op::Atan2
        | Op::MulDiv
        | Op::Course => {
            vm.pc = pc.wrapping_add(1);
            return Err(Stop::Exit(code.into()));
        }
        _ => {
            let right = vm.pop();
            let left = vm.pop();
            vm.push(math::binary(op, left, right)?);
        }
    }
    Ok(next)
}

/// RETURN, EXIT SUB and the end of a FUNCTION.
fn leave<C: Chip>(vm: &mut Vm<C>, op: Op) -> Result<u16, Stop> {
    loop {
        let (address, kind) = vm.close()?;
        match kind {
            // Subroutines that are open in the one that is left.
            entry::GOSUB if op != Op::Return => {}
            entry::FUNC.. if op == Op::Give => {
                vm.base += 4 * u16::from(kind & 7);
                return Ok(address);
            }
            _ if op == Op::Give => return Err(Fault::Stack.into()),
            entry::GOSUB | entry::SUB => return Ok(address),
            entry::EVENT => {
                vm.pc = address;
                return Err(Stop::Exit(HANDLER_END));
            }
            _ => return Err(Fault::Stack.into()),
        }
    }
}
