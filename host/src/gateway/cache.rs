//! Replies of a board that are recent enough to be given again.

use std::time::{Duration, Instant};

use lang::wire::Table;

use super::pdu::Touch;

/// Answers that are kept of one board.
const MOST: usize = 32;

struct Kept {
    touch: Touch,
    /// The values as they came: bits packed from the lowest, registers high byte first.
    data: Vec<u8>,
    read: Instant,
}

/// What a board said lately.
#[derive(Default)]
pub struct Cache {
    kept: Vec<Kept>,
}

impl Cache {
    /// The reply to a read, taken out of one answer that is no older than `age`: so values of 32 bits
    /// are of one instant, as from the board itself.
    pub fn reply(&self, touch: &Touch, age: Duration, now: Instant) -> Option<Vec<u8>> {
        let young = |kept: &&Kept| now.saturating_duration_since(kept.read) < age;
        let holds = |kept: &&Kept| {
            let (own, wanted) = (kept.touch.range(), touch.range());
            kept.touch.table == touch.table && own.start <= wanted.start && wanted.end <= own.end
        };
        if touch.write {
            return None;
        }
        let kept = self.kept.iter().filter(young).find(holds)?;
        let skip = usize::from(touch.first - kept.touch.first);
        let count = usize::from(touch.count);
        let data = match touch.table {
            Table::Coils | Table::Inputs => {
                let bit = |i: usize| kept.data[i / 8] >> (i % 8) & 1;
                let mut bytes = vec![0; count.div_ceil(8)];
                (0..count).for_each(|i| bytes[i / 8] |= bit(skip + i) << (i % 8));
                bytes
            }
            Table::Holding | Table::InputRegisters => {
                kept.data[2 * skip..2 * (skip + count)].to_vec()
            }
        };
        let mut reply = vec![touch.table as u8, data.len() as u8];
        reply.extend(data);
        Some(reply)
    }

    /// Keeps a board's reply to a read; the oldest one makes room.
    pub fn keep(&mut self, touch: &Touch, reply: &[u8], now: Instant) {
        let good = reply.len() == touch.reply_length() && reply[0] == touch.table as u8;
        if !good || !touch.may_be_kept() {
            return;
        }
        self.kept.retain(|kept| kept.touch != *touch);
        if self.kept.len() >= MOST {
            self.kept.remove(0);
        }
        self.kept.push(Kept { touch: *touch, data: reply[2..].to_vec(), read: now });
    }

    /// The board was told something: what it said before may hold no more.
    pub fn forget(&mut self) {
        self.kept.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::{Cache, MOST};
    use crate::gateway::pdu::Touch;
    use lang::wire::Table;
    use std::time::{Duration, Instant};

    const AGE: Duration = Duration::from_millis(50);

    fn read(table: Table, first: u16, count: u16) -> Touch {
        Touch { table, first, count, write: false }
    }

    #[test]
    fn a_part_of_an_answer_is_given_again_while_it_is_young() {
        let mut cache = Cache::default();
        let now = Instant::now();
        cache.keep(&read(Table::Holding, 100, 3), &[3, 6, 0, 1, 0, 2, 0, 3], now);
        let middle = read(Table::Holding, 101, 2);
        assert_eq!(cache.reply(&middle, AGE, now), Some(vec![3, 4, 0, 2, 0, 3]));
        assert_eq!(cache.reply(&middle, AGE, now + AGE), None);
        assert_eq!(cache.reply(&middle, Duration::ZERO, now), None);
        assert_eq!(cache.reply(&read(Table::Holding, 102, 2), AGE, now), None);
        assert_eq!(cache.reply(&read(Table::InputRegisters, 101, 1), AGE, now), None);
        cache.forget();
        assert_eq!(cache.reply(&middle, AGE, now), None);
    }

    proptest::proptest! {
        #[test]
        fn bits_are_those_of_the_board(
            bits in proptest::collection::vec(proptest::bool::ANY, 1..200),
            skip in 0usize..200, count in 1usize..200,
        ) {
            let pack = |bits: &[bool]| {
                let mut bytes = vec![0u8; bits.len().div_ceil(8)];
                bits.iter().enumerate().for_each(|(i, on)| bytes[i / 8] |= u8::from(*on) << (i % 8));
                [vec![2, bytes.len() as u8], bytes].concat()
            };
            let mut cache = Cache::default();
            let now = Instant::now();
            cache.keep(&read(Table::Inputs, 256, bits.len() as u16), &pack(&bits), now);
            let touch = read(Table::Inputs, 256 + skip as u16, count as u16);
            let wanted = bits.get(skip..skip + count).map(pack);
            proptest::prop_assert_eq!(cache.reply(&touch, AGE, now), wanted);
        }
    }

    #[test]
    fn what_is_kept_is_bounded_and_exceptions_are_not_kept() {
        let mut cache = Cache::default();
        let now = Instant::now();
        for first in 0..1000 {
            cache.keep(&read(Table::Holding, first, 1), &[3, 2, 0, 1], now);
        }
        assert_eq!(cache.kept.len(), MOST);
        assert!(cache.reply(&read(Table::Holding, 999, 1), AGE, now).is_some());
        cache.keep(&read(Table::Holding, 5000, 1), &[0x83, 2], now);
        assert_eq!(cache.reply(&read(Table::Holding, 5000, 1), AGE, now), None);
    }
}
