//! Modbus RTU frames as a master sees them: requests to bytes, bytes to replies.
//!
//! Sources: Modbus Application Protocol V1.1b3, section 6 (functions); Modbus over Serial Line
//! V1.02, section 2.5.1 (RTU framing, CRC low byte first).

use nom::IResult;
use nom::Parser;
use nom::bytes::streaming::take;
use nom::combinator::verify;
use nom::multi::length_data;
use nom::number::streaming::{be_u16, le_u16, u8};

use crate::link::adu::crc_of;

/// One of the four tables, read by its own function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bits {
    /// Function 1.
    Coils,
    /// Function 2.
    Inputs,
}

/// Registers that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Registers {
    /// Function 3.
    Holding,
    /// Function 4.
    Input,
}

/// What a master asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request<'a> {
    /// Functions 1 and 2.
    ReadBits {
        /// Which table.
        table: Bits,
        /// First bit.
        first: u16,
        /// How many, 1..=2000.
        count: u16,
    },
    /// Functions 3 and 4.
    ReadRegisters {
        /// Which table.
        table: Registers,
        /// First register.
        first: u16,
        /// How many, 1..=125.
        count: u16,
    },
    /// Function 5.
    WriteCoil {
        /// Which.
        address: u16,
        /// New state.
        on: bool,
    },
    /// Function 6.
    WriteRegister {
        /// Which.
        address: u16,
        /// New value.
        value: u16,
    },
    /// Function 16.
    WriteRegisters {
        /// First register.
        first: u16,
        /// New values, 1..=123.
        values: &'a [u16],
    },
}

/// What came back.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Values of the bits that were read.
    Bits(Vec<bool>),
    /// Values of the registers that were read.
    Registers(Vec<u16>),
    /// A write was done.
    Written,
    /// Exception with its code.
    Exception(u8),
}

/// Result of looking for a reply in what has come so far.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Scan {
    /// A reply.
    Found(Reply),
    /// Not all of it has come.
    Incomplete,
}

impl Request<'_> {
    /// Function code.
    pub const fn function(&self) -> u8 {
        match self {
            Request::ReadBits { table: Bits::Coils, .. } => 1,
            Request::ReadBits { table: Bits::Inputs, .. } => 2,
            Request::ReadRegisters { table: Registers::Holding, .. } => 3,
            Request::ReadRegisters { table: Registers::Input, .. } => 4,
            Request::WriteCoil { .. } => 5,
            Request::WriteRegister { .. } => 6,
            Request::WriteRegisters { .. } => 16,
        }
    }

    /// The whole frame for the board with this address.
    pub fn frame(&self, address: u8) -> Vec<u8> {
        let mut frame = vec![address, self.function()];
        let mut word = |value: u16| frame.extend(value.to_be_bytes());
        match *self {
            Request::ReadBits { first, count, .. }
            | Request::ReadRegisters { first, count, .. } => {
                word(first);
                word(count);
            }
            Request::WriteCoil { address, on } => {
                word(address);
                word(if on { 0xFF00 } else { 0 });
            }
            Request::WriteRegister { address, value } => {
                word(address);
                word(value);
            }
            Request::WriteRegisters { first, values } => {
                word(first);
                word(values.len() as u16);
                frame.push((values.len() * 2) as u8);
                frame.extend(values.iter().flat_map(|value| value.to_be_bytes()));
            }
        }
        frame.extend(crc_of(&frame).to_le_bytes());
        frame
    }

    /// Bytes of the frame of a reply without an exception.
    pub const fn reply_length(&self) -> usize {
        match self {
            Request::ReadBits { count, .. } => 5 + (*count as usize).div_ceil(8),
            Request::ReadRegisters { count, .. } => 5 + 2 * *count as usize,
            _ => 8,
        }
    }

    /// Looks for the reply from `address` in `received`, which may begin with noise: every place is
    /// tried, and only a right CRC makes a reply.
    pub fn scan(&self, address: u8, received: &[u8]) -> Scan {
        (0..received.len())
            .find_map(|start| self.reply(address, &received[start..]).ok())
            .map_or(Scan::Incomplete, |(_, reply)| Scan::Found(reply))
    }

    /// Parses one reply frame.
    fn reply<'i>(&self, address: u8, input: &'i [u8]) -> IResult<&'i [u8], Reply> {
        let function = self.function();
        let (rest, _) = verify(u8, |got| *got == address).parse(input)?;
        let (rest, got) = verify(u8, |got| *got & 0x7F == function).parse(rest)?;
        let (rest, reply) = if got == function { self.body(rest)? } else { exception(rest)? };
        let length = input.len() - rest.len();
        let expected = crc_of(&input[..length]);
        let (rest, _) = verify(le_u16, |crc| *crc == expected).parse(rest)?;
        Ok((rest, reply))
    }

    fn body<'i>(&self, input: &'i [u8]) -> IResult<&'i [u8], Reply> {
        match *self {
            Request::ReadBits { count, .. } => {
                let bytes = usize::from(count).div_ceil(8);
                let (rest, data) =
                    verify(length_data(u8), |data: &[u8]| data.len() == bytes).parse(input)?;
                let bit = |i: usize| data[i / 8] >> (i % 8) & 1 != 0;
                Ok((rest, Reply::Bits((0..usize::from(count)).map(bit).collect())))
            }
            Request::ReadRegisters { count, .. } => {
                let bytes = 2 * usize::from(count);
                let (rest, data) =
                    verify(length_data(u8), |data: &[u8]| data.len() == bytes).parse(input)?;
                let words = data.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
                Ok((rest, Reply::Registers(words.collect())))
            }
            Request::WriteCoil { address, on } => echo(input, address, if on { 0xFF00 } else { 0 }),
            Request::WriteRegister { address, value } => echo(input, address, value),
            Request::WriteRegisters { first, values } => echo(input, first, values.len() as u16),
        }
    }
}

