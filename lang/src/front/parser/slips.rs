//! Slips whose remedy can be written with the numbers and names that stand there.

use super::input::{In, hyphenated, name};
use crate::axis::Axis;
use crate::front::codes::Code;
use crate::front::diag::{Diag, MAX_DIAGS};
use crate::front::lexer::begins_gcode;
use crate::front::literal;
use crate::front::span::Span;
use crate::front::token::{Sign, Tok};
use crate::front::words::{Kw, nearest};

/// Whether a digit stands directly before a place.
pub fn digit_before(text: &str, span: Span) -> bool {
    let before = text.as_bytes().get(..span.start as usize);
    before.and_then(<[u8]>::last).is_some_and(u8::is_ascii_digit)
}

/// Whether a comma stands between two digits, as in `2,5mm`.
pub fn is_decimal_comma(text: &str, comma: Span) -> bool {
    let after = text.as_bytes().get(comma.end as usize);
    digit_before(text, comma) && after.is_some_and(u8::is_ascii_digit)
}

/// The comma of `2,5mm`.
pub fn decimal_comma(comma: Span) -> Diag {
    Diag::new(Code::BadNumber, comma, "a comma stands in a number: it separates arguments")
        .hint("decimals have a point, as in `2.5mm`")
        .fix(comma, ".")
}

/// The literal that digits and a unit apart from them were meant as: `1200mm/min` of `1200 mm/min`.
/// `i` stands at the digits.
pub fn joined(i: In<'_>) -> String {
    let unit = i.rest().first().span;
    let rest = i.context.text.get(unit.start as usize..).unwrap_or("");
    let length = literal::unit_length(rest).unwrap_or((unit.end - unit.start) as usize);
    format!("{}{}", i.word(), &rest[..length])
}

/// `G 1 X 10 F 300`: letters and their numbers stand apart. `i` stands at the first letter.
pub fn words_apart(i: In<'_>) -> Option<Diag> {
    let apart = matches!(i.second().tok, Tok::Number);
    if !apart || i.word().len() != 1 || i.second().span.start == i.first().span.end {
        return None;
    }
    let start = i.first().span.start as usize;
    let text = i.context.text.get(start..)?;
    let end = text.find(['\r', '\n', ':', '\'', '(', ';']).unwrap_or(text.len());
    let line = text[..end].trim_end();
    let mut joined = String::with_capacity(line.len());
    let mut parts = line.split_whitespace();
    let mut open = false;
    for part in parts.by_ref() {
        let letter = part.len() == 1 && part.as_bytes()[0].is_ascii_alphabetic();
        if !open && !joined.is_empty() {
            joined.push(' ');
        }
        joined.push_str(part);
        open = letter;
    }
    let words = joined.split(' ');
    if open
        || !words.into_iter().all(|word| begins_gcode(word) || begins_gcode(&format!("G1 {word}")))
    {
        return None;
    }
    let whole = Span::new(i.first().span.start, i.first().span.start + line.len() as u32);
    let message = format!("`{}` and its number stand apart", i.word());
    Some(
        Diag::new(Code::GcodeWord, i.first().span.to(i.second().span), message)
            .hint(format!("the number follows its letter directly: `{joined}`"))
            .fix(whole, joined),
    )
}

/// `IF c THEN PRINT 1 END IF`: an IF with its statement in one line needs no end. `i` stands at the IF.
pub fn closed_line(i: In<'_>) -> Option<Diag> {
    let length = i.tokens.iter().position(|t| t.tok == Tok::LineEnd)?;
    let (Tok::Kw(Kw::If), line) = (i.tok(), i.tokens.get(..length)?) else { return None };
    let span = match line {
        [.., end, last] if (end.tok, last.tok) == (Tok::Kw(Kw::End), Tok::Kw(Kw::If)) => {
            end.span.to(last.span)
        }
        [.., last] if last.span.of(i.context.text).eq_ignore_ascii_case("ENDIF") => last.span,
        _ => return None,
    };
    let then = line.iter().any(|t| t.tok == Tok::Kw(Kw::Then));
    then.then(|| one_line_end(span))
}

/// What is told of the END IF of an IF that has its statement in its line.
pub fn one_line_end(span: Span) -> Diag {
    Diag::new(Code::BlockInOneLine, span, "a one-line IF has no END IF")
        .hint("leave it out, or end the line behind THEN")
        .fix(span, "")
}

