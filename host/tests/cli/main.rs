//! The command line's contract: names, exit codes, formats.

mod parts;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// A folder with scripts, and the tool in it.
struct Bench {
    folder: TempDir,
}

/// What a command gave.
struct Result {
    code: i32,
    out: String,
    err: String,
}

impl Bench {
    fn new() -> Bench {
        Bench { folder: tempfile::tempdir().expect("a folder") }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> &Bench {
        fs::write(self.path(name), content).expect("a file");
        self
    }

    fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pasapas"));
        command.args(args).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    fn run(&self, args: &[&str]) -> Result {
        let Output { status, stdout, stderr } =
            self.command(args).output().expect("the tool starts");
        Result {
            code: status.code().expect("no signal"),
            out: String::from_utf8(stdout).expect("UTF-8"),
            err: String::from_utf8(stderr).expect("UTF-8"),
        }
    }

    /// Runs and parses every line of standard output.
    fn json(&self, args: &[&str]) -> (i32, Vec<Value>) {
        let result = self.run(args);
        let lines = result.out.lines().map(|line| {
            serde_json::from_str(line).unwrap_or_else(|error| panic!("{error} in {line}"))
        });
        (result.code, lines.collect())
    }
}

const GOOD: &str =
    "DIM i\nFOR i = 1 TO 3\n  MoveAxe X, 2mm * i\n  SetOut 1, ON\nNEXT\nSetOut 1, OFF\n";

/// `FILE:LINE:COL: error[CODE]: text` with a capital letter and three digits.
fn is_diagnostic(line: &str, file: &str) -> bool {
    let Some(rest) = line.strip_prefix(file).and_then(|rest| rest.strip_prefix(':')) else {
        return false;
    };
    let mut parts = rest.splitn(3, ':');
    let number = |part: Option<&str>| part.is_some_and(|n| n.parse::<u32>().is_ok_and(|n| n > 0));
    let place = number(parts.next()) && number(parts.next());
    let code = parts.next().and_then(|rest| rest.strip_prefix(" error["));
    let code = code.and_then(|rest| rest.split_once("]: ")).map(|(code, _)| code.as_bytes());
    place
        && code.is_some_and(|code| {
            code.len() == 4
                && code[0].is_ascii_uppercase()
                && code[1..].iter().all(u8::is_ascii_digit)
        })
}

#[test]
fn a_good_script_is_exit_code_0_and_silent() {
    let bench = Bench::new();
    let result = bench.file("a.bas", GOOD).run(&["check", "a.bas"]);
    assert_eq!((result.code, result.out.as_str(), result.err.as_str()), (0, "", ""));
}

#[test]
fn every_wrong_input_is_exit_code_1_with_file_line_and_column() {
    let bench = Bench::new();
    bench
        .file("wait.bas", "Wait 5\n")
        .file("binary.bas", [0u8, 1, 2, 255, 254, 0, 7])
        .file("unclosed.bas", "IF 1 = 1 THEN\n")
        .file("nested.bas", format!("DIM a\na = {}1{}\n", "(".repeat(9999), ")".repeat(9999)))
        .file("cells.bas", "DIM a(256)\na(0) = 1\n");
    for file in ["wait.bas", "binary.bas", "unclosed.bas", "nested.bas", "cells.bas", "missing.bas"]
    {
        for command in ["check", "build", "sim", "disasm"] {
            if (command, file) == ("sim", "cells.bas") {
                continue; // The desktop's engines have memory enough.
            }
            let result = bench.run(&[command, file]);
            assert_eq!(result.code, 1, "{command} {file}: {}", result.err);
            let first = result.err.lines().next().unwrap_or_default();
            assert!(is_diagnostic(first, file), "{command} {file}: {first}");
        }
    }
}

/// The firmware beside the scripts is taken for one of them.
#[test]
fn firmware_is_told_from_programs() {
    let bench = Bench::new();
    let firmware = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/image/pasapas-g2553.elf");
    bench.file("firmware.elf", fs::read(firmware).expect("the image"));
    for command in ["disasm", "check", "build", "sim"] {
        let result = bench.run(&[command, "firmware.elf"]);
        assert_eq!(result.code, 1, "{command}: {}", result.err);
        assert!(is_diagnostic(result.err.lines().next().unwrap_or_default(), "firmware.elf"));
        for word in ["ELF", "pasapas flash", "pasapas build -o"] {
            assert!(result.err.contains(word), "{command}: {}", result.err);
        }
        assert!(!result.err.contains("is it an image"), "{command}: {}", result.err);
    }
}

#[test]
fn files_that_are_no_scripts_do_no_harm() {
    let bench = Bench::new();
    bench
        .file("empty.bas", "")
        .file("crlf.bas", GOOD.replace('\n', "\r\n"))
        .file("latin1.bas", b"' \xE9t\xE9\nWait 5ms\n");
    for file in ["empty.bas", "crlf.bas", "latin1.bas"] {
        assert_eq!(bench.run(&["check", file]).code, 0, "{file}");
        assert_eq!(bench.run(&["sim", file]).code, 0, "{file}");
    }
    let folder = bench.run(&["check", "."]);
    assert_eq!(folder.code, 1);
    if Path::new("/dev/zero").exists() {
        let endless = bench.run(&["check", "/dev/zero"]);
        assert_eq!(endless.code, 1);
        assert!(is_diagnostic(endless.err.trim_end(), "/dev/zero"), "{}", endless.err);
    }
}

#[test]
fn a_wrong_command_line_is_exit_code_2() {
    let bench = Bench::new();
    bench.file("a.bas", GOOD);
    for args in [
        &["frobnicate"][..],
        &[],
        &["check"],
        &["sim", "a.bas", "--engine", "warp"],
        &["sim", "a.bas", "--plot", "a.png"],
        &["sim", "a.bas", "--limit", "soon"],
        &["sim", "a.bas", "--vcd", "a.vcd"],
        &["build", "a.bas", "a.bas", "-o", "a.img"],
        &["status"],
        &["status", "--port", "x", "--address", "300"],
        &["check", "a.bas", "--profile", "nonesuch"],
    ] {
        let result = bench.run(args);
        assert_eq!(result.code, 2, "{args:?}: {}", result.err);
        assert!(!result.err.is_empty(), "{args:?} says nothing");
    }
    assert_eq!(bench.run(&["--help"]).code, 0);
    assert_eq!(bench.run(&["--version"]).code, 0);
}

#[test]
fn a_run_that_goes_wrong_is_exit_code_3() {
    let bench = Bench::new();
    bench
        .file("fault.bas", "DIM a\na = 0\na = 5 / a\n")
        .file("limit.bas", "DIM n\nHome\nn = 400\nMoveAxe X, n * 1mm\n")
        .file("stuck.bas", "WaitIn 3, ON\n")
        .file("good.bas", GOOD)
        .file("expect.rhai", "expect_pos(\"X\", 601);");
    for engine in ["rhai", "vm"] {
        let fault = bench.run(&["sim", "fault.bas", "--engine", engine]);
        assert_eq!(fault.code, 3, "{}", fault.err);
        assert!(fault.err.contains("fault.bas:3:1: fault F02: division by zero"), "{}", fault.err);
        let limit = bench.run(&["sim", "limit.bas", "--engine", engine]);
        let place = "machine positions: X 0.000 mm (travel 0.000 to 300.000), Y 0.000 mm (travel ";
        assert!(limit.code == 3 && limit.err.contains(place), "{}", limit.err);
        assert!(limit.err.contains("asked for: X to 400.000 mm\n"), "{}", limit.err);
        assert_eq!(bench.run(&["sim", "stuck.bas", "--engine", engine]).code, 3);
        let world = ["sim", "good.bas", "--world", "expect.rhai", "--engine", engine];
        let expect = bench.run(&world);
        assert_eq!(expect.code, 3);
        assert!(expect.err.contains("expect.rhai:1"), "{}", expect.err);
    }
}

#[test]
fn a_port_that_is_not_there_is_exit_code_4() {
    let bench = Bench::new();
    bench.file("a.bas", GOOD);
    for command in ["status", "start", "stop", "pause", "resume", "home", "io"] {
        let result = bench.run(&[command, "--port", "no/such/port"]);
        assert_eq!(result.code, 4, "{command}: {}", result.err);
        assert!(result.err.contains("no/such/port"), "{}", result.err);
    }
    assert_eq!(bench.run(&["upload", "a.bas", "--port", "no/such/port"]).code, 4);
    assert_eq!(bench.run(&["profile", "get", "--port", "no/such/port"]).code, 4);
    // A port number that nobody listens on: 1 is never given to a program.
    assert_eq!(bench.run(&["status", "--port", "tcp:1"]).code, 4);
}

#[test]
fn a_world_that_is_wrong_is_shown_at_its_place() {
    let bench = Bench::new();
    bench.file("a.bas", GOOD).file("w.rhai", "at(5, || set_in(1, true));\nfrobnicate(3);\n");
    let result = bench.run(&["sim", "a.bas", "--world", "w.rhai"]);
    assert_eq!(result.code, 1);
    let line = result.err.lines().next().unwrap_or_default();
    assert!(line.starts_with("w.rhai:2:") && is_diagnostic(line, "w.rhai"), "{line}");
}

#[test]
fn diagnostics_as_json_have_every_part() {
    let bench = Bench::new();
    let (code, lines) =
        bench.file("a.bas", "Wait 5\nHoem\n").json(&["check", "a.bas", "--format", "json"]);
    assert_eq!((code, lines.len()), (1, 2));
    assert_eq!(lines[0]["file"], "a.bas");
    assert_eq!(lines[0]["line"], 1);
    assert_eq!(lines[0]["col"], 6);
    assert_eq!(lines[0]["severity"], "error");
    assert!(lines[0]["text"].as_str().is_some_and(|text| text.contains("Time")));
    assert_eq!(lines[1]["line"], 2);
    assert!(lines[1]["hint"].is_string(), "{}", lines[1]);
}

#[test]
fn build_gives_its_figures_for_each_file() {
    let bench = Bench::new();
    bench.file("a.bas", GOOD).file("b.bas", "KEEP n\nn = n + 1\n");
    let (code, lines) = bench.json(&["build", "a.bas", "b.bas", "--format", "json"]);
    assert_eq!((code, lines.len()), (0, 2));
    for line in &lines {
        for field in ["statements", "code_bytes", "table_bytes", "cells", "stack", "calls"] {
            assert!(line[field].is_u64(), "{field} in {line}");
        }
    }
    assert_eq!(lines[0]["file"], "a.bas");
    assert_eq!(lines[0]["cells"], 1);
    assert_eq!(lines[0]["statements"], 4);
    let text = bench.run(&["build", "b.bas"]);
    assert!(text.out.contains("registers 4000, 4001: n"), "{}", text.out);
}

#[test]
fn an_image_can_be_written_and_taken_apart() {
    let bench = Bench::new();
    assert_eq!(bench.file("a.bas", GOOD).run(&["build", "a.bas", "-o", "a.img"]).code, 0);
    let from_script = bench.run(&["disasm", "a.bas"]);
    assert!(from_script.out.contains("line 3"), "{}", from_script.out);
    let from_image = bench.run(&["disasm", "a.img"]);
    assert_eq!(from_image.code, 0, "{}", from_image.err);
    let mut image = fs::read(bench.path("a.img")).expect("the image");
    let last = image.len() - 1;
    image[last] ^= 1;
    let broken = bench.file("broken.img", image).run(&["disasm", "broken.img"]);
    assert_eq!(broken.code, 1);
    assert!(is_diagnostic(broken.err.trim_end(), "broken.img"), "{}", broken.err);
}

#[test]
fn the_trace_is_json_lines_and_the_same_on_both_desktop_engines() {
    let bench = Bench::new();
    bench.file("a.bas", GOOD);
    let (code, lines) = bench.json(&["sim", "a.bas", "--trace", "-"]);
    assert_eq!(code, 0);
    let kinds: Vec<&str> = lines.iter().filter_map(|line| line["ev"].as_str()).collect();
    assert_eq!(kinds, ["move", "out", "move", "out", "move", "out", "out", "end"]);
    assert_eq!(lines[0]["to"]["X"], 200);
    let end = &lines[lines.len() - 1];
    assert_eq!((end["status"].as_str(), end["line"].as_u64()), (Some("done"), Some(6)));
    assert_eq!(end["pos"]["X"], 600);
    assert_eq!(bench.run(&["sim", "a.bas", "--engine", "vm", "--trace", "t"]).code, 0);
    let other = fs::read_to_string(bench.path("t")).expect("the trace");
    for (line, other) in lines.iter().zip(other.lines()) {
        let mut other: Value = serde_json::from_str(other).expect("JSON");
        let mut line = line.clone();
        line["us"].take();
        other["us"].take();
        assert_eq!(line, other);
    }
}

#[test]
fn the_summary_as_json_is_one_line() {
    let bench = Bench::new();
    let (code, lines) = bench.file("a.bas", GOOD).json(&["sim", "a.bas", "--format", "json"]);
    assert_eq!((code, lines.len()), (0, 1));
    assert_eq!(lines[0]["status"], "done");
    assert_eq!(lines[0]["engine"], "rhai");
    assert_eq!(lines[0]["part"], "f5529");
    assert_eq!(lines[0]["steps"][0], 600);
    assert!(lines[0]["us"].as_u64().is_some_and(|us| us > 100_000));
}

#[test]
fn plots_are_written_in_both_forms() {
    let bench = Bench::new();
    bench.file("a.bas", GOOD);
    for (name, head) in [("p.svg", "<svg"), ("p.html", "<!doctype html>")] {
        assert_eq!(bench.run(&["sim", "a.bas", "--plot", name]).code, 0);
        let text = fs::read_to_string(bench.path(name)).expect("the plot");
        assert!(text.starts_with(head), "{name}");
        assert!(text.contains("MoveAxe X, 2mm * i"), "{name} does not name the statement");
    }
    let nowhere = bench.run(&["sim", "a.bas", "--plot", "no/such/folder/p.svg"]);
    assert_eq!(nowhere.code, 4);
}

#[test]
fn fmt_changes_files_in_place_and_check_only_tells() {
    let bench = Bench::new();
    bench.file("a.bas", "dim i\nfor i=1 to 3\nsetout i,on\nnext\n");
    let told = bench.run(&["fmt", "--check", "a.bas"]);
    assert_eq!((told.code, told.out.as_str()), (1, "a.bas\n"));
    assert_eq!(bench.run(&["fmt", "a.bas"]).code, 0);
    assert_eq!(bench.run(&["fmt", "--check", "a.bas"]).code, 0);
    let before = "IF 1 THEN\n";
    assert_eq!(bench.file("wrong.bas", before).run(&["fmt", "wrong.bas"]).code, 1);
    assert_eq!(fs::read_to_string(bench.path("wrong.bas")).expect("the file"), before);
}

#[test]
fn profiles_are_listed_shown_and_found_beside_the_script() {
    let bench = Bench::new();
    let (code, lines) = bench.json(&["profile", "list", "--format", "json"]);
    assert_eq!(code, 0);
    let names: Vec<&str> = lines.iter().filter_map(|line| line["name"].as_str()).collect();
    assert_eq!(names, ["mill", "charly", "thesis", "laser", "picker"]);
    let mill = bench.run(&["profile", "show", "mill"]).out;
    let own = mill.replace("name = \"mill\"", "name = \"own\"").replace("um = 4000", "um = 8000");
    bench.file("own.toml", own).file("a.bas", format!("PROFILE \"own\"\n{GOOD}"));
    let (code, lines) = bench.json(&["sim", "a.bas", "--format", "json"]);
    assert_eq!(code, 0);
    assert_eq!(lines[0]["steps"][0], 300);
    let (_, lines) = bench.json(&["sim", "a.bas", "--profile", "mill", "--format", "json"]);
    assert_eq!(lines[0]["steps"][0], 600);
    bench.file("bad.toml", mill.replace("pulse_us = 3", "pulse_us = 300"));
    let bad = bench.run(&["check", "a.bas", "--profile", "bad.toml"]);
    assert_eq!(bad.code, 1);
    assert!(is_diagnostic(bad.err.trim_end(), "bad.toml"), "{}", bad.err);
}

/// The shell's convention: 128 and the number of SIGPIPE, and no word.
#[test]
fn a_reader_that_goes_away_ends_the_tool_in_silence() {
    let bench = Bench::new();
    bench.file("a.bas", "DIM i\nFOR i = 1 TO 20000\n  PRINT i\nNEXT\n");
    let mut child = bench
        .command(&["sim", "a.bas"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the tool starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(141));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn every_importable_file_is_simulated_and_drawn_as_it_is() {
    let bench = Bench::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/import");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("a folder") {
        let file = entry.expect("a file").path();
        if file.extension().is_some_and(|e| e == "trace" || e == "rhai") {
            continue;
        }
        count += 1;
        let name = file.display().to_string();
        let plot = bench.path("plot.svg").display().to_string();
        let mut args = vec!["sim", &name, "--plot", &plot];
        if name.ends_with("letter.nc") {
            args.extend(["--profile", "thesis"]);
        }
        let world = file.with_extension("rhai").display().to_string();
        if Path::new(&world).is_file() {
            args.extend(["--world", &world]);
        }
        let result = bench.run(&args);
        assert_eq!(result.code, 0, "{name}: {}", result.err);
        let drawn = fs::read_to_string(bench.path("plot.svg")).expect("a drawing");
        assert!(drawn.contains("<svg") && drawn.contains("<path"), "{name}");
        fs::remove_file(bench.path("plot.svg")).expect("it was there");
    }
    assert!(count >= 12, "{count}");
}

/// No argument is wrong there: the axis moves.
#[test]
fn a_place_set_while_the_axis_moves_is_told_as_that() {
    let bench = Bench::new();
    for (moves, sets) in [
        ("START MoveAxe X, 20mm", "SetPos X, 0mm"),
        ("MoveSpeed Y, 5mm/s", "SetPos Y, 1mm"),
        ("START MoveRel Z, -5mm", "G92 Z0"),
        ("MoveSpeed Y, 5mm/s", "WaitMove Y"),
    ] {
        bench.file("moving.bas", format!("{moves}\n{sets}\nStopAll\n"));
        let result = bench.run(&["sim", "moving.bas"]);
        assert_eq!(result.code, 3, "{moves} {sets}: {}", result.err);
        assert!(result.err.contains("moving.bas:2:1: fault F20"), "{sets}: {}", result.err);
        let name = sets.split(' ').next().unwrap_or_default();
        assert!(result.err.contains(name) && result.err.contains("come to rest"), "{}", result.err);
    }
}

#[test]
fn equal_warnings_become_one_with_their_number() {
    let bench = Bench::new();
    bench.file("fast.nc", "G21 G90\nG1 X1 F9000\nX2 F9000\nX3 F9000\nM30\n");
    let result = bench.run(&["check", "fast.nc"]);
    assert_eq!(result.code, 0, "{}", result.err);
    assert_eq!(result.err.matches("M005").count(), 1, "{}", result.err);
    assert!(result.err.contains("(and 2 more places)"), "{}", result.err);
}

/// The script that a file becomes is nowhere to be looked at: what is told are the file's lines.
#[test]
fn an_importable_file_is_told_by_its_own_lines() {
    let bench = Bench::new();
    bench.file("far.nc", "%\nG21 G90\n$H\n\n\n\nF600\nG1 X1\nG1 X400\n");
    let result = bench.run(&["sim", "far.nc"]);
    assert_eq!(result.code, 3, "{}", result.err);
    assert!(result.err.contains("far.nc:9:1: warning[M006]: X to 400mm"), "{}", result.err);
    assert!(result.err.contains("(in the script: `G1 X400`)"), "{}", result.err);
    assert!(result.err.contains("far.nc:9:1: fault F05"), "{}", result.err);
    assert!(result.out.contains("fault in line 9"), "{}", result.out);
}

#[test]
fn sim_says_why_a_run_was_stopped() {
    let bench = Bench::new();
    bench.file("wait.bas", "WaitIn 3, ON\n").file("loop.bas", "DO\nWait 1s\nLOOP\n");
    bench.file("held.rhai", "hold_stop(500, 2500);\n");
    let cases: [(&[&str], &str); 3] = [
        (&["wait.bas"], "idle"),
        (&["loop.bas", "--limit", "5s"], "limit"),
        (&["loop.bas", "--world", "held.rhai"], "button"),
    ];
    for (args, reason) in cases {
        let args = [&["sim", "--format", "json"], args].concat();
        let (code, lines) = bench.json(&args);
        assert_eq!(code, 3, "{args:?}");
        assert_eq!(lines.last().expect("a summary")["stopped"], reason, "{args:?}");
    }
    let text = bench.run(&["sim", "wait.bas"]).out;
    assert!(text.contains("waits for what never comes"), "{text}");
}
