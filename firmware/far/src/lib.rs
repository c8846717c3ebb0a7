//! Lays compiled functions of an MSP430X above 64 KB, where a compiler for the MSP430 cannot.
//!
//! Such a compiler calls by `CALL`, which knows 16 bits of an address and pushes 16. All that has to be
//! other for code above 64 KB are the words that name an address in code, and each of them has a
//! counterpart of the same length: `CALLA` for `CALL`, `RETA` for `RET`, `BRA` for `BR`; jumps are
//! relative. So an object file is changed in place, between compiler and linker:
//!
//! - A *far* function is one that a compiler made: it is left by `RETA`, and every `CALL` of it, in
//!   assembly, too, becomes `CALLA`. Arguments on the stack lie two bytes further then.
//! - All but those that [`Near`] names go to sections `.high.*` instead of `.text.*`, which the linker
//!   script puts to addresses from 10000 to 1FFFF; when these are taken, to `.more.*`, from 20000 on.
//! - Assembly is left as it is, below 64 KB and by `CALL` and `RET`. Far functions up there call the
//!   routine `x` through the gate `gate.x`, which the assembly must have: `call #x` and `RETA`.
//!
//! What has no counterpart is refused by name: functions whose address is taken, tables of jumps.

mod code;

use code::{BR, CALL, RET, RETA, RETI, bra, calla, decode, lengthen_return};
use object::elf::{
    FileHeader32, R_MSP430_16_BYTE, Rela32, SHF_ALLOC, SHF_EXECINSTR, SHT_RELA, STT_FUNC,
    SectionFlags, Sym32,
};
use object::read::elf::{FileHeader, SectionHeader, SectionTable, Sym, SymbolTable};
use object::{LittleEndian as Le, SectionIndex, SymbolIndex};
use std::collections::BTreeMap;

/// What the sections of compiled functions are called, and what they are called from here on by the bits 19:16 of their
/// addresses: each as long as that.
const TEXT: &str = ".text.";
const BANKS: [&str; 3] = [TEXT, ".high.", ".more."];
/// Bytes of functions that go to bits 1: 64 KB but for what aligns them. The linker drops those that nobody calls, so
/// the bank is never overfull.
const FULL: usize = 0xFE00;
/// Before the name of a routine in that of its gate.
const GATE: &str = "gate.";

/// Functions that stay below 64 KB because they are called often or call assembly often.
#[derive(Clone, Debug, Default)]
pub struct Near(Vec<Vec<String>>);

impl Near {
    /// One function, or one module, a line: the end of its path as in the sources, `ramp::Run::segment`.
    /// Empty lines and those that begin with `#` are none.
    pub fn parse(text: &str) -> Near {
        let lines = text.lines().map(str::trim);
        let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        // In a mangled name (RFC 2603) each identifier stands behind its length.
        let mangled = |name: &str| format!("{}{name}", name.len());
        Near(lines.map(|line| line.split("::").map(mangled).collect()).collect())
    }

    fn has(&self, symbol: &str) -> bool {
        self.0.iter().any(|path| {
            let mut rest = symbol;
            path.iter().all(|name| match rest.split_once(name.as_str()) {
                Some((_, behind)) => {
                    rest = behind;
                    true
                }
                None => false,
            })
        })
    }
}

/// A section with the function in it.
#[derive(Clone, Debug)]
struct Function {
    name: String,
    /// Bits 19:16 of its address.
    bank: u16,
}

/// An object file as `rustc` gives it to the linker, with its functions made far.
///
/// # Errors
/// The file is no ELF object, or a function has what cannot be far.
pub fn rewrite(object: &[u8], near: &Near) -> Result<Vec<u8>, String> {
    let header = FileHeader32::<Le>::parse(object).map_err(damaged)?;
    let sections = header.sections(Le, object).map_err(damaged)?;
    let symbols = sections.symbols(Le, object, object::elf::SHT_SYMTAB).map_err(damaged)?;
    let file = File { object, sections, symbols };
    let mut functions = file.functions()?;
    let mut out = object.to_vec();
    let strings = header.section_strings_index(Le, object).map_err(damaged)?;
    let strings = file.sections.section(strings).map_err(damaged)?.sh_offset(Le) as usize;
    let mut handlers = Vec::new();
    let mut taken = 0;
    for (index, function) in &mut functions {
        let section = file.sections.section(SectionIndex(*index)).map_err(damaged)?;
        let mut words = words(section.data(Le, object).map_err(damaged)?);
        if !lengthen(&mut words).map_err(|error| format!("{}: {error}", function.name))? {
            handlers.push(*index);
            continue;
        }
        put(&mut out, section.sh_offset(Le) as usize, &words);
        let label = file.sections.section_name(Le, section).map_err(damaged)?;
        if label.starts_with(TEXT.as_bytes()) && !near.has(&function.name) {
            taken += 2 * words.len();
            function.bank = if taken <= FULL { 1 } else { 2 };
            let name = BANKS[usize::from(function.bank)];
            let at = strings + section.sh_name(Le) as usize;
            out[at..at + name.len()].copy_from_slice(name.as_bytes());
        }
    }
    functions.retain(|index, _| !handlers.contains(index));
    file.redirect(&functions, &mut out)?;
    Ok(out)
}