/// The reply to a write repeats its first two words.
fn echo(input: &[u8], first: u16, second: u16) -> IResult<&[u8], Reply> {
    let (rest, _) = verify((be_u16, be_u16), |got| *got == (first, second)).parse(input)?;
    Ok((rest, Reply::Written))
}

fn exception(input: &[u8]) -> IResult<&[u8], Reply> {
    let (rest, code) = take(1usize)(input)?;
    Ok((rest, Reply::Exception(code[0])))
}

#[cfg(test)]
mod tests {
    use super::{Bits, Registers, Reply, Request, Scan, crc_of};

    fn framed(bytes: &[u8]) -> Vec<u8> {
        let mut frame = bytes.to_vec();
        frame.extend(crc_of(bytes).to_le_bytes());
        frame
    }

    #[test]
    fn a_request_has_the_bytes_of_the_standard() {
        let request = Request::ReadRegisters { table: Registers::Holding, first: 0x6B, count: 3 };
        assert_eq!(request.frame(0x11)[..6], [0x11, 3, 0, 0x6B, 0, 3]);
        assert_eq!(request.frame(0x11), framed(&[0x11, 3, 0, 0x6B, 0, 3]));
        let request = Request::WriteRegisters { first: 1, values: &[0x000A, 0x0102] };
        assert_eq!(request.frame(1), framed(&[1, 16, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2]));
    }

    #[test]
    fn replies_are_found_behind_noise_and_their_own_echo() {
        let request = Request::ReadRegisters { table: Registers::Holding, first: 0, count: 2 };
        let mut line = vec![0x55, 0x01, 0x03, 0xFF];
        line.extend(request.frame(1));
        let noise = line.clone();
        line.extend(framed(&[1, 3, 4, 0x12, 0x34, 0xAB, 0xCD]));
        assert_eq!(request.scan(1, &line), Scan::Found(Reply::Registers(vec![0x1234, 0xABCD])));
        assert_eq!(request.scan(1, &noise), Scan::Incomplete);
    }

    #[test]
    fn every_prefix_of_a_reply_is_incomplete() {
        let request = Request::ReadBits { table: Bits::Coils, first: 0, count: 10 };
        let reply = framed(&[7, 1, 2, 0b1000_0001, 0b10]);
        assert_eq!(reply.len(), request.reply_length());
        for end in 0..reply.len() {
            assert_eq!(request.scan(7, &reply[..end]), Scan::Incomplete);
        }
        let Scan::Found(Reply::Bits(bits)) = request.scan(7, &reply) else {
            panic!("no reply found");
        };
        let on: Vec<usize> = (0..10).filter(|i| bits[*i]).collect();
        assert_eq!(on, [0, 7, 9]);
    }

    #[test]
    fn a_reply_of_another_board_or_function_or_with_a_wrong_crc_is_none() {
        let request = Request::WriteRegister { address: 5, value: 9 };
        let good = framed(&[1, 6, 0, 5, 0, 9]);
        assert_eq!(request.scan(1, &good), Scan::Found(Reply::Written));
        assert_eq!(request.scan(2, &good), Scan::Incomplete);
        assert_eq!(request.scan(1, &framed(&[1, 6, 0, 5, 0, 8])), Scan::Incomplete);
        assert_eq!(request.scan(1, &framed(&[1, 16, 0, 5, 0, 9])), Scan::Incomplete);
        let mut broken = good;
        broken[3] ^= 4;
        assert_eq!(request.scan(1, &broken), Scan::Incomplete);
        assert_eq!(request.scan(1, &framed(&[1, 0x86, 6])), Scan::Found(Reply::Exception(6)));
    }
}
