//! From blocks to a script.

use core::fmt::Write;

use super::fold::{self, Part};
use super::named::{self, Name};
use super::read::{Block, Value};
use crate::codes::Code;
use crate::diag::{Diag, Diags};
use crate::script::{Made, Script, literal, mm};
use crate::{Format, Job, MAX_SIZED, size};
use lang::front::lexer::begins_gcode;

/// REPEATs of one script; the largest controller has 256 cells.
const MAX_LOOPS: usize = 100;
/// Rows of a table on one line.
const ROWS_A_LINE: usize = 4;

/// Writes the script; repetition is kept as loops where the compiler takes them.
pub(super) fn script(
    job: &Job<'_>,
    format: Format,
    all: (&[Block<'_>], &[Name]),
    diags: &mut Diags,
) -> Made {
    let (blocks, _) = all;
    if blocks.iter().all(|block| block.words.is_empty() && block.statement.is_empty()) {
        diags.push(Diag::new(Code::NoProgram, 1, 1, "no line of the file does anything"));
        return Made::default();
    }
    let plain = [Part::Plain(0, blocks.len())];
    let parts = if job.options.plain { plain.to_vec() } else { fold::parts(blocks) };
    if parts == plain {
        return write(job, format, all, &plain, None);
    }
    let long = write(job, format, all, &plain, None);
    if long.text.len() > MAX_SIZED {
        return write(job, format, all, &fewer_loops(parts), None);
    }
    let folded = write(job, format, all, &parts, None);
    match (size(job.profile, &long.text), size(job.profile, &folded.text)) {
        (Some(before), Some(after)) if after < before => {
            let saved = format!(
                "{} bytes instead of {before}: {} saved by the loops",
                after,
                before - after
            );
            diags.push(Diag::new(Code::Said, 1, 1, saved.clone()).note());
            write(job, format, all, &parts, Some(&saved))
        }
        // A mode that differs between the ways into a loop: the lines stay as they are.
        _ => long,
    }
}

/// The same parts with at most [`MAX_LOOPS`] REPEATs, those that save most: each takes a cell of the
/// controller.
fn fewer_loops(mut parts: Vec<Part>) -> Vec<Part> {
    let saved = |part: &Part| match part {
        Part::Same { len, times, .. } => len * (times - 1),
        _ => 0,
    };
    let mut loops: Vec<usize> = (0..parts.len()).filter(|i| saved(&parts[*i]) > 0).collect();
    loops.sort_by_key(|i| std::cmp::Reverse(saved(&parts[*i])));
    for i in loops.into_iter().skip(MAX_LOOPS) {
        if let Part::Same { from, len, times } = parts[i] {
            parts[i] = Part::Plain(from, from + len * times);
        }
    }
    parts
}

fn write(
    job: &Job<'_>,
    format: Format,
    (blocks, names): (&[Block<'_>], &[Name]),
    parts: &[Part],
    saved: Option<&str>,
) -> Made {
    let what = match format {
        Format::Laser => "laser G-code",
        Format::Ncp => "a program of isel's controllers",
        _ => "G-code",
    };
    let mut script = Script::new(job.name, what, job.profile);
    if let Some(saved) = saved {
        script.remark(saved);
    }
    named::declare(&mut script, names);
    let tables = parts.iter().filter(|part| matches!(part, Part::Table { .. })).count();
    if tables > 0 {
        script.line("DIM i");
    }
    let mut number = 0;
    for part in parts {
        if let Part::Table { rows, .. } = part {
            number += 1;
            table(&mut script, &table_name(number, tables), rows);
        }
    }
    script.gap();
    number = 0;
    for part in parts {
        match part {
            Part::Plain(from, to) => {
                for block in &blocks[*from..*to] {
                    line(&mut script, block, names, None);
                }
            }
            Part::Same { from, len, times } => {
                script.open(&format!("REPEAT {times}"));
                for block in &blocks[*from..from + len] {
                    line(&mut script, block, names, None);
                }
                script.close("END REPEAT");
            }
            Part::Table { from, len, rows } => {
                number += 1;
                let name = table_name(number, tables);
                script.remark(&format!(
                    "{} holes, lines {} to {}",
                    rows.len(),
                    blocks[*from].line,
                    blocks[from + len * rows.len() - 1].line
                ));
                script.open(&format!("FOR i = 0 TO COUNT({name}) - 1"));
                for block in &blocks[*from..from + len] {
                    line(&mut script, block, names, Some(&name));
                }
                script.close("NEXT");
            }
        }
    }
    script.finish()
}

fn table_name(number: usize, tables: usize) -> String {
    if tables == 1 { "holes".to_owned() } else { format!("holes_{number}") }
}

fn table(script: &mut Script, name: &str, rows: &[[i64; 2]]) {
    let cell = |row: &[i64; 2]| format!("{}, {}", mm(row[0]), mm(row[1]));
    let lines: Vec<String> = rows
        .chunks(ROWS_A_LINE)
        .map(|chunk| chunk.iter().map(cell).collect::<Vec<_>>().join("; "))
        .collect();
    if let [only] = &lines[..] {
        return script.line(&format!("TABLE {name}(2) = {only}"));
    }
    script.line(&format!("TABLE {name}(2) = _"));
    for (i, text) in lines.iter().enumerate() {
        let end = if i + 1 < lines.len() { "; _" } else { "" };
        script.line(&format!("  {text}{end}"));
    }
}

/// One block; `table` names the table whose row X and Y come from.
fn line(script: &mut Script, block: &Block<'_>, names: &[Name], table: Option<&str>) {
    script.set_place(block.line);
    moves(script, block, names, table);
    for (index, value) in &block.sets {
        let name = names.get(usize::from(*index)).map_or("", |own| &own.name);
        script.line(&format!("{name} = {value}"));
    }
}

/// Its words, its remark and its message.
fn moves(script: &mut Script, block: &Block<'_>, names: &[Name], table: Option<&str>) {
    if let Some(message) = &block.message {
        script.line(&format!("PRINT \"{}\"", literal(message)));
    }
    if !block.statement.is_empty() {
        return script.remarked(block.statement, &block.remark);
    }
    if block.words.is_empty() {
        if !block.remark.is_empty() {
            script.remark(&block.remark);
        }
        return;
    }
    let mut text = String::with_capacity(32);
    // A hole in the table has both coordinates, where the source may leave out one that stays.
    let mut placed = false;
    for (letter, value) in &block.words {
        let separator = if text.is_empty() { "" } else { " " };
        let _ = match (letter, table) {
            ('X' | 'Y', Some(name)) => {
                if core::mem::replace(&mut placed, true) {
                    continue;
                }
                write!(text, "{separator}X[{name}(i, 0)] Y[{name}(i, 1)]")
            }
            _ => match value {
                Value::Named { index, minus } => {
                    text.push_str(separator);
                    named::word(&mut text, *letter, names, *index, *minus);
                    Ok(())
                }
                _ => write!(text, "{separator}{letter}{value}"),
            },
        };
    }
    // In a loop each line says for itself how it moves: the ways into it may bring another mode.
    let modal = !block.words.iter().any(|(letter, _)| *letter == 'G');
    let moves = block.words.iter().any(|(letter, _)| matches!(letter, 'X' | 'Y' | 'Z'));
    if table.is_some() && modal && moves {
        text = format!("G{} {text}", block.motion);
    }
    // `I5 J0` could be names.
    if !begins_gcode(&text) {
        text = format!("G{} {text}", block.motion);
    }
    script.remarked(&text, &block.remark);
}
