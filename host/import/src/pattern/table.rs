//! TABLEs of places in a script: found with the names of their rows, and written back.
//!
//! A row's name is the comment behind it: `10mm, 5mm; _ ' left clamp`.

use std::collections::HashSet;

use lang::front::diag::Diags;
use lang::front::lexer::lex;
use lang::front::literal::settle;
use lang::front::source::Source;
use lang::front::token::{Sign, Tok, Token};
use lang::front::words::Kw;
use lang::front::{ProfileChoice, compile};
use lang::kind::Kind;
use serde::{Deserialize, Serialize};

use super::{MAX_UM, MOST_POINTS};
use crate::script::{clean, mm};

/// Numbers of a table on one line, where its rows have no names.
const NUMBERS_A_LINE: usize = 8;
/// Longest name of a row.
const LONGEST_NAME: usize = 60;

/// A row.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// What the comment behind it calls it; empty for none.
    #[serde(default)]
    pub name: String,
    /// A length for each column, um.
    pub at: Vec<i64>,
}

/// A table whose values are lengths without any arithmetic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Table {
    /// Its name.
    pub name: String,
    /// Columns, 1 to 3.
    pub columns: usize,
    /// Its rows.
    pub rows: Vec<Row>,
    /// Where its statement begins and ends, bytes of the script.
    pub span: [usize; 2],
    /// The comment on its first line, before the first row; empty for none.
    pub remark: String,
}

/// The tables of lengths of a script, as far as it can be read.
pub fn find(text: &str) -> Vec<Table> {
    let tokens = lex(text, &mut Diags::new());
    let mut found = Vec::new();
    let mut fresh = true;
    for (at, token) in tokens.iter().enumerate() {
        if fresh && token.tok == Tok::Kw(Kw::Table) {
            let end = tokens[at..].iter().position(|token| token.tok == Tok::LineEnd);
            let statement = &tokens[at..end.map_or(tokens.len(), |end| at + end)];
            found.extend(read(text, statement));
        }
        fresh = matches!(token.tok, Tok::LineEnd | Tok::Sign(Sign::Colon));
    }
    found
}

/// Reads one statement; `None` where it is more than lengths.
fn read(text: &str, statement: &[Token]) -> Option<Table> {
    let word = |token: &Token| token.span.of(text);
    let mut tokens = statement.iter().skip(1).filter(|token| !token.tok.is_trivia()).peekable();
    let name = tokens.next().filter(|token| token.tok == Tok::Name).map(word)?;
    let mut columns = 1;
    if tokens.next_if(|token| token.tok == Tok::Sign(Sign::Open)).is_some() {
        let count = tokens.next().filter(|token| token.tok == Tok::Number)?;
        columns = word(count).parse().ok().filter(|n| (1..=3).contains(n))?;
        tokens.next_if(|token| token.tok == Tok::Sign(Sign::Close))?;
    }
    let equals = tokens.next().filter(|token| token.tok == Tok::Sign(Sign::Eq))?;
    let from = statement.iter().position(|token| token.span == equals.span)? + 1;
    let mut table = Table {
        name: name.to_owned(),
        columns,
        rows: vec![Row::default()],
        span: [0; 2],
        remark: String::new(),
    };
    let mut sign = 1;
    for token in &statement[from..] {
        let row = table.rows.last_mut()?;
        match token.tok {
            Tok::Sign(Sign::Minus) => sign = -sign,
            Tok::Number => {
                let literal = settle(word(token)).ok().filter(|own| own.kind == Kind::Length)?;
                row.at.push(sign * literal.value);
                sign = 1;
            }
            Tok::Sign(Sign::Comma) if columns > 1 && row.at.len() < columns => {}
            Tok::Sign(Sign::Semicolon | Sign::Comma) => table.rows.push(Row::default()),
            Tok::Comment | Tok::Continuation => {
                let Some((_, remark)) = word(token).split_once('\'') else { continue };
                let remark = clean(remark);
                // Behind a `;` the next row is still empty: the comment is that of the one before.
                match table.rows.iter_mut().rev().find(|row| !row.at.is_empty()) {
                    Some(row) => row.name = remark,
                    None => table.remark = remark,
                }
            }
            _ => return None,
        }
    }
    table.span = [statement.first()?.span.start, statement.last()?.span.end].map(|at| at as usize);
    table.rows.iter().all(|row| row.at.len() == columns).then_some(table)
}

