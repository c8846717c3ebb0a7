//! TI-TXT: `@ADDR` lines, rows of hexadecimal bytes, and a closing `q`.

use super::{Image, LoadError};

impl Image {
    /// Reads TI-TXT, the text format of TI's flash tools (SLAU131, "TI-TXT hex format").
    ///
    /// # Errors
    /// At anything that is no address, no byte, or when the closing `q` is missing.
    pub fn from_titxt(text: &str) -> Result<Image, LoadError> {
        let mut image = Image::default();
        let mut addr: Option<u32> = None;
        for (n, row) in text.lines().enumerate() {
            let (line, row) = (n + 1, row.trim());
            if row.eq_ignore_ascii_case("q") {
                return Ok(image);
            }
            if let Some(hex) = row.strip_prefix('@') {
                let value = u32::from_str_radix(hex.trim(), 16)
                    .map_err(|_| LoadError::new(line, format!("`{hex}` is no address")))?;
                addr = Some(value);
                continue;
            }
            let bytes = row
                .split_whitespace()
                .map(|b| u8::from_str_radix(b, 16))
                .collect::<Result<Vec<u8>, _>>()
                .map_err(|_| LoadError::new(line, "expected bytes as two hexadecimal digits"))?;
            if bytes.is_empty() {
                continue;
            }
            let at = addr.ok_or_else(|| LoadError::new(line, "bytes before the first `@ADDR`"))?;
            image.push(line, at, &bytes)?;
            addr = Some(at + bytes.len() as u32);
        }
        Err(LoadError::new(0, "TI-TXT without its closing `q`: the file is cut short"))
    }
}
