//! Model boards on a line with the timing of a real one: a hundred of them take hardly any processor time.
//!
//! They hold registers and coils and nothing else. The gateway's effect on a line's time is measured
//! and tested with them.

use std::collections::{HashMap, VecDeque};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use lang::wire::{Exception, Table};

use super::pdu::{NO_ANSWER, Touch, refusal};
use crate::link::adu::{open_rtu, rtu};
use crate::link::{Link, Mode};

/// Work of a board between the end of a request and its reply.
const WORK: Duration = Duration::from_micros(500);

/// What the boards of a line hold; a test may look and change it.
#[derive(Default)]
pub struct Memory {
    /// By address, then register; a register that was never written shows [`first_value`].
    pub registers: HashMap<u8, HashMap<u16, u16>>,
    /// Addresses that answer nothing.
    pub dead: Vec<u8>,
    /// Requests that came over the line: address and function.
    pub heard: Vec<(u8, u8)>,
    /// What befalls requests that write to a register or read from it on: the first entry that matches is used once.
    pub mishaps: Vec<(u16, Mishap)>,
}

/// What befalls a request. The board carries it out all the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mishap {
    /// Its reply is lost.
    Lost,
    /// Its reply is lost, and a gateway before the board says so by exception 11.
    Told,
    /// Its reply and those after it come so much later.
    Late(Duration),
}

/// What a register of a board shows that nobody wrote.
pub const fn first_value(address: u8, register: u16) -> u16 {
    (address as u16) << 8 | register & 0xFF
}

/// A line with light boards.
pub struct Light {
    memory: Arc<Mutex<Memory>>,
    opened: Instant,
    mode: Mode,
    /// The replies on their way, and when the last character of each is there.
    replies: VecDeque<(Instant, Vec<u8>)>,
}

impl Light {
    /// A line at the usual rate.
    pub fn new(memory: Arc<Mutex<Memory>>) -> Light {
        Light { memory, opened: Instant::now(), mode: Mode::DEFAULT, replies: VecDeque::new() }
    }

    /// What befalls this request, if anything does.
    fn mishap(&self, pdu: &[u8]) -> Option<Mishap> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        let first = Touch::of(pdu).ok()?.first;
        let place = memory.mishaps.iter().position(|(register, _)| *register == first)?;
        Some(memory.mishaps.remove(place).1)
    }

    fn answer(&self, address: u8, pdu: &[u8]) -> Option<Vec<u8>> {
        let mut memory = self.memory.lock().unwrap_or_else(PoisonError::into_inner);
        memory.heard.push((address, pdu[0]));
        if memory.dead.contains(&address) {
            return None;
        }
        let registers = memory.registers.get_mut(&address)?;
        let touch = match Touch::of(pdu) {
            Ok(touch) => touch,
            Err(exception) => return Some(refusal(pdu, exception as u8)),
        };
        if !matches!(touch.table, Table::Holding | Table::InputRegisters) {
            return Some(refusal(pdu, Exception::IllegalAddress as u8));
        }
        let range = touch.range().map(|register| register as u16);
        if touch.write {
            let data = if pdu[0] == 6 { &pdu[3..5] } else { &pdu[6..] };
            for (register, pair) in range.zip(data.chunks_exact(2)) {
                registers.insert(register, u16::from_be_bytes([pair[0], pair[1]]));
            }
            return Some(pdu[..5].to_vec());
        }
        let value =
            |register: u16| *registers.get(&register).unwrap_or(&first_value(address, register));
        let mut reply = vec![pdu[0], 2 * touch.count as u8];
        reply.extend(range.flat_map(|register| value(register).to_be_bytes()));
        Some(reply)
    }
}

impl Link for Light {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let Some((address, pdu)) = open_rtu(frame) else { return Ok(()) };
        let mishap = self.mishap(pdu);
        let Some(reply) = self.answer(address, pdu) else { return Ok(()) };
        let (reply, late) = match mishap {
            None => (reply, Duration::ZERO),
            Some(Mishap::Lost) => return Ok(()),
            Some(Mishap::Told) => (refusal(pdu, NO_ANSWER), Duration::ZERO),
            Some(Mishap::Late(by)) => (reply, by),
        };
        let reply = rtu(address, &reply);
        // A slave knows a frame's end by the rest after it, and answers one request after the other.
        let time = self.mode.time_of(frame.len() + reply.len()) + self.mode.silence() + WORK + late;
        let now = Instant::now();
        let begin = self.replies.back().map_or(now, |(due, _)| now.max(*due));
        self.replies.push_back((begin + time, reply));
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let wait =
            self.replies.front().map(|(due, _)| due.saturating_duration_since(Instant::now()));
        match wait {
            Some(wait) if wait <= patience => {
                std::thread::sleep(wait);
                let reply = self.replies.pop_front().map(|(_, reply)| reply).unwrap_or_default();
                let count = reply.len().min(buffer.len());
                buffer[..count].copy_from_slice(&reply[..count]);
                Ok(count)
            }
            _ => {
                std::thread::sleep(patience);
                Ok(0)
            }
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn pause(&mut self, time: Duration) {
        std::thread::sleep(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.mode = mode;
        Ok(true)
    }
}

/// Boards with these addresses on a line of their own.
pub fn boards(addresses: &[u8]) -> Arc<Mutex<Memory>> {
    let registers = addresses.iter().map(|address| (*address, HashMap::new())).collect();
    Arc::new(Mutex::new(Memory { registers, ..Memory::default() }))
}

/// Time from one read of so many registers to the next on a line that never rests longer than it must.
pub fn cycle(registers: usize) -> Duration {
    let mode = Mode::DEFAULT;
    // Request, reply, the slave's rest and the master's.
    mode.time_of(8 + 5 + 2 * registers) + 2 * mode.silence() + WORK
}
