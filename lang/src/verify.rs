//! The check of an image before the host's VM runs it. The chips have their own, in assembly (`firmware/shared/check.rs`).
//!
//! After it the VM can touch nothing but the image, its cells, its stack and its call stack. What
//! only a run can know it tests itself: array and table indices, kinds on the call stack, room for
//! a call.
//!
//! The code is read from its start, instruction by instruction. The depth of the expression stack
//! before each, counted from what the routine found, follows from those before it; after an
//! instruction that never falls through it is 0. Every jump must lead to an instruction with the
//! depth that it leaves, calls and handlers to one with depth 0: so the depth is the same on every
//! path. Where an instruction begins is found again from anchors, one place with depth 0 for each
//! block of code, which the first pass leaves in a few bytes of memory; the second pass looks up
//! each target by reading on from the anchor before it.

use crate::image::{Flaw, Image, MAX_EVENTS, NARROW, pool_limit};
use crate::isa::{self, Class, Op, Operands};
use crate::record::feature;
use crate::vm::{effects, entry};

/// Code that one anchor stands for, at least; a power of two.
const BLOCK: usize = 64;
/// An anchor of a block in which no instruction begins with depth 0.
const NO_ANCHOR: u16 = u16::MAX;

/// What a VM has to offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes for cells, expression stack and calls.
    pub pool: usize,
    /// Features that it has.
    pub features: u16,
}

impl Limits {
    /// The device's, for an image with these features.
    pub const fn device(features: u8) -> Limits {
        Limits { pool: pool_limit(features), features: !feature::WIDE }
    }

    /// The host's: any size of code.
    pub const fn host(features: u8) -> Limits {
        Limits { pool: pool_limit(features), features: u16::MAX }
    }
}

/// An instruction as the verifier sees it.
struct Insn {
    code: u8,
    operands: Operands,
    class: Class,
    pops: u8,
    pushes: u8,
    /// Address behind it.
    next: usize,
}

/// Checks header and code; the CRC is [`crate::image::crc_of`]'s.
///
/// `anchors` is scratch memory; 24 entries keep a program of 3 KB to blocks of 128 bytes. More
/// make it faster.
///
/// # Errors
/// The first flaw that is found.
pub fn verify(image: &Image<'_>, limits: &Limits, anchors: &mut [u16]) -> Result<(), Flaw> {
    check_header(image, limits)?;
    let mut block = BLOCK;
    while image.code.len().div_ceil(block) > anchors.len() {
        block = block.checked_mul(2).filter(|_| !anchors.is_empty()).ok_or(Flaw::Layout)?;
    }
    let mut verifier = Verifier { image, anchors, block };
    verifier.first_pass()?;
    verifier.second_pass()
}

fn check_header(image: &Image<'_>, limits: &Limits) -> Result<(), Flaw> {
    let header = &image.header;
    if u16::from(header.features) & !limits.features != 0 {
        return Err(Flaw::Feature);
    }
    if header.pool_bytes() > limits.pool
        || header.frame > header.stack
        || header.keeps > 8
        || usize::from(header.keep_base) + usize::from(header.keeps) > usize::from(header.cells)
    {
        return Err(Flaw::Memory);
    }
    if !header.wide() && header.len > NARROW || header.code_len == 0 {
        return Err(Flaw::Layout);
    }
    for axis in 0..3 {
        if matches!(image.scale(axis), Some((0, _) | (_, 0))) {
            return Err(Flaw::Layout);
        }
    }
    Ok(())
}

struct Verifier<'a, 's> {
    image: &'a Image<'a>,
    anchors: &'s mut [u16],
    block: usize,
}

impl Verifier<'_, '_> {
    /// Reads the whole code: instructions, operands, depths; leaves the anchors.
    fn first_pass(&mut self) -> Result<(), Flaw> {
        self.anchors.fill(NO_ANCHOR);
        let (mut pc, mut depth, mut ends) = (0, 0, false);
        while pc < self.image.code.len() {
            if depth == 0 {
                let offset = (pc % self.block) as u16;
                let anchor = self.anchors.get_mut(pc / self.block).ok_or(Flaw::Layout)?;
                if *anchor == NO_ANCHOR {
                    *anchor = offset;
                }
            }
            let insn = self.insn(pc)?;
            self.check_operands(pc, &insn)?;
            self.check_depth(&insn, depth)?;
            // Values in the code come on the stack for their effect.
            let inline = isa::inline(insn.code).map_or(0, |inline| inline.values);
            let before = depth;
            depth = after(&insn, depth)?;
            if depth.max(before + inline) > self.image.header.frame {
                return Err(Flaw::Depth);
            }
            ends = insn.class == Class::Ends;
            pc = insn.next;
        }
        if ends { Ok(()) } else { Err(Flaw::End) }
    }

