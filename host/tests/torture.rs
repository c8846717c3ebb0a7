//! `pasapas torture` as a command: one table, exit code 0, and nothing written anywhere.

use std::process::Command;

#[test]
fn hostile_input_leaves_no_file_and_no_loss() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(["torture", "host", "--short", "--seed", "7", "--format", "json"])
        .current_dir(folder.path())
        .output()
        .expect("it runs");
    let text = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{text}");
    let rows: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(rows.len(), pasapas::torture::host::BODIES.len());
    for row in rows {
        assert_eq!(
            (&row["kind"], &row["lost"], &row["seed"]),
            (&"host".into(), &0.into(), &7.into())
        );
        assert!(row["survived"].as_u64() > Some(200), "{row}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("it is there").count(), 0);
}

#[test]
fn every_fuzz_target_has_a_body_and_each_body_a_target() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/fuzz_targets");
    let mut files: Vec<String> = std::fs::read_dir(folder)
        .expect("the targets")
        .map(|entry| entry.expect("readable").path())
        .filter_map(|path| path.file_stem().map(|name| name.to_string_lossy().into_owned()))
        .collect();
    files.sort();
    let mut names: Vec<&str> =
        pasapas::torture::host::BODIES.iter().map(|(name, ..)| *name).collect();
    names.sort_unstable();
    assert_eq!(files, names);
}
