//! `set_port` and `on_port`: outputs and inputs by the addresses of the card's ports.

use nom::Parser;
use nom::sequence::terminated;

use super::statement::{expected, label_name, nom_or};
use super::{Read, Reader, Refused};
use crate::codes::Code;
use crate::isel::instr::Op;
use crate::line::{Parsed, sign, whole};

impl Reader<'_, '_> {
    pub(super) fn set_port<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let (rest, address, bit, value) = port(rest)?;
        let first = match address {
            65_529 => 1,
            65_530 => 9,
            _ => {
                return Err(Refused::new(
                    Code::OutOfRange,
                    format!("{address} is no port of outputs"),
                    "they are 65529 and 65530",
                ));
            }
        };
        self.push(Op::Port { first, bit, value })?;
        Ok(rest)
    }

    pub(super) fn on_port<'t>(&mut self, rest: &'t str) -> Read<&'t str> {
        let (rest, address, bit, value) = port(rest)?;
        if address != 65_531 {
            return Err(Refused::new(
                Code::OutOfRange,
                format!("{address} is no port of inputs"),
                "it is 65531",
            ));
        }
        let (rest, _): (_, char) = nom_or(sign(',').parse(rest), "a comma and where to go")?;
        let offset: Parsed<'_, i64> = whole(rest);
        if let Ok((rest, offset)) = offset {
            let jump = self.away(offset)?;
            self.push(Op::PortTest { bit, value, jump })?;
            return Ok(rest);
        }
        let (rest, name) = label_name(rest).map_err(|_| expected("a label or an offset"))?;
        self.jump(name, Op::PortTest { bit, value, jump: 0 })?;
        Ok(rest)
    }
}

/// `65529,5=0`: address, bit, value.
fn port(rest: &str) -> Read<(&str, i64, i64, i64)> {
    let mut parts = (terminated(whole, sign(',')), terminated(whole, sign('=')), whole);
    let (rest, (address, bit, value)) = nom_or(parts.parse(rest), "`65529,5=1`")?;
    let top = if bit == 0 { 255 } else { 1 };
    if !(0..=8).contains(&bit) || !(0..=top).contains(&value) {
        return Err(Refused::new(
            Code::OutOfRange,
            format!("bit {bit} with value {value}"),
            "bits 1 to 8 are 0 or 1; bit 0 stands for all eight, 0 to 255",
        ));
    }
    Ok((rest, address, bit, value))
}
