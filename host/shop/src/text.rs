//! Lengths as scripts write them.

/// A length of a script, from mm: whole um, without zeros at its end.
pub(crate) fn mm(value: f64) -> String {
    format!("{}mm", plain(value))
}

/// The same number without its unit, for words of G-code.
pub(crate) fn plain(value: f64) -> String {
    let um = (value * 1000.0).round() as i64;
    let sign = if um < 0 { "-" } else { "" };
    let size = um.unsigned_abs();
    let text = format!("{sign}{}.{:03}", size / 1000, size % 1000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A text for a comment: printable ASCII in one line.
pub(crate) fn comment(text: &str) -> String {
    let keep = |c: char| if c == '"' || c.is_control() || !c.is_ascii() { '_' } else { c };
    text.chars().take(200).map(keep).collect()
}

#[cfg(test)]
mod tests {
    use super::{comment, mm, plain};

    #[test]
    fn lengths_are_whole_um_and_comments_one_line() {
        assert_eq!([mm(1.0), mm(-0.0004), mm(-0.25)], ["1mm", "0mm", "-0.25mm"]);
        assert_eq!(plain(12.3456), "12.346");
        assert_eq!(comment("a\n\"b\"é"), "a__b__");
    }
}
