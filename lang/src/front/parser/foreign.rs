//! What people write who come from other BASICs and controllers, and what to write here.

use super::input::{In, is_unit};
use super::piece::{Closer, Opener, Piece, closing_words};
use super::slips;
pub use super::slips::{argument_sign, axis_as_value, joined, loop_label, print_comma, undeclared};
use super::stmt::behind_parentheses;
use crate::front::ast::{Expr, ExprKind};
use crate::front::codes::Code;
use crate::front::diag::{Diag, MAX_DIAGS};
use crate::front::span::Span;
use crate::front::token::{Sign, Tok};
use crate::front::words::{Class, Func, Kw, Reserved, lookup, nearest};
use crate::kind::Kind;

/// Statement words of other systems, folded to upper case, and what is written here.
const STATEMENTS: &[(&str, &str)] = &[
    ("AFTER", "write `Wait 500ms`, or `ON EVERY 500ms GOSUB sub`"),
    ("EVERY", "write `ON EVERY 100ms GOSUB sub`"),
    ("TASK", "one program runs: `START` moves beside it, ON IN and ON EVERY serve events"),
    ("PARALLEL", "one program runs: `START` moves beside it, ON IN and ON EVERY serve events"),
    ("TYPE", "there are no records: a TABLE has columns, and an array has places"),
    ("DELAY", "write `Wait 500ms`"),
    ("PAUSE", "write `Wait 500ms`; to wait for a person write `WaitStart`"),
    ("SLEEP", "write `Wait 500ms`"),
    ("DWELL", "write `Wait 500ms`"),
    ("WAITMS", "write `Wait 500ms`"),
    ("LET", "leave LET out: `n = 1`"),
    ("VAR", "declare with DIM: `DIM n`"),
    ("INT", "declare with DIM: `DIM n`"),
    ("INTEGER", "declare with DIM: `DIM n`"),
    ("LONG", "declare with DIM: `DIM n`"),
    ("LOCAL", "declare with DIM: inside a SUB it is local"),
    ("STATIC", "declare with DIM outside of the SUB"),
    ("GLOBAL", "declare with DIM outside of SUBs"),
    ("FLOAT", "values are whole numbers with a kind: `DIM x AS LENGTH`"),
    ("DATA", "constant values stand in a TABLE: `TABLE t = 1, 2, 3`"),
    ("READ", "read a TABLE by its index: `n = t(i)`"),
    ("RESTORE", "a TABLE is read by its index: `n = t(i)`"),
    ("ENDIF", "write `END IF`"),
    ("ENDSUB", "write `END SUB`"),
    ("ENDFUNCTION", "write `END FUNCTION`"),
    ("ENDSELECT", "write `END SELECT`"),
    ("ENDREPEAT", "write `END REPEAT`"),
    ("ENDWHILE", "write `WEND`"),
    ("FOREVER", "`LOOP` closes a DO that repeats for ever"),
    ("ELSIF", "write `ELSEIF`"),
    ("ELIF", "write `ELSEIF`"),
    ("SWITCH", "write `SELECT CASE`"),
    ("BREAK", "write `EXIT FOR`, or what else it is in"),
    ("LEAVE", "write `EXIT FOR`, or what else it is in"),
    ("HALT", "write `END`"),
    ("STOP", "write `END` to end the run, `StopAll` to stop the axes"),
    ("QUIT", "write `END`"),
    ("PROC", "write `SUB name` ... `END SUB`"),
    ("PROCEDURE", "write `SUB name` ... `END SUB`"),
    ("DEF", "write `SUB name` ... `END SUB` or `FUNCTION name()`"),
    ("FUNC", "write `FUNCTION name()` ... `END FUNCTION`"),
    ("DEFINE", "write `CONST name = value`"),
    ("ECHO", "write `PRINT`"),
    ("PRINTF", "write `PRINT \"text\"; value`"),
    ("PRINTLN", "write `PRINT`"),
    ("WRITE", "write `PRINT`"),
    ("SETPIN", "write `SetOut n, ON`"),
    ("PIN", "write `SetOut n, ON`, and `IN(n)` to read"),
    ("DIGITALWRITE", "write `SetOut n, ON`"),
    ("SETIO", "write `SetOut n, ON`"),
    ("CLRIO", "write `SetOut n, OFF`"),
    ("OUTON", "write `SetOut n, ON`"),
    ("OUTOFF", "write `SetOut n, OFF`"),
    ("MOVE", "write `MoveAxe X, 10mm` for one axis, `G0 X10 Y5` for several"),
    ("MOVEABS", "write `MoveAxe X, 10mm`"),
    ("MOVEA", "write `MoveAxe X, 10mm`"),
    ("MOVEAXIS", "write `MoveAxe X, 10mm`"),
    ("MOVER", "write `MoveRel X, 10mm`"),
    ("MOVETO", "write `MoveAxe X, 10mm` for one axis, `G0 X10 Y5` for several"),
    ("MOVEINC", "write `MoveRel X, 10mm`"),
    ("WAITIDLE", "write `WaitMove`"),
    ("REFERENCE", "write `Home X`"),
    ("REF", "write `Home X`"),
    ("DATUM", "write `Home X`"),
    ("HOMING", "write `Home X`"),
    ("INC", "write `n = n + 1`"),
    ("DEC", "write `n = n - 1`"),
    ("INCR", "write `n = n + 1`"),
    ("DECR", "write `n = n - 1`"),
    ("OPTION", "leave it out: every name is declared"),
    ("SUBEND", "write `END SUB`"),
    ("RETI", "write `RETURN`"),
    ("BEGIN", "leave it out: blocks end with their own word"),
    ("THENELSE", "write `THEN` and `ELSE` apart"),
    ("HIGH", "write `SetOut n, ON`"),
    ("LOW", "write `SetOut n, OFF`"),
    ("SET", "write `SetOut n, ON`"),
    ("RESET", "write `SetOut n, OFF`"),
    ("TOGGLE", "write `SetOut n, NOT OUT(n)`"),
    ("PULSOUT", "write `Pulse n, 20ms`"),
    ("PULSEOUT", "write `Pulse n, 20ms`"),
    ("SYMBOL", "write `INPUT name = 1`, `OUTPUT name = 1` or `CONST name = value`"),
    ("ALIAS", "write `INPUT name = 1` or `OUTPUT name = 1`"),
    ("SERTXD", "write `PRINT \"text\"; value`"),
    ("DEBUG", "write `PRINT \"text\"; value`"),
    ("WAITUS", "write `Wait 1ms`, the shortest wait"),
    ("CONFIG", "leave it out: the machine's profile says what hangs where"),
    ("STEPPER", "the profile describes the motors; write `Home`, `MoveAxe X, 10mm`, `G0 X10 Y5`"),
    ("SETTICK", "write `ON EVERY 100ms GOSUB label`"),
    ("END_VAR", "leave it out: each variable is declared by `DIM name`"),
    ("END_FUNCTION_BLOCK", "write `END SUB`"),
];

