//! Every remedy that can be applied by one click takes its diagnostic away and brings none of its own.

use lang::front::diag::Diag;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use std::path::Path;

fn diags(text: &str) -> Vec<Diag> {
    let source = Source::new("a.bas", text.to_owned());
    compile(&source, ProfileChoice::built_in()).1.into_sorted()
}

/// Whether a diagnostic is there.
fn has(diags: &[Diag], sought: &Diag) -> bool {
    diags.iter().any(|diag| (diag.code, diag.span.start) == (sought.code, sought.span.start))
}

#[test]
fn fixes_mend() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wrong");
    let mut fixed = 0;
    for file in ["flow", "gcode", "habits", "kinds", "machine", "newcomer", "words"] {
        let text = std::fs::read_to_string(root.join(file).with_extension("txt")).unwrap();
        for case in text.split("### ").skip(1) {
            let (title, script) = case.split_once('\n').unwrap();
            let before = diags(script);
            for diag in &before {
                let Some(fix) = &diag.fix else { continue };
                fixed += 1;
                let mut mended = script.to_owned();
                mended.replace_range(fix.span.start as usize..fix.span.end as usize, &fix.text);
                let after = diags(&mended);
                assert!(
                    !has(&after, diag) && after.len() <= before.len(),
                    "{file}, {title}: {} with {fix:?} gives {after:?}\n{mended}",
                    diag.message
                );
                assert!(diag.hint.is_some(), "{title}: a fix without words");
            }
        }
    }
    assert!(fixed >= 35, "{fixed} fixes");
}
