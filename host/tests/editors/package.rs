//! The extension for Visual Studio Code: its parts, its package, and its code with the real server.

use std::process::Command;

use lang::front::diag::Diags;
use lang::front::parser::parse;
use serde_json::Value;

use crate::{host, text, there};

fn json(path: &str) -> Value {
    serde_json::from_str(&text(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn the_manifest_names_files_that_are_there() {
    let package = json("editors/vscode/package.json");
    let parts = &package["contributes"];
    for name in [
        &package["main"],
        &parts["languages"][0]["configuration"],
        &parts["grammars"][0]["path"],
        &parts["snippets"][0]["path"],
    ] {
        let name = name.as_str().expect("a name");
        assert!(host("editors/vscode").join(name).is_file(), "{name}");
    }
    assert_eq!(package["version"], env!("CARGO_PKG_VERSION"));
    json("editors/vscode/language-configuration.json");
}

/// A snippet's text with what its places hold at first.
fn filled(body: &str) -> String {
    let mut out = String::new();
    let mut rest = body;
    while let Some((before, behind)) = rest.split_once("${") {
        let (place, after) = behind.split_once('}').expect("its end");
        out.push_str(before);
        out.push_str(place.split_once(':').expect("a value").1);
        rest = after;
    }
    (out + rest).replace("$0", "Wait 1ms")
}

#[test]
fn snippets_are_scripts() {
    let snippets = json("editors/vscode/snippets.json");
    for (name, snippet) in snippets.as_object().expect("snippets") {
        let lines = snippet["body"].as_array().expect("lines").iter().filter_map(Value::as_str);
        let body = filled(&lines.collect::<Vec<_>>().join("\n"));
        let mut diags = Diags::new();
        parse(&format!("{body}\n"), &mut diags);
        assert!(!diags.has_errors(), "{name}: {:?}\n{body}", diags.into_sorted());
    }
}

#[test]
fn the_package_holds_all_and_is_the_same_each_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let pack = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let status = Command::new("python3")
            .arg(host("editors/vsix.py"))
            .arg(&out)
            .args(more)
            .status()
            .expect("python3");
        assert!(status.success());
        out
    };
    let plain = pack("a.vsix", &[]);
    let read = |path: &std::path::Path| std::fs::read(path).expect("a package");
    assert_eq!(read(&plain), read(&pack("b.vsix", &[])));
    // With a tool inside, for one platform.
    let tool = folder.path().join("tool");
    std::fs::write(&tool, "#!/bin/sh\n").expect("a file");
    let tool = tool.display().to_string();
    let whole = pack("c.vsix", &["--target", "linux-x64", "--binary", &tool]);
    let script = r#"
import json, sys, zipfile
from xml.dom.minidom import parseString
packed = zipfile.ZipFile(sys.argv[1])
assert packed.testzip() is None
manifest = parseString(packed.read("extension.vsixmanifest"))
parseString(packed.read("[Content_Types].xml"))
for asset in manifest.getElementsByTagName("Asset"):
    packed.getinfo(asset.getAttribute("Path"))
identity = manifest.getElementsByTagName("Identity")[0]
package = json.loads(packed.read("extension/package.json"))
assert identity.getAttribute("Version") == package["version"]
assert identity.getAttribute("TargetPlatform") == "linux-x64"
for part in ("extension.js", "client.js", "providers.js", "syntaxes/pasapas.tmLanguage.json"):
    packed.getinfo("extension/" + part)
assert packed.getinfo("extension/bin/pasapas").external_attr >> 16 == 0o755
"#;
    let checked =
        Command::new("python3").args(["-c", script]).arg(&whole).output().expect("python3");
    assert!(checked.status.success(), "{}", String::from_utf8_lossy(&checked.stderr));
}

#[test]
fn the_extension_serves_an_editor() {
    if !there("node") {
        return;
    }
    let output = Command::new("node")
        .arg(host("tests/editors/extension.js"))
        .arg(host("editors/vscode"))
        .arg(env!("CARGO_BIN_EXE_pasapas"))
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&output.stdout);
    let wrong = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.trim_end().ends_with("all is well"), "{said}\n{wrong}");
}