/// Kinds that other languages have.
const KINDS: &[(&str, &str)] = &[
    ("INTEGER", "write `AS NUMBER`, or leave it out"),
    ("INT", "write `AS NUMBER`, or leave it out"),
    ("LONG", "write `AS NUMBER`, or leave it out"),
    ("SINGLE", "there are no fractions: lengths in `AS LENGTH` are whole micrometres"),
    ("DOUBLE", "there are no fractions: lengths in `AS LENGTH` are whole micrometres"),
    ("FLOAT", "there are no fractions: lengths in `AS LENGTH` are whole micrometres"),
    ("STRING", "there are no text variables: texts stand in PRINT"),
    ("BOOL", "write `AS TRUTH`"),
    ("BOOLEAN", "write `AS TRUTH`"),
    ("BYTE", "write `AS NUMBER`"),
    ("POSITION", "write `AS LENGTH` or `AS STEPS`"),
    ("DISTANCE", "write `AS LENGTH`"),
];

/// The hint of a table for a word.
fn look_up(table: &[(&'static str, &'static str)], word: &str) -> Option<&'static str> {
    table.iter().find(|(w, _)| w.eq_ignore_ascii_case(word)).map(|(_, hint)| *hint)
}

/// The words of ours that a hint says to write, where they are the whole of it: they may take the
/// place of the foreign one.
fn bare_words(hint: &'static str) -> Option<&'static str> {
    let words = hint.strip_prefix("write `")?.strip_suffix('`')?;
    let ours = |word| matches!(lookup(word), Some(Reserved::Kw(_)));
    words.split(' ').all(ours).then_some(words)
}

/// A block's line that another BASIC writes in another way, read as what it means.
pub fn block_word(i: In<'_>) -> Option<(Piece, usize)> {
    let word = i.word();
    let close = |closer, count| Some((Piece::Close(closer), count));
    match (i.tok(), i.second().tok) {
        (Tok::Kw(Kw::End), Tok::Kw(Kw::While | Kw::Wend)) => close(Closer::While, 2),
        (Tok::Kw(Kw::End), Tok::Kw(Kw::For | Kw::Next)) => close(Closer::For(None), 2),
        (Tok::Kw(Kw::End), Tok::Kw(Kw::Do | Kw::Loop)) => close(Closer::Do(None), 2),
        (Tok::Name, _) => match word.to_ascii_uppercase().as_str() {
            "ENDIF" | "END_IF" => close(Closer::If, 1),
            "ENDSUB" | "SUBEND" => close(Closer::Sub, 1),
            "ENDFUNCTION" | "END_FUNCTION" => close(Closer::Function, 1),
            "ENDSELECT" | "END_CASE" => close(Closer::Select, 1),
            "ENDREPEAT" | "END_REPEAT" => close(Closer::Repeat, 1),
            "ENDWHILE" | "END_WHILE" => close(Closer::While, 1),
            "ENDFOR" | "END_FOR" => close(Closer::For(None), 1),
            "FOREVER" => close(Closer::Do(None), 1),
            _ => None,
        },
        _ => None,
    }
}

/// The diagnostic for what [`block_word`] found.
pub fn block_word_diag(i: In<'_>, piece: &Piece, span: Span) -> Diag {
    let shown = span.of(i.context.text).to_ascii_uppercase();
    let closing = match piece {
        Piece::Close(closer) => closing_words(closer.opener()),
        _ => "ELSEIF",
    };
    Diag::new(Code::ForeignStatement, span, format!("`{shown}` does not exist here"))
        .hint(format!("write `{closing}`"))
        .fix(span, closing)
}

/// A statement that begins with a name that is no SUB and is not assigned to.
pub fn unknown_statement(i: In<'_>) -> Diag {
    let word = i.word();
    let span = i.first().span;
    if let Some(diag) = slips::words_apart(i).or_else(|| slips::axis_statement(i)) {
        return diag;
    }
    if let Some(hint) = look_up(STATEMENTS, word) {
        let message = format!("there is no statement `{word}`");
        if let Some(diag) = slips::pause(i, &message) {
            return diag;
        }
        let diag = Diag::new(Code::ForeignStatement, span, message).hint(hint);
        return match bare_words(hint) {
            Some(ours) => diag.fix(span, ours),
            None if word.eq_ignore_ascii_case("LET") => {
                diag.fix(Span::new(span.start, i.second().span.start), "")
            }
            None => diag,
        };
    }
    if let Tok::Sign(Sign::Colon) = i.second().tok {
        let message = format!("`{word}` is no statement");
        let diag = Diag::new(Code::BlankLabel, span, message);
        let colon = i.second().span;
        return if colon.start > span.end {
            diag.hint(format!("a label's colon follows directly: `{word}:`"))
                .fix(Span::new(span.end, colon.start), "")
        } else {
            diag.hint("a label stands at the start of its line")
        };
    }
    // `led Alias Portb.0` of BASCOM.
    if i.second().span.of(i.context.text).eq_ignore_ascii_case("alias") {
        let message = "there is no `ALIAS`";
        return Diag::new(Code::ForeignStatement, i.second().span, message)
            .hint(format!("write `INPUT {word} = 1` or `OUTPUT {word} = 1`"));
    }
    if let Some(diag) = slips::unit_in_word(i) {
        return diag;
    }
    // A word only where what acts on the way follows it.
    if word.eq_ignore_ascii_case(Kw::Sync.text())
        && matches!(i.second().tok, Tok::Name | Tok::Kw(_))
    {
        let second = i.second().span;
        let message = format!("`{}` does not act on the way", second.of(i.context.text));
        return Diag::new(Code::UnknownStatement, second, message)
            .hint(format!("the form is `{}`", Kw::Sync.entry().usage));
    }
    let message = format!("there is no statement or SUB `{word}`");
    let diag = Diag::new(Code::UnknownStatement, span, message);
    if is_later_word(word) && matches!(i.second().tok, Tok::Name | Tok::LineEnd) {
        return diag.hint("a block of G-code whose words could be names begins with its `G` word");
    }
    let words = Kw::ALL.iter().filter(|kw| kw.begins_statement()).map(|kw| kw.text());
    let guesses = i.context.guesses.get();
    i.context.guesses.set(guesses + 1);
    let subs = i.context.routines.iter().map(String::as_str).take(1000);
    let near = if guesses < MAX_DIAGS { nearest(word, words.chain(subs)) } else { None };
    match (near, i.second().tok) {
        (Some(near), _) => diag.near(near),
        (None, Tok::Sign(Sign::OpenBracket)) => {
            diag.hint(format!("an index stands in parentheses: `{word}(0) = 1`"))
        }
        (None, Tok::Sign(Sign::Open)) => diag.hint(format!(
            "a SUB is declared with `SUB {word}`; an assignment has `=` behind the parentheses"
        )),
        (None, Tok::LineEnd | Tok::Kw(Kw::Else)) if i.depth > 0 => {
            diag.hint(format!("to go to a label write `GOTO {word}`"))
        }
        (None, Tok::LineEnd) => {
            diag.hint(format!("a label is written `{word}:`, an assignment `{word} = 1`"))
        }
        (None, Tok::Number | Tok::Name | Tok::Text) => diag.hint(format!(
            "an assignment is `{word} = ...`; a SUB of that name begins with `SUB {word}(n)`"
        )),
        (None, _) => diag.hint(format!("a SUB is declared with `SUB {word}`")),
    }
}

/// `I5`: a name, and a word of a block where others come before it.
fn is_later_word(word: &str) -> bool {
    let (letter, digits) = word.split_at(1);
    "IJKRPQLijkrpql".contains(letter)
        && !digits.is_empty()
        && digits.bytes().all(|b| b.is_ascii_digit())
}

/// Something that can not begin a statement.
pub fn no_statement(i: In<'_>) -> Diag {
    let span = i.first().span;
    let word = i.word();
    match i.tok() {
        Tok::Number if !word.contains(|c: char| c.is_ascii_alphabetic()) => {
            Diag::new(Code::LineNumber, span, "lines have no numbers")
                .hint("delete it; a label is written `name:`")
                .fix(Span::new(span.start, i.second().span.start.max(span.end)), "")
        }
        Tok::Func(Func::Out) => {
            Diag::new(Code::ForeignStatement, span, "OUT is a function that reads an output")
                .hint("write `SetOut n, ON`")
        }
        Tok::Func(Func::In) => {
            Diag::new(Code::ForeignStatement, span, "IN is a function that reads an input")
                .hint("write `WaitIn n, ON` or `IF IN(n) THEN`")
        }
        Tok::Func(func) => {
            let message = format!("`{}` is a function and no statement", func.text());
            Diag::new(Code::UnknownStatement, span, message)
                .hint(format!("use its value: `n = {}`", func.usage()))
        }
        Tok::Kw(Kw::Until) => Diag::new(Code::UnopenedBlock, span, "UNTIL closes no block")
            .hint("write `DO` ... `LOOP UNTIL condition`"),
        Tok::Kw(kw) if kw.entry().class == Class::Part => {
            let message = format!("`{}` can not begin a statement", kw.text());
            Diag::new(Code::UnknownStatement, span, message)
                .hint(format!("it belongs to `{}`", kw.entry().usage))
        }
        _ => {
            let message = format!("`{}` can not begin a statement", short(word));
            Diag::new(Code::UnknownStatement, span, message)
                .hint("a statement begins with a statement word, a name or a G-code word")
        }
    }
}

fn short(word: &str) -> String {
    word.chars().take(30).collect()
}

/// `10mm/MIN(a, b)`: letters behind digits are a unit, also where a function was meant.
pub fn unit_call(i: In<'_>) -> Option<Diag> {
    let (number, open) = (i.first().span, i.second());
    if open.tok != Tok::Sign(Sign::Open) || open.span.start != number.end {
        return None;
    }
    let word = i.word();
    let letters = word.len() - word.trim_end_matches(|c: char| c.is_ascii_alphabetic()).len();
    let (before, unit) = word.split_at(word.len() - letters);
    if !["in", "min"].iter().any(|name| name.eq_ignore_ascii_case(unit)) {
        return None;
    }
    let before = before.strip_suffix('/').map_or(before.to_owned(), |b| format!("{b} /"));
    let message = format!("`{unit}` is the unit of `{word}` here and no function");
    let diag = Diag::new(Code::BadUnit, number.to(open.span), message);
    Some(diag.hint(format!("write a blank: `{before} {}(`", unit.to_ascii_uppercase())))
}

/// What stands behind a complete statement.
pub fn surplus(i: In<'_>) -> Option<Diag> {
    let span = i.first().span;
    let word = short(i.word());
    if i.tok() == Tok::Bad {
        return None;
    }
    if is_unit(i) {
        return Some(
            Diag::new(Code::UnitApart, span, format!("the unit `{word}` stands apart"))
                .hint(format!(
                    "a unit follows digits, as in `5{word}`; other values are multiplied: `* 1{word}`"
                )),
        );
    }
    let diag = match i.tok() {
        Tok::Sign(Sign::Comma) if slips::is_decimal_comma(i.context.text, span) => {
            slips::decimal_comma(span)
        }
        Tok::Text if span.start > 0 && slips::digit_before(i.context.text, span) => {
            let sign = Span::new(span.start, span.start + 1);
            Diag::new(Code::BadUnit, sign, "`\"` is no unit")
                .hint("inches are written `in`, as in `2in`")
                .fix(sign, "in")
        }
        Tok::Sign(Sign::Comma) => {
            Diag::new(Code::WrongArguments, span, "there are too many arguments")
        }
        Tok::Sign(Sign::Close) => Diag::new(Code::Expected, span, "this `)` closes nothing")
            .hint("delete it, or open it with `(`")
            .fix(span, ""),
        Tok::Sign(Sign::OpenBracket) => {
            Diag::new(Code::ForeignBrackets, span, "`[` has no meaning")
                .hint("a size or an index stands in parentheses: `a(5)`")
        }
        Tok::Sign(Sign::CloseBracket) => Diag::new(Code::Expected, span, "this `]` closes nothing")
            .hint("delete it; indices stand in parentheses: `a(5)`")
            .fix(span, ""),
        Tok::Sign(Sign::Semicolon) => {
            Diag::new(Code::ForeignComment, span, "`;` has no meaning here")
                .hint("comments begin with `'`; `;` begins one in G-code only")
                .fix(span, "'")
        }
        Tok::Kw(Kw::Then) => Diag::new(Code::Expected, span, "`THEN` has no IF"),
        Tok::Kw(Kw::Do) => Diag::new(Code::Expected, span, "`DO` begins a block of its own")
            .hint("leave it out: FOR and WHILE have no DO")
            .fix(span, ""),
        Tok::Sign(Sign::Eq) => Diag::new(Code::Expected, span, "no value can be given here")
            .hint("assign by a statement of its own: `a = 5`"),
        Tok::Kw(kw) if kw.begins_statement() => {
            let message = format!("the statement before `{word}` does not end");
            Diag::new(Code::Expected, span, message).hint("a `:` separates statements")
        }
        _ => {
            let message = format!("the statement should end before `{word}`");
            Diag::new(Code::Expected, span, message)
        }
    };
    Some(diag)
}

/// END IF behind a statement of a one-line IF.
pub fn one_line_end(i: In<'_>) -> Option<Diag> {
    let (Tok::Kw(Kw::End), Tok::Kw(Kw::If)) = (i.tok(), i.second().tok) else { return None };
    let span = i.first().span.to(i.second().span);
    Some(slips::one_line_end(span))
}

/// A block's line inside a one-line IF.
pub fn in_one_line(i: In<'_>, span: Span, piece: &Piece) -> Diag {
    let word = i.word().to_ascii_uppercase();
    match piece {
        Piece::Close(Closer::If) => slips::one_line_end(span),
        Piece::ElseIf(_) => Diag::new(Code::BlockInOneLine, span, "a one-line IF has no ELSEIF")
            .hint("write `ELSE IF ... THEN`, or the block form with THEN at the line's end"),
        _ => Diag::new(
            Code::BlockInOneLine,
            span,
            format!("`{word}` can not stand in a one-line IF"),
        )
        .hint("end the line behind THEN and close with `END IF`"),
    }
}

/// The form of an ON statement with this second word.
pub fn on_usage(second: Tok) -> &'static str {
    match second {
        Tok::Kw(Kw::Error) => "ON ERROR GOTO label` or `ON ERROR STOP",
        Tok::Func(Func::In) => "ON IN n RISE|FALL GOSUB sub` or `ON IN n OFF",
        Tok::Kw(Kw::Every) => "ON EVERY time GOSUB sub` or `ON EVERY OFF",
        _ => "ON ERROR ...`, `ON IN ...` or `ON EVERY ...",
    }
}

