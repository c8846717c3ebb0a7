//! Instructions of the MSP430 as far as their length and their use of the stack go.

/// Registers by number.
const PC: u16 = 0;
const SP: u16 = 1;
const SR: u16 = 2;
const CG: u16 = 3;

/// `CALL #N`.
pub const CALL: u16 = 0x12B0;
/// `RET`, that is `MOV @SP+, PC`.
pub const RET: u16 = 0x4130;
/// `RETI`.
pub const RETI: u16 = 0x1300;
/// `BR #N`, that is `MOV #N, PC`.
pub const BR: u16 = 0x4030;

/// `RETA`, that is `MOVA @SP+, PC`; this one and those below by SLAU208, 6.5 (address instructions).
pub const RETA: u16 = 0x0110;

/// `CALLA #imm20` to an address whose bits 19:16 are these.
pub fn calla(high: u16) -> u16 {
    0x13B0 | high
}

/// `BRA #imm20`, that is `MOVA #imm20, PC`.
pub fn bra(high: u16) -> u16 {
    0x0080 | high << 8
}

/// An instruction: where its words are, as indices of the code's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Insn {
    /// Its first word.
    pub at: usize,
    /// That word.
    pub word: u16,
    /// Where the extension of its source is.
    pub source: Option<usize>,
    /// Where the extension of its destination is.
    pub target: Option<usize>,
}

impl Insn {
    /// The instruction behind.
    pub fn next(&self) -> usize {
        self.at + 1 + usize::from(self.source.is_some()) + usize::from(self.target.is_some())
    }

    fn two_operands(&self) -> bool {
        self.word >= 0x4000
    }

    /// Register and mode of the source, or of the only operand.
    fn source_mode(&self) -> (u16, u16) {
        let register = if self.two_operands() { self.word >> 8 & 15 } else { self.word & 15 };
        (register, self.word >> 4 & 3)
    }

    /// Whether this writes the program counter in another way than the ones above.
    pub fn jumps_by_value(&self) -> bool {
        let to_pc = self.two_operands() && self.word & 0x8F == PC;
        let calls = self.word & 0xFF80 == 0x1280;
        to_pc && !matches!(self.word, RET | BR) || calls && self.word != CALL
    }

    /// The extension words that are offsets from the stack pointer.
    pub fn stack_offsets(&self) -> impl Iterator<Item = usize> {
        let (register, mode) = self.source_mode();
        let jump = (0x2000..0x4000).contains(&self.word);
        let source = self.source.filter(|_| !jump && register == SP && mode == 1);
        let target = self.target.filter(|_| self.word & 15 == SP);
        source.into_iter().chain(target)
    }

    /// Bytes that this puts on the stack: `PUSH Rn`, or `SUB #n, SP` with its constant.
    fn puts(&self, words: &[u16]) -> Option<u16> {
        if self.word & 0xFFF0 == 0x1200 {
            return Some(2);
        }
        (self.word & 0xF0CF == 0x8001).then(|| self.constant(words)).flatten()
    }

    /// The value of an immediate source.
    fn constant(&self, words: &[u16]) -> Option<u16> {
        match (self.source_mode(), self.source) {
            ((PC, 3), Some(at)) => words.get(at).copied(),
            ((CG, 1), _) => Some(1),
            ((CG, 2), _) => Some(2),
            ((SR, 2), _) => Some(4),
            ((SR, 3), _) => Some(8),
            _ => None,
        }
    }

    /// Whether this moves the stack pointer.
    fn moves_stack(&self) -> bool {
        let arithmetic = self.two_operands() && self.word & 0x8F == SP;
        // CMP and BIT only look.
        let looks = matches!(self.word >> 12, 0x9 | 0xB);
        let pushes = self.word & 0xFF80 == 0x1200;
        arithmetic && !looks || pushes
    }

    /// Whether this is part of a way out: `ADD #n, SP` or `POP Rn`.
    fn takes_off(&self) -> bool {
        self.word & 0xF0CF == 0x5001 || self.word & 0xFFF0 == 0x4130
    }
}

/// The instructions of compiled code.
///
/// # Errors
/// A word that no compiler for the MSP430 writes, by its place in bytes.
pub fn decode(words: &[u16]) -> Result<Vec<Insn>, String> {
    let mut list = Vec::new();
    let mut at = 0;
    while let Some(&word) = words.get(at) {
        let mut insn = Insn { at, word, source: None, target: None };
        let mut next = at + 1;
        match word >> 12 {
            2 | 3 => {}
            1 if word < 0x1300 || word == RETI => {
                if word != RETI && extends(word & 15, word >> 4 & 3) {
                    insn.source = Some(next);
                }
            }
            4.. => {
                if extends(word >> 8 & 15, word >> 4 & 3) {
                    insn.source = Some(next);
                    next += 1;
                }
                if word & 0x80 != 0 {
                    insn.target = Some(next);
                }
            }
            _ => return Err(format!("no instruction of the MSP430 at {:#x}: {word:#06x}", 2 * at)),
        }
        at = insn.next();
        if at > words.len() {
            return Err("the last instruction is cut off".to_owned());
        }
        list.push(insn);
    }
    Ok(list)
}

/// Whether an operand has a word of its own.
fn extends(register: u16, mode: u16) -> bool {
    match mode {
        1 => register != CG,
        3 => register == PC,
        _ => false,
    }
}

/// Arguments that a function finds on the stack lie behind its return address: makes that two bytes
/// longer.
///
/// # Errors
/// Code that uses the stack in another way than the compiler's known ones.
pub fn lengthen_return(words: &mut [u16], code: &[Insn]) -> Result<(), String> {
    let entry = code.iter().take_while(|insn| insn.puts(words).is_some()).count();
    let frame: u16 = code[..entry].iter().filter_map(|insn| insn.puts(words)).sum();
    let first = frame + 2;
    let place = |insn: &Insn| format!("at {:#x}", 2 * insn.at);
    let mut addressed = None;
    for insn in &code[entry..] {
        if insn.moves_stack() && !insn.takes_off() {
            return Err(format!("the stack moves {}", place(insn)));
        }
        for at in insn.stack_offsets() {
            if words[at] >= first {
                words[at] += 2;
            }
        }
        // An address on the stack is made by MOV SP, Rn and ADD #n, Rn.
        let taken = addressed.take();
        if insn.word & 0xFFF0 == 0x4100 && insn.word & 15 > CG {
            addressed = Some(insn.word & 15);
        } else if insn.word & 0xF0CF == 0x5000 | taken.unwrap_or(u16::MAX) {
            // What a register is added for is an array, and no argument is one.
            match (insn.constant(words), insn.source) {
                (Some(offset), _) if offset < first => {}
                (Some(_), Some(at)) => words[at] += 2,
                (Some(_), None) => {
                    return Err(format!(
                        "an argument's address is made by a short constant {}",
                        place(insn)
                    ));
                }
                (None, _) => {}
            }
        }
    }
    Ok(())
}
