//! The Modbus RTU slave: checks a whole request, then computes the reply while it is sent.
//!
//! There is one buffer of [`FRAME`] bytes. A request is received into it. Once it is understood,
//! only an address and a count are kept and the buffer becomes the ring from which the reply is
//! sent, so the longest reply (125 registers are 255 bytes) needs no buffer of its size.
//! Source: Modbus Application Protocol V1.1b3 (functions, exceptions), Modbus over Serial Line
//! V1.02 (address, CRC, broadcast).

use lang::wire::{BLOCKS, Block, CRC_START, Exception, LONG, Table, WRITABLE, crc16};

/// Bytes of the frame buffer: function 16 with 63 registers, so that the line carries more pieces of a streamed
/// job than gaps. The G2553 has a shorter one of its own (`g2553/ram.rs`).
pub const FRAME: usize = 9 + 2 * 63 + 1;

/// Longest read: what a reply's byte count can tell.
const MAX_REGISTERS: u16 = 125;
const MAX_BITS: u16 = 2000;

/// The serial line below the slave.
pub trait Line {
    /// Byte `index` of the request.
    fn byte(&self, index: u8) -> u8;
    /// Room for reply bytes.
    fn room(&self) -> u8;
    /// Appends a byte to the reply; only called when there is room.
    fn put(&mut self, byte: u8);
    /// Appends a word, high byte first; only called when there is room for both.
    fn put_word(&mut self, word: u16) {
        self.put((word >> 8) as u8);
        self.put(word as u8);
    }
    /// Nothing more will be put; the line listens again once all is sent.
    fn finish(&mut self);
    /// One byte more into a CRC.
    fn crc(crc: u16, byte: u8) -> u16 {
        crc16(crc, byte)
    }
    /// A word more into a CRC, high byte first.
    fn crc_word(crc: u16, word: u16) -> u16 {
        Self::crc(Self::crc(crc, (word >> 8) as u8), word as u8)
    }
}

/// What the addresses mean.
pub trait Map {
    /// A read request begins: forget what was held for the second half of a 32-bit value.
    fn begin(&mut self);
    /// The register at an address that lies in a block.
    fn read(&mut self, table: Table, address: u16) -> u16;
    /// Called after each [`BREATH`] registers of a reply: what cannot wait for all of them comes between.
    fn between(&mut self) {}
    /// The bit at an address that lies in a block.
    fn read_bit(&mut self, table: Table, address: u16) -> bool;
    /// Whether who asks may write at all: a request from this address on, its value when it is of one register.
    ///
    /// # Errors
    /// Busy.
    fn may_steer(&mut self, _address: u16, _value: Option<u16>) -> Result<(), Exception> {
        Ok(())
    }
    /// Whether a register may be written. A request asks for all of its registers before it writes the first; what
    /// only the state of the machine refuses may still be refused by [`Map::write`].
    ///
    /// # Errors
    /// The exception to answer with.
    fn may_write(&self, address: u16, value: u16) -> Result<(), Exception>;
    /// Writes a register for which [`Map::may_write`] was asked.
    ///
    /// # Errors
    /// The exception to answer with.
    fn write(&mut self, address: u16, value: u16) -> Result<(), Exception>;
    /// Whether a 32-bit value may be written at its low register. A request asks for all of its values
    /// before it writes the first.
    ///
    /// # Errors
    /// The exception to answer with.
    fn may_write_long(&self, address: u16, value: i32) -> Result<(), Exception>;
    /// Writes a 32-bit value at its low register.
    ///
    /// # Errors
    /// The exception to answer with.
    fn write_long(&mut self, address: u16, value: i32) -> Result<(), Exception>;
    /// Whether a coil may be written. A request asks for all of its coils before it writes the first.
    ///
    /// # Errors
    /// The exception to answer with.
    fn may_write_bit(&self, address: u16) -> Result<(), Exception>;
    /// Writes a coil for which [`Map::may_write_bit`] was asked.
    fn write_bit(&mut self, address: u16, on: bool);
    /// All registers of a request were written, the first of them this one.
    ///
    /// # Errors
    /// The exception to answer with.
    fn written(&mut self, address: u16) -> Result<(), Exception>;
}

