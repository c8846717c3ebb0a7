//! Firmware images in the formats of other tools: ELF, Intel HEX, TI-TXT.

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

/// What is loaded, by the address at which it is kept: that of initialised data is another than where it is
/// used.
///
/// # Errors
/// It is no ELF file of such a chip.
pub fn pieces(image: &[u8]) -> Result<Vec<(u32, Vec<u8>)>, String> {
    let file = ElfFile32::<Endianness>::parse(image).map_err(|error| error.to_string())?;
    let endian = file.endian();
    let mut pieces = Vec::new();
    for section in file.sections() {
        let header = section.elf_section_header();
        let loaded = header.sh_flags(file.endian()) & elf::SHF_ALLOC == elf::SHF_ALLOC
            && header.sh_type(file.endian()) == elf::SHT_PROGBITS
            && section.size() > 0;
        if loaded {
            let data = section.data().map_err(|error| error.to_string())?;
            let at = header.sh_addr(endian);
            let segment = file.elf_program_headers().iter().find(|segment| {
                let start = segment.p_vaddr.get(endian);
                let loads = segment.p_type.get(endian) == elf::PT_LOAD;
                loads && (start..start + segment.p_filesz.get(endian)).contains(&at)
            });
            let segment = segment.ok_or("a section is in no segment")?;
            let start = at - segment.p_vaddr.get(endian) + segment.p_paddr.get(endian);
            pieces.push((start, data.to_vec()));
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
        let start = segment.p_paddr.get(endian);
        let end = start + segment.p_filesz.get(endian);
        let holds = |(at, _): &(u32, Vec<u8>)| (start..end).contains(at);
        if segment.p_type.get(endian) == elf::PT_LOAD && !pieces.iter().any(holds) {
            let place = first + n * size;
            let kind = changed.get_mut(place..place + 4).ok_or("its headers lie outside")?;
            kind.copy_from_slice(&[0; 4]);
        }
    }
    Ok(changed)
}

/// No section of our images crosses a border of 64 KB.
fn intel_hex(pieces: &[(u32, Vec<u8>)]) -> String {
    let mut text = String::new();
    let mut put = |kind: u8, at: u16, data: &[u8]| {
        let [high, low] = at.to_be_bytes();
        let mut record = vec![data.len() as u8, high, low, kind];
        record.extend(data);
        let sum = record.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        record.push(sum.wrapping_neg());
        text.push(':');
        record.iter().for_each(|byte| hex(&mut text, *byte));
        text.push('\n');
    };
    let mut upper = 0;
    for (start, bytes) in pieces {
        if start >> 16 != upper {
            // Extended linear address.
            upper = start >> 16;
            put(4, 0, &(upper as u16).to_be_bytes());
        }
        for (n, line) in bytes.chunks(LINE).enumerate() {
            put(0, (*start as u16).wrapping_add((n * LINE) as u16), line);
        }
    }
    text + ":00000001FF\n"
}

fn ti_txt(pieces: &[(u32, Vec<u8>)]) -> String {
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

    /// What a flash tool makes of a file.
    fn memory(file: &[u8]) -> Vec<u8> {
        let image = emulator::Image::parse(file).expect("one of the formats");
        let mut memory = vec![0xFF; 0x4_0000];
        for segment in &image.segments {
            let start = segment.addr as usize;
            memory[start..start + segment.data.len()].copy_from_slice(&segment.data);
        }
        memory
    }

    #[test]
    fn every_image_is_the_same_in_every_format() {
        for build in crate::board::BUILDS.into_iter() {
            let first = *build.chip.flash.start() as usize;
            let wanted = memory(build.elf);
            for format in [Format::Elf, Format::IntelHex, Format::TiTxt] {
                let file = memory(&format.of_image(build.elf).expect("an image"));
                let name = build.part.name;
                assert!(file[first..] == wanted[first..], "{name} as {format:?}");
                assert!(file[..first].iter().all(|byte| *byte == 0xFF), "{name} as {format:?}");
            }
        }
    }

    #[test]
    fn other_endings_are_refused_by_name() {
        for ending in [None, Some("bin"), Some("")] {
            assert!(Format::of(ending).is_err_and(|text| text.contains(".hex")), "{ending:?}");
        }
        assert_eq!(Format::of(Some("HEX")), Ok(Format::IntelHex));
    }
}