/// A word behind AS that is no kind.
pub fn kind(i: In<'_>) -> Diag {
    let word = i.word();
    let names = || Kind::ALL.iter().map(|k| k.name());
    let diag = Diag::new(Code::Expected, i.first().span, format!("`{word}` is not a kind"));
    if let Some(hint) = look_up(KINDS, word) {
        let ours = hint.strip_prefix("write `AS ").and_then(|rest| rest.split_once('`'));
        let diag = diag.hint(hint);
        return match ours {
            Some((kind, _)) => diag.fix(i.first().span, kind),
            None => diag,
        };
    }
    match nearest(word, names()) {
        Some(near) => diag.near(near),
        None => diag.hint(format!("kinds are {}", names().collect::<Vec<_>>().join(", "))),
    }
}

/// `MoveAxe(1, 2000, ...)`, `SetOut(1, 1)`: parentheses round a statement's arguments.
pub fn parenthesised_list(word: Kw, i: In<'_>) -> Option<Diag> {
    if i.tok() != Tok::Sign(Sign::Open) || word == Kw::Print {
        return None;
    }
    let takes_axis = word.entry().usage.contains("axis,") || word.entry().usage.ends_with("axis");
    let takes_axis = takes_axis && word != Kw::Motors;
    let mut rest = i.rest();
    let mut open = 1usize;
    let mut list = false;
    while open > 0 && !rest.at_end() {
        match rest.tok() {
            Tok::Sign(Sign::Open) => open += 1,
            Tok::Sign(Sign::Close) => open -= 1,
            Tok::Sign(Sign::Comma) => list |= open == 1,
            _ => {}
        }
        rest = rest.rest();
    }
    let whole = behind_parentheses(i).is_some_and(In::at_end);
    if !(takes_axis || (list && whole)) {
        return None;
    }
    let message = format!("the arguments of `{}` stand without parentheses", word.text());
    let diag = Diag::new(Code::ForeignBrackets, i.first().span.to(i.span_to(rest)), message);
    let example = matches!(word, Kw::MoveAxe).then_some("MoveAxe X, 2000st");
    Some(diag.hint(match example {
        Some(example) => format!("write `{example}`; the form is `{}`", word.entry().usage),
        None => format!("the form is `{}`", word.entry().usage),
    }))
}