/// Registers that are read at once. Beside three fast axes a register takes up to 60 us.
const BREATH: u16 = 16;

/// The slave: what is left to send of a reply.
#[derive(Debug, Default)]
pub struct Slave {
    /// Reading function whose data is being sent, 0 for none.
    function: u8,
    next: u16,
    left: u16,
    crc: u16,
}

fn block(table: Table, address: u16, count: u16) -> Result<&'static Block, Exception> {
    for block in BLOCKS {
        let offset = address.wrapping_sub(block.first);
        if block.table == table as u8 && offset < block.count {
            return if block.count - offset >= count {
                Ok(block)
            } else {
                Err(Exception::IllegalAddress)
            };
        }
    }
    Err(Exception::IllegalAddress)
}

fn word<L: Line>(line: &L, index: u8) -> u16 {
    u16::from_be_bytes([line.byte(index), line.byte(index + 1)])
}

/// The 32-bit values of function 16, each low word first, with their offset from the address.
fn longs<L: Line>(
    line: &L,
    registers: u16,
    mut each: impl FnMut(u16, i32) -> Result<(), Exception>,
) -> Result<(), Exception> {
    let mut offset = 0;
    while offset < registers {
        let index = 7 + 2 * offset as u8;
        let value = u32::from(word(line, index + 2)) << 16 | u32::from(word(line, index));
        each(offset, value as i32)?;
        offset += 2;
    }
    Ok(())
}

impl Slave {
    /// Nothing to send.
    pub const fn new() -> Slave {
        Slave { function: 0, next: 0, left: 0, crc: 0 }
    }

    /// Takes a frame of `length` bytes from the line. Returns whether it was a sound request for
    /// this slave (a host is there).
    pub fn request<L: Line, M: Map>(
        &mut self,
        line: &mut L,
        map: &mut M,
        own_address: u8,
        length: u8,
    ) -> bool {
        let address = line.byte(0);
        let mut crc = CRC_START;
        let mut index = 0;
        while index < length {
            crc = L::crc(crc, line.byte(index));
            index += 1;
        }
        if length < 4 || crc != 0 || (address != own_address && address != 0) {
            line.finish();
            return false;
        }
        let function = line.byte(1);
        let result = self.perform(line, map, function, length);
        if address == 0 {
            self.left = 0;
            self.function = 0;
            line.finish();
            return true;
        }
        self.crc = CRC_START;
        // The echo of a write lies in the buffer that the reply is put into, so it is read first.
        let (place, value) = (word(line, 2), word(line, 4));
        self.put(line, address);
        match result {
            Ok(()) if self.function != 0 => {
                self.put(line, function);
                let bytes = if function <= 2 { self.left.div_ceil(8) } else { self.left * 2 };
                self.put(line, bytes as u8);
            }
            Ok(()) => {
                self.put(line, function);
                self.put_word(line, place);
                self.put_word(line, value);
                self.end(line);
            }
            Err(exception) => {
                self.function = 0;
                self.put(line, function | 0x80);
                self.put(line, exception as u8);
                self.end(line);
            }
        }
        true
    }

    /// Puts more of the reply into the line while there is room.
    pub fn poll<L: Line, M: Map>(&mut self, line: &mut L, map: &mut M) {
        while self.function != 0 && line.room() >= 4 {
            let table = self.table();
            if self.function <= 2 {
                let mut byte = 0;
                let mut bit = 1u8;
                while bit != 0 && self.left != 0 {
                    if map.read_bit(table, self.next) {
                        byte |= bit;
                    }
                    self.next += 1;
                    self.left -= 1;
                    bit <<= 1;
                }
                self.put(line, byte);
            } else {
                let value = map.read(table, self.next);
                self.put_word(line, value);
                self.next += 1;
                self.left -= 1;
                if self.left.is_multiple_of(BREATH) {
                    map.between();
                }
            }
            if self.left == 0 {
                self.function = 0;
                self.end(line);
            }
        }
    }

    fn table(&self) -> Table {
        match self.function {
            1 => Table::Coils,
            2 => Table::Inputs,
            3 => Table::Holding,
            _ => Table::InputRegisters,
        }
    }

