//! The script, its file, and what pages may ask about it.

use super::Desk;
use serde_json::json;

/// A script of a folder.
fn desk(text: &str) -> (tempfile::TempDir, std::path::PathBuf, Desk) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.bas");
    std::fs::write(&file, text).expect("a file");
    let desk = Desk::open(Some(&file.display().to_string()), None, |_| {}).expect("it opens");
    (folder, file, desk)
}

#[test]
fn a_save_sees_what_another_program_has_just_written() {
    let (folder, file, mut desk) = desk("Home\n");
    desk.set(desk.number(), "Home Y\n".to_owned()).expect("newest");
    std::fs::write(&file, "Home Z\n").expect("a file");
    // Nobody has looked at the file meanwhile.
    assert!(desk.save(None).is_err() && desk.save(Some("a.bas")).is_err());
    assert!(desk.shown().conflict);
    assert_eq!(std::fs::read_to_string(&file).expect("a file"), "Home Z\n");
    desk.settle(false);
    desk.save(None).expect("it is written");
    assert_eq!(std::fs::read_to_string(&file).expect("a file"), "Home Y\n");
    // The folder holds nothing else, and a user's own file beside it stays.
    let own = folder.path().join("a.bas.new");
    std::fs::write(&own, "mine").expect("a file");
    desk.set(desk.number(), "Home X\n".to_owned()).expect("newest");
    desk.save(None).expect("it is written");
    assert_eq!(std::fs::read_to_string(&own).expect("a file"), "mine");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 2);
}

#[cfg(unix)]
#[test]
fn a_save_keeps_links_and_rights() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let (real, link) = (folder.path().join("real.bas"), folder.path().join("a.bas"));
    std::fs::write(&real, "Home\n").expect("a file");
    std::fs::set_permissions(&real, PermissionsExt::from_mode(0o640)).expect("rights");
    std::os::unix::fs::symlink("real.bas", &link).expect("a link");
    let mut desk = Desk::open(Some(&link.display().to_string()), None, |_| {}).expect("it opens");
    desk.set(desk.number(), "Home Y\n".to_owned()).expect("newest");
    desk.save(None).expect("it is written");
    assert!(std::fs::symlink_metadata(&link).expect("a link").is_symlink());
    assert_eq!(std::fs::read_to_string(&real).expect("a file"), "Home Y\n");
    assert_eq!(std::fs::metadata(&real).expect("a file").permissions().mode() & 0o777, 0o640);
}

#[test]
fn pages_make_only_requests_about_the_text() {
    let (_folder, _file, desk) = desk("Home\n");
    let ask = |method: &str, params| {
        desk.request(1, &json!({ "id": 1, "method": method, "params": params }))
    };
    assert!(ask("textDocument/hover", json!({})).is_ok());
    for params in [json!(5), json!([1]), json!("x"), json!(null), json!(true)] {
        assert!(ask("textDocument/hover", params.clone()).is_err(), "{params}");
    }
    for method in ["shutdown", "exit", "initialize", "textDocument/didChange", "x", ""] {
        assert!(ask(method, json!({})).is_err(), "{method}");
    }
    assert!(desk.request(1, &json!({ "id": 1, "params": {} })).is_err());
    assert!(desk.request(1, &json!(7)).is_err());
}

#[test]
fn a_text_and_its_file_go_together() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.bas");
    std::fs::write(&file, "Home\n").expect("a file");
    let name = file.display().to_string();
    let mut desk = Desk::open(Some(&name), None, |_| {}).expect("it opens");
    assert!(!desk.look() && !desk.shown().dirty);
    // Another program changes the file: a text without changes follows.
    std::fs::write(&file, "Home X\n").expect("a file");
    assert!(desk.look());
    assert_eq!(
        (desk.text(), desk.shown().dirty, desk.shown().conflict),
        ("Home X\n", false, false)
    );
    // Both change: nothing is lost, and nothing is written over.
    desk.set(desk.number(), "Home Y\n".to_owned()).expect("newest");
    std::fs::write(&file, "Home Z\n").expect("a file");
    assert!(desk.look());
    assert!(desk.shown().conflict && desk.save(None).is_err());
    assert_eq!(desk.text(), "Home Y\n");
    desk.settle(false);
    desk.save(None).expect("it is written");
    assert_eq!(std::fs::read_to_string(&file).expect("a file"), "Home Y\n");
    assert!(desk.set(1, String::new()).is_err(), "an old base");
    desk.save(Some("b.bas")).expect("it is written");
    assert_eq!(desk.files(), ["a.bas", "b.bas"]);
    for wrong in ["../c.bas", "/c.bas", "c", "a.bas", ".bas", "c.bas/d.bas", "c\\d.bas"] {
        assert!(desk.save(Some(wrong)).is_err(), "{wrong}");
    }
    assert!(desk.change("../a.bas").is_err() && desk.change("a.bas").is_ok());
    // A new one is written beside, and never over another or over what is not saved.
    assert!(desk.create("b.bas", "Home\n".to_owned()).is_err(), "it is there");
    assert!(desk.create("../c.bas", "Home\n".to_owned()).is_err());
    desk.set(desk.number(), "Wait 1s\n".to_owned()).expect("newest");
    assert!(desk.create("c.bas", "Home\n".to_owned()).is_err(), "not saved");
    desk.save(None).expect("it is written");
    desk.create("c.bas", "Home Y\n".to_owned()).expect("a new one");
    assert_eq!((desk.text(), desk.name().as_deref()), ("Home Y\n", Some("c.bas")));
}

/// A job that is too long to be changed here is shown as it is, follows its file, and no page writes it.
#[test]
fn a_long_job_is_shown_and_not_changed() {
    let line = "G1 X10 Y10 F600\n";
    let long = line.repeat(super::LONGEST / line.len() + 2);
    let (_folder, file, mut desk) = desk(&long);
    assert!(desk.shown().fixed && desk.shown().text == long);
    assert!(desk.set(desk.number(), "Home\n".to_owned()).is_err());
    assert_eq!(desk.text(), long);
    // Another program may change it.
    assert!(!desk.look() && !desk.look());
    std::fs::write(&file, format!("Home\n{long}")).expect("a file");
    assert!(desk.look());
    assert!(desk.text().starts_with("Home\nG1"));
    assert!(!desk.look());
    // What is too long even for that is refused, with the command that runs it.
    std::fs::write(&file, line.repeat(super::super::file::LARGEST / line.len() + 2))
        .expect("a file");
    let refused = super::Desk::open(Some(&file.display().to_string()), None, |_| {});
    assert!(refused.is_err());
}
