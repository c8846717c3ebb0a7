//! Wrong scripts, each a few lines: what the whole front end says about them.
//!
//! A file holds many; `### title` begins one. The snapshots have code, place, text and remedy.

use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use std::fmt::Write;
use std::path::Path;

#[test]
fn wrong_scripts() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/wrong");
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.set_snapshot_path(&root);
    let (mut cases, mut hinted) = (0, 0);
    settings.bind(|| {
        for file in ["flow", "gcode", "habits", "kinds", "machine", "newcomer", "words"] {
            let text = std::fs::read_to_string(root.join(file).with_extension("txt")).unwrap();
            let mut shown = String::new();
            for case in text.split("### ").skip(1) {
                let (title, script) = case.split_once('\n').unwrap();
                let source = Source::new("a.bas", script.to_owned());
                let (_, diags) = compile(&source, ProfileChoice::built_in());
                let rendered = diags.render(&source);
                assert!(!rendered.is_empty(), "nothing is said about: {title}\n{script}");
                cases += 1;
                hinted += usize::from(rendered.contains("hint: "));
                let _ = write!(shown, "### {title}\n{rendered}");
            }
            insta::assert_snapshot!(file, shown);
        }
    });
    assert!(cases >= 150, "{cases} cases");
    assert!(hinted * 10 >= cases * 9, "{hinted} of {cases} have a remedy");
}
