//! MIN and MAX of AT variables on the emulated board: what lies outside is exception 3, from any client that writes
//! it, and nothing of such a request is written.

mod common;

use std::process::Command;
use std::time::{Duration, Instant};

use common::Board;
use lang::wire::{Control, Exception, RUN_CONTROL, RUN_STATE, RunState};
use pasapas::client::{Client, ClientError};
use pasapas::link::{self, Link};

/// Two variables with limits, one with half of them, one with none and a gap between.
const SCRIPT: &str = "DIM qty AT 3000 MIN 1 MAX 500\nDIM row(3) AT 3004 MIN -2 MAX 70000\n\
                      DIM free AT 3010\nDIM depth AS LENGTH AT 3012 MAX -1mm\nDIM own\n\
                      own = 7: WaitIn 3, ON\nqty = 501\n";

/// Our own command; gives what it said.
fn pasapas(args: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_pasapas")).args(args).output();
    let output = output.expect("pasapas starts");
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{args:?}: {said}");
    said
}

struct Panel(Client<Box<dyn Link>>);

impl Panel {
    fn write(&mut self, register: u16, values: &[i32]) -> Result<(), ClientError> {
        let halves = |value: &i32| [*value as u16, (*value >> 16) as u16];
        self.0.write_all(register, &values.iter().flat_map(halves).collect::<Vec<_>>())
    }

    fn refused(&mut self, register: u16, values: &[i32]) {
        let error = self.write(register, values).expect_err("a value outside");
        assert!(error.is_exception(Exception::IllegalValue), "{register} {values:?}: {error}");
    }

    fn read(&mut self, register: u16) -> i32 {
        let halves = self.0.holding(register, 2).expect("read");
        (u32::from(halves[1]) << 16 | u32::from(halves[0])) as i32
    }

    /// What an operator may and may not do.
    fn try_out(&mut self) {
        self.write(3000, &[500]).expect("the greatest");
        self.refused(3000, &[501]);
        self.refused(3000, &[0]);
        self.refused(3000, &[i32::MIN]);
        assert_eq!(self.read(3000), 500);
        self.write(3000, &[1]).expect("the least");
        // Function 6 sets the whole value.
        self.0.write(3000, 42).expect("within");
        assert!(self.0.write(3000, 501).is_err_and(|it| it.is_exception(Exception::IllegalValue)));
        assert!(
            self.0.write(3000, 0xFFFF).is_err_and(|it| it.is_exception(Exception::IllegalValue))
        );
        assert_eq!(self.read(3000), 42);
        // Each value of an array; one that is wrong leaves the others as they were.
        self.write(3004, &[-2, 70_000, 0]).expect("all within");
        self.refused(3004, &[1, 2, 70_001]);
        self.refused(3004, &[1, -3, 3]);
        assert_eq!([3004, 3006, 3008].map(|at| self.read(at)), [-2, 70_000, 0]);
        // Neighbours have none, or one.
        self.write(3010, &[i32::MAX, -1_000]).expect("free, and the greatest depth");
        self.write(3010, &[i32::MIN, i32::MIN]).expect("no least depth");
        self.refused(3010, &[5, -999]);
        assert_eq!([self.read(3010), self.read(3012)], [i32::MIN, i32::MIN]);
    }
}

fn panel(board: &Board) -> Panel {
    let port = board.port();
    let mut client = Client::new(link::open(port.to_str().expect("UTF-8")).expect("the port"), 1);
    client.find().expect("the board");
    Panel(client)
}

fn upload(board: &Board) -> String {
    let script = board.folder.path().join("limits.bas");
    std::fs::write(&script, SCRIPT).expect("a script");
    let port = board.port();
    pasapas(&["upload", script.to_str().expect("UTF-8"), "--port", port.to_str().expect("UTF-8")])
}

#[test]
fn a_value_outside_of_min_and_max_is_exception_3_and_nothing_of_it_is_written() {
    let world = tempfile::NamedTempFile::with_suffix(".rhai").expect("a file");
    std::fs::write(world.path(), "at(20000, || set_in(3, true));\n").expect("a world");
    let world = world.path().to_str().expect("UTF-8");
    let board = Board::start(&["--part", "f5529", "--world", world]);
    let said = upload(&board);
    assert!(!said.contains("MIN"), "{said}");
    let mut panel = panel(&board);
    // Without a run.
    panel.try_out();
    panel.0.write(RUN_CONTROL, Control::Start as u16).expect("a start");
    // In one; the program's own variables have no limits.
    panel.try_out();
    panel.write(3014, &[12_345]).expect("`own`");
    let begun = Instant::now();
    while panel.0.holding(RUN_STATE, 1).expect("the state") != [RunState::Ready as u16] {
        assert!(begun.elapsed() < Duration::from_secs(60), "it goes on");
        std::thread::sleep(Duration::from_millis(50));
    }
    // The program is not bound by them.
    assert_eq!(panel.read(3000), 501);
}

#[test]
fn a_chip_that_does_not_know_limits_says_so_at_the_upload() {
    let board = Board::start(&["--part", "g2553"]);
    let script = "DIM qty AT 3000 MIN 1 MAX 500\nqty = qty + 0\n";
    let file = board.folder.path().join("one.bas");
    std::fs::write(&file, script).expect("a script");
    let (port, file) = (board.port(), file.to_str().expect("UTF-8").to_owned());
    let note = "MIN and MAX of `qty`";
    let said = pasapas(&["upload", &file, "--port", port.to_str().expect("UTF-8")]);
    assert!(said.contains(note) && said.contains("one.bas:1:5: note"), "{said}");
    panel(&board).write(3000, &[501]).expect("taken");
    let said = pasapas(&["check", &file, "--part", "g2553"]);
    assert!(said.contains(note) && said.contains("f5529"), "{said}");
    let said = pasapas(&["check", &file, "--part", "f5529"]);
    assert!(!said.contains("MIN"), "{said}");
}
