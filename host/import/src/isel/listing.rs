//! BASIC listings whose `PRINT #` lines go to the card, as the binder has them.

/// What a line of a listing sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sent<'t> {
    /// This.
    Text(&'t str),
    /// Nothing to the card.
    Nothing,
    /// What only a run of the program shows; why.
    Unknown(&'static str),
}

/// Signs that open and close a text; the binder prints some as guillemets.
const QUOTES: [char; 3] = ['"', '«', '»'];

/// Whether a file is a listing: one of its lines prints a command of the card.
pub(super) fn is_one(lines: &[(u32, &str)]) -> bool {
    lines.iter().any(|(_, line)| matches!(sent(line), Sent::Text(text) if text.starts_with('@')))
}

/// What a line sends.
pub(super) fn sent(line: &str) -> Sent<'_> {
    let rest = line.trim_start().trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
    let word_end = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
    let (word, rest) = rest.split_at(word_end);
    match word.to_ascii_lowercase().as_str() {
        "print" => printed(rest),
        "for" | "next" | "while" | "wend" | "do" | "loop" | "read" | "data" | "input" => {
            Sent::Unknown(
                "the listing's own loop or data: what it sends is not known without a run",
            )
        }
        _ if prints(rest) => Sent::Unknown(
            "whether this PRINT is reached is not known without a run: write it on a line of its own",
        ),
        _ => Sent::Nothing,
    }
}

/// Whether a text has a `PRINT #`.
fn prints(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    lower
        .match_indices("print")
        .any(|(at, word)| lower[at + word.len()..].trim_start().starts_with('#'))
}

fn printed(rest: &str) -> Sent<'_> {
    let to_card = rest.trim_start().starts_with('#');
    let Some(from) = rest.find(QUOTES) else {
        return match to_card {
            true => {
                Sent::Unknown("this prints a variable: what it sends is not known without a run")
            }
            false => Sent::Nothing,
        };
    };
    let quote = rest[from..].chars().next().map_or(1, char::len_utf8);
    // `print"1,"@0S"` and `print#"7 1"` stand in the binder for `print#1,"..."`.
    let mut text = &rest[from + quote..];
    if let Some(at) = text.strip_prefix("1,").and_then(|tail| tail.starts_with(QUOTES).then_some(2))
    {
        let quote = text[at..].chars().next().map_or(1, char::len_utf8);
        text = &text[at + quote..];
    } else if !to_card && !text.starts_with('@') {
        return Sent::Nothing;
    }
    let (text, tail) = match text.find(QUOTES) {
        Some(end) => text.split_at(end),
        None => (text, ""),
    };
    let tail = tail.trim_start_matches(QUOTES).trim_start();
    if prints(tail) {
        return Sent::Unknown("a second PRINT on this line: write it on a line of its own");
    }
    if tail.starts_with([';', '+'])
        && tail[1..].trim_start().starts_with(|c: char| c.is_alphabetic())
    {
        return Sent::Unknown("this prints a variable: what it sends is not known without a run");
    }
    Sent::Text(text)
}

#[cfg(test)]
mod tests {
    use super::{Sent, sent};

    #[test]
    fn only_what_is_printed_goes_to_the_card() {
        for (line, text) in [
            ("110 print#1,\"@07\":gosub 1000", "@07"),
            ("110 print#1,»@07»:gosub 1000", "@07"),
            ("PRINT #1, \"0 100,900\"", "0 100,900"),
            ("150 print#\"7 1\":gosub1000", "7 1"),
            ("190 print\"1,\"@0S\",gosub1000", "@0S"),
            ("130 print#1,\"020,200,30,300\"gosub1000", "020,200,30,300"),
            ("165 print\"@0S", "@0S"),
        ] {
            assert_eq!(sent(line), Sent::Text(text), "{line}");
        }
        for line in [
            "100 open \"com1:9600,N,8,1\" as #1",
            "1010 a$=input$(1,1)",
            "1015 if a$=\"0\" then return",
            "1020 print \"carte répond erreur\":a$",
            "125 gosub1000",
            "",
        ] {
            assert_eq!(sent(line), Sent::Nothing, "{line}");
        }
        for line in [
            "30 FOR i = 1 TO 5",
            "40 print#1,x$",
            "50 print#1,\"0 \";x;\",900\"",
            "60 if x then print #1,\"@0R1\"",
            "70 print#1,\"@07\":print#1,\"@0R7\"",
        ] {
            assert!(matches!(sent(line), Sent::Unknown(_)), "{line}");
        }
    }
}
