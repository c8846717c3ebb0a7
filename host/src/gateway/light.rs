//! Light boards on a line that takes the time of a real one: a hundred of them cost no processor.
//!
//! They hold registers and coils and nothing else; what a gateway does to a line's time is measured
//! and tested with them.

use std::collections::HashMap;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use lang::wire::{Exception, Table};

use super::pdu::{Touch, refusal};
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
    /// The reply on its way, and when its last character is there.
    reply: Option<(Instant, Vec<u8>)>,
}

impl Light {
    /// A line at the usual rate.
    pub fn new(memory: Arc<Mutex<Memory>>) -> Light {
        Light { memory, opened: Instant::now(), mode: Mode::DEFAULT, reply: None }
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
        self.reply = open_rtu(frame).and_then(|(address, pdu)| {
            let reply = rtu(address, &self.answer(address, pdu)?);
            // A slave knows a frame's end by the rest behind it.
            let time = self.mode.time_of(frame.len() + reply.len()) + self.mode.silence() + WORK;
            Some((Instant::now() + time, reply))
        });
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let wait =
            self.reply.as_ref().map(|(due, _)| due.saturating_duration_since(Instant::now()));
        match wait {
            Some(wait) if wait <= patience => {
                std::thread::sleep(wait);
                let reply = self.reply.take().map(|(_, reply)| reply).unwrap_or_default();
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