/// `F1200mm/min` at the begin of a line, where it could be a name.
pub fn unit_in_word(i: In<'_>) -> Option<Diag> {
    let start = i.first().span.start;
    let word = i.word().chars().next().filter(|c| "FSXYZ".contains(c.to_ascii_uppercase()))?;
    let value = i.context.text.get(start as usize + 1..)?;
    let digits =
        value.len() - value.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
    let unit = literal::unit_length(&value[digits..]).filter(|_| digits > 0)?;
    let value = &value[..digits + unit];
    let whole = Span::new(start, start + 1 + value.len() as u32);
    let message = format!("a unit stands in the word `{word}{value}`");
    let instead = format!("{word}[{value}]");
    let hint = format!("a value that is no plain number stands in brackets: `{instead}`");
    Some(Diag::new(Code::GcodeWord, whole, message).hint(hint).fix(whole, instead))
}

/// `PAUSE 100` and `DELAY 100`, which count ms where they come from.
pub fn pause(i: In<'_>, message: &str) -> Option<Diag> {
    let counts_ms =
        ["DELAY", "PAUSE", "WAITMS"].iter().any(|word| word.eq_ignore_ascii_case(i.word()));
    let number = i.second();
    let digits = number.span.of(i.context.text);
    let plain = number.tok == Tok::Number && digits.bytes().all(|b| b.is_ascii_digit());
    if !counts_ms || !plain || !i.rest().rest().at_end() {
        return None;
    }
    let instead = format!("Wait {digits}ms");
    let whole = i.first().span.to(number.span);
    let diag = Diag::new(Code::ForeignStatement, i.first().span, message);
    Some(diag.hint(format!("write `{instead}`")).fix(whole, instead))
}

/// An axis letter where a value should stand: `a = X`.
pub fn axis_as_value(i: In<'_>) -> Option<Diag> {
    let mut letters = i.word().chars();
    let (Tok::Name, Some(letter), None) = (i.tok(), letters.next(), letters.next()) else {
        return None;
    };
    let axis = Axis::from_letter(letter)?.letter();
    let message = format!("`{letter}` is an axis, not a value");
    let diag = Diag::new(Code::WrongUse, i.first().span, message);
    if hyphenated(i).is_some() {
        let value = i.rest().second().span.of(i.context.text);
        return Some(diag.hint(format!(
            "its position is `POS({axis})`: `POS({axis}) - {value}`; one name has no `-` in it: `{letter}_{value}`"
        )));
    }
    Some(
        diag.hint(format!("its position is `POS({axis})`"))
            .fix(i.first().span, format!("POS({axis})")),
    )
}

/// `SetOut glue = ON` and `MoveAxe Z-depth`: another sign stands where the comma behind the first argument belongs.
/// `i` stands at the statement's word.
pub fn argument_sign(i: In<'_>) -> Option<Diag> {
    let i = if i.tok() == Tok::Kw(Kw::Start) { i.rest() } else { i };
    let (Tok::Kw(word) | Tok::Quiet(word)) = i.tok() else { return None };
    let [_, argument, sign, value, ..] = i.tokens else { return None };
    let usage = word.entry().usage;
    let shown = |span: Span| span.of(i.context.text);
    let (statement, first) = (shown(i.first().span), shown(argument.span));
    match (argument.tok, sign.tok) {
        (Tok::Name | Tok::Number, Tok::Sign(Sign::Eq)) if usage.contains(" n, ") => {
            let message = format!("`=` can not stand between the arguments of `{statement}`");
            let blank = if value.span.start == sign.span.end { ", " } else { "," };
            let diag = Diag::new(Code::Expected, sign.span, message);
            let hint = format!("write `,`: `{statement} {first}, {}`", shown(value.span));
            Some(diag.hint(hint).fix(Span::new(argument.span.end, sign.span.end), blank))
        }
        (Tok::Name, Tok::Sign(Sign::Minus)) if usage.contains(" axis, ") => {
            first.parse::<char>().ok().and_then(Axis::from_letter)?;
            let value = shown(value.span);
            let message = format!("`{first}` and `-{value}` are two arguments of `{statement}`");
            let diag = Diag::new(Code::Expected, sign.span, message);
            let place = Span::new(argument.span.end, sign.span.start);
            Some(diag.hint(format!("write `,`: `{statement} {first}, -{value}`")).fix(place, ", "))
        }
        _ => None,
    }
}

