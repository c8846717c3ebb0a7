//! A virtual board that a test keeps up, as a user would.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// `pasapas board` on a pseudo-terminal, running until it is dropped.
pub struct Board {
    child: Child,
    /// For the test's files; the pseudo-terminal is there too.
    pub folder: TempDir,
}

impl Board {
    /// Waits until the board's pseudo-terminal is there.
    pub fn start(more: &[&str]) -> Board {
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("board");
        let child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["board", "--pty"])
            .arg(&link)
            .args(more)
            .stdout(Stdio::null())
            .spawn()
            .expect("the board starts");
        let board = Board { child, folder };
        let begun = Instant::now();
        while !link.exists() {
            assert!(begun.elapsed() < Duration::from_secs(20), "no pseudo-terminal appeared");
            std::thread::sleep(Duration::from_millis(20));
        }
        board
    }

    /// Name of the pseudo-terminal.
    pub fn port(&self) -> PathBuf {
        self.folder.path().join("board")
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
