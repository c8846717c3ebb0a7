//! Modbus frames as they are transmitted: RTU on a serial line, MBAP on TCP.
//!
//! Both carry the same function and data (the PDU). RTU puts the address before it and a CRC after it;
//! MBAP puts a header of seven bytes before it: transaction, protocol 0, length, unit.
//!
//! Sources: Modbus over Serial Line V1.02, section 2.5.1; Modbus Messaging on TCP/IP Implementation
//! Guide V1.0b, section 3.1.3.

use std::io::{self, Read};

use lang::wire::{CRC_START, crc16};

/// Longest RTU frame: address, 253 bytes of PDU, CRC.
pub const MAX_RTU: usize = 256;
/// Bytes of an MBAP header without the unit, which its length counts.
const MBAP_HEAD: usize = 6;

/// CRC of an RTU frame's bytes before it.
pub fn crc_of(bytes: &[u8]) -> u16 {
    bytes.iter().fold(CRC_START, |crc, byte| crc16(crc, *byte))
}

/// The RTU frame of a PDU.
pub fn rtu(address: u8, pdu: &[u8]) -> Vec<u8> {
    let mut frame = vec![address];
    frame.extend(pdu);
    frame.extend(crc_of(&frame).to_le_bytes());
    frame
}

/// Address and PDU of an RTU frame, if its CRC is right.
pub fn open_rtu(frame: &[u8]) -> Option<(u8, &[u8])> {
    let (bytes, crc) = frame.split_last_chunk::<2>()?;
    let (address, pdu) = bytes.split_first()?;
    (!pdu.is_empty() && crc_of(bytes) == u16::from_le_bytes(*crc)).then_some((*address, pdu))
}

/// Bytes of the RTU request that `bytes` begin with, if all of it is there and its CRC is right.
/// TCP knows no silence between two frames: the function tells where one ends.
pub fn rtu_request(bytes: &[u8]) -> Option<usize> {
    let length = match bytes.get(1)? {
        1..=6 => 8,
        15 | 16 => 9 + usize::from(*bytes.get(6)?),
        _ => return None,
    };
    open_rtu(bytes.get(..length)?).map(|_| length)
}

/// A message of Modbus TCP.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mbap {
    /// Number that the reply repeats.
    pub transaction: u16,
    /// Address of a board behind a gateway; 0 and 255 are the one that is asked.
    pub unit: u8,
    /// Function and data, 1 to 253 bytes.
    pub pdu: Vec<u8>,
}

/// What came is no Modbus TCP: nothing behind it can be understood.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotMbap;

