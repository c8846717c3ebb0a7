//! Modbus TCP: the frames of a serial line in MBAP messages.

use std::io;
use std::time::Duration;

use super::adu::{MAX_RTU, Mbap, open_rtu, rtu};
use super::{Link, Mode, Tcp};

/// A connection to a board, gateway or PLC that speaks Modbus TCP. Whoever uses the link sees the
/// frames of a serial line.
pub struct ModbusTcp {
    tcp: Tcp,
    transaction: u16,
    /// The request that waits for its reply.
    asked: Vec<u8>,
    received: Vec<u8>,
    /// The reply as an RTU frame, as far as it was not taken.
    reply: Vec<u8>,
}

impl ModbusTcp {
    /// Wraps a connection.
    pub fn new(tcp: Tcp) -> ModbusTcp {
        ModbusTcp {
            tcp,
            transaction: 0,
            asked: Vec::new(),
            received: Vec::new(),
            reply: Vec::new(),
        }
    }
}

fn invalid(text: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, text)
}

impl Link for ModbusTcp {
    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        let (unit, pdu) =
            open_rtu(frame).ok_or_else(|| invalid("Modbus TCP carries whole frames only"))?;
        // A request that is repeated takes the late reply to itself as well.
        if self.asked != frame {
            self.transaction = self.transaction.wrapping_add(1);
            self.asked = frame.to_vec();
        }
        let message = Mbap { transaction: self.transaction, unit, pdu: pdu.to_vec() };
        self.tcp.send(&message.bytes())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.reply.is_empty() {
            let mut piece = [0; MAX_RTU];
            let count = self.tcp.receive(&mut piece, patience)?;
            self.received.extend(&piece[..count]);
            while let Some(message) = Mbap::take(&mut self.received)
                .map_err(|_| invalid("what answers speaks no Modbus TCP; rtu:HOST:PORT is RTU"))?
            {
                // A reply to a request that was given up is nobody's.
                if message.transaction == self.transaction {
                    self.reply = rtu(message.unit, &message.pdu);
                    self.asked.clear();
                }
            }
        }
        let count = self.reply.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.reply[..count]);
        self.reply.drain(..count);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.tcp.now()
    }

    fn pause(&mut self, time: Duration) {
        self.tcp.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.tcp.set_mode(mode)
    }
}
