use super::{FRAME, Line, Map, Slave};
use lang::wire::{CRC_START, Exception, OWN, POSITIONS, Table, crc16};

#[derive(Default)]
struct TestLine {
    request: Vec<u8>,
    reply: Vec<u8>,
    finished: bool,
}

impl Line for TestLine {
    fn byte(&self, index: u8) -> u8 {
        self.request.get(usize::from(index)).copied().unwrap_or(0)
    }
    fn room(&self) -> u8 {
        6
    }
    fn put(&mut self, byte: u8) {
        self.reply.push(byte);
    }
    fn finish(&mut self) {
        self.finished = true;
    }
}

#[derive(Default)]
struct TestMap {
    writes: Vec<(u16, i32)>,
    refuse: Option<Exception>,
    /// The greatest value that may be written, and the last coil.
    most: Option<i32>,
}

impl TestMap {
    fn note(&mut self, address: u16, value: i32) -> Result<(), Exception> {
        self.writes.push((address, value));
        self.refuse.map_or(Ok(()), Err)
    }

    fn may(&self, value: i32) -> Result<(), Exception> {
        if self.most.is_some_and(|most| value > most) {
            return Err(Exception::IllegalValue);
        }
        Ok(())
    }
}

impl Map for TestMap {
    fn begin(&mut self) {}
    fn read(&mut self, table: Table, address: u16) -> u16 {
        address ^ (table as u16) << 12
    }
    fn read_bit(&mut self, _: Table, address: u16) -> bool {
        address.is_multiple_of(3)
    }
    fn may_write(&self, _: u16, value: u16) -> Result<(), Exception> {
        self.may(value.into())
    }
    fn write(&mut self, address: u16, value: u16) -> Result<(), Exception> {
        self.note(address, value.into())
    }
    fn may_write_long(&self, _: u16, value: i32) -> Result<(), Exception> {
        self.may(value)
    }
    fn write_long(&mut self, address: u16, value: i32) -> Result<(), Exception> {
        self.note(address, value)
    }
    fn may_write_bit(&self, address: u16) -> Result<(), Exception> {
        self.may(address.into())
    }
    fn write_bit(&mut self, address: u16, on: bool) {
        self.writes.push((address, on.into()));
    }
    fn written(&mut self, _: u16) -> Result<(), Exception> {
        Ok(())
    }
}

fn sealed(body: &[u8]) -> Vec<u8> {
    let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
    [body, &crc.to_le_bytes()].concat()
}

/// The reply without its CRC (which is checked), empty for silence.
fn exchange(map: &mut TestMap, frame: Vec<u8>) -> Vec<u8> {
    assert!(frame.len() <= FRAME);
    let length = frame.len() as u8;
    let mut line = TestLine { request: frame, ..TestLine::default() };
    let mut slave = Slave::new();
    slave.request(&mut line, map, 1, length);
    slave.poll(&mut line, map);
    assert!(line.finished);
    if line.reply.is_empty() {
        return Vec::new();
    }
    let body = line.reply.len() - 2;
    assert_eq!(sealed(&line.reply[..body]), line.reply);
    line.reply.truncate(body);
    line.reply
}

fn ask(body: &[u8]) -> Vec<u8> {
    exchange(&mut TestMap::default(), sealed(body))
}

fn high(address: u16) -> u8 {
    (address >> 8) as u8
}

#[test]
fn sixty_four_registers_in_one_reply() {
    let reply = ask(&[1, 3, high(OWN), OWN as u8, 0, 64]);
    assert_eq!(reply[..3], [1, 3, 128]);
    let last = (OWN + 63) ^ 0x3000;
    assert_eq!(reply[129..], [high(last), last as u8]);
}

#[test]
fn bits_are_packed_low_first_and_padded() {
    // Bits 0..=9 of which 0, 3, 6, 9 are set.
    assert_eq!(ask(&[1, 2, 0, 0, 0, 10]), [1, 2, 2, 0b0100_1001, 0b10]);
}

#[test]
fn writes_echo_and_arrive() {
    let mut map = TestMap::default();
    let frame = [1, 16, 7, 208, 0, 2, 4, 0, 103, 0, 1];
    assert_eq!(exchange(&mut map, sealed(&frame)), [1, 16, 7, 208, 0, 2]);
    assert_eq!(map.writes, [(2000, 103), (2001, 1)]);
    let mut map = TestMap::default();
    assert_eq!(exchange(&mut map, sealed(&[1, 5, 0, 2, 0xFF, 0])), [1, 5, 0, 2, 0xFF, 0]);
    assert_eq!(map.writes, [(2, 1)]);
    let mut map = TestMap::default();
    assert_eq!(exchange(&mut map, sealed(&[1, 15, 0, 0, 0, 3, 1, 5])), [1, 15, 0, 0, 0, 3]);
    assert_eq!(map.writes, [(0, 1), (1, 0), (2, 1)]);
}

