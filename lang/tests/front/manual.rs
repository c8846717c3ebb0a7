//! The reference manual: its tables are those of the code, its programs are good.

use lang::fault::Fault;
use lang::front::codes::Code;
use lang::front::fmt::format;
use lang::front::source::Source;
use lang::front::words::{Func, Kw};
use lang::front::{ProfileChoice, compile};
use lang::image::Header;
use lang::part::PARTS;
use lang::record::feature;
use std::fmt::Write;
use std::path::PathBuf;

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("README.md")
}

fn manual() -> String {
    std::fs::read_to_string(path()).unwrap()
}

/// A cell of a table: `|` would end it.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

fn words() -> String {
    let mut out = "| word | form | meaning |\n|---|---|---|\n".to_owned();
    for entry in Kw::ALL.iter().map(|kw| kw.entry()) {
        let (text, usage, about) = (entry.text, cell(entry.usage), cell(entry.about));
        let _ = writeln!(out, "| {text} | `{usage}` | {about} |");
    }
    out
}

fn functions() -> String {
    let mut out = "| function | gives |\n|---|---|\n".to_owned();
    for func in Func::ALL {
        let _ = writeln!(out, "| `{}` | {} |", func.usage(), cell(func.about()));
    }
    out
}

fn faults() -> String {
    let mut out = "| fault | what | why | remedy | ON ERROR |\n|---|---|---|---|---|\n".to_owned();
    for fault in Fault::ALL {
        let handled = if fault.can_be_handled() { "yes" } else { "no" };
        let (text, cause, remedy) = (fault.text(), cell(fault.cause()), cell(fault.remedy()));
        let _ = writeln!(out, "| {fault} | {text} | {cause} | {remedy} | {handled} |");
    }
    out
}

fn diagnostics() -> String {
    let mut out = "| code | what | why |\n|---|---|---|\n".to_owned();
    for code in Code::ALL {
        let (title, explanation) = (cell(code.title()), cell(code.explanation()));
        let severity = code.severity().word();
        let _ = writeln!(out, "| {} ({severity}) | {title} | {explanation} |", code.id());
    }
    out
}

/// Values and calls that the program of the table of limits has open at most.
const OPEN: (u8, u8) = (4, 2);

fn limits() -> String {
    let mut out = "| part | program, bytes | with KEEP | memory, bytes | of it a call | ON lines | and each | cells |\n\
                   |---|---|---|---|---|---|---|---|\n"
        .to_owned();
    for part in PARTS {
        let (stack, calls) = OPEN;
        let header = Header { stack, calls, ..Header::default() };
        let ([all, each], [code, keeps]) =
            (part.event_pool, [false, true].map(|k| part.room_for(k)));
        let (pool, call) = (part.pool_for(0), part.call_bytes);
        let lines = part.features & feature::EVENTS != 0;
        let [all, each] = [all, each].map(|n| if lines { n.to_string() } else { "-".into() });
        let cells = part.cells_for(&header, 0);
        let _ = writeln!(
            out,
            "| {} | {code} | {keeps} | {pool} | {call} | {all} | {each} | {cells} |",
            part.name
        );
    }
    out
}

#[test]
fn tables_are_those_of_the_code() {
    let mut text = manual();
    for (name, table) in [
        ("words", words()),
        ("functions", functions()),
        ("faults", faults()),
        ("diagnostics", diagnostics()),
        ("limits", limits()),
        ("instructions", lang::isa::markdown()),
    ] {
        let start = format!("<!-- table: {name} -->\n");
        let (before, rest) = text.split_once(&start).unwrap_or_else(|| panic!("no table {name}"));
        let (_, after) = rest.split_once("<!-- end -->").unwrap();
        text = format!("{before}{start}{table}<!-- end -->{after}");
    }
    if std::env::var_os("UPDATE_MANUAL").is_some() {
        std::fs::write(path(), &text).unwrap();
    }
    assert!(text == manual(), "run the tests of lang once with UPDATE_MANUAL=1");
}

/// The programs between its fences.
pub fn programs() -> Vec<String> {
    let manual = manual();
    let fenced = manual.split("```basic\n").skip(1).filter_map(|p| p.split("```").next());
    fenced.map(str::to_owned).collect()
}

#[test]
fn programs_are_good() {
    let programs = programs();
    assert!(programs.len() >= 8);
    for program in programs {
        let source = Source::new("README.md", program.clone());
        let (checked, diags) = compile(&source, ProfileChoice::built_in());
        let shown = diags.render(&source);
        assert!(checked.is_some() && shown.is_empty(), "{program}\n{shown}");
        assert_eq!(
            format(&program).as_deref(),
            Ok(program.as_str()),
            "not in the formatter's style"
        );
    }
}
