//! Program images: bytes at addresses, from ELF, Intel HEX or TI-TXT.

mod elf;
mod hex;
mod titxt;

use std::collections::BTreeMap;
use std::fmt;

/// Bytes that belong at `addr`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segment {
    /// Load address.
    pub addr: u16,
    /// Content; `addr + data.len()` is at most 0x1_0000.
    pub data: Vec<u8>,
}

/// A program as a loader found it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Image {
    /// Bytes in file order.
    pub segments: Vec<Segment>,
    /// Symbol name to address; only ELF files have any.
    pub symbols: BTreeMap<String, u16>,
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
    /// When the bytes reach beyond 0xFFFF.
    pub fn from_bytes(addr: u16, data: &[u8]) -> Result<Image, LoadError> {
        let mut image = Image::default();
        image.push(0, u32::from(addr), data)?;
        Ok(image)
    }

    /// The byte that the image puts at `addr`.
    #[must_use]
    pub fn byte(&self, addr: u16) -> Option<u8> {
        self.segments
            .iter()
            .rev()
            .find_map(|s| s.data.get(usize::from(addr.checked_sub(s.addr)?)).copied())
    }

    /// Address of a symbol.
    #[must_use]
    pub fn symbol(&self, name: &str) -> Option<u16> {
        self.symbols.get(name).copied()
    }

    /// The symbol at or below `addr` and the distance to it.
    #[must_use]
    pub fn symbol_at(&self, addr: u16) -> Option<(&str, u16)> {
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
        let start = u16::try_from(addr).ok().filter(|_| end <= 0x1_0000);
        let Some(addr) = start else {
            return Err(LoadError::new(
                line,
                format!("{} bytes at {addr:#x} are beyond 0xffff", data.len()),
            ));
        };
        if let Some(last) = self.segments.last_mut()
            && usize::from(last.addr) + last.data.len() == usize::from(addr)
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
