//! Program images: bytes at addresses, from ELF, Intel HEX or TI-TXT.

mod elf;
mod hex;
mod titxt;

use std::collections::BTreeMap;
use std::fmt;

use crate::address::Address;

/// First address that the 20 bits of the MSP430X do not reach.
const LIMIT: u64 = 0x10_0000;

/// Bytes that belong at `addr`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segment {
    /// Load address.
    pub addr: u32,
    /// Content; `addr + data.len()` is at most [`LIMIT`].
    pub data: Vec<u8>,
}

/// A program as a loader found it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Image {
    /// Bytes in file order.
    pub segments: Vec<Segment>,
    /// Symbol name to address; only ELF files have any.
    pub symbols: BTreeMap<String, u32>,
}

/// Why a file could not be loaded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoadError {
    /// Line of a text file, counted from 1; 0 when the format has none.
    pub line: usize,
    /// What is wrong.
    pub text: String,
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}", self.text),
            line => write!(f, "line {line}: {}", self.text),
        }
    }
}

impl std::error::Error for LoadError {}

impl LoadError {
    fn new(line: usize, text: impl Into<String>) -> Self {
        LoadError { line, text: text.into() }
    }
}

impl Image {
    /// Loads an image, recognising its format by its first bytes.
    ///
    /// # Errors
    /// When the content is none of ELF (`\x7fELF`), Intel HEX (`:`) and TI-TXT (`@`), or is damaged.
    pub fn parse(bytes: &[u8]) -> Result<Image, LoadError> {
        if bytes.starts_with(b"\x7fELF") {
            return Image::from_elf(bytes);
        }
        let text = std::str::from_utf8(bytes).map_err(|_| {
            LoadError::new(0, "neither ELF nor text: expected ELF, Intel HEX or TI-TXT")
        })?;
        match text.trim_start().chars().next() {
            Some(':') => Image::from_hex(text),
            Some('@' | 'q' | 'Q') => Image::from_titxt(text),
            _ => Err(LoadError::new(1, "expected ELF, Intel HEX (`:`) or TI-TXT (`@`)")),
        }
    }

    /// An image of raw bytes at one address.
    ///
    /// # Errors
    /// When the bytes reach beyond the 20-bit addresses of the MSP430X.
    pub fn from_bytes(addr: impl Address, data: &[u8]) -> Result<Image, LoadError> {
        let mut image = Image::default();
        image.push(0, addr.wide(), data)?;
        Ok(image)
    }

    /// The byte that the image puts at `addr`.
    #[must_use]
    pub fn byte(&self, addr: impl Address) -> Option<u8> {
        let addr = addr.wide();
        self.segments
            .iter()
            .rev()
            .find_map(|s| s.data.get(addr.checked_sub(s.addr)? as usize).copied())
    }

    /// Address of a symbol.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<u32> {
        self.symbols.get(name).copied()
    }

    /// The symbol at or below `addr` and the distance to it.
    #[must_use]
    pub fn symbol_at(&self, addr: impl Address) -> Option<(&str, u32)> {
        let addr = addr.wide();
        self.symbols
            .iter()
            .filter(|(_, a)| **a <= addr)
            .max_by_key(|(_, a)| **a)
            .map(|(name, a)| (name.as_str(), addr - a))
    }

    fn push(&mut self, line: usize, addr: u32, data: &[u8]) -> Result<(), LoadError> {
        if data.is_empty() {
            return Ok(());
        }
        let end = u64::from(addr) + data.len() as u64;
        if end > LIMIT {
            return Err(LoadError::new(
                line,
                format!("{} bytes at {addr:#x} are beyond {:#x}", data.len(), LIMIT - 1),
            ));
        }
        if let Some(last) = self.segments.last_mut()
            && last.addr as usize + last.data.len() == addr as usize
        {
            last.data.extend_from_slice(data);
        } else {
            self.segments.push(Segment { addr, data: data.to_vec() });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
