//! Lines of G-code as words.

/// A letter and its number.
pub(super) type Word = (char, f64);

/// The words of a line, without comments and a block number; and what stood behind a semicolon or in
/// brackets, as it was.
pub(super) struct Line<'t> {
    pub words: Vec<Word>,
    pub comment: &'t str,
}

/// Takes a line apart; the text that is no word if there is such.
pub(super) fn line(text: &str) -> Result<Line<'_>, String> {
    let end = text.find([';', '(']).unwrap_or(text.len());
    let (code, comment) = text.split_at(end);
    let inside = comment.starts_with('(');
    // Words behind a comment in brackets would be lost.
    let after = if inside { comment.split_once(')').map_or("", |(_, rest)| rest) } else { "" };
    if !after.trim().is_empty() && !after.trim().starts_with([';', '(']) {
        return Err(after.trim().chars().take(20).collect());
    }
    let mut words = Vec::new();
    let mut rest = code.trim();
    while let Some(letter) = rest.chars().next() {
        let bad = || rest.chars().take(20).collect::<String>();
        if !letter.is_ascii_alphabetic() {
            return Err(bad());
        }
        let body = rest[1..].trim_start();
        let number = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-' | '+');
        let end = body.find(|c| !number(c)).unwrap_or(body.len());
        let value = body[..end].parse::<f64>().ok().filter(|value| value.abs() <= 1e7);
        let letter = letter.to_ascii_uppercase();
        if letter != 'N' {
            words.push((letter, value.ok_or_else(bad)?));
        }
        rest = body[end..].trim_start();
    }
    Ok(Line { words, comment: comment.trim_end() })
}
