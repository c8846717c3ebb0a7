//! A link without a device: two ends in one process, for a virtual board in the same process as its host.

use std::collections::VecDeque;
use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use super::{Link, Mode};

/// One end.
pub struct Pipe {
    to: Sender<Vec<u8>>,
    from: Receiver<Vec<u8>>,
    /// Bytes that came and did not fit into the reader's buffer.
    rest: VecDeque<u8>,
    opened: Instant,
}

/// Two ends: what one sends the other receives.
pub fn pipe() -> (Pipe, Pipe) {
    let (to_b, from_a) = mpsc::channel();
    let (to_a, from_b) = mpsc::channel();
    let end = |to, from| Pipe { to, from, rest: VecDeque::new(), opened: Instant::now() };
    (end(to_b, from_b), end(to_a, from_a))
}

impl Link for Pipe {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.to.send(bytes.to_vec()).map_err(|_| gone())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.rest.is_empty() {
            match self.from.recv_timeout(patience) {
                Ok(bytes) => self.rest.extend(bytes),
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => return Err(gone()),
            }
        }
        let count = buffer.len().min(self.rest.len());
        for (place, byte) in buffer.iter_mut().zip(self.rest.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn set_mode(&mut self, _mode: Mode) -> io::Result<bool> {
        Ok(false)
    }
}

fn gone() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "the other end is gone")
}

#[cfg(test)]
mod tests {
    use super::pipe;
    use crate::link::Link;
    use std::time::Duration;

    #[test]
    fn what_one_end_sends_the_other_receives_in_pieces_of_any_size() {
        let (mut a, mut b) = pipe();
        a.send(b"abc").expect("open");
        let mut two = [0; 2];
        assert_eq!(b.receive(&mut two, Duration::ZERO).expect("open"), 2);
        assert_eq!(&two, b"ab");
        assert_eq!(b.receive(&mut two, Duration::ZERO).expect("open"), 1);
        assert_eq!(b.receive(&mut two, Duration::ZERO).expect("open"), 0);
        drop(a);
        assert!(b.receive(&mut two, Duration::from_millis(1)).is_err());
        assert!(b.send(b"x").is_err());
    }
}
