//! Rights of a client by its network address: which boards it sees and which addresses it writes.
//!
//! Modbus has no login, so nothing may be written unless the gateway's file says so. Stopping is the one
//! exception: every client that sees a board may stop it, unless the file forbids that.

use std::net::IpAddr;
use std::ops::Range;

use lang::wire::{NAMES, Table};

use super::pdu::Touch;

/// A range of machines on the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Network {
    address: u128,
    /// Leading bits that must agree.
    bits: u32,
}

/// IPv4 addresses among those of IPv6 (RFC 4291, 2.5.5.2).
fn wide(address: IpAddr) -> u128 {
    match address {
        IpAddr::V4(v4) => v4.to_ipv6_mapped().to_bits(),
        IpAddr::V6(v6) => v6.to_bits(),
    }
}

impl Network {
    /// Reads `any`, `192.168.1.20` or `192.168.1.0/24`.
    ///
    /// # Errors
    /// It is none of these; in words.
    pub fn parse(text: &str) -> Result<Network, String> {
        if text == "any" {
            return Ok(Network { address: 0, bits: 0 });
        }
        let (address, bits) = match text.split_once('/') {
            Some((address, bits)) => (address, Some(bits)),
            None => (text, None),
        };
        let wrong = || {
            format!(
                "`{text}` is no machine of the network: write any, 192.168.1.20 or 192.168.1.0/24"
            )
        };
        let address: IpAddr = address.parse().map_err(|_| wrong())?;
        let own = if address.is_ipv4() { 32 } else { 128 };
        let bits: u32 = bits.map_or(Ok(own), str::parse).map_err(|_| wrong())?;
        if bits > own {
            return Err(wrong());
        }
        Ok(Network { address: wide(address), bits: 128 - own + bits })
    }

    /// Whether a machine is one of these.
    pub fn holds(&self, address: IpAddr) -> bool {
        let differ = self.address ^ wide(address);
        differ.leading_zeros() >= self.bits
    }
}

/// Coils and registers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ranges(Vec<(Table, Range<u32>)>);

impl Ranges {
    /// Every coil and register.
    pub fn all() -> Ranges {
        Ranges(vec![(Table::Coils, 0..0x1_0000), (Table::Holding, 0..0x1_0000)])
    }

    /// Reads `all`, `coils 0..7`, `registers 3000..3071` (both ends count), or a register's name from
    /// the register map, each as one item.
    ///
    /// # Errors
    /// An item is none of these; in words.
    pub fn parse<'a>(items: impl IntoIterator<Item = &'a str>) -> Result<Ranges, String> {
        let mut ranges = Ranges::default();
        for item in items {
            ranges.add(item.trim())?;
        }
        Ok(ranges)
    }

    fn add(&mut self, item: &str) -> Result<(), String> {
        if item == "all" {
            self.0.extend(Ranges::all().0);
            return Ok(());
        }
        if let Some((_, address, _)) = NAMES.iter().find(|(name, ..)| *name == item) {
            self.0.push((Table::Holding, (*address).into()..u32::from(*address) + 1));
            return Ok(());
        }
        let wrong = || {
            format!(
                "`{item}` is nothing that can be written: write all, coils 0..7, registers \
                 3000..3071, or a register's name such as RUN_CONTROL"
            )
        };
        let (table, numbers) = item.split_once(' ').ok_or_else(wrong)?;
        let table = match table {
            "coil" | "coils" => Table::Coils,
            "register" | "registers" => Table::Holding,
            _ => return Err(wrong()),
        };
        let (first, last) = numbers.split_once("..").unwrap_or((numbers, numbers));
        let number = |text: &str| text.trim().parse::<u16>().map_err(|_| wrong());
        let (first, last) = (number(first)?, number(last)?);
        if last < first {
            return Err(wrong());
        }
        self.0.push((table, first.into()..u32::from(last) + 1));
        Ok(())
    }

    /// Whether all that a request touches is among these.
    pub fn hold(&self, touch: &Touch) -> bool {
        touch.range().all(|address| {
            self.0.iter().any(|(table, range)| *table == touch.table && range.contains(&address))
        })
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// What the clients from one part of the network may do.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Which clients.
    pub from: Network,
    /// Units that they see; none: all.
    pub units: Option<Vec<u8>>,
    /// What they may write.
    pub write: Ranges,
    /// They may end motion, whatever else they may write.
    pub stop: bool,
    /// They get nothing from memory.
    pub fresh: bool,
}

impl Rule {
    /// What holds for whom no rule is there: everything may be read and stopped, nothing else written.
    pub fn reader() -> Rule {
        let from = Network { address: 0, bits: 0 };
        Rule { from, units: None, write: Ranges::default(), stop: true, fresh: false }
    }

    /// Whether it lets a unit be seen.
    pub fn sees(&self, unit: u8) -> bool {
        self.units.as_ref().is_none_or(|units| units.contains(&unit))
    }
}

#[cfg(test)]
mod tests {
    use super::{Network, Ranges};
    use crate::gateway::pdu::Touch;
    use lang::wire::{self, Table};
    use std::net::IpAddr;

    fn ip(text: &str) -> IpAddr {
        text.parse().expect("an address")
    }

    #[test]
    fn networks_hold_their_machines_only() {
        let net = Network::parse("192.168.1.0/24").expect("good");
        assert!(net.holds(ip("192.168.1.255")) && net.holds(ip("::ffff:192.168.1.7")));
        assert!(!net.holds(ip("192.168.2.1")) && !net.holds(ip("fe80::1")));
        let one = Network::parse("fe80::7").expect("good");
        assert!(one.holds(ip("fe80::7")) && !one.holds(ip("fe80::8")));
        let any = Network::parse("any").expect("good");
        assert!(any.holds(ip("10.0.0.1")) && any.holds(ip("fe80::8")));
        assert!(!Network::parse("0.0.0.0/0").expect("good").holds(ip("fe80::1")));
        for wrong in ["", "hall", "1.2.3.4/33", "1.2.3.4/", "1.2.3/8", "::/129"] {
            assert!(Network::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_write_must_lie_in_what_is_listed_with_all_of_it() {
        let ranges = Ranges::parse([
            "registers 3000..3003",
            "registers 3004..3007",
            "coils 2",
            "RUN_CONTROL",
        ])
        .expect("good");
        let write = |table, first, count| Touch { table, first, count, write: true };
        assert!(ranges.hold(&write(Table::Holding, 3002, 4)));
        assert!(!ranges.hold(&write(Table::Holding, 3006, 3)));
        assert!(!ranges.hold(&write(Table::Coils, 3000, 1)));
        assert!(ranges.hold(&write(Table::Coils, 2, 1)));
        assert!(ranges.hold(&write(Table::Holding, wire::RUN_CONTROL, 1)));
        assert!(!ranges.hold(&write(Table::Holding, wire::RUN_CONTROL, 2)));
        assert!(Ranges::all().hold(&write(Table::Holding, 0xFFFF, 1)));
        for wrong in ["", "coils", "coils 7..2", "registers 70000", "inputs 1", "run_control"] {
            assert!(Ranges::parse([wrong]).is_err(), "{wrong}");
        }
    }
}