    fn perform<L: Line, M: Map>(
        &mut self,
        line: &L,
        map: &mut M,
        function: u8,
        length: u8,
    ) -> Result<(), Exception> {
        self.function = 0;
        if length < 8 {
            return Err(if matches!(function, 1..=6 | 15 | 16) {
                Exception::IllegalValue
            } else {
                Exception::IllegalFunction
            });
        }
        let address = word(line, 2);
        let value = word(line, 4);
        match function {
            1..=4 => {
                let limit = if function <= 2 { MAX_BITS } else { MAX_REGISTERS };
                if length != 8 || value == 0 || value > limit {
                    return Err(Exception::IllegalValue);
                }
                self.function = function;
                if let Err(exception) = block(self.table(), address, value) {
                    self.function = 0;
                    return Err(exception);
                }
                self.next = address;
                self.left = value;
                map.begin();
                Ok(())
            }
            5 | 6 => {
                if length != 8 || (function == 5 && value != 0 && value != 0xFF00) {
                    return Err(Exception::IllegalValue);
                }
                let table = if function == 5 { Table::Coils } else { Table::Holding };
                let block = block(table, address, 1)?;
                if block.flags & WRITABLE == 0 {
                    return Err(Exception::IllegalAddress);
                }
                map.may_steer(address, (function == 6).then_some(value))?;
                if function == 5 {
                    map.may_write_bit(address)?;
                    map.write_bit(address, value != 0);
                    return Ok(());
                }
                if block.flags & LONG != 0 {
                    if address & 1 != 0 {
                        return Err(Exception::IllegalValue);
                    }
                    let value = i32::from(value as i16);
                    map.may_write_long(address, value)?;
                    return map.write_long(address, value);
                }
                map.may_write(address, value)?;
                map.write(address, value)?;
                map.written(address)
            }
            15 | 16 => {
                let bytes = u16::from(line.byte(6));
                let wanted = if function == 15 { value.div_ceil(8) } else { value.wrapping_mul(2) };
                // A frame longer than the buffer never arrives here, so `value` is small.
                if value == 0 || bytes != wanted || u16::from(length) != bytes + 9 || value > 1968 {
                    return Err(Exception::IllegalValue);
                }
                let table = if function == 15 { Table::Coils } else { Table::Holding };
                let block = block(table, address, value)?;
                if block.flags & WRITABLE == 0 {
                    return Err(Exception::IllegalAddress);
                }
                let long = block.flags & LONG != 0;
                if long && (address | value) & 1 != 0 {
                    return Err(Exception::IllegalValue);
                }
                let one = function == 16 && value == 1;
                map.may_steer(address, one.then(|| word(line, 7)))?;
                if long {
                    longs(line, value, |at, own| map.may_write_long(address + at, own))?;
                    longs(line, value, |at, own| map.write_long(address + at, own))?;
                    return map.written(address);
                }
                if function == 15 {
                    for index in 0..value {
                        map.may_write_bit(address + index)?;
                    }
                    for index in 0..value {
                        let byte = line.byte(7 + (index >> 3) as u8);
                        map.write_bit(address + index, byte >> (index & 7) & 1 != 0);
                    }
                    return Ok(());
                }
                for index in 0..value {
                    map.may_write(address + index, word(line, 7 + (index as u8) * 2))?;
                }
                for index in 0..value {
                    map.write(address + index, word(line, 7 + (index as u8) * 2))?;
                }
                map.written(address)
            }
            _ => Err(Exception::IllegalFunction),
        }
    }

    fn put<L: Line>(&mut self, line: &mut L, byte: u8) {
        self.crc = L::crc(self.crc, byte);
        line.put(byte);
    }

    fn put_word<L: Line>(&mut self, line: &mut L, word: u16) {
        self.crc = L::crc_word(self.crc, word);
        line.put_word(word);
    }

    fn end<L: Line>(&mut self, line: &mut L) {
        let crc = self.crc;
        line.put(crc as u8);
        line.put((crc >> 8) as u8);
        line.finish();
    }
}

#[cfg(test)]
mod tests;
