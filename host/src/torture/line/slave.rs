//! The Modbus slave without hardware: a million frames, sound and damaged.

use firmware::modbus::{FRAME, Line, Map, Slave};
use lang::wire::{Exception, Table};

use super::super::stand::crc;
use super::super::{Row, Settings, Sink, Verdict};
use super::{any_request, damage, is_sound};

/// A line that holds one request and takes the reply.
struct Wire {
    request: Vec<u8>,
    reply: Vec<u8>,
    finished: u32,
}

impl Line for Wire {
    fn byte(&self, index: u8) -> u8 {
        self.request.get(usize::from(index)).copied().unwrap_or(0xA5)
    }
    fn room(&self) -> u8 {
        FRAME as u8 - 1
    }
    fn put(&mut self, byte: u8) {
        self.reply.push(byte);
    }
    fn finish(&mut self) {
        self.finished += 1;
    }
}

/// Registers that hold nothing and count what is done to them.
#[derive(Default)]
struct Counts {
    writes: u32,
}

impl Counts {
    /// Some are refused before anything is done.
    fn may(address: u16) -> Result<(), Exception> {
        if address.is_multiple_of(5) { Err(Exception::IllegalValue) } else { Ok(()) }
    }

    /// Some values are refused.
    fn take(&mut self, address: u16) -> Result<(), Exception> {
        self.writes += 1;
        if address.is_multiple_of(7) { Err(Exception::Busy) } else { Ok(()) }
    }
}

impl Map for Counts {
    fn begin(&mut self) {}
    fn read(&mut self, _table: Table, address: u16) -> u16 {
        address
    }
    fn read_bit(&mut self, _table: Table, address: u16) -> bool {
        address & 1 != 0
    }
    fn may_write(&self, address: u16, _value: u16) -> Result<(), Exception> {
        Counts::may(address)
    }
    fn write(&mut self, address: u16, _value: u16) -> Result<(), Exception> {
        self.take(address)
    }
    fn may_write_long(&self, address: u16, _value: i32) -> Result<(), Exception> {
        Counts::may(address)
    }
    fn write_long(&mut self, address: u16, _value: i32) -> Result<(), Exception> {
        self.take(address)
    }
    fn may_write_bit(&self, address: u16) -> Result<(), Exception> {
        Counts::may(address)
    }
    fn write_bit(&mut self, _address: u16, _on: bool) {
        self.writes += 1;
    }
    fn written(&mut self, _address: u16) -> Result<(), Exception> {
        Ok(())
    }
}

/// Gives bytes to the slave; `sound` says what it is to take for a frame.
///
/// # Errors
/// What it did that it must not.
pub fn try_out(bytes: &[u8], sound: impl Fn(&[u8], u8) -> bool) -> Result<(), String> {
    let mut wire = Wire { request: bytes.to_vec(), reply: Vec::new(), finished: 0 };
    let mut map = Counts::default();
    let mut slave = Slave::new();
    let length = u8::try_from(bytes.len()).unwrap_or(u8::MAX);
    let taken = slave.request(&mut wire, &mut map, 1, length);
    for _ in 0..300 {
        slave.poll(&mut wire, &mut map);
    }
    let reply = &wire.reply;
    if !sound(bytes, 1) {
        let nothing = !taken && map.writes == 0 && reply.is_empty();
        return if nothing { Ok(()) } else { Err(format!("no frame, but {reply:02X?}")) };
    }
    if wire.finished != 1 {
        return Err(format!("the line was finished {} times", wire.finished));
    }
    if bytes[0] == 0 {
        return if reply.is_empty() { Ok(()) } else { Err(format!("a broadcast: {reply:02X?}")) };
    }
    let good =
        reply.len() >= 5 && crc(reply) == 0 && reply[0] == 1 && reply[1] & 0x7F == bytes[1] & 0x7F;
    if good { Ok(()) } else { Err(format!("{reply:02X?}")) }
}

/// Frames through the slave.
///
/// # Errors
/// The table cannot be written.
pub fn run(settings: &Settings, sink: Sink<'_>) -> Result<(), String> {
    for (fault, damages) in
        [("damaged frames, slave", true), ("any function and payload, slave", false)]
    {
        let mut row = Row::new("line", fault, settings);
        row.run(settings, settings.count(20_000, 200_000, 600_000), |n| {
            let mut rng = settings.rng(fault, n);
            let mut bytes = any_request(&mut rng);
            if damages {
                bytes = damage(&mut rng, &bytes);
            }
            bytes.truncate(FRAME);
            match try_out(&bytes, is_sound) {
                Ok(()) => Verdict::Survived,
                Err(text) => Verdict::Lost(format!("{bytes:02X?}: {text}")),
            }
        });
        sink(row)?;
    }
    Ok(())
}
