//! The lines for Helix on the page for editors: the file's form is tried here, and what it starts; Helix
//! itself, which Debian 12 does not have, by `.ci/helix`.

use std::process::{Command, Stdio};

use toml::Value;

use crate::block;

fn texts(value: &Value) -> Vec<&str> {
    value.as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

/// Keys that Helix reads (its book, "Adding languages"): others would end its start with an error.
const LANGUAGE: [&str; 10] = [
    "name",
    "scope",
    "file-types",
    "comment-token",
    "indent",
    "roots",
    "auto-format",
    "language-servers",
    "formatter",
    "debugger",
];

#[test]
fn the_lines_have_the_form_of_its_file() {
    let file: toml::Table = block("toml").parse().expect("TOML");
    assert_eq!(file.keys().collect::<Vec<_>>(), ["language", "language-server"]);
    let languages = file["language"].as_array().expect("languages");
    let language = languages[0].as_table().expect("a language");
    for key in language.keys() {
        assert!(LANGUAGE.contains(&key.as_str()), "{key}");
    }
    assert_eq!(texts(&language["file-types"]), ["bas"]);
    // A language's servers are names of `language-server`.
    for name in texts(&language["language-servers"]) {
        assert!(file["language-server"].get(name).is_some(), "{name}");
    }
    let debugger = language["debugger"].as_table().expect("a debugger");
    assert_eq!(debugger["transport"].as_str(), Some("stdio"));
    for template in debugger["templates"].as_array().expect("templates") {
        assert!(matches!(template["request"].as_str(), Some("launch" | "attach")));
        // `{0}` is the answer to the first question.
        let questions = template["completion"].as_array().map_or(0, Vec::len);
        let asked = template["args"].to_string().matches('{').count() - 1;
        assert_eq!(questions, asked, "{template}");
    }
}

#[test]
fn what_the_lines_start_is_there() {
    let file: toml::Table = block("toml").parse().expect("TOML");
    let debugger = &file["language"][0]["debugger"];
    for started in [&file["language-server"]["pasapas"], debugger] {
        assert_eq!(started["command"].as_str(), Some("pasapas"));
        // Both end in peace when nobody speaks to them.
        let status = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(texts(&started["args"]))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .expect("it runs");
        assert_ne!(status.code(), Some(2), "{started}: the command line is wrong");
    }
}
