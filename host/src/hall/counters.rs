//! Counters of the gateway, and the registers that show them.

use std::sync::atomic::{AtomicU32, Ordering};

/// A number that only grows, modulo 2^32.
#[derive(Debug, Default)]
pub struct Count(AtomicU32);

impl Count {
    /// One more.
    pub fn add(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// So far.
    pub fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    /// A figure instead of a count.
    pub fn set(&self, value: u32) {
        self.0.store(value, Ordering::Relaxed);
    }
}

macro_rules! counts {
    ($(#[doc = $about:literal])+ $name:ident, $table:ident {
        $($(#[doc = $doc:literal])+ $field:ident,)*
    }) => {
        $(#[doc = $about])+
        #[derive(Debug, Default)]
        pub struct $name { $($(#[doc = $doc])+ pub $field: Count,)* }

        /// Name and meaning of each, in the order of their registers.
        pub const $table: &[(&str, &str)] = &[$((stringify!($field), concat!($($doc),+)),)*];

        impl $name {
            /// Their values, in the order of the table.
            pub fn values(&self) -> Vec<u32> {
                vec![$(self.$field.get(),)*]
            }
        }
    };
}

counts! {
    /// What is counted of the gateway as a whole.
    Totals, TOTALS {
        /// Boards.
        boards,
        /// Clients that are connected.
        clients,
        /// Clients that ever were.
        connected,
        /// Clients that made room for another one.
        displaced,
        /// Clients that found no room: all others were at work.
        turned_away,
        /// Connections that sent something else than Modbus TCP.
        foreign,
        /// Requests of all clients.
        requests,
        /// Requests for units that there are not, or that the client does not see.
        astray,
    }
}

counts! {
    /// What is counted of each board.
    Counters, COUNTERS {
        /// Its unit.
        unit,
        /// 0: not asked yet, 1: it answers, 2: it does not.
        health,
        /// Requests of clients.
        requests,
        /// Those of them that were answered from memory.
        cached,
        /// Exchanges on the line.
        exchanges,
        /// Exchanges without an answer.
        timeouts,
        /// Exceptions of the board itself.
        exceptions,
        /// Writes that the client has no right to.
        refused,
        /// Requests answered at once because the board is silent or its line is not open.
        spared,
        /// Time of the last exchange, us.
        last_us,
    }
}

/// Unit that shows the counters: the last one that every client can ask for (Modbus over Serial Line
/// V1.02, 2.2; libmodbus takes none above it). A board with this address needs a unit of its own.
pub const OWN_UNIT: u8 = 247;
/// Register from which on the first board's counters stand, each as 32 bits, low word first.
pub const FIRST_BOARD: u16 = 100;
/// Registers from one board to the next.
pub const BOARD_STEP: u16 = 40;

/// The counters' registers, from 0 on.
pub fn registers(totals: &Totals, boards: &[&Counters]) -> Vec<u16> {
    let mut registers = vec![0; usize::from(FIRST_BOARD) + boards.len() * usize::from(BOARD_STEP)];
    let mut put = |first: usize, values: Vec<u32>| {
        for (i, value) in values.into_iter().enumerate() {
            registers[first + 2 * i] = value as u16;
            registers[first + 2 * i + 1] = (value >> 16) as u16;
        }
    };
    put(0, totals.values());
    for (i, counters) in boards.iter().enumerate() {
        put(usize::from(FIRST_BOARD) + i * usize::from(BOARD_STEP), counters.values());
    }
    registers
}

#[cfg(test)]
mod tests {
    use super::{BOARD_STEP, COUNTERS, Counters, FIRST_BOARD, TOTALS, Totals, registers};

    #[test]
    fn every_count_has_its_two_registers_and_blocks_do_not_meet() {
        assert!(2 * TOTALS.len() <= usize::from(FIRST_BOARD));
        assert!(2 * COUNTERS.len() <= usize::from(BOARD_STEP));
        let (totals, a, b) = (Totals::default(), Counters::default(), Counters::default());
        totals.boards.set(2);
        a.unit.set(7);
        b.last_us.set(0x1_0002);
        let words = registers(&totals, &[&a, &b]);
        assert_eq!(words[0], 2);
        assert_eq!(words[100], 7);
        assert_eq!(words[140 + 18..], [2, 1].into_iter().chain([0; 20]).collect::<Vec<u16>>());
    }
}