#[test]
fn long_registers_are_written_whole() {
    let address = [high(POSITIONS), POSITIONS as u8];
    let mut map = TestMap::default();
    let frame = [1, 16, address[0], address[1], 0, 2, 4, 0xFF, 0xFE, 0xFF, 0xFF];
    exchange(&mut map, sealed(&frame));
    assert_eq!(map.writes, [(POSITIONS, -2)]);
    let mut map = TestMap::default();
    exchange(&mut map, sealed(&[1, 6, address[0], address[1], 0xFF, 0xFF]));
    assert_eq!(map.writes, [(POSITIONS, -1)], "function 6 extends the sign");
    assert_eq!(ask(&[1, 6, address[0], address[1] + 1, 0, 0]), [1, 0x86, 3]);
    assert_eq!(ask(&[1, 16, address[0], address[1] + 1, 0, 2, 4, 0, 0, 0, 0]), [1, 0x90, 3]);
}

#[test]
fn one_value_that_may_not_be_leaves_all_of_a_request_unwritten() {
    let [high, low] = [high(POSITIONS), POSITIONS as u8];
    let both = |last: u8| sealed(&[1, 16, high, low, 0, 4, 8, 0, 5, 0, 0, 0, last, 0, 0]);
    let mut map = TestMap { most: Some(7), ..TestMap::default() };
    assert_eq!(exchange(&mut map, both(8)), [1, 0x90, 3]);
    assert_eq!(exchange(&mut map, sealed(&[1, 6, high, low, 0, 8])), [1, 0x86, 3]);
    assert_eq!(map.writes, []);
    assert_eq!(exchange(&mut map, both(7)), [1, 16, high, low, 0, 4]);
    assert_eq!(map.writes, [(POSITIONS, 5), (POSITIONS + 2, 7)]);
}

#[test]
fn one_register_or_coil_that_may_not_be_leaves_all_of_a_request_unwritten() {
    let both = |last: u8| sealed(&[1, 16, 7, 208, 0, 2, 4, 0, 5, 0, last]);
    let mut map = TestMap { most: Some(7), ..TestMap::default() };
    assert_eq!(exchange(&mut map, both(8)), [1, 0x90, 3]);
    assert_eq!(exchange(&mut map, sealed(&[1, 6, 7, 208, 0, 8])), [1, 0x86, 3]);
    assert_eq!(exchange(&mut map, sealed(&[1, 15, 0, 6, 0, 3, 1, 7])), [1, 0x8F, 3]);
    assert_eq!(exchange(&mut map, sealed(&[1, 5, 0, 8, 0xFF, 0])), [1, 0x85, 3]);
    assert_eq!(map.writes, []);
    assert_eq!(exchange(&mut map, both(7)), [1, 16, 7, 208, 0, 2]);
    assert_eq!(exchange(&mut map, sealed(&[1, 15, 0, 6, 0, 2, 1, 3])), [1, 15, 0, 6, 0, 2]);
    assert_eq!(map.writes, [(2000, 5), (2001, 7), (6, 1), (7, 1)]);
}

#[test]
fn exceptions_are_those_of_the_standard() {
    assert_eq!(ask(&[1, 7, 0, 0, 0, 0]), [1, 0x87, 1]);
    assert_eq!(ask(&[1, 7]), [1, 0x87, 1], "a function without data is judged by its number");
    assert_eq!(ask(&[1, 3, 0x70, 0, 0, 1]), [1, 0x83, 2]);
    assert_eq!(ask(&[1, 3, 0x13, 0x88, 0, 201 - 100 + 99]), [1, 0x83, 3], "more than 125");
    assert_eq!(ask(&[1, 4, 0x05, 0x32 + 10, 0, 40]), [1, 0x84, 2], "leaves its block");
    assert_eq!(ask(&[1, 3, 0x13, 0x88, 0, 0]), [1, 0x83, 3], "no register");
    assert_eq!(ask(&[1, 5, 0, 0, 0, 1]), [1, 0x85, 3], "neither on nor off");
    assert_eq!(ask(&[1, 16, 0x07, 0xD0, 0, 2, 3, 0, 0, 0]), [1, 0x90, 3], "bytes disagree");
    assert_eq!(ask(&[1, 6, 0x09, 0x6C, 0, 1]), [1, 0x86, 2], "speeds are read only");
    let mut map = TestMap { refuse: Some(Exception::Busy), ..TestMap::default() };
    assert_eq!(exchange(&mut map, sealed(&[1, 6, 0x07, 0xD0, 0, 1])), [1, 0x86, 6]);
}

#[test]
fn strangers_noise_and_broadcast_get_no_reply() {
    assert!(ask(&[2, 3, 0, 0, 0, 1]).is_empty(), "another slave");
    let mut frame = sealed(&[1, 3, 0x13, 0x88, 0, 1]);
    frame[3] ^= 0x10;
    assert!(exchange(&mut TestMap::default(), frame).is_empty(), "a flipped bit");
    assert!(exchange(&mut TestMap::default(), vec![1]).is_empty());
    assert!(exchange(&mut TestMap::default(), vec![]).is_empty());
    let mut map = TestMap::default();
    assert!(exchange(&mut map, sealed(&[0, 6, 0x07, 0xD0, 0, 1])).is_empty());
    assert_eq!(map.writes, [(2000, 1)], "a broadcast is obeyed");
    assert!(exchange(&mut map, sealed(&[0, 3, 0x13, 0x88, 0, 1])).is_empty());
}
