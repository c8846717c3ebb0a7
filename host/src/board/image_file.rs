//! A firmware image as other tools take it: ELF, Intel HEX, TI-TXT.

use std::fmt::Write as _;

use object::elf;
use object::read::elf::{ElfFile32, FileHeader as _, SectionHeader as _};
use object::{Endianness, Object as _, ObjectSection as _};

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// With symbols, for debuggers too.
    Elf,
    /// Intel's hexadecimal object file format, revision A.
    IntelHex,
    /// TI-TXT (SLAU131, "TI-TXT hex format").
    TiTxt,
}

/// Bytes of a line of both text formats.
const LINE: usize = 16;

impl Format {
    /// By the ending of a file's name.
    ///
    /// # Errors
    /// It is none of ours.
    pub fn of(ending: Option<&str>) -> Result<Format, String> {
        match ending.map(str::to_ascii_lowercase).as_deref() {
            Some("elf" | "out") => Ok(Format::Elf),
            Some("hex" | "ihex" | "a43") => Ok(Format::IntelHex),
            Some("txt") => Ok(Format::TiTxt),
            _ => Err("the file's ending says what it becomes: .elf, .hex (Intel HEX) or .txt \
                      (TI-TXT)"
                .to_owned()),
        }
    }

    /// The image in this format.
    ///
    /// # Errors
    /// It is no ELF file of a 16-bit chip.
    pub fn of_image(self, image: &[u8]) -> Result<Vec<u8>, String> {
        match self {
            Format::Elf => without_empty_segments(image),
            Format::IntelHex => Ok(intel_hex(&pieces(image)?).into_bytes()),
            Format::TiTxt => Ok(ti_txt(&pieces(image)?).into_bytes()),
        }
    }
}

/// What is loaded, by address.
fn pieces(image: &[u8]) -> Result<Vec<(u16, Vec<u8>)>, String> {
    let file = ElfFile32::<Endianness>::parse(image).map_err(|error| error.to_string())?;
    let mut pieces = Vec::new();
    for section in file.sections() {
        let header = section.elf_section_header();
        let loaded = header.sh_flags(file.endian()) & elf::SHF_ALLOC == elf::SHF_ALLOC
            && header.sh_type(file.endian()) == elf::SHT_PROGBITS
            && section.size() > 0;
        if loaded {
            let data = section.data().map_err(|error| error.to_string())?;
            let last = section.address() + section.size() - 1;
            let start = u16::try_from(last).ok().and(u16::try_from(section.address()).ok());
            pieces.push((start.ok_or("a section lies behind 64 KB")?, data.to_vec()));
        }
    }
    pieces.sort();
    Ok(pieces)
}

/// The linker makes a segment of the file's own headers, at address 0: a tool that loads segments
/// would write them over the chip's peripherals. Such a segment, in which no section lies, becomes
/// none.
fn without_empty_segments(image: &[u8]) -> Result<Vec<u8>, String> {
    let file = ElfFile32::<Endianness>::parse(image).map_err(|error| error.to_string())?;
    let header = file.elf_header();
    let endian = file.endian();
    let first = header.e_phoff.get(endian) as usize;
    let size = usize::from(header.e_phentsize.get(endian));
    let pieces = pieces(image)?;
    let mut changed = image.to_vec();
    let segments = header.program_headers(endian, image).map_err(|error| error.to_string())?;
    for (n, segment) in segments.iter().enumerate() {
        let start = segment.p_vaddr.get(endian);
        let end = start + segment.p_filesz.get(endian);
        let holds = |(at, _): &(u16, Vec<u8>)| (start..end).contains(&u32::from(*at));
        if segment.p_type.get(endian) == elf::PT_LOAD && !pieces.iter().any(holds) {
            let place = first + n * size;
            let kind = changed.get_mut(place..place + 4).ok_or("its headers lie outside")?;
            kind.copy_from_slice(&[0; 4]);
        }
    }
    Ok(changed)
}

fn intel_hex(pieces: &[(u16, Vec<u8>)]) -> String {
    let mut text = String::new();
    for (start, bytes) in pieces {
        for (n, line) in bytes.chunks(LINE).enumerate() {
            let [high, low] = (start + (n * LINE) as u16).to_be_bytes();
            let mut record = vec![line.len() as u8, high, low, 0];
            record.extend(line);
            let sum = record.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
            record.push(sum.wrapping_neg());
            text.push(':');
            record.iter().for_each(|byte| hex(&mut text, *byte));
            text.push('\n');
        }
    }
    text + ":00000001FF\n"
}

fn ti_txt(pieces: &[(u16, Vec<u8>)]) -> String {
    let mut text = String::new();
    for (start, bytes) in pieces {
        let _ = writeln!(text, "@{start:04X}");
        for line in bytes.chunks(LINE) {
            for (n, byte) in line.iter().enumerate() {
                if n > 0 {
                    text.push(' ');
                }
                hex(&mut text, *byte);
            }
            text.push('\n');
        }
    }
    text + "q\n"
}

fn hex(text: &mut String, byte: u8) {
    let _ = write!(text, "{byte:02X}");
}

#[cfg(test)]
mod tests {
    use super::{Format, intel_hex, ti_txt};

    #[test]
    fn records_have_the_bytes_of_the_formats_descriptions() {
        // The record that Intel's description and its sum are shown by.
        let data = [
            0x21, 0x46, 0x01, 0x36, 0x01, 0x21, 0x47, 0x01, 0x36, 0x00, 0x7E, 0xFE, 0x09, 0xD2,
            0x19, 0x01,
        ];
        let told = ":10010000214601360121470136007EFE09D2190140\n:00000001FF\n";
        assert_eq!(intel_hex(&[(0x0100, data.to_vec())]), told);
        let told = "@F000\n31 40 00 03\n@FFFE\n00 F0\nq\n";
        assert_eq!(ti_txt(&[(0xF000, vec![0x31, 0x40, 0, 3]), (0xFFFE, vec![0, 0xF0])]), told);
    }

    #[test]
    fn other_endings_are_refused_by_name() {
        for ending in [None, Some("bin"), Some("")] {
            assert!(Format::of(ending).is_err_and(|text| text.contains(".hex")), "{ending:?}");
        }
        assert_eq!(Format::of(Some("HEX")), Ok(Format::IntelHex));
    }
}
