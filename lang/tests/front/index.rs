//! The index of names: whatever is renamed by it, the program stays the same.

use lang::front::index::{Index, Sort};
use lang::front::source::Source;
use lang::front::{Analysis, ProfileChoice, analyse, compile};
use lang::hir::Storage;
use lang::image::Image;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Every script in the repository that compiles.
fn scripts() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders =
        vec![root.join("../examples"), root.join("tests/data"), root.join("../tests/data")];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "bas") {
                let text = std::fs::read_to_string(&path).unwrap_or_default();
                if image(&text).is_some() {
                    found.push((path, text));
                }
            }
        }
    }
    found
}

/// What the text compiles to, and its diagnostics' codes. In front of the code stands a hash of the
/// KEEPs' names, by which a board knows whose values it has: only there a new name shows.
fn image(text: &str) -> Option<(Vec<u8>, Vec<&'static str>)> {
    let source = Source::new("a.bas", text.to_owned());
    let (program, diags) = compile(&source, ProfileChoice::built_in());
    let codes = diags.into_sorted().iter().map(|diag| diag.code.id()).collect();
    let program = program?;
    let mut image = lang::back::compile(&program).ok()?.image;
    if program.vars.iter().any(|var| matches!(var.storage, Storage::Keep(_))) {
        image = Image::new(&image).ok()?.code.to_vec();
    }
    Some((image, codes))
}

fn index(text: &str) -> Index {
    let source = Source::new("a.bas", text.to_owned());
    Index::new(&analyse(&source, ProfileChoice::built_in()).script)
}

/// The text with every mention of a symbol replaced.
fn renamed(text: &str, index: &Index, symbol: usize, to: &str) -> String {
    let mut text = text.to_owned();
    let mut places: Vec<_> = index.mentions_of(symbol).map(|m| m.span).collect();
    places.sort_by_key(|span| std::cmp::Reverse(span.start));
    for span in places {
        text.replace_range(span.start as usize..span.end as usize, to);
    }
    text
}

#[test]
fn a_renamed_script_compiles_to_the_same_image() {
    let mut sorts = BTreeMap::new();
    for (path, text) in scripts() {
        let index = index(&text);
        let before = image(&text);
        for (n, symbol) in index.symbols().iter().enumerate() {
            let to = format!("{}_again", symbol.name.text);
            if index.may_rename(n, &to).is_err() {
                continue;
            }
            *sorts.entry(format!("{:?}", symbol.sort)).or_insert(0) += 1;
            let after = renamed(&text, &index, n, &to);
            assert_ne!(after, text);
            assert_eq!(
                image(&after),
                before,
                "{}: {} -> {to}\n{after}",
                path.display(),
                symbol.name.text
            );
        }
    }
    // Each sort of name was there.
    assert_eq!(sorts.len(), 10, "{sorts:?}");
    assert!(sorts.values().all(|&count| count >= 3), "{sorts:?}");
}

#[test]
fn names_are_bound_as_the_checker_binds_them() {
    let text = "CONST a = 2\nDIM b\nSUB go(c)\n  CONST a = a + 1\n  DIM b\n  b = a * c\nEND SUB\n\
                b = a\ngo b\nb: GOTO b\n";
    let index = index(text);
    let line = |offset: u32| text[..offset as usize].matches('\n').count() + 1;
    let lines = |name: &str, sort: Sort| -> Vec<Vec<usize>> {
        let wanted = index.symbols().iter().enumerate();
        let wanted = wanted.filter(|(_, s)| &*s.name.key == name && s.sort == sort);
        let places = |n| index.mentions_of(n).map(|m| line(m.span.start)).collect();
        wanted.map(|(n, _)| places(n)).collect()
    };
    // The local CONST is made from the outer one.
    assert_eq!(lines("a", Sort::Const), [vec![1, 4, 8], vec![4, 6]]);
    assert_eq!(lines("b", Sort::Variable), [vec![2, 8, 9], vec![5, 6]]);
    assert_eq!(lines("b", Sort::Label), [vec![10, 10]]);
    assert_eq!(lines("c", Sort::Parameter), [vec![3, 6]]);
    assert_eq!(lines("go", Sort::Sub), [vec![3, 9]]);
}

#[test]
fn a_rename_that_would_change_the_meaning_is_refused() {
    let text = "PROFILE \"mill\"\nDIM n, m\nSUB go(depth)\n  n = depth\nEND SUB\ngo 1\nSetOut spare, ON\nm = 2\nPRINT m\n";
    let index = index(text);
    let n = index.look(None, "n").unwrap();
    for wrong in ["m", "depth", "go", "x", "G1", "ABS", "stop", "IF", "", "1a", "a b", "spare"] {
        assert!(index.may_rename(n, wrong).is_err(), "{wrong}");
    }
    for right in ["N", "parts", "n_2", "p1"] {
        assert_eq!(index.may_rename(n, right), Ok(()), "{right}");
    }
}

#[test]
fn facts_tell_kinds_and_values_of_scripts_with_errors_too() {
    let text = "CONST pitch = 2.54mm\nDIM spot\nTABLE t(2) = 1, 2mm; 3, 4mm\nspot = 3mm\nfoo = 1\n";
    let source = Source::new("a.bas", text.to_owned());
    let Analysis { facts, program, .. } = analyse(&source, ProfileChoice::built_in());
    assert!(program.is_none());
    let fact = |name: &str| &facts[&(text.find(name).unwrap() as u32)];
    assert_eq!((fact("pitch").kinds[0].name(), fact("pitch").value), ("Length", Some(2540)));
    assert_eq!((fact("spot").kinds[0].name(), fact("spot").inferred), ("Length", true));
    let kinds: Vec<_> = fact("t(2)").kinds.iter().map(|kind| kind.name()).collect();
    assert_eq!((kinds, fact("t(2)").value), (vec!["Number", "Length"], Some(2)));
}
