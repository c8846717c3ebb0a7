//! ELF32 little endian: loadable segments at their physical addresses, and symbols.

use object::elf::{FileHeader32, PT_LOAD};
use object::read::elf::{ElfFile, ProgramHeader};
use object::{Endianness, Object, ObjectSymbol, SymbolSection};

use super::{Image, LoadError};

impl Image {
    /// Reads an ELF file: each `PT_LOAD` segment goes to its physical address, so that initial
    /// values of `.data` land in flash where the startup code copies them from.
    ///
    /// # Errors
    /// When the file is no 32-bit ELF, is damaged, or loads beyond the 20-bit addresses of the MSP430X.
    pub fn from_elf(bytes: &[u8]) -> Result<Image, LoadError> {
        let bad = |e: object::Error| LoadError::new(0, format!("damaged ELF file: {e}"));
        let file = ElfFile::<FileHeader32<Endianness>>::parse(bytes).map_err(bad)?;
        let endian = file.endian();
        let mut image = Image::default();
        for header in file.elf_program_headers() {
            if header.p_type(endian) != PT_LOAD {
                continue;
            }
            let data = header
                .data(endian, bytes)
                .map_err(|()| LoadError::new(0, "an ELF segment reaches beyond the file"))?;
            image.push(0, header.p_paddr(endian), data)?;
        }
        if image.segments.is_empty() {
            return Err(LoadError::new(0, "the ELF file has nothing to load: link it first"));
        }
        for symbol in file.symbols() {
            if let (Ok(name), Ok(addr)) = (symbol.name(), u32::try_from(symbol.address()))
                && !name.is_empty()
                // Assembly names fixed RAM addresses by global absolute symbols.
                && (symbol.is_definition()
                    || symbol.is_global() && symbol.section() == SymbolSection::Absolute)
            {
                image.symbols.insert(name.to_owned(), addr);
            }
        }
        Ok(image)
    }
}