    /// Reads it again for the jumps, then looks at the targets that stand elsewhere.
    fn second_pass(&self) -> Result<(), Flaw> {
        let image = self.image;
        let (mut pc, mut depth) = (0, 0);
        while pc < image.code.len() {
            let insn = self.insn(pc)?;
            if let Some(target) = self.target(pc, &insn) {
                let wanted = match insn.operands {
                    Operands::Sub8 | Operands::Sub => 0,
                    _ => depth - insn.pops,
                };
                self.check_target(target, wanted)?;
            }
            depth = after(&insn, depth)?;
            pc = insn.next;
        }
        if image.has_limits() && image.limits().is_none() {
            return Err(Flaw::Layout);
        }
        self.check_target(image.header.entry, 0)?;
        if image.header.has(feature::EVENTS)
            && image.data.first().is_none_or(|&lines| usize::from(lines) > MAX_EVENTS)
        {
            return Err(Flaw::Layout);
        }
        for slot in 0..image.events() {
            self.check_target(image.event_target(slot).ok_or(Flaw::Layout)?, 0)?;
        }
        if image.header.has(feature::LINES) {
            let mut end = 0;
            for place in image.statements().ok_or(Flaw::Layout)? {
                self.check_target(place.entry, 0)?;
                self.check_target(place.resume, 0)?;
                end = place.end;
                if end >= image.code.len() {
                    break;
                }
            }
            // A fault finds its statement; the last instruction, an END, needs none.
            if end + 1 < image.code.len() {
                return Err(Flaw::Layout);
            }
        }
        Ok(())
    }

    fn byte(&self, at: usize) -> u8 {
        self.image.code.get(at).copied().unwrap_or(0)
    }

    fn insn(&self, pc: usize) -> Result<Insn, Flaw> {
        let code = self.byte(pc);
        let shape = isa::shape(code).ok_or(Flaw::Opcode)?;
        let operands = shape.operands();
        let next = pc + 1 + operands.len(self.image.header.wide());
        if next > self.image.code.len() {
            return Err(Flaw::Operand);
        }
        let more = isa::arguments(code, self.byte(pc + 1), self.byte(pc + 2));
        Ok(Insn {
            code,
            operands,
            class: shape.class(),
            pops: shape.pops() + more,
            pushes: shape.pushes(),
            next,
        })
    }

    fn target(&self, pc: usize, insn: &Insn) -> Option<usize> {
        match insn.operands {
            Operands::Rel | Operands::CellRel | Operands::U8Rel | Operands::CellWordRel => {
                let distance = self.byte(insn.next - 1).cast_signed();
                // A target before the code wraps to one far behind it.
                Some(insn.next.wrapping_add_signed(distance.into()))
            }
            Operands::Sub8 => Some(self.byte(pc + 1).into()),
            Operands::Addr | Operands::Sub => Some(self.address(pc)),
            _ => None,
        }
    }

    fn address(&self, pc: usize) -> usize {
        let address = crate::image::address(self.image.code, pc + 1, self.image.header.wide());
        address.unwrap_or(usize::MAX)
    }

