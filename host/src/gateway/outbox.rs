//! Messages that must arrive: kept on disk in their order until the broker has acknowledged them.
//!
//! No library keeps them when a broker forgets the session, so the gateway does. Each message has a
//! number that is also part of its text, so a receiver can drop duplicates. A message is sent only after it
//! is on disk. The file is lines of JSON, appended at its end; a line that a power cut has torn
//! is dropped. The file is bounded: the oldest message makes room, and that is counted and reported.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::output;

/// Bytes of texts that may wait.
const MOST_BYTES: usize = 16 << 20;
/// The file is made anew when it has this many lines beyond those of what waits.
const MOST_STALE: usize = 10_000;

/// A message.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Letter {
    /// Its number: one more than that of the one before.
    pub id: u64,
    /// Where it goes.
    pub topic: String,
    /// Its text.
    pub text: String,
}

/// A line of the file.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Line {
    Letter(Letter),
    /// Everything up to this number has arrived or was dropped.
    Done {
        done: u64,
    },
}

/// The messages of one gateway.
pub struct Outbox {
    path: PathBuf,
    file: File,
    waiting: VecDeque<Letter>,
    bytes: usize,
    /// Number of the newest message.
    newest: u64,
    most: usize,
    /// Lines in the file.
    lines: usize,
    /// Messages that made room and of which nobody was told yet.
    dropped: u64,
    dirty: bool,
    /// Held for as long as the messages are ours.
    _lock: File,
}

fn write_line(file: &mut impl Write, line: &Line) -> io::Result<()> {
    let mut text = serde_json::to_string(line)?;
    text.push('\n');
    file.write_all(text.as_bytes())
}

/// Takes the messages for this process: two that write them would lose those of each other. The file itself is
/// made anew now and then, so the lock is one beside it.
fn lock(path: &Path) -> io::Result<File> {
    let mut name = path.as_os_str().to_owned();
    name.push(".lock");
    let file = File::create(&name)?;
    file.try_lock().map_err(|error| match error {
        TryLockError::WouldBlock => {
            io::Error::other("another gateway has it; give it another `outbox`")
        }
        TryLockError::Error(error) => error,
    })?;
    Ok(file)
}

/// Writes the file with what waits alone, in one step.
fn write_anew(path: &Path, newest: u64, waiting: &VecDeque<Letter>) -> io::Result<File> {
    let done = waiting.front().map_or(newest, |letter| letter.id - 1);
    let mut text = Vec::new();
    write_line(&mut text, &Line::Done { done })?;
    for letter in waiting {
        write_line(&mut text, &Line::Letter(letter.clone()))?;
    }
    output::replace(path, &text)?;
    let file = OpenOptions::new().append(true).open(path)?;
    file.sync_data()?;
    Ok(file)
}

