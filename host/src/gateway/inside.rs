//! Access to a board from inside the gateway: requests of the gateway's own services take their turns among
//! those of all clients.

use std::io;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

use super::Gateway;
use super::pdu::Touch;
use super::turns::Asker;
use crate::link::adu::{open_rtu, rtu};
use crate::link::{Link, Mode};

/// The address that frames have here: the board behind it is the only one.
pub const ADDRESS: u8 = 1;

/// The way to one board.
pub struct Inside {
    gateway: Weak<Gateway>,
    board: usize,
    asker: Asker,
    opened: Instant,
    /// The reply that is awaited.
    reply: Option<Receiver<Vec<u8>>>,
}

impl Inside {
    /// To the board with this number in the gateway's file.
    pub fn new(gateway: &Arc<Gateway>, board: usize, asker: Asker) -> Inside {
        let gateway = Arc::downgrade(gateway);
        Inside { gateway, board, asker, opened: Instant::now(), reply: None }
    }
}

fn gone() -> io::Error {
    io::Error::new(io::ErrorKind::NotConnected, "the gateway ends")
}

impl Link for Inside {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let (_, pdu) = open_rtu(frame).ok_or(io::ErrorKind::InvalidData)?;
        let touch = Touch::of(pdu).map_err(|_| io::ErrorKind::InvalidData)?;
        let gateway = self.gateway.upgrade().ok_or_else(gone)?;
        let place = &gateway.places[self.board];
        let (to, reply) = channel();
        // Whoever asked may have given up.
        let answer = Box::new(move |pdu: Vec<u8>| drop(to.send(pdu)));
        self.reply = Some(reply);
        let line = &gateway.lines[place.line];
        line.ask(self.asker, place.station, (pdu.to_vec(), touch), Duration::ZERO, answer);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let Some(reply) = &self.reply else {
            std::thread::sleep(patience);
            return Ok(0);
        };
        match reply.recv_timeout(patience) {
            Ok(pdu) => {
                self.reply = None;
                let frame = rtu(ADDRESS, &pdu);
                let count = frame.len().min(buffer.len());
                buffer[..count].copy_from_slice(&frame[..count]);
                Ok(count)
            }
            Err(RecvTimeoutError::Timeout) => Ok(0),
            Err(RecvTimeoutError::Disconnected) => Err(gone()),
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    /// The line's owner knows its mode.
    fn set_mode(&mut self, _mode: Mode) -> io::Result<bool> {
        Ok(false)
    }
}