    /// Cells, data and flags; jumps are the second pass's.
    fn check_operands(&self, pc: usize, insn: &Insn) -> Result<(), Flaw> {
        let cells = usize::from(self.image.header.cells);
        let first = usize::from(self.byte(pc + 1));
        let good = match insn.operands {
            Operands::Cell | Operands::CellRel | Operands::CellWordRel => first < cells,
            Operands::Array => first + usize::from(self.byte(pc + 2)) <= cells,
            Operands::Column8 => self.image.column(first).is_some(),
            Operands::Column => self.image.column(self.address(pc)).is_some(),
            Operands::Text8 => self.image.text(first).is_some(),
            Operands::Text => self.image.text(self.address(pc)).is_some(),
            Operands::Axis if insn.class == Class::Pure => {
                self.image.scale(self.byte(pc + 1)).is_some()
            }
            Operands::Axis => first < 3,
            Operands::MmFlags | Operands::Mm2Flags | Operands::Mm3Flags | Operands::Mm2Flags2 => {
                self.inline_fits(pc, insn.code)
            }
            Operands::Flags | Operands::Flags2 | Operands::Flags3 => {
                let operands = [self.byte(pc + 1), self.byte(pc + 2), self.byte(pc + 3)];
                let known = effects::decode(insn.code, operands, Default::default()).is_some();
                known && (insn.code != Op::Event as u8 || self.slot_exists(operands[0]))
            }
            _ => {
                // What has a low cell in its code stands side by side, as loads and stores do.
                const LOW: u8 = Op::NextShort as u8;
                let short = insn.code.wrapping_sub(isa::LOAD);
                let low = insn.code.wrapping_sub(LOW);
                (short >= 2 * isa::SHORT_CELLS || usize::from(short % isa::SHORT_CELLS) < cells)
                    && (low >= 3 * isa::LOW_CELLS || usize::from(low % isa::LOW_CELLS) < cells)
            }
        };
        if good { Ok(()) } else { Err(Flaw::Operand) }
    }

    /// The flags ask for as many values as stand before them.
    fn inline_fits(&self, pc: usize, code: u8) -> bool {
        let Some(inline) = isa::inline(code) else { return false };
        let at = pc + 1 + usize::from(inline.values);
        let flags = [self.byte(at), self.byte(at + 1), 0];
        let Some(shape) = isa::shape(inline.code) else { return false };
        shape.pops() + isa::arguments(inline.code, flags[0], flags[1]) == inline.values
            && effects::decode(inline.code, flags, Default::default()).is_some()
    }

    fn slot_exists(&self, bits: u8) -> bool {
        let registers = matches!(
            bits & isa::flags::EVENT_KIND,
            isa::flags::ON_RISE | isa::flags::ON_FALL | isa::flags::ON_EVERY
        );
        !registers || bits & 3 < self.image.events()
    }

    /// Depths that an instruction demands, beyond the values that it takes.
    fn check_depth(&self, insn: &Insn, depth: u8) -> Result<(), Flaw> {
        const CALL: u8 = Op::Call as u8;
        const CALL_FAR: u8 = Op::CallFar as u8;
        const GOSUB: u8 = Op::Gosub as u8;
        const RETURN: u8 = Op::Return as u8;
        const EXIT_SUB: u8 = Op::ExitSub as u8;
        const LEAVE: u8 = Op::Leave as u8;
        const GIVE: u8 = Op::Give as u8;
        const FUNC: u8 = Op::Func as u8;
        let good = match insn.code {
            CALL | CALL_FAR | GOSUB | RETURN | EXIT_SUB | LEAVE => depth == 0,
            GIVE => depth == 1,
            FUNC => depth < entry::FUNC,
            _ => true,
        };
        if good { Ok(()) } else { Err(Flaw::Depth) }
    }

    /// An instruction begins at `target`, with depth `depth` before it.
    fn check_target(&self, target: usize, depth: u8) -> Result<(), Flaw> {
        if target >= self.image.code.len() {
            return Err(Flaw::Target);
        }
        let mut pc = self.anchor_before(target);
        let mut here = 0;
        while pc < target {
            let insn = self.insn(pc)?;
            here = after(&insn, here)?;
            pc = insn.next;
        }
        match pc == target {
            false => Err(Flaw::Target),
            true if here != depth => Err(Flaw::Depth),
            true => Ok(()),
        }
    }

    /// The last anchor that does not lie behind `target`.
    fn anchor_before(&self, target: usize) -> usize {
        let blocks = self.anchors.iter().enumerate().take(target / self.block + 1).rev();
        for (block, &anchor) in blocks {
            let place = block * self.block + usize::from(anchor);
            if anchor != NO_ANCHOR && place <= target {
                return place;
            }
        }
        0
    }
}

/// Depth behind an instruction.
fn after(insn: &Insn, depth: u8) -> Result<u8, Flaw> {
    let left = depth.checked_sub(insn.pops).ok_or(Flaw::Depth)?;
    match insn.class {
        Class::Ends => Ok(0),
        _ => Ok(left + insn.pushes),
    }
}
