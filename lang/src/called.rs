//! What a program of a library is called, and which programs an image runs.

use crate::image::{Image, address};
use crate::isa::{self, Op};

/// Whether two programs of a library have the same name: letters of both cases are the same.
pub fn same(left: &str, right: &str) -> bool {
    left.eq_ignore_ascii_case(right)
}

/// Whether a program may be called so.
///
/// # Errors
/// It may not; the text says why.
#[cfg(feature = "compiler")]
pub fn check(name: &str) -> Result<(), String> {
    const NAME: usize = crate::part::NAME;
    let plain = |c: char| c.is_ascii_graphic() && c != '"' || c == ' ';
    if let Some(other) = name.chars().find(|c| !plain(*c)) {
        return Err(format!("a program's name cannot have {other:?}: ASCII, no quotes"));
    }
    if name.trim() != name || name.is_empty() {
        return Err("a program's name begins and ends with a letter or a sign".to_owned());
    }
    if name.len() > NAME {
        return Err(format!("a program's name has {NAME} characters at most"));
    }
    if name.parse::<u32>().is_ok() {
        return Err(format!("{name} is a program's number, not its name"));
    }
    Ok(())
}

/// Each RUN of an image: its address in the code, and the name.
pub fn runs<'a>(image: &Image<'a>) -> impl Iterator<Item = (usize, &'a [u8])> + use<'a> {
    let image = *image;
    let wide = image.header.wide();
    let mut pc = 0;
    core::iter::from_fn(move || {
        loop {
            let here = pc;
            let code = *image.code.get(here)?;
            pc += 1 + isa::shape(code)?.operands().len(wide);
            if code == Op::Run as u8 {
                return Some((here, image.text(address(image.code, here + 1, wide)?)?));
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::check;

    #[test]
    fn names_are_what_sixteen_bytes_of_ascii_hold() {
        for good in ["a", "drill plate", "sixteen letters!", "12b", "-1"] {
            assert_eq!(check(good), Ok(()), "{good}");
        }
        for wrong in ["", " a", "a ", "a\"b", "\u{e9}", "seventeen letters", "12"] {
            assert!(check(wrong).is_err(), "{wrong}");
        }
    }
}
