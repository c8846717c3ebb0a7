//! The formatter: changes no token, no line, and nothing that it wrote itself.

use crate::data::scripts;
use lang::front::diag::Diags;
use lang::front::fmt::format;
use lang::front::lexer::lex;
use lang::front::token::Tok;
use proptest::prelude::*;

/// Tokens with their lines and, but for case, their texts.
fn essence(text: &str) -> Vec<(Tok, u32, String)> {
    let tokens = lex(text, &mut Diags::new());
    let words = tokens.iter().map(|t| {
        let written = match t.tok {
            Tok::LineEnd | Tok::Continuation => "",
            _ => t.span.of(text).trim_end(),
        };
        let exact = matches!(t.tok, Tok::Text | Tok::Comment | Tok::GComment);
        let keeps_case = exact && !written.get(..3).is_some_and(|w| w.eq_ignore_ascii_case("rem"));
        let written = if keeps_case { written.to_owned() } else { written.to_ascii_lowercase() };
        (t.tok, t.line, written)
    });
    words.collect()
}

fn check(text: &str) -> String {
    let once = format(text).unwrap_or_else(|d| panic!("{text}\n{d:?}"));
    assert_eq!(essence(text), essence(&once), "{text}\n---\n{once}");
    assert_eq!(format(&once).as_deref(), Ok(once.as_str()), "not the same twice:\n{text}");
    once
}

#[test]
fn formatted_files() {
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path("../data/fmt");
    settings.bind(|| {
        for file in scripts("fmt") {
            let stem = file.file_stem().unwrap().to_str().unwrap().to_owned();
            insta::assert_snapshot!(stem, check(&std::fs::read_to_string(&file).unwrap()));
        }
    });
}

#[test]
fn good_scripts_keep_their_meaning() {
    for file in scripts("parse/ok") {
        check(&std::fs::read_to_string(file).unwrap());
    }
}

#[test]
fn a_wrong_script_is_left_alone() {
    assert_eq!(format("a = \n").map_err(|d| d[0].code.id()), Err("P002"));
}

/// Good scripts with their blanks and their case changed at random.
fn shaken() -> impl Strategy<Value = String> {
    let texts: Vec<String> = scripts("parse/ok")
        .iter()
        .chain(&scripts("fmt"))
        .map(|file| std::fs::read_to_string(file).unwrap())
        .collect();
    (prop::sample::select(texts), prop::collection::vec(any::<u8>(), 64)).prop_map(
        |(text, noise)| {
            let mut out = String::new();
            let mut noise = noise.iter().cycle();
            let mut end = 0;
            for token in lex(&text, &mut Diags::new()) {
                let written = token.span.of(&text);
                let touches = end == token.span.start as usize;
                let n = noise.next().copied().unwrap_or(0);
                let glued = matches!(token.tok, Tok::Sign(_)) || touches;
                let at_line_start = out.is_empty() || out.ends_with('\n');
                let least = usize::from(!glued && !at_line_start);
                let may = !touches || at_line_start || token.tok == Tok::GWord;
                out.push_str(&" ".repeat(least + if may { usize::from(n % 3) } else { 0 }));
                let word =
                    matches!(token.tok, Tok::Kw(_) | Tok::Func(_) | Tok::GWord | Tok::Number);
                match (word, n & 16) {
                    (true, 0) => out.push_str(&written.to_ascii_uppercase()),
                    (true, _) => out.push_str(&written.to_ascii_lowercase()),
                    (false, _) => out.push_str(written),
                }
                end = token.span.end as usize;
            }
            out
        },
    )
}

proptest! {
    #[test]
    fn shaken_scripts_keep_their_meaning(text in shaken()) {
        check(&text);
    }
}

#[test]
fn lines_end_as_they_did() {
    assert_eq!(format("dim n\r\n n=1\r\nprint n").unwrap(), "DIM n\r\nn = 1\r\nPRINT n\r\n");
    assert_eq!(format("dim n\rn=1\r").unwrap(), "DIM n\rn = 1\r");
    assert_eq!(format("n = 1\n").unwrap(), "n = 1\n");
}