/// The statement of a table, without a line end.
///
/// # Errors
/// A name, a count or a length is wrong; in words.
pub fn text(name: &str, columns: usize, remark: &str, rows: &[Row]) -> Result<String, String> {
    check_name(name)?;
    if !(1..=3).contains(&columns) || rows.is_empty() || rows.len() > MOST_POINTS {
        return Err("a table of places has 1 to 3 columns and at least one row".to_owned());
    }
    let mut named = false;
    let mut cells = Vec::new();
    for row in rows {
        if row.at.len() != columns || row.at.iter().any(|um| um.saturating_abs() > MAX_UM) {
            return Err("a row has a length for each column, within 10 m".to_owned());
        }
        let row_name: String = clean(&row.name).chars().take(LONGEST_NAME).collect();
        named |= !row_name.is_empty();
        let lengths: Vec<String> = row.at.iter().map(|um| mm(*um)).collect();
        cells.push((lengths.join(", "), row_name));
    }
    let width = if columns == 1 { String::new() } else { format!("({columns})") };
    let part = if columns == 1 { ", " } else { "; " };
    let head = format!("TABLE {name}{width} =");
    let a_line = if named { 1 } else { NUMBERS_A_LINE / columns };
    if cells.len() <= a_line && !named && remark.is_empty() {
        let all: Vec<&str> = cells.iter().map(|(cell, _)| cell.as_str()).collect();
        return Ok(format!("{head} {}", all.join(part)));
    }
    let comment = |words: &str| {
        if words.is_empty() { String::new() } else { format!(" ' {words}") }
    };
    if let ([(cell, row_name)], "") = (&cells[..], remark) {
        return Ok(format!("{head} {cell}{}", comment(row_name)));
    }
    let mut out = format!("{head} _{}", comment(&clean(remark)));
    let lines: Vec<_> = cells.chunks(a_line).collect();
    for (n, line) in lines.iter().enumerate() {
        let all: Vec<&str> = line.iter().map(|(cell, _)| cell.as_str()).collect();
        out += &format!("\n  {}", all.join(part));
        if n + 1 < lines.len() {
            out += &format!("{} _", part.trim_end());
        }
        out += &comment(&line[line.len() - 1].1);
    }
    Ok(out)
}

/// The words of a script that are not comments or texts, in small letters: its names among them.
pub fn words(text: &str) -> HashSet<String> {
    let tokens = lex(text, &mut Diags::new());
    let counts = |token: &&Token| {
        !token.tok.is_trivia() && !matches!(token.tok, Tok::Text | Tok::Number | Tok::Sign(_))
    };
    tokens.iter().filter(counts).map(|token| token.span.of(text).to_lowercase()).collect()
}

/// Whether a word can be a name of a script.
///
/// # Errors
/// It cannot; in words.
pub fn check_name(name: &str) -> Result<(), String> {
    let tokens = lex(name, &mut Diags::new());
    let word = tokens.len() == 2 && tokens[0].tok == Tok::Name && tokens[0].span.of(name) == name;
    // What else is taken, axis letters and words of G-code, the compiler knows.
    let declared = Source::new("name", format!("DIM {name}\n"));
    if word && name.len() <= 32 && compile(&declared, ProfileChoice::built_in()).0.is_some() {
        return Ok(());
    }
    Err(format!(
        "`{}` is no name: a letter, then letters, digits and `_`, and no word of the language",
        clean(name).chars().take(40).collect::<String>()
    ))
}

/// Where a new table goes: behind the declarations at the script's head; bytes of the script.
pub fn place(text: &str) -> usize {
    const DECLARES: [Kw; 7] =
        [Kw::Profile, Kw::Const, Kw::Dim, Kw::Keep, Kw::Input, Kw::Output, Kw::Table];
    let tokens = lex(text, &mut Diags::new());
    let mut end = 0;
    let mut declares = false;
    let mut first = true;
    for token in &tokens {
        match token.tok {
            Tok::LineEnd => {
                if declares {
                    end = token.span.end as usize;
                }
                (declares, first) = (false, true);
            }
            _ if token.tok.is_trivia() => {
                // The comment at the script's head stays above.
                declares |= first && end == 0 && token.span.start as usize == end;
            }
            Tok::Kw(kw) if first && DECLARES.contains(&kw) => (declares, first) = (true, false),
            _ if first => break,
            _ => {}
        }
    }
    end
}
