//! Whether a statement is a G-code block, from its first characters.

use crate::front::literal;

/// Whether the statement that begins `rest` (blanks first) is a G-code block or a G-code comment.
///
/// It begins with one of G M F S T N X Y Z and a number or `[`. A run of name characters counts
/// only where it falls apart into such words (`G1X10F300`, `G1X[a]`): `t2max` is a name. With a
/// letter of [`LATER`] and plain digits, which are a name, it counts where a word follows that is
/// none: `I5 X10`.
pub fn begins_gcode(rest: &str) -> bool {
    let mut rest = blanks_off(rest.as_bytes());
    if rest.first().is_some_and(|first| matches!(first, b'(' | b';' | b'%')) {
        return true;
    }
    loop {
        match run(rest) {
            Run::Block => return true,
            Run::Name => return false,
            Run::Either(length) => rest = blanks_off(&rest[length..]),
        }
    }
}

/// Letters that a block may begin with although they and a number are a name.
const LATER: &[u8] = b"IJKRPQL";

/// What a run of name characters is.
enum Run {
    Block,
    Name,
    /// A name of so many characters, or a word of a block.
    Either(usize),
}

fn run(rest: &[u8]) -> Run {
    let block = |is: bool| if is { Run::Block } else { Run::Name };
    let Some(first) = rest.first().map(u8::to_ascii_uppercase) else { return Run::Name };
    let later = LATER.contains(&first);
    if !later && !b"GMFSTNXYZ".contains(&first) {
        return Run::Name;
    }
    let mut at = 0;
    while let Some(letter) = rest.get(at).filter(|b| b.is_ascii_alphabetic()) {
        let value = rest.get(at + 1).copied().unwrap_or(b' ');
        if matches!(value, b'[' | b'+' | b'-' | b'.') {
            let value = &rest[at + 1..];
            return block(match value[0] {
                b'[' => !(later && is_assigned(value)),
                b'.' if at == 0 => is_number(value) && !is_bit(value),
                _ => is_number(value),
            });
        }
        if !value.is_ascii_digit() {
            // The run ends in a letter without a number: X10 and ELSE may still touch.
            return block(at > 0 && !later && touches_else(*letter, &rest[at..]));
        }
        at += 1;
        at += rest[at..].iter().take_while(|b| b.is_ascii_digit()).count();
        if rest.get(at) == Some(&b'.') {
            return Run::Block;
        }
    }
    match rest.get(at).is_some_and(|&b| literal::is_name_byte(b)) {
        true => Run::Name,
        false if later => Run::Either(at),
        false => Run::Block,
    }
}

fn blanks_off(rest: &[u8]) -> &[u8] {
    let is_blank = |rest: &[u8]| match rest {
        [b' ' | b'\t' | 0x0B | 0x0C, ..] => 1,
        [0xC2, 0xA0, ..] => 2,
        _ => 0,
    };
    let mut rest = rest;
    while is_blank(rest) > 0 {
        rest = &rest[is_blank(rest)..];
    }
    rest
}

/// `[index] =`: what other languages write for an array.
fn is_assigned(rest: &[u8]) -> bool {
    let line = rest.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(rest.len());
    let close = rest[..line].iter().position(|b| *b == b']');
    close.is_some_and(|close| blanks_off(&rest[close + 1..]).first() == Some(&b'='))
}

/// `.3 =`, the bit of a variable that has one letter.
fn is_bit(rest: &[u8]) -> bool {
    let digits = rest[1..].iter().take_while(|b| b.is_ascii_digit()).count();
    blanks_off(&rest[1 + digits..]).first() == Some(&b'=')
}

fn is_number(rest: &[u8]) -> bool {
    let unsigned = rest.strip_prefix(b"-").or_else(|| rest.strip_prefix(b"+")).unwrap_or(rest);
    let digits = unsigned.strip_prefix(b".").unwrap_or(unsigned);
    digits.first().is_some_and(u8::is_ascii_digit)
}

fn touches_else(letter: u8, rest: &[u8]) -> bool {
    letter.eq_ignore_ascii_case(&b'E')
        && rest.get(..4).is_some_and(|w| w.eq_ignore_ascii_case(b"ELSE"))
        && !rest.get(4).is_some_and(|&b| literal::is_name_byte(b))
}
