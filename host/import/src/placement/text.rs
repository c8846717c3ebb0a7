//! The encodings that placement files come in: UTF-16, mostly with its mark (EasyEDA), UTF-8, else Windows'
//! Latin-1 (Altium).

use lang::front::source::utf16;

use crate::codes::Code;
use crate::diag::Diag;

/// Largest file that is read.
const MAX_BYTES: usize = 16 << 20;

/// The text of a file.
pub fn decode(bytes: &[u8]) -> Result<String, Diag> {
    if bytes.len() > MAX_BYTES {
        let words = format!("the file has {} bytes; at most {MAX_BYTES} are read", bytes.len());
        return Err(Diag::new(Code::TooLarge, 1, 1, words));
    }
    let wide = |little: bool| {
        let units = bytes.chunks_exact(2).map(|pair| match little {
            true => u16::from_le_bytes([pair[0], pair[1]]),
            false => u16::from_be_bytes([pair[0], pair[1]]),
        });
        let chars = char::decode_utf16(units);
        chars.map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>()
    };
    let text: String = match utf16(bytes) {
        Some(little) => wide(little).trim_start_matches('\u{FEFF}').to_owned(),
        None => {
            let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
            match core::str::from_utf8(bytes) {
                Ok(text) => text.to_owned(),
                Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect(),
            }
        }
    };
    if text.contains('\0') {
        let words = "the file is not text";
        return Err(Diag::new(Code::NotText, 1, 1, words).hint("export it as CSV"));
    }
    Ok(text.replace("\r\n", "\n").replace('\r', "\n"))
}
