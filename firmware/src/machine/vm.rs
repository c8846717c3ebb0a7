//! The VM's registers, its memory's layout for a program, and the instructions that the assembly core does not execute.

use crate::machine::chip::Chip;
use crate::machine::flash::Image;
use crate::machine::pool::{self, PIECE_POOL};
use crate::motion::math::{signed, size};
use crate::verify::{Bytes, CODE};
use lang::fault::Fault;
use lang::image::{HEADER, at, cells};
use lang::isa::first;
use lang::record::{MachineRecord, feature};
use lang::trig;
use lang::vm::{entry, flag};

/// What the core returns when its slice is used up.
pub const YIELD: u16 = 0x200;
/// What the core returns when an event handler was left.
pub const HANDLER_END: u16 = 0x300;

/// Registers of the VM, as the core loads and stores them. Addresses are the chip's.
#[repr(C)]
pub struct Vm<C> {
    /// Address in flash of the next instruction.
    pub pc: u16,
    /// Address of the value below the top.
    pub sp: u16,
    /// Top of the expression stack, low word first.
    pub top: i32,
    /// Address of the code.
    pub code: u16,
    /// Address of the cells.
    pub cells: u16,
    /// The machine stack on entry of the core.
    pub frame: u16,
    /// Place of the next entry of the call stack.
    pub calls: u16,
    /// End of the call stack.
    pub calls_end: u16,
    /// `sp` of the open FUNCTION's empty stack.
    pub base: u16,
    /// Address of the program's data.
    pub data: u16,
    /// Address of the error handler, 0 for none.
    pub handler: u16,
    /// Address of the failing instruction of the last fault.
    pub fault_pc: u16,
    /// Number of the last fault.
    pub fault: u8,
    /// Come back at the next backward jump or call.
    pub poll: u8,
    /// [`flag`] bits.
    pub flags: u8,
    /// Number of cells.
    pub cell_count: u16,
    /// It stands in a streamed piece, not in the stored program.
    pub is_piece: bool,
    /// Whose memory it has.
    pub chip: C,
}

/// The statement table's word on a place in the code.
struct Place {
    line: u16,
    start: u16,
    resume: u16,
}

impl<C: Chip> Vm<C> {
    /// Bytes of an entry of the call stack: offset in the code, and kind in the upper 4 bits.
    const CALL: u16 = C::PART.call_bytes as u16;

    /// The VM of a board at reset.
    pub fn new(chip: C) -> Vm<C> {
        Vm {
            pc: 0,
            sp: 0,
            top: 0,
            code: 0,
            cells: 0,
            frame: 0,
            calls: 0,
            calls_end: 0,
            base: 0,
            data: 0,
            handler: 0,
            fault_pc: 0,
            fault: 0,
            poll: 0,
            flags: 0,
            cell_count: 0,
            is_piece: false,
            chip,
        }
    }

    fn byte(&self, address: u16) -> u8 {
        self.chip.byte(address)
    }

    fn at(&self, address: u16) -> Image<C> {
        Image(self.chip.clone(), address)
    }

    /// End of the pool of what the VM stands in.
    fn pool_end(&self) -> u16 {
        let words = if self.is_piece { PIECE_POOL } else { const { pool::words(&C::PART) } };
        self.chip.pool() + 2 * words as u16
    }

    /// Stands at the beginning of the verified image at `image`. Cells are 0, but for the first `kept`
    /// of the program that ran or was attached before.
    pub fn begin(&mut self, image: u16, kept: u16) {
        // Where pieces have been, no cell is what it was.
        let kept = if self.cell_count == 0 { 0 } else { kept };
        self.attach(image);
        let (mut address, end) = (self.chip.pool(), self.pool_end());
        while address < end {
            if kept != 0 && address == self.cells {
                address += 4 * kept;
                continue;
            }
            self.chip.set_word(address, 0);
            address += 2;
        }
        self.pc = self.code + self.at(image).word(at::ENTRY as u16);
        self.calls = self.chip.pool();
        self.sp = end;
        self.base = self.sp;
        self.handler = 0;
        self.fault = 0;
        self.flags = 0;
    }

    /// The verified program at `image` is the stored one, or none is (0). One that was not attached
    /// before gets a pool of its layout, with cells of 0.
    pub fn attach(&mut self, image: u16) {
        let code = if image == 0 { 0 } else { image + CODE };
        if code == 0 || code != self.code || self.cell_count == 0 {
            let mut address = self.chip.pool();
            while address != self.pool_end() {
                self.chip.set_word(address, 0);
                address += 2;
            }
            self.cell_count = 0;
        }
        self.code = code;
        if code != 0 {
            let head = self.at(image);
            self.data = code + head.word(at::CODE_LEN as u16);
            self.calls_end = self.chip.pool() + Self::CALL * u16::from(head.byte(at::CALLS as u16));
            self.cells = self.calls_end;
            self.cell_count = cells(head.byte(at::CELLS as u16));
        }
        self.pc = code;
    }