impl Mbap {
    /// Its bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(MBAP_HEAD + 1 + self.pdu.len());
        bytes.extend(self.transaction.to_be_bytes());
        bytes.extend([0, 0]);
        bytes.extend((self.pdu.len() as u16 + 1).to_be_bytes());
        bytes.push(self.unit);
        bytes.extend(&self.pdu);
        bytes
    }

    /// Takes the first message out of `received`; none when not all of it has come.
    ///
    /// # Errors
    /// Another protocol than 0, or a length that no PDU has.
    pub fn take(received: &mut Vec<u8>) -> Result<Option<Mbap>, NotMbap> {
        let Some(head) = received.first_chunk::<MBAP_HEAD>() else { return Ok(None) };
        let length = usize::from(u16::from_be_bytes([head[4], head[5]]));
        if head[2..4] != [0, 0] || !(2..=MAX_RTU - 2).contains(&length) {
            return Err(NotMbap);
        }
        let transaction = u16::from_be_bytes([head[0], head[1]]);
        if received.len() < MBAP_HEAD + length {
            return Ok(None);
        }
        let rest = received.split_off(MBAP_HEAD + length);
        let message = std::mem::replace(received, rest);
        let pdu = message[MBAP_HEAD + 1..].to_vec();
        Ok(Some(Mbap { transaction, unit: message[MBAP_HEAD], pdu }))
    }

    /// Reads a connection until a message is there; what came behind it stays in `received`.
    ///
    /// # Errors
    /// The connection fails or ends, or what comes is no Modbus TCP.
    pub fn read(stream: &mut impl Read, received: &mut Vec<u8>) -> io::Result<Mbap> {
        loop {
            let taken = Mbap::take(received).map_err(|NotMbap| {
                io::Error::new(io::ErrorKind::InvalidData, "what answers speaks no Modbus TCP")
            })?;
            if let Some(message) = taken {
                return Ok(message);
            }
            let mut piece = [0; 2 * MAX_RTU];
            match stream.read(&mut piece)? {
                0 => return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it closed")),
                count => received.extend(&piece[..count]),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Mbap, NotMbap, open_rtu, rtu, rtu_request};

    #[test]
    fn a_message_has_the_bytes_of_the_guide() {
        // Modbus Messaging on TCP/IP Implementation Guide V1.0b, 4.4.2.1: read register 5 of unit 255.
        let bytes = [0x15, 0x01, 0, 0, 0, 6, 0xFF, 3, 0, 4, 0, 1];
        let message = Mbap { transaction: 0x1501, unit: 0xFF, pdu: vec![3, 0, 4, 0, 1] };
        assert_eq!(message.bytes(), bytes);
        let mut received = [&bytes[..], &bytes[..5]].concat();
        assert_eq!(Mbap::take(&mut received), Ok(Some(message)));
        assert_eq!(received, bytes[..5]);
    }

    #[test]
    fn every_prefix_of_a_message_is_incomplete_and_stays() {
        let bytes = Mbap { transaction: 7, unit: 1, pdu: vec![6, 0, 1, 0, 2] }.bytes();
        for end in 0..bytes.len() {
            let mut received = bytes[..end].to_vec();
            assert_eq!(Mbap::take(&mut received), Ok(None));
            assert_eq!(received, bytes[..end]);
        }
    }

    #[test]
    fn a_reader_gets_message_by_message_and_hears_of_the_end() {
        let one = Mbap { transaction: 7, unit: 1, pdu: vec![6, 0, 1, 0, 2] };
        let other = Mbap { transaction: 8, ..one.clone() };
        let bytes = [one.bytes(), other.bytes(), vec![0, 9]].concat();
        let (mut stream, mut received) = (&bytes[..], Vec::new());
        assert_eq!(Mbap::read(&mut stream, &mut received).expect("whole"), one);
        assert_eq!(Mbap::read(&mut stream, &mut received).expect("whole"), other);
        let end = Mbap::read(&mut stream, &mut received).expect_err("half");
        assert_eq!(end.kind(), std::io::ErrorKind::UnexpectedEof);
        let foreign = Mbap::read(&mut &b"HTTP/1.1 400"[..], &mut Vec::new()).expect_err("foreign");
        assert_eq!(foreign.kind(), std::io::ErrorKind::InvalidData);
    }

    #[test]
    fn other_protocols_and_lengths_are_no_modbus() {
        let get = b"GET / HTTP/1.1\r\n";
        assert_eq!(Mbap::take(&mut get.to_vec()), Err(NotMbap));
        for length in [0u16, 1, 255, 0xFFFF] {
            let mut bytes = vec![0, 1, 0, 0];
            bytes.extend(length.to_be_bytes());
            assert_eq!(Mbap::take(&mut bytes), Err(NotMbap), "length {length}");
        }
    }

    #[test]
    fn two_rtu_requests_in_one_piece_are_told_apart() {
        let pdus: [&[u8]; 3] =
            [&[3, 0, 4, 0, 1], &[16, 0, 1, 0, 2, 4, 0, 10, 1, 2], &[5, 0, 1, 255, 0]];
        for first in pdus {
            for second in pdus {
                let frame = rtu(1, first);
                let both = [frame.clone(), rtu(1, second)].concat();
                assert_eq!(rtu_request(&both), Some(frame.len()));
                assert_eq!(open_rtu(&frame), Some((1, first)));
                for end in 0..frame.len() {
                    assert_eq!(rtu_request(&frame[..end]), None);
                }
            }
        }
        let mut broken = rtu(1, pdus[0]);
        broken[3] ^= 1;
        assert_eq!(rtu_request(&broken), None);
        assert_eq!(open_rtu(&broken), None);
    }
}
