//! Programs of others, unchanged, where a folder with them is named: they are fetched, never kept here.

use std::path::{Path, PathBuf};
use std::process::Command;

use super::Stand;
use super::common::{has, text};

/// Runs a Python program of ours that uses one of theirs, before a card at a pseudo-terminal.
fn run(file: &str, modules: &str, answer: &str, program: &str) -> Option<Stand> {
    let Some(folder) = std::env::var_os("PASAPAS_CARD_CLIENTS").map(PathBuf::from) else {
        eprintln!("PASAPAS_CARD_CLIENTS names no folder with programs: they are left out");
        return None;
    };
    if !folder.join(file).exists() || !has("python3", &["-c", modules]) {
        eprintln!("{file} is not there, or what it needs: it is left out");
        return None;
    }
    let place = tempfile::tempdir().expect("a folder");
    let link = place.path().join("card");
    let more = format!("pty = {:?}\nanswer = {answer:?}\ndialect = \"imcs8\"", text(&link));
    let stand = Stand::start("f5529", &more);
    let args = [Path::new("-c"), Path::new(program), &folder, &link];
    // Theirs keeps settings in the user's folder.
    let output = Command::new("python3").args(args).env("HOME", place.path()).output();
    let output = output.expect("python starts");
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
    Some(stand)
}

#[test]
fn traverse_control_runs_unchanged() {
    let modules = "import serial, numpy, tqdm";
    let Some(stand) = run("commands.py", modules, "cr", TRAVERSE) else { return };
    assert_eq!([stand.at("X"), stand.at("Y"), stand.at("Z")], [3200, 6400, 1600]);
}

#[test]
fn isel_controller_imc_s8_runs_unchanged() {
    let file = "isel_imc_s8_controller.py";
    let Some(stand) = run(file, "import serial", "bare", ISEL) else { return };
    let x = stand.rest();
    assert!(x > 300 && x < 30_000, "its stop came at {x}");
}

/// Uses `commands.py` of traverse-control as its README says; 320 steps are its millimetre.
const TRAVERSE: &str = r#"
import contextlib, io, sys
sys.path.insert(0, sys.argv[1])
from commands import Traverse
traverse = Traverse(port=sys.argv[2])

def end(reply):
    # It gives a long move up after 2 s; the answer comes when the motion has ended.
    while not reply:
        reply = traverse.ser.read_until(b"\r")
    return reply

assert traverse.initialize() == b"0\r"
assert traverse.get_version_data() == b"0\r"
assert end(traverse.reference_run()) == b"0\r"
assert end(traverse.execute_absolute_movement(10, 20, 5)) == b"0\r"
told = io.StringIO()
with contextlib.redirect_stdout(told):
    traverse.get_position()
assert told.getvalue() == "x: 10.0 y: 20.0 z: 5.0\n", told.getvalue()
assert end(traverse.execute_absolute_movement(1, 20, 500)) == b"2\r"
assert end(traverse.execute_absolute_movement(10, 20, 5)) == b"0\r"
"#;

/// Uses the class of `isel_imc_s8_controller.py` as its window does, without the window.
const ISEL: &str = r#"
import sys, time
from unittest.mock import MagicMock
for name in ("tkinter", "tkinter.ttk", "tkinter.messagebox", "tkinter.filedialog"):
    sys.modules[name] = MagicMock()
sys.modules["tkinter"].Tk = object
sys.path.insert(0, sys.argv[1])
from isel_imc_s8_controller import IselController

isel = IselController()
isel.steps_per_mm = {"x": 100.0, "y": 100.0, "z": 100.0}
errors = []
isel.log_callback = lambda time, kind, text, x, y, z: kind == "ERROR" and errors.append(text)
assert isel.connect(sys.argv[2])

def done():
    end = time.time() + 60
    while isel.is_moving or isel.cmd_queue.unfinished_tasks:
        assert time.time() < end, (errors, isel.status_msg)
        time.sleep(0.05)

def position():
    isel.get_position()
    done()
    return [isel.current_pos[axis] for axis in "xyz"]

isel.init_axes()
isel.set_homing_speed(20, 20, 20)
isel.home_axes()
done()
assert position() == [0, 0, 0] and not errors, (position(), errors)
isel.move_absolute(3, 4, 1, 10)
done()
assert position() == [3, 4, 1], position()
isel.move_relative(-1, 0.5, 0, 10, accel=50)
done()
assert position() == [2, 4.5, 1], position()
points = [{"x": x, "y": 4, "z": 1} for x in (1, 2, 3)]
assert isel.start_grid(points, 10, 50, 0.1)[0]
end = time.time() + 60
while isel.grid_running:
    assert time.time() < end
    time.sleep(0.1)
done()
assert position() == [3, 4, 1] and not errors, (position(), errors)
isel.move_absolute(300, 4, 1, 10)
time.sleep(1)
isel.emergency_stop()
time.sleep(1)
isel.disconnect()
"#;