    /// The cells' memory is given to others until the next program is attached or begins.
    pub fn give_cells(&mut self) {
        self.cell_count = 0;
    }

    /// Address of a cell; `None` when the program does not have it.
    fn cell_address(&self, n: u16) -> Option<u16> {
        self.has_cell(n).then(|| self.cells + 4 * n)
    }

    /// Whether the program has a cell.
    pub fn has_cell(&self, n: u16) -> bool {
        n < self.cell_count
    }

    /// The value of a cell, 0 for one that the program does not have.
    pub fn cell(&self, n: u16) -> i32 {
        self.cell_address(n).map_or(0, |address| self.chip.long(address))
    }

    /// Changes a cell; `false` when the program does not have it.
    pub fn set_cell(&mut self, n: u16, value: i32) -> bool {
        let address = self.cell_address(n);
        if let Some(address) = address {
            self.chip.set_long(address, value);
        }
        address.is_some()
    }

    /// The top of the expression stack, taken from it.
    #[inline(never)]
    pub fn pop(&mut self) -> i32 {
        let value = self.top;
        self.top = self.chip.long(self.sp);
        self.sp += 4;
        value
    }

    /// The top, which must lie in 0..=`most`; anything else gives `most + 1`.
    #[inline(never)]
    pub fn pop_small(&mut self, most: u16) -> u16 {
        let value = self.pop();
        if (value >> 16) as u16 != 0 || value as u16 > most { most + 1 } else { value as u16 }
    }

    /// Puts a value on the expression stack.
    #[inline(never)]
    pub fn push(&mut self, value: i32) {
        self.sp -= 4;
        self.chip.set_long(self.sp, self.top);
        self.top = value;
    }

    /// The next operand byte.
    #[inline(never)]
    pub fn operand(&mut self) -> u8 {
        self.pc += 1;
        self.byte(self.pc - 1)
    }

    /// The next operand byte, which stays the next.
    pub fn next_operand(&self) -> u8 {
        self.byte(self.pc)
    }

    /// The next operand word.
    pub fn operand_word(&mut self) -> u16 {
        let low = self.operand();
        u16::from_le_bytes([low, self.operand()])
    }

    /// Whether an event handler may begin: between statements, and none is open.
    pub fn can_interrupt(&self) -> bool {
        let busy = flag::EVENT | flag::ERROR | flag::MORE | flag::WITHIN;
        self.flags & busy == 0 && self.sp == self.base
    }

    /// Puts an entry on the call stack, with the address to go back to; `false` when it is full.
    pub fn open(&mut self, kind: u8, address: u16) -> bool {
        if self.calls == self.calls_end {
            return false;
        }
        self.chip.set_word(self.calls, address - self.code);
        self.chip.set_word(self.calls + 2, u16::from(kind) << 12);
        self.calls += Self::CALL;
        true
    }

    /// Begins the handler of an event slot; `false` when the call stack is full.
    pub fn interrupt(&mut self, slot: u8) -> bool {
        let target = self.at(self.data).word(1 + 2 * u16::from(slot));
        if !self.open(entry::EVENT, self.pc) {
            return false;
        }
        self.flags |= flag::EVENT;
        self.pc = self.code + target;
        true
    }

    /// The call stack has an entry for the error handler of a fault of the instruction behind `pc` (the address is
    /// inside its statement), or `between` two; `false` when there is no room for it.
    pub fn open_handler(&mut self, pc: u16, between: bool) -> bool {
        // Without its table of statements nothing says where RESUME NEXT goes on.
        if u16::from(self.byte(self.code.wrapping_sub(CODE - 1))) & feature::LINES == 0 {
            return false;
        }
        let mut address = pc;
        let mut kind = entry::ERROR;
        if between {
            kind = entry::ERROR_BETWEEN;
            address = self.statement(pc).start;
        }
        self.open(kind, address)
    }

    /// The expression stack is that of the open routine's beginning.
    pub fn unwind(&mut self) {
        if self.sp != self.base {
            self.top = self.chip.long(self.base - 4);
            self.sp = self.base;
        }
    }

    /// Line of the statement at `pc`, 0 when the image tells none.
    pub fn line(&self, pc: u16) -> u16 {
        self.statement(pc).line
    }

    fn statement(&self, pc: u16) -> Place {
        let mut place = Place { line: 0, start: pc, resume: pc };
        // Without a program the table would begin among the vectors, and lead through the peripherals' registers.
        if self.code == 0 {
            return place;
        }
        let features = u16::from(self.byte(self.code.wrapping_sub(CODE - 1)));
        if features & feature::LINES == 0 {
            return place;
        }
        let mut at = self.data;
        if features & feature::EVENTS != 0 {
            at += 1 + 2 * u16::from(self.byte(at));
        }
        at = self.data + self.at(at).word(0);
        let mut next = self.code;
        while next <= pc {
            let start = next;
            let mut continues = false;
            let head = self.byte(at);
            at += 1;
            let mut len = head & 31;
            if len == 31 {
                next += u16::from(self.byte(at));
                at += 1;
            }
            next += u16::from(len);
            len = head >> 6;
            match len {
                3 => {
                    place.line = self.at(at).word(0);
                    at += 2;
                }
                2 => {
                    let more = self.byte(at);
                    continues = more == 0;
                    place.line += u16::from(more);
                    at += 1;
                }
                _ => place.line += u16::from(len),
            }
            if !continues {
                place.start = start;
            }
            place.resume = next;
            if head & 32 != 0 {
                place.resume = self.code + self.at(at).word(0);
                at += 2;
            }
        }
        place
    }