/// The inner or closing line of a block that a line which could not be read stands for.
pub fn broken_line(i: In<'_>) -> Option<Piece> {
    match i.tok() {
        Tok::Kw(Kw::Case) => Some(Piece::Case(Vec::new())),
        Tok::Kw(Kw::ElseIf) => Some(Piece::ElseIf(Expr {
            kind: ExprKind::Literal { kind: Kind::Truth, value: 0 },
            span: i.first().span,
        })),
        Tok::Kw(Kw::Wend) => Some(Piece::Close(Closer::While)),
        Tok::Kw(Kw::Loop) => Some(Piece::Close(Closer::Do(None))),
        Tok::Kw(Kw::Next) => Some(Piece::Close(Closer::For(None))),
        _ => None,
    }
}

/// The opener that a line which could not be read stands for, so that its end finds it.
pub fn broken_opener(i: In<'_>, line: In<'_>) -> Option<Opener> {
    let Tok::Kw(kw) = i.tok() else { return None };
    match kw {
        Kw::For | Kw::While | Kw::Do | Kw::Repeat | Kw::Select | Kw::Sub | Kw::Function => {
            Some(Opener::Broken(kw))
        }
        Kw::If => {
            let tokens = line.tokens.iter().take_while(|t| t.tok != Tok::LineEnd);
            let then = tokens.clone().position(|t| t.tok == Tok::Kw(Kw::Then));
            let block = then.is_none_or(|n| n + 1 == tokens.count());
            block.then_some(Opener::Broken(Kw::If))
        }
        _ => None,
    }
}
