//! A reference model of the chips' check of an image, which is assembly (`shared/check.rs`): the same verdict,
//! refusal for refusal. No image contains it. Three users need to know exactly what a chip answers: the tests
//! of the assembly on both chips (`tests/tests/image_check.rs`, `tests/compact/check.rs`) and `pasapas torture images`, which
//! uploads damaged images to the emulated boards.
//!
//! `lang::verify`, the check of the host's VM, cannot stand in for it: it knows images of any size, has more memory for
//! anchors, and refuses flag bits without a meaning. The chips accept such bits, as their effects test what
//! they use of them. `image_check.rs` compares both checks in everything else.

use lang::image::{COLUMN_HEAD, FORMAT, MAX_EVENTS, at};
use lang::isa::{self, Class, FINGERPRINT, LOW_CELLS, Op, Operands, SHORT_CELLS, flags, shape};
use lang::part::Part;
use lang::record::{AxisRecord, MachineRecord, feature};
use lang::wire::Refusal;

use super::{Bytes, CODE, MACHINE, anchors, block, feature_of};

const NO_ANCHOR: u8 = 0xFF;

/// What the firmware has.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Features, those beyond the header's byte among them.
    pub features: u16,
    /// Bytes for cells, expression stack and calls: for programs that move one axis at a time,
    /// and for those that interpolate or use START.
    pub pool: [u16; 2],
    /// Bytes of these that ON lines take: all of them, and each.
    pub event_pool: [u16; 2],
    /// It looks at the limits of AT variables.
    pub at_limits: bool,
    /// Bytes of an entry of the call stack.
    pub call_bytes: u8,
    /// The longest image.
    pub longest: usize,
}

impl Limits {
    /// Those of a part's firmware.
    pub const fn of(part: &Part) -> Limits {
        let Part { features, pool, event_pool, at_limits, call_bytes, .. } = *part;
        let longest = part.room_for(false);
        Limits { features, pool, event_pool, at_limits, call_bytes, longest }
    }
}

/// Checks header and code of an image that is [`sound`](super::sound).
///
/// # Errors
/// Why it must not run.
pub fn verify<B: Bytes>(image: &B, limits: &Limits) -> Result<(), Refusal> {
    if image.byte(0) != FORMAT || image.word(2) != FINGERPRINT {
        return Err(Refusal::Version);
    }
    let features = image.byte(1);
    if u16::from(features) & !limits.features != 0 {
        return Err(Refusal::Feature);
    }
    let many = features & (feature::INTERPOLATE | feature::START) as u8 != 0;
    let cells = lang::image::cells(image.byte(at::CELLS as u16));
    let stack = image.byte(at::STACK as u16);
    let calls = image.byte(at::CALLS as u16);
    let keeps = image.byte(at::KEEPS as u16);
    let frame = image.byte(at::FRAME as u16);
    let pool = (cells + u16::from(stack)) * 4 + u16::from(calls) * u16::from(limits.call_bytes);
    if pool > limits.pool[usize::from(many)]
        || frame > stack
        || keeps > 8
        || u16::from(image.byte(at::KEEP_BASE as u16)) + u16::from(keeps) > cells
    {
        return Err(Refusal::Memory);
    }
    let code_len = image.word(at::CODE_LEN as u16);
    let length = image.word(at::LEN as u16);
    if code_len == 0 || code_len > length - CODE {
        return Err(Refusal::Code);
    }
    let mut at = MACHINE + 8;
    while at < CODE {
        let present = image.byte(at) & AxisRecord::PRESENT as u8 != 0;
        if present && (image.word(at + 2) == 0 || image.word(at + 4) == 0) {
            return Err(Refusal::Code);
        }
        at += AxisRecord::SIZE as u16;
    }
    let data = CODE + code_len;
    let mut check = Check {
        image,
        block: block(limits.longest) as u16,
        anchors: vec![NO_ANCHOR; anchors(limits.longest)],
        free: limits.pool[usize::from(many)] - pool,
        event_pool: limits.event_pool,
        code_len,
        data,
        data_len: length - data,
        cells,
        frame,
        features: limits.features,
        at_limits: limits.at_limits,
    };
    if check.code() { Ok(()) } else { Err(Refusal::Code) }
}

/// An instruction.
struct Insn {
    code: u8,
    operands: Operands,
    class: Class,
    pops: u8,
    pushes: u8,
    /// Address behind it.
    next: u16,
}

struct Check<'a, B> {
    image: &'a B,
    block: u16,
    anchors: Vec<u8>,
    free: u16,
    event_pool: [u16; 2],
    code_len: u16,
    data: u16,
    data_len: u16,
    cells: u16,
    frame: u8,
    features: u16,
    at_limits: bool,
}