/// An axis where a statement should begin, and a name with a `-` in it that a value is given to.
pub fn axis_statement(i: In<'_>) -> Option<Diag> {
    let word = i.word();
    let axis = word.parse::<char>().ok().and_then(Axis::from_letter).map(Axis::letter);
    let hyphen = hyphenated(i).filter(|_| {
        axis.is_some() || i.tokens.get(3).is_some_and(|next| next.tok == Tok::Sign(Sign::Eq))
    });
    if hyphen.is_some() {
        return hyphen;
    }
    let axis = axis?;
    let message = format!("`{word}` is an axis and no statement");
    Some(
        Diag::new(Code::UnknownStatement, i.first().span, message).hint(format!(
            "to move it write `MoveAxe {axis}, 10mm`, or `G0 {axis}10` with other axes"
        )),
    )
}

/// What is wrong with the names of a list of declarations behind the first that is wrong: DIM and its
/// like end at the first one. `count` is the number of tokens of the statement.
pub fn further_names(i: In<'_>, count: usize) -> Vec<Diag> {
    if !matches!(i.tok(), Tok::Kw(Kw::Dim | Kw::Keep)) {
        return Vec::new();
    }
    let mut found = Vec::new();
    let mut open = 0_usize;
    for at in 1..count {
        let before = i.tokens[at - 1].tok;
        match before {
            Tok::Sign(Sign::Open) => open += 1,
            Tok::Sign(Sign::Close) => open = open.saturating_sub(1),
            _ => {}
        }
        let begins = at == 1 || before == Tok::Sign(Sign::Comma) && open == 0;
        let here = In { tokens: i.tokens.get(at..).unwrap_or(&[]), ..i };
        if begins
            && let Err(nom::Err::Failure(failure)) = name(here)
            && let Some(diag) = failure.into_diag(i.context.text, None)
            && diag.code == Code::BadName
        {
            found.push(diag);
        }
    }
    found
}

/// A word of the language where a value stands, and a declared name is nearly so: the name was meant.
pub fn undeclared(i: In<'_>) -> Option<Diag> {
    let (word, span) = (i.word(), i.first().span);
    let what = match i.tok() {
        Tok::Kw(kw) => format!("`{}` is a statement", kw.text()),
        Tok::Func(func) => format!("`{}` is a function", func.usage()),
        _ => return None,
    };
    let guesses = i.context.guesses.get();
    i.context.guesses.set(guesses + 1);
    if guesses >= MAX_DIAGS {
        return None;
    }
    let near = nearest(word, i.context.declared.iter().copied())?;
    let message = format!("`{word}` is not declared: {what}");
    Some(Diag::new(Code::UnknownName, span, message).near(near))
}

/// The same where a value is assigned: `count = 1`, `count(0) = 1`.
pub fn undeclared_target(i: In<'_>) -> Option<Diag> {
    match (i.tok(), i.second().tok) {
        (Tok::Kw(_) | Tok::Func(_), Tok::Sign(Sign::Eq))
        | (Tok::Func(_), Tok::Sign(Sign::Open)) => undeclared(i),
        _ => None,
    }
}

/// A reserved word with a colon, where the statement of that word needs more.
pub fn reserved_label(i: In<'_>) -> Option<Diag> {
    let (Tok::Kw(_) | Tok::Func(_), Tok::Sign(Sign::Colon)) = (i.tok(), i.second().tok) else {
        return None;
    };
    let word = i.word();
    let lower = word.to_ascii_lowercase();
    let common = match i.tok() {
        Tok::Kw(kw) => kw.may_be_name(),
        Tok::Func(func) => func.may_be_name(),
        _ => false,
    };
    let (message, hint) = if common {
        (
            format!("`{word}:` is a label only where a GOTO or GOSUB names it"),
            format!(
                "choose another name, as `my_{lower}:`, or write `GOTO {word}` where it is meant"
            ),
        )
    } else {
        (
            format!("`{word}` is a reserved word and can not be a label"),
            format!("choose another name, as `my_{lower}:`"),
        )
    };
    Some(Diag::new(Code::BadName, i.first().span, message).hint(hint))
}

/// `loop:` with no DO open, the commonest label of all.
pub fn loop_label(i: In<'_>, open: bool) -> Option<Diag> {
    let direct = i.second().span.start == i.first().span.end;
    (i.tok() == Tok::Kw(Kw::Loop) && direct && !open).then(|| reserved_label(i)).flatten()
}

/// A comma between the parts of a PRINT.
pub fn print_comma(i: In<'_>) -> Diag {
    Diag::new(Code::Expected, i.first().span, "`,` can not stand between the parts of a PRINT")
        .hint("write `;`; the parts are joined without blanks: PRINT a; \" \"; b")
        .fix(i.first().span, ";")
}
