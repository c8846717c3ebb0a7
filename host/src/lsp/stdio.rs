//! Standard input and output as the connection of the language server.
//!
//! lsp-server has this too, but reserves as much memory as `Content-Length` says before it reads a
//! byte: 99999999999999 ends the process.

use std::io::{self, stdin, stdout};
use std::thread::{JoinHandle, spawn};
use std::time::{Duration, Instant};

use crossbeam_channel::bounded;
use lsp_server::{Connection, Message};

use crate::dap::wire;

/// Longest message, bytes: a script of 8 MB, each character of which may be written as six.
const LONGEST: usize = 64 << 20;

/// Time in which a reader that has failed ends.
const PATIENCE: Duration = Duration::from_millis(500);

/// The threads that read and write.
pub struct Threads {
    reader: JoinHandle<io::Result<()>>,
    writer: JoinHandle<io::Result<()>>,
}

/// A connection to whoever started the process.
pub fn connect() -> (Connection, Threads) {
    let (to_server, receiver) = bounded(0);
    let (sender, from_server) = bounded::<Message>(0);
    let reader = spawn(move || {
        let mut input = stdin().lock();
        while let Some(value) = wire::read_up_to(&mut input, LONGEST)? {
            let message: Message = serde_json::from_value(value)
                .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
            let last = matches!(&message, Message::Notification(note) if note.method == "exit");
            if to_server.send(message).is_err() || last {
                break;
            }
        }
        Ok(())
    });
    let writer = spawn(move || {
        let mut output = stdout().lock();
        from_server.into_iter().try_for_each(|message| message.write(&mut output))
    });
    (Connection { sender, receiver }, Threads { reader, writer })
}

impl Threads {
    /// Why reading ended, if it has ended by something that is no message.
    ///
    /// # Errors
    /// The input broke, or was no message.
    pub fn ended(self, broken: bool) -> io::Result<()> {
        // A server that gave up does not wait for an editor that still holds its end open; but what
        // ended the reader is the reason.
        let until = Instant::now() + PATIENCE;
        while broken && !self.reader.is_finished() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(5));
        }
        if !broken || self.reader.is_finished() {
            self.reader.join().unwrap_or(Ok(()))?;
        }
        self.writer.join().unwrap_or(Ok(()))
    }
}
