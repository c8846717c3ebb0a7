//! Texts that are too large for help at each key: an answer at once, in little memory.

use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{Editor, URI};

/// Every request that goes by the open document alone.
const WHOLE: [&str; 4] = [
    "textDocument/documentSymbol",
    "textDocument/foldingRange",
    "textDocument/semanticTokens/full",
    "textDocument/formatting",
];
const AT: [&str; 6] = [
    "textDocument/hover",
    "textDocument/completion",
    "textDocument/signatureHelp",
    "textDocument/definition",
    "textDocument/documentHighlight",
    "textDocument/prepareRename",
];

#[test]
fn a_text_that_is_too_large_says_so_and_is_answered_at_once() {
    let lines = |line: &str, bytes: usize| line.repeat(bytes / line.len());
    let whole = format!("DIM a\n{}", lines("a = a + 1\n", 8_000_000));
    let long = format!("DIM a\nPRINT a{}\n", lines("; a", 60_000));
    for (text, words) in [(whole, "the file has 8.0 MB"), (long, "a line has 60")] {
        let mut editor = Editor::new();
        let begun = Instant::now();
        let shown = editor.open(&text);
        assert_eq!(shown.as_array().map(Vec::len), Some(1), "{shown}");
        let message = shown[0]["message"].as_str().unwrap_or_default();
        assert!(
            message.starts_with(words) && message.contains("`pasapas check a.bas`"),
            "{message}"
        );
        // Information, no error: the file itself is in order.
        assert_eq!(shown[0]["severity"], json!(3));
        for method in AT {
            let answer = editor.at(method, 1, 1).to_string();
            assert!(answer.len() < 1_000, "{method}: {}", answer.len());
        }
        for method in WHOLE {
            let options = json!({ "tabSize": 2, "insertSpaces": true });
            let params = json!({ "textDocument": { "uri": URI }, "options": options });
            let answer = editor.ask(method, params).to_string();
            assert!(answer.len() < 1_000, "{method}: {}", answer.len());
        }
        // Of a build with checks on a busy computer; reading the text alone would take longer.
        assert!(begun.elapsed() < Duration::from_secs(10), "{:?}", begun.elapsed());
        editor.close();
    }
}

#[test]
fn what_an_answer_holds_is_bounded() {
    let mut editor = Editor::new();
    let names: Vec<String> = (0..6_000).map(|n| format!("n{n}_")).collect();
    let declared: String = names.iter().map(|name| format!("DIM {name}\n")).collect();
    let used = "n0_ = n0_ + 1\n".repeat(6_000);
    assert_eq!(editor.open(&format!("{declared}{used}"))[0]["code"], "N003");
    let count = |answer: Value| answer.as_array().map_or(0, Vec::len);
    let last = 6_000 + 100;
    assert_eq!(count(editor.at("textDocument/documentHighlight", last, 1)), 5_000);
    let completed = count(editor.at("textDocument/completion", last, 6));
    assert!((5_000..5_200).contains(&completed), "{completed}");
    let symbols = json!({ "textDocument": { "uri": URI } });
    assert_eq!(count(editor.ask("textDocument/documentSymbol", symbols)), 5_000);
    let position = json!({ "line": last, "character": 1 });
    let rename =
        json!({ "textDocument": { "uri": URI }, "position": position, "newName": "other" });
    let refused =
        editor.response("textDocument/rename", rename).response_result.expect_err("refused");
    assert!(refused.message.contains("more than 5000 places"), "{}", refused.message);
    editor.close();
}

/// A line with thousands of names is not shown with each of them.
#[test]
fn a_long_declaration_is_shown_by_its_beginning() {
    let mut editor = Editor::new();
    let names: Vec<String> = (0..2_000).map(|n| format!("n{n}_")).collect();
    let line = format!("DIM {}\n", names.join(", "));
    assert!(line.len() > 10_000);
    editor.open(&format!("{line}n7_ = 5\n"));
    let hover = editor.at("textDocument/hover", 1, 1)["contents"]["value"].to_string();
    assert!(hover.contains("DIM n0_") && hover.len() < 600, "{}", hover.len());
    let completed = editor.at("textDocument/completion", 1, 6).to_string();
    assert!(completed.len() < 2_500_000, "{}", completed.len());
    editor.close();
}