    /// Executes a pure instruction that the core left. `Some(true)`: a handler was left.
    ///
    /// # Errors
    /// The fault of the instruction.
    pub fn soft(&mut self, code: u8, axes: &MachineRecord) -> Result<bool, Fault> {
        match code {
            first::Leave => {
                if self.is_piece || self.newest().1 | 1 == entry::ERROR | 1 {
                    self.calls = self.chip.pool();
                    self.sp = self.pool_end();
                    self.base = self.sp;
                    self.flags &= !(flag::EVENT | flag::ERROR);
                    return Ok(true);
                }
            }
            first::OnError => self.handler = self.code + self.operand_word(),
            first::OnErrorStop => self.handler = 0,
            first::ResumeNext => return self.resume(false),
            first::Resume => return self.resume(true),
            first::Sin => self.top = trig::sin(self.top, C::mul_div),
            first::Cos => self.top = trig::cos(self.top, C::mul_div),
            first::Atan2 => {
                let x = self.pop();
                self.top = trig::atan2(self.top, x, C::mul_div);
            }
            first::MulDiv => {
                let [over, times] = [self.pop(), self.pop()];
                self.top = trig::mul_div(self.top, times, over, C::mul_div)?;
            }
            first::Err => self.push(i32::from(self.fault)),
            first::Erl => {
                let line = if self.fault == 0 { 0 } else { self.line(self.fault_pc) };
                self.push(i32::from(line));
            }
            _ => {
                let axis = self.operand();
                let value = self.top;
                self.top = convert::<C>(axes, axis, value, code == first::ToSteps)?;
            }
        }
        Ok(false)
    }

    /// Word `n` of the call stack, the outermost entry first; 0 behind the newest.
    pub fn open_call(&self, n: u16) -> u16 {
        let address = self.chip.pool() + 2 * n;
        if address >= self.calls {
            return 0;
        }
        self.chip.word(address)
    }

    /// Offset in the code and kind of the newest entry, 0 of none.
    pub fn newest(&self) -> (u16, u8) {
        if self.calls == self.chip.pool() {
            return (0, 0);
        }
        let newest = self.calls - Self::CALL;
        (self.chip.word(newest), (self.chip.word(newest + 2) >> 12) as u8)
    }

    /// RESUME NEXT, or with `again` RESUME.
    fn resume(&mut self, again: bool) -> Result<bool, Fault> {
        if self.is_piece {
            let open = self.flags & (flag::EVENT | flag::ERROR);
            // No event comes in an error handler, so that is the newer one.
            self.flags &= !if open & flag::ERROR != 0 { flag::ERROR } else { flag::EVENT };
            return if open == 0 { Err(Fault::Stack) } else { Ok(true) };
        }
        if self.flags & flag::ERROR == 0 {
            return Err(Fault::Stack);
        }
        loop {
            let (address, kind) = self.newest();
            self.calls -= Self::CALL;
            let address = self.code + address;
            match kind {
                entry::ERROR => {
                    let Place { start, resume, .. } = self.statement(address);
                    self.pc = if again { start } else { resume };
                }
                entry::ERROR_BETWEEN => self.pc = address,
                entry::FUNC.. => {
                    self.base += 4 * u16::from(kind & 7);
                    continue;
                }
                _ => continue,
            }
            self.flags &= !flag::ERROR;
            return Ok(true);
        }
    }
}

/// An axis's part of a profile.
#[inline(never)]
pub fn axis_of(axes: &MachineRecord, n: u8) -> &lang::record::AxisRecord {
    // Axis numbers come from verified code or were tested; the third stands in for all others.
    match n {
        0 => &axes.axes[0],
        1 => &axes.axes[1],
        _ => &axes.axes[2],
    }
}

/// um to steps of an axis or back, half away from zero.
///
/// # Errors
/// F01.
#[inline(never)]
pub fn convert<C: Chip>(
    axes: &MachineRecord,
    n: u8,
    value: i32,
    to_steps: bool,
) -> Result<i32, Fault> {
    let axis = axis_of(axes, n);
    let (times, over) = if to_steps { (axis.steps, axis.um) } else { (axis.um, axis.steps) };
    let twice = C::mul_div(size(value), u32::from(times) << 1, u32::from(over));
    if twice == u32::MAX {
        return Err(Fault::Overflow);
    }
    let half = ((twice + 1) >> 1) as i32;
    if half < 0 {
        return Err(Fault::Overflow);
    }
    Ok(signed(half, value))
}

const _: () = assert!(HEADER == 20);
