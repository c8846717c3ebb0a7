//! The TextMate grammar, made from the table of words.

use lang::front::words::{Class, Func, Kw};
use lang::kind::Kind;
use serde_json::{Value, json};

use crate::{host, text, there};

const FILE: &str = "editors/vscode/syntaxes/pasapas.tmLanguage.json";

/// A pattern for any of these words, in any case.
fn words<'a>(words: impl Iterator<Item = &'a str>) -> String {
    let list: Vec<&str> = words.collect();
    format!("(?i)\\b(?:{})\\b", list.join("|"))
}

fn of_class(class: Class, wanted: impl Fn(Kw) -> bool) -> String {
    let own = Kw::ALL.iter().filter(|kw| kw.entry().class == class && wanted(**kw));
    words(own.map(|kw| kw.text()))
}

fn grammar() -> Value {
    let rule = |name: &str, pattern: String| json!({ "name": format!("{name}.pasapas"), "match": pattern });
    let is_kind = |kw: Kw| Kind::from_name(kw.text()).is_some();
    let constant = |kw: Kw| matches!(kw, Kw::True | Kw::False | Kw::Off);
    let quiets: Vec<&str> =
        Kw::ALL.iter().filter(|kw| kw.has_quiet_form()).map(|kw| kw.text()).collect();
    // A block begins with a letter that no name of letter and number has; what follows may be any.
    let gcode = concat!(
        "(?i)(?<![A-Za-z0-9_])[GMFSTNXYZ][+-]?(?:\\d+(?:\\.\\d*)?|\\.\\d+)",
        "(?:\\s*[A-Z][+-]?(?:\\d+(?:\\.\\d*)?|\\.\\d+))*(?![A-Za-z_])|(?<![A-Za-z0-9_])[A-Z](?=\\[)"
    );
    let number = "(?i)&H[0-9A-F_]+|&B[01_]+|(?<![A-Za-z0-9_])(?:\\d[\\d_]*(?:\\.[\\d_]*)?|\\.\\d[\\d_]*)(?:[a-z]+(?:/[a-z]+2?)?)?";
    json!({
        "name": "Pasapas",
        "scopeName": "source.pasapas",
        "fileTypes": ["bas"],
        "patterns": [
            rule("comment.line.apostrophe", "'.*$".to_owned()),
            rule("comment.line.rem", "(?i)\\bREM\\b.*$".to_owned()),
            rule("comment.line.gcode", "^\\s*[(;%].*$".to_owned()),
            rule("string.quoted.double", "\"[^\"\\r\\n]*\"?".to_owned()),
            {
                "match": "^\\s*([A-Za-z]\\w*)(:)(?!=)",
                "captures": { "1": { "name": "entity.name.label.pasapas" } },
            },
            {
                "match": "(?i)\\b(SUB|FUNCTION)\\s+([A-Za-z]\\w*)",
                "captures": {
                    "1": { "name": "keyword.declaration.pasapas" },
                    "2": { "name": "entity.name.function.pasapas" },
                },
            },
            {
                "match": format!("(?i)\\b(AS)\\s+({})\\b", Kind::ALL.map(Kind::name).join("|")),
                "captures": {
                    "1": { "name": "keyword.other.pasapas" },
                    "2": { "name": "storage.type.pasapas" },
                },
            },
            rule("constant.numeric", number.to_owned()),
            rule("keyword.control", of_class(Class::Control, |_| true)),
            rule("keyword.declaration", of_class(Class::Declaration, |_| true)),
            rule("keyword.other", of_class(Class::Part, |kw| kw != Kw::Rem)),
            rule("constant.language", of_class(Class::Operator, constant)),
            rule("keyword.operator.word", of_class(Class::Operator, |kw| !constant(kw))),
            rule("support.function.machine", format!("(?i)\\b(?:{})\\?", quiets.join("|"))),
            rule("support.function.machine", of_class(Class::Machine, |_| true)),
            rule("keyword.other.soft", of_class(Class::Soft, |kw| !is_kind(kw))),
            rule("support.function.builtin", words(Func::ALL.iter().map(|func| func.text()))),
            rule("entity.name.tag.gcode", gcode.to_owned()),
            rule("keyword.operator", "<=|>=|<>|<<|>>|[-+*/=<>]".to_owned()),
        ],
    })
}

#[test]
fn the_grammar_is_that_of_the_table_of_words() {
    let mut made = serde_json::to_string_pretty(&grammar()).expect("JSON");
    made.push('\n');
    if std::env::var_os("UPDATE_EDITORS").is_some() {
        std::fs::write(host(FILE), &made).expect("it is written");
    }
    assert_eq!(text(FILE), made, "run UPDATE_EDITORS=1 cargo test -p pasapas --test editors");
}

#[test]
fn lines_are_coloured_as_they_are_meant() {
    if !there("node") {
        return;
    }
    let lines = [
        (
            "MoveAxe X, 5mm ' G1",
            "MoveAxe:support.function.machine | 5mm:constant.numeric | ' G1:comment.line.apostrophe",
        ),
        (
            "G1X10F300 Y[k2 * 1mm]",
            "G1X10F300:entity.name.tag.gcode | Y:entity.name.tag.gcode | *:keyword.operator | 1mm:constant.numeric",
        ),
        (
            "k2 = NOT IN(3)",
            "=:keyword.operator | NOT:keyword.operator.word | IN:support.function.builtin | 3:constant.numeric",
        ),
        ("again: GOTO again", "again:entity.name.label | GOTO:keyword.control"),
        (
            "sub drill(n as length)",
            "sub:keyword.declaration | drill:entity.name.function | as:keyword.other | length:storage.type",
        ),
        (
            "home? z : print \"REM\"; on",
            "home?:support.function.machine | print:support.function.machine | \"REM\":string.quoted.double | on:keyword.control",
        ),
        ("(a comment) G1 X1", "(a comment) G1 X1:comment.line.gcode"),
        (
            "n = &H1F + 1_000",
            "=:keyword.operator | &H1F:constant.numeric | +:keyword.operator | 1_000:constant.numeric",
        ),
    ];
    let output = std::process::Command::new("node")
        .arg(host("tests/editors/grammar.js"))
        .arg(host(FILE))
        .args(lines.iter().map(|(line, _)| *line))
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.lines().collect::<Vec<_>>(), lines.map(|(_, colours)| colours));
}
