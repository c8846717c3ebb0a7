//! Intel HEX, by the crate `ihex`.

use ihex::{Reader, Record};

use super::{Image, LoadError};

impl Image {
    /// Reads Intel HEX text (I8HEX, I16HEX or I32HEX).
    ///
    /// # Errors
    /// At a malformed record, a wrong checksum, a missing end record or an address beyond the 20-bit addresses of the MSP430X.
    pub fn from_hex(text: &str) -> Result<Image, LoadError> {
        let mut image = Image::default();
        let mut base = 0u32;
        let mut ended = false;
        for (n, record) in Reader::new(text).enumerate() {
            let line = n + 1;
            let record = record.map_err(|e| LoadError::new(line, format!("Intel HEX: {e}")))?;
            match record {
                Record::Data { offset, value } => {
                    image.push(line, base + u32::from(offset), &value)?;
                }
                Record::ExtendedSegmentAddress(segment) => base = u32::from(segment) << 4,
                Record::ExtendedLinearAddress(high) => base = u32::from(high) << 16,
                Record::StartSegmentAddress { .. } | Record::StartLinearAddress(_) => {}
                Record::EndOfFile => ended = true,
            }
        }
        if !ended {
            return Err(LoadError::new(
                0,
                "Intel HEX without its end record: the file is cut short",
            ));
        }
        Ok(image)
    }
}
