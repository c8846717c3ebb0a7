//! What the packages hold beside the tool: udev rules, man pages, completions, licences, changes, and
//! the workflow that makes them.

use std::path::{Path, PathBuf};
use std::process::Command;

use pasapas::usb::KINDS;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn every_device_that_we_know_has_a_udev_rule() {
    let rules = text("host/dist/70-pasapas.rules");
    let rules: Vec<&str> = rules.lines().filter(|line| line.starts_with("SUBSYSTEM")).collect();
    for kind in &KINDS {
        let (vendor, product) = kind.id;
        let fits = |rule: &&&str| {
            let of =
                |field: &str, id: u16| rule.contains(&format!("ATTRS{{{field}}}==\"{id:04x}\""));
            of("idVendor", vendor) && (!rule.contains("idProduct") || of("idProduct", product))
        };
        let rule = rules.iter().find(fits).unwrap_or_else(|| panic!("no rule for {}", kind.name));
        assert!(rule.contains("TAG+=\"uaccess\""), "{rule}");
    }
}

#[test]
fn the_newest_changes_are_those_of_this_version() {
    let changes = text("CHANGELOG.md");
    let newest = changes.lines().find_map(|line| line.strip_prefix("## "));
    assert_eq!(newest, Some(env!("CARGO_PKG_VERSION")));
}

#[test]
fn the_version_names_commit_and_images() {
    let said = Command::new(env!("CARGO_BIN_EXE_pasapas")).arg("--version").output().expect("runs");
    let said = String::from_utf8(said.stdout).expect("text");
    let names: Vec<&str> =
        said.lines().filter_map(|line| line.rsplit_once(' ')).map(|at| at.0).collect();
    assert_eq!(names[..2], ["pasapas", "commit"]);
    assert_eq!(names.len(), 2 + pasapas::board::BUILDS.len());
}

/// Made in the same way as `host/examples/pages.rs` makes them.
#[test]
fn every_command_has_a_man_page_and_shells_can_read_their_completions() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = pasapas::cmd::command_line();
    clap_mangen::generate_to(command.clone().disable_help_subcommand(true), &folder)
        .expect("pages");
    for own in command.get_subcommands() {
        let page = folder.path().join(format!("pasapas-{}.1", own.get_name()));
        let page = std::fs::read_to_string(page).unwrap_or_else(|error| panic!("{own}: {error}"));
        assert!(page.contains(".SH SYNOPSIS"), "{own}");
    }
    let made = clap_complete::generate_to(
        clap_complete::Shell::Bash,
        &mut command,
        "pasapas",
        folder.path(),
    );
    let read =
        Command::new("bash").arg("-n").arg(made.expect("completions")).output().expect("bash");
    assert!(read.status.success() && read.stderr.is_empty(), "{read:?}");
}

#[test]
fn every_part_has_a_licence_that_was_read() {
    let said = Command::new("python3")
        .arg(root().join("host/dist/licences.py"))
        .arg("x86_64-unknown-linux-gnu")
        .current_dir(root())
        .output()
        .expect("python3");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let said = String::from_utf8_lossy(&said.stdout);
    // A part of the tool, one of the firmware, and one whose licence asks for the place of its source.
    for part in ["\nclap ", "\nheapless ", "\nserialport "] {
        assert!(said.contains(part), "{part} is missing");
    }
    let line = said.lines().find(|line| line.starts_with("serialport ")).expect("it is there");
    assert!(line.contains("MPL-2.0, source: "), "{line}");
}

#[test]
fn the_workflow_names_files_that_are_there() {
    let workflow = text(".github/workflows/release.yml");
    let named = workflow.split(|c: char| !(c.is_ascii_alphanumeric() || "._-/".contains(c)));
    let named: Vec<&str> =
        named.filter(|word| word.starts_with("host/") || word.starts_with("examples/")).collect();
    assert!(named.len() >= 4, "{named:?}");
    for name in named {
        assert!(root().join(name).exists(), "{name}");
    }
}

/// Whoever installs has the manuals: no link of a page that is packed leads to a file that is not.
#[test]
fn a_package_holds_the_pages_that_its_readme_links_to() {
    let script = r##"
import pathlib, re, sys, tempfile
sys.path.insert(0, "host/dist")
import pack
with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    for place in ("pages/man", "pages/completions", "book"):
        (folder / place).mkdir(parents=True)
    (folder / "book/language.html").write_text("<html></html>")
    files = pack.archive_files(pathlib.Path("pasapas"), folder / "pages", b"", folder / "book")
    assert "manual/language.html" in files and "lang/README.md" in files, list(files)
    links = 0
    for path in pack.PAGES:
        folder = pathlib.PurePosixPath(path).parent
        for _, words, target in pack.LINK.findall(files[path].decode()):
            place = target.split("#")[0]
            if not place or re.match("[a-z]+:", place):
                continue
            whole = []
            for part in (folder / place).parts:
                whole = whole[:-1] if part == ".." else whole + [part]
            assert "/".join(whole) in files, (path, target)
            links += 1
    assert links >= 30, links
    readme = files["README.md"].decode()
    assert "(ARCHITECTURE.md)" not in readme and "ARCHITECTURE.md" in readme
    assert "](lang/README.md)" in readme
"##;
    let said =
        Command::new("python3").args(["-c", script]).current_dir(root()).output().expect("python3");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
}