/// A function's own words; `false` for a handler of the hardware, which knows 16 bits.
fn lengthen(words: &mut [u16]) -> Result<bool, String> {
    let code = decode(words)?;
    if code.iter().any(|insn| insn.word == RETI) {
        return Ok(false);
    }
    if let Some(insn) = code.iter().find(|insn| insn.jumps_by_value()) {
        return Err(format!("goes where a value says at {:#x}: a table of jumps?", 2 * insn.at));
    }
    lengthen_return(words, &code)?;
    for insn in code.iter().filter(|insn| insn.word == RET) {
        words[insn.at] = RETA;
    }
    Ok(true)
}

fn damaged(error: object::Error) -> String {
    format!("damaged object file: {error}")
}

type Header = FileHeader32<Le>;

/// An object file, taken apart.
struct File<'a> {
    object: &'a [u8],
    sections: SectionTable<'a, Header>,
    symbols: SymbolTable<'a, Header>,
}

impl File<'_> {
    fn name(&self, symbol: &Sym32<Le>) -> Result<String, String> {
        let name = symbol.name(Le, self.symbols.strings()).map_err(damaged)?;
        Ok(String::from_utf8_lossy(name).into_owned())
    }

    /// The compiled functions, by the numbers of their sections.
    fn functions(&self) -> Result<BTreeMap<usize, Function>, String> {
        let mut functions = BTreeMap::new();
        for symbol in self.symbols.iter().filter(|symbol| symbol.st_type() == STT_FUNC) {
            let function = Function { name: self.name(symbol)?, bank: 0 };
            let name = function.name.clone();
            let home = usize::from(symbol.st_shndx(Le).0);
            if symbol.st_value(Le) != 0 || functions.insert(home, function).is_some() {
                return Err(format!("{name} has no section of its own"));
            }
        }
        Ok(functions)
    }

    /// Turns calls of functions, and those calls of assembly that come from above.
    fn redirect(
        &self,
        functions: &BTreeMap<usize, Function>,
        out: &mut [u8],
    ) -> Result<(), String> {
        let by_name: BTreeMap<String, usize> = (0..)
            .zip(self.symbols.iter())
            .skip(1)
            .map(|(index, symbol)| Ok((self.name(symbol)?, index)))
            .collect::<Result<_, String>>()?;
        let relocations = self.sections.iter().filter(|section| section.sh_type(Le) == SHT_RELA);
        for section in relocations {
            let from = section.sh_info(Le) as usize;
            let owner = self.sections.section(SectionIndex(from)).map_err(damaged)?;
            let has = |flag: SectionFlags| owner.sh_flags(Le).0 & flag.0 != 0;
            let caller_is_high = functions.get(&from).is_some_and(|caller| caller.bank != 0);
            let list = section.data_as_array::<Rela32<Le>, _>(Le, self.object).map_err(damaged)?;
            for (n, own) in list.iter().enumerate() {
                let entry = section.sh_offset(Le) as usize + n * size_of::<Rela32<Le>>();
                let at = own.r_offset.get(Le) as usize;
                let place = || {
                    let label = self.sections.section_name(Le, owner).unwrap_or_default();
                    format!("{}+{at:#x}", String::from_utf8_lossy(label))
                };
                let info = own.r_info.get(Le);
                let target = SymbolIndex((info >> 8) as usize);
                // A relocation against nothing is an absolute address.
                let Ok(symbol) = self.symbols.symbol(target) else { continue };
                let callee = functions.get(&usize::from(symbol.st_shndx(Le).0));
                let instruction =
                    has(SHF_EXECINSTR) && info & 0xFF == R_MSP430_16_BYTE.0 && at >= 2;
                let before = owner.sh_offset(Le) as usize + at.saturating_sub(2);
                let word = instruction.then(|| word(out, before));
                let turned = match (callee, word) {
                    (Some(callee), Some(CALL)) => calla(callee.bank),
                    (Some(callee), Some(BR)) => bra(callee.bank),
                    (Some(callee), _) if has(SHF_ALLOC) => {
                        return Err(format!(
                            "the address of {} is taken at {}",
                            callee.name,
                            place()
                        ));
                    }
                    (None, Some(CALL)) if caller_is_high => {
                        let gate = format!("{GATE}{}", self.name(symbol)?);
                        let Some(gate) = by_name.get(&gate) else {
                            return Err(format!("there is no {gate}, wanted at {}", place()));
                        };
                        let info = (*gate as u32) << 8 | info & 0xFF;
                        out[entry + 4..entry + 8].copy_from_slice(&info.to_le_bytes());
                        calla(0)
                    }
                    (None, Some(BR)) if caller_is_high => {
                        return Err(format!("goes on in assembly at {}", place()));
                    }
                    _ => continue,
                };
                out[before..before + 2].copy_from_slice(&turned.to_le_bytes());
                let bank = callee.map_or(0, |callee| callee.bank);
                if bank != 0 {
                    // A relocation of 16 bits: the linker must not see more.
                    let addend = own.r_addend.get(Le) - (i32::from(bank) << 16);
                    out[entry + 8..entry + 12].copy_from_slice(&addend.to_le_bytes());
                }
            }
        }
        Ok(())
    }
}

fn words(bytes: &[u8]) -> Vec<u16> {
    bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

fn word(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn put(bytes: &mut [u8], at: usize, words: &[u16]) {
    for (place, word) in bytes[at..].chunks_exact_mut(2).zip(words) {
        place.copy_from_slice(&word.to_le_bytes());
    }
}