impl<B: Bytes> Check<'_, B> {
    fn byte(&self, address: u16) -> u8 {
        self.image.byte(CODE + address)
    }

    fn word(&self, address: u16) -> u16 {
        self.image.word(CODE + address)
    }

    fn code(&mut self) -> bool {
        let mut pc = 0;
        let mut depth = 0;
        let mut ends = false;
        while pc < self.code_len {
            if depth == 0
                && let Some(anchor) = self.anchors.get_mut(usize::from(pc / self.block))
                && *anchor == NO_ANCHOR
            {
                *anchor = (pc % self.block) as u8;
            }
            let Some(insn) = self.insn(pc) else { return false };
            if insn.next > self.code_len || !self.operands(pc, &insn) || !room(&insn, depth) {
                return false;
            }
            let Some(left) = after(&insn, depth) else { return false };
            // Values in the code come on the stack for their effect.
            let inline = isa::inline(insn.code).map_or(0, |inline| inline.values);
            if left > self.frame || depth + inline > self.frame {
                return false;
            }
            depth = left;
            ends = insn.class as u8 == Class::Ends as u8;
            pc = insn.next;
        }
        ends && self.targets()
    }

    fn targets(&self) -> bool {
        let mut pc = 0;
        let mut depth = 0;
        while pc < self.code_len {
            let Some(insn) = self.insn(pc) else { return false };
            if let Some(target) = self.target(pc, &insn) {
                let wanted = match insn.operands {
                    Operands::Sub8 | Operands::Sub => 0,
                    _ => depth - insn.pops,
                };
                if !self.lands(target, wanted) {
                    return false;
                }
            }
            let Some(left) = after(&insn, depth) else { return false };
            depth = left;
            pc = insn.next;
        }
        self.lands(self.image.word(at::ENTRY as u16), 0) && self.handlers()
    }

    /// Targets that stand in the data: ON lines, statement table.
    fn handlers(&self) -> bool {
        let features = u16::from(self.image.byte(1));
        let mut at = 0;
        if features & feature::EVENTS != 0 {
            let count = u16::from(self.events());
            at = 1 + 2 * count;
            let [all, each] = self.event_pool;
            if at > self.data_len
                || count > MAX_EVENTS as u16
                || count != 0 && all + each * count > self.free
            {
                return false;
            }
            let mut event = 0;
            while event < count {
                if !self.lands(self.image.word(self.data + 1 + 2 * event), 0) {
                    return false;
                }
                event += 1;
            }
        }
        let lines = features & feature::LINES != 0;
        if self.at_limits && self.image.byte(MACHINE) & MachineRecord::AT_LIMITS != 0 {
            let at = at + if lines { 2 } else { 0 };
            if at + 2 > self.data_len {
                return false;
            }
            let column = self.image.word(self.data + at);
            // Whole entries of four values.
            if !self.column(column) || !self.image.word(self.data + column + 1).is_multiple_of(4) {
                return false;
            }
        }
        if !lines {
            return true;
        }
        if at + 2 > self.data_len {
            return false;
        }
        let mut at = self.image.word(self.data + at);
        if at > self.data_len {
            return false;
        }
        let mut start = 0;
        while at < self.data_len {
            let head = self.image.byte(self.data + at);
            at += 1;
            let mut len = u16::from(head & 31);
            if len == 31 {
                len += u16::from(self.image.byte(self.data + at));
                at += 1;
            }
            at += [0, 0, 1, 2][usize::from(head >> 6)];
            if at > self.data_len || !self.lands(start, 0) {
                return false;
            }
            start += len;
            if head & 32 != 0 {
                if at + 2 > self.data_len || !self.lands(self.image.word(self.data + at), 0) {
                    return false;
                }
                at += 2;
            } else if !self.lands(start, 0) {
                return false;
            }
            if start >= self.code_len {
                return true;
            }
        }
        // A fault finds its statement; the last instruction, an END, needs none.
        start + 1 >= self.code_len
    }

    fn events(&self) -> u8 {
        let events = u16::from(self.image.byte(1)) & feature::EVENTS != 0;
        if events && self.data_len != 0 { self.image.byte(self.data) } else { 0 }
    }

    fn insn(&self, pc: u16) -> Option<Insn> {
        let code = self.byte(pc);
        if feature_of(code) & !self.features != 0 {
            return None;
        }
        let shape = shape(code)?;
        let operands = shape.operands();
        let more = isa::arguments(code, self.byte(pc + 1), self.byte(pc + 2));
        Some(Insn {
            code,
            operands,
            class: shape.class(),
            pops: shape.pops() + more,
            pushes: shape.pushes(),
            next: pc + 1 + operands.len(false) as u16,
        })
    }

    fn target(&self, pc: u16, insn: &Insn) -> Option<u16> {
        match insn.operands {
            Operands::Rel | Operands::CellRel | Operands::U8Rel | Operands::CellWordRel => {
                let distance = self.byte(insn.next - 1) as i8;
                Some(insn.next.wrapping_add(i16::from(distance) as u16))
            }
            Operands::Sub8 => Some(u16::from(self.byte(pc + 1))),
            Operands::Addr | Operands::Sub => Some(self.word(pc + 1)),
            _ => None,
        }
    }

    /// A table column lies at a data offset.
    fn column(&self, at: u16) -> bool {
        if at >= self.data_len {
            return false;
        }
        let width = self.image.byte(self.data + at);
        let rows = self.image.word(self.data + at + 1);
        let length = COLUMN_HEAD as u32 + u32::from(rows) * u32::from(width);
        (1..=4).contains(&width) && length <= u32::from(self.data_len - at)
    }

    fn text(&self, at: u16) -> bool {
        at < self.data_len && u16::from(self.image.byte(self.data + at)) < self.data_len - at
    }

    /// Cells, data, axes and event slots.
    fn operands(&self, pc: u16, insn: &Insn) -> bool {
        let b = self.byte(pc + 1);
        let low = u16::from(b);
        match insn.operands {
            Operands::Cell | Operands::CellRel | Operands::CellWordRel => u16::from(b) < self.cells,
            Operands::MmFlags | Operands::Mm2Flags | Operands::Mm3Flags | Operands::Mm2Flags2 => {
                self.inline_fits(pc, insn.code)
            }
            Operands::Array => low + u16::from(self.byte(pc + 2)) <= self.cells,
            Operands::Column8 => self.column(low),
            Operands::Column => self.column(self.word(pc + 1)),
            Operands::Text8 => self.text(low),
            Operands::Text => self.text(self.word(pc + 1)),
            Operands::Axis => {
                let record = MACHINE + 8 + low * AxisRecord::SIZE as u16;
                // The axis of a conversion must be there.
                b < 3
                    && (insn.class as u8 == Class::Effect as u8
                        || self.image.byte(record) & AxisRecord::PRESENT as u8 != 0)
            }
            Operands::Flags | Operands::Flags2 | Operands::Flags3 => {
                const EVENT: u8 = Op::Event as u8;
                if insn.code == EVENT {
                    let registers = matches!(
                        b & flags::EVENT_KIND,
                        flags::ON_RISE | flags::ON_FALL | flags::ON_EVERY
                    );
                    return !registers || b & 3 < self.events();
                }
                true
            }
            _ => {
                const LOW: u8 = Op::NextShort as u8;
                let short = insn.code.wrapping_sub(isa::LOAD);
                let low = insn.code.wrapping_sub(LOW);
                (short >= 2 * SHORT_CELLS || u16::from(short % SHORT_CELLS) < self.cells)
                    && (low >= 3 * LOW_CELLS || u16::from(low % LOW_CELLS) < self.cells)
            }
        }
    }

    /// The flags ask for as many values as stand before them.
    fn inline_fits(&self, pc: u16, code: u8) -> bool {
        let Some(inline) = isa::inline(code) else { return false };
        let Some(shape) = shape(inline.code) else { return false };
        let at = pc + 1 + u16::from(inline.values);
        let more = isa::arguments(inline.code, self.byte(at), self.byte(at + 1));
        // A probe's input and state stand on the stack, never in the code.
        let on_stack = inline.code == Op::Probe as u8 && self.byte(at + 1) & flags::SENSOR != 0;
        !on_stack && shape.pops() + more == inline.values
    }

    /// An instruction begins at `target`, with depth `depth` before it.
    fn lands(&self, target: u16, depth: u8) -> bool {
        if target >= self.code_len {
            return false;
        }
        let mut block = target / self.block;
        let mut pc;
        loop {
            let anchor = self.anchors.get(usize::from(block)).copied().unwrap_or(NO_ANCHOR);
            pc = block * self.block + u16::from(anchor);
            if anchor != NO_ANCHOR && pc <= target {
                break;
            }
            if block == 0 {
                pc = 0;
                break;
            }
            block -= 1;
        }
        let mut here = 0;
        while pc < target {
            let Some(insn) = self.insn(pc) else { return false };
            let Some(left) = after(&insn, here) else { return false };
            here = left;
            pc = insn.next;
        }
        pc == target && here == depth
    }
}

/// Depths that calls and returns demand, beyond the values that they take.
fn room(insn: &Insn, depth: u8) -> bool {
    const CALL: u8 = Op::Call as u8;
    const CALL_FAR: u8 = Op::CallFar as u8;
    const GOSUB: u8 = Op::Gosub as u8;
    const RETURN: u8 = Op::Return as u8;
    const EXIT_SUB: u8 = Op::ExitSub as u8;
    const LEAVE: u8 = Op::Leave as u8;
    const GIVE: u8 = Op::Give as u8;
    const FUNC: u8 = Op::Func as u8;
    match insn.code {
        CALL | CALL_FAR | GOSUB | RETURN | EXIT_SUB | LEAVE => depth == 0,
        GIVE => depth == 1,
        FUNC => depth < 8,
        _ => true,
    }
}

/// Depth behind an instruction; `None` when it takes more than there is.
fn after(insn: &Insn, depth: u8) -> Option<u8> {
    if depth < insn.pops {
        return None;
    }
    if insn.class as u8 == Class::Ends as u8 {
        return Some(0);
    }
    Some(depth - insn.pops + insn.pushes)
}