impl Outbox {
    /// Opens the file or makes it, with at most `most` messages.
    ///
    /// # Errors
    /// It cannot be read or written, or another gateway has it.
    pub fn open(path: &Path, most: usize) -> io::Result<Outbox> {
        let lock = lock(path)?;
        let mut waiting: VecDeque<Letter> = VecDeque::new();
        let (mut newest, mut done) = (0, 0);
        match File::open(path) {
            Ok(file) => {
                for line in BufReader::new(file).lines() {
                    match line.map(|line| serde_json::from_str(&line)) {
                        Ok(Ok(Line::Letter(letter))) if letter.id > newest => {
                            newest = letter.id;
                            waiting.push_back(letter);
                        }
                        Ok(Ok(Line::Done { done: to })) => {
                            done = done.max(to);
                            newest = newest.max(to);
                        }
                        // The end of a write that a power cut broke off.
                        Ok(_) => {}
                        Err(error) if error.kind() == io::ErrorKind::InvalidData => {}
                        Err(error) => return Err(error),
                    }
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
        waiting.retain(|letter| letter.id > done);
        let bytes = waiting.iter().map(|letter| letter.text.len()).sum();
        // What was torn goes before anything is written behind it.
        let file = write_anew(path, newest, &waiting)?;
        let (path, lines, most) = (path.to_owned(), 1 + waiting.len(), most.max(1));
        let mut outbox = Outbox {
            path,
            file,
            waiting,
            bytes,
            newest,
            most,
            lines,
            dropped: 0,
            dirty: false,
            _lock: lock,
        };
        outbox.make_room()?;
        Ok(outbox)
    }

    /// Takes a message; `text` makes its text from its number. It may be sent behind [`Outbox::sync`].
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn push(&mut self, topic: &str, text: impl FnOnce(u64) -> String) -> io::Result<()> {
        self.newest += 1;
        let letter = Letter { id: self.newest, topic: topic.to_owned(), text: text(self.newest) };
        let line = Line::Letter(letter);
        write_line(&mut self.file, &line)?;
        let Line::Letter(letter) = line else { return Ok(()) };
        self.bytes += letter.text.len();
        self.waiting.push_back(letter);
        self.lines += 1;
        self.dirty = true;
        self.make_room()
    }

    fn make_room(&mut self) -> io::Result<()> {
        while self.waiting.len() > self.most || self.bytes > MOST_BYTES && self.waiting.len() > 1 {
            let Some(oldest) = self.waiting.front() else { break };
            self.dropped += 1;
            self.arrived(oldest.id)?;
        }
        Ok(())
    }

    /// Brings all that was taken onto the disk.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn sync(&mut self) -> io::Result<()> {
        if self.lines > self.waiting.len() + MOST_STALE {
            self.file = write_anew(&self.path, self.newest, &self.waiting)?;
            self.lines = 1 + self.waiting.len();
        } else if self.dirty {
            self.file.sync_data()?;
        }
        self.dirty = false;
        Ok(())
    }

    /// The first message behind a number.
    pub fn behind(&self, id: u64) -> Option<&Letter> {
        let first = self.waiting.front()?.id;
        let skip = id.saturating_add(1).saturating_sub(first);
        self.waiting.get(usize::try_from(skip).ok()?)
    }

    /// Number before the oldest message that waits.
    pub fn done(&self) -> u64 {
        self.waiting.front().map_or(self.newest, |letter| letter.id - 1)
    }

    /// Everything up to this number has arrived, or is given up.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn arrived(&mut self, id: u64) -> io::Result<()> {
        while self.waiting.front().is_some_and(|letter| letter.id <= id) {
            if let Some(letter) = self.waiting.pop_front() {
                self.bytes -= letter.text.len();
            }
        }
        // Not synced: what arrived and is sent once more is told by its number.
        self.lines += 1;
        write_line(&mut self.file, &Line::Done { done: id })
    }

    /// How many wait.
    #[cfg(test)]
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Messages that made room since this was asked last.
    pub fn take_dropped(&mut self) -> u64 {
        std::mem::take(&mut self.dropped)
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_STALE, Outbox};
    use std::io::Write;

    fn text(id: u64) -> String {
        format!("{{\"id\":{id}}}")
    }

    fn ids(outbox: &Outbox) -> Vec<u64> {
        let mut ids = Vec::new();
        let mut at = outbox.done();
        while let Some(letter) = outbox.behind(at) {
            at = letter.id;
            ids.push(at);
        }
        ids
    }

    #[test]
    fn what_has_not_arrived_is_there_after_a_restart_in_its_order() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("outbox");
        let mut outbox = Outbox::open(&path, 100).expect("new");
        (0..5).for_each(|_| outbox.push("t", text).expect("room"));
        outbox.sync().expect("a disk");
        outbox.arrived(2).expect("a disk");
        drop(outbox);
        // A power cut in the middle of a line.
        let mut file = std::fs::OpenOptions::new().append(true).open(&path).expect("there");
        file.write_all(b"{\"id\":6,\"topic\":\"t\",\"te").expect("written");
        drop(file);
        let mut outbox = Outbox::open(&path, 100).expect("there");
        assert_eq!(ids(&outbox), [3, 4, 5]);
        let other = Outbox::open(&path, 100).map(|_| ()).expect_err("it is taken");
        assert!(other.to_string().contains("another gateway"), "{other}");
        outbox.push("t", text).expect("room");
        outbox.arrived(6).expect("a disk");
        assert_eq!(outbox.len(), 0);
        drop(outbox);
        let mut outbox = Outbox::open(&path, 100).expect("there");
        assert_eq!(outbox.len(), 0);
        outbox.push("t", text).expect("room");
        assert_eq!(ids(&outbox), [7], "a number is never given twice");
    }

    #[test]
    fn the_oldest_make_room_and_are_counted_and_the_file_stays_bounded() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("outbox");
        let mut outbox = Outbox::open(&path, 10).expect("new");
        for n in 0..3 * MOST_STALE {
            outbox.push("t", text).expect("room");
            if n % 100 == 0 {
                outbox.sync().expect("a disk");
            }
        }
        assert_eq!(outbox.take_dropped(), 3 * MOST_STALE as u64 - 10);
        assert_eq!(outbox.take_dropped(), 0);
        assert_eq!(ids(&outbox).len(), 10);
        let length = std::fs::metadata(&path).expect("there").len();
        assert!(length < 60 * (MOST_STALE as u64 + 200), "{length} bytes");
    }
}
