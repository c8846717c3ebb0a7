//! The link to an emulated board in this process: the client's time is the board's.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use emulator::{Board, Format, Parity as LineParity};
use lang::profile::Parity;

use super::hardware::Hardware;
use super::rig::Rig;
use crate::link::{Link, Mode};

/// Time between two looks for characters, us: less than one takes at 115200.
const LOOK_US: u64 = 50;

/// A link whose other end is the UART of a [`Rig`].
pub struct InProcess<B: Hardware = Board> {
    rig: Rc<RefCell<Rig<B>>>,
    received: VecDeque<u8>,
}

impl<B: Hardware> InProcess<B> {
    /// A link to the rig.
    pub fn new(rig: Rc<RefCell<Rig<B>>>) -> InProcess<B> {
        InProcess { rig, received: VecDeque::new() }
    }

    fn run_until(&self, tick: u64) -> io::Result<()> {
        self.rig.borrow_mut().run_until(tick).map_err(io::Error::other)
    }

    /// When `time` has passed from now, in ticks.
    fn end_of(&self, time: Duration) -> u64 {
        let mut rig = self.rig.borrow_mut();
        let per_second = rig.board().ticks_per_second();
        rig.now().saturating_add(ticks(time, per_second))
    }

    fn collect(&mut self) {
        let mut rig = self.rig.borrow_mut();
        self.received.extend(rig.board().uart_take().into_iter().map(|(_, byte)| byte));
    }
}

const NS_PER_SECOND: u128 = 1_000_000_000;

/// Rounded up: a wait for less than a tick must end, too.
fn ticks(time: Duration, per_second: u64) -> u64 {
    let ticks = (time.as_nanos() * u128::from(per_second)).div_ceil(NS_PER_SECOND);
    u64::try_from(ticks).unwrap_or(u64::MAX)
}

impl<B: Hardware> Link for InProcess<B> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let gone = self.rig.borrow_mut().board().uart_send(bytes);
        self.run_until(gone)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let end = self.end_of(patience);
        let look = self.rig.borrow().ticks(LOOK_US);
        loop {
            self.collect();
            if !self.received.is_empty() {
                let count = buffer.len().min(self.received.len());
                for (place, byte) in buffer.iter_mut().zip(self.received.drain(..count)) {
                    *place = byte;
                }
                return Ok(count);
            }
            let now = self.rig.borrow().now();
            if now >= end {
                return Ok(0);
            }
            self.run_until(end.min(now + look))?;
        }
    }

    fn now(&self) -> Duration {
        let mut rig = self.rig.borrow_mut();
        let per_second = rig.board().ticks_per_second();
        let ns = u128::from(rig.now()) * NS_PER_SECOND / u128::from(per_second);
        Duration::from_nanos(u64::try_from(ns).unwrap_or(u64::MAX))
    }

    fn pause(&mut self, time: Duration) {
        let end = self.end_of(time);
        // A world that fails fails again at the next exchange, which can say so.
        let _ = self.run_until(end);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        let parity = match mode.parity {
            Parity::None => LineParity::None,
            Parity::Even => LineParity::Even,
            Parity::Odd => LineParity::Odd,
        };
        self.rig.borrow_mut().board().set_uart_format(Format { baud: mode.rate, parity });
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::ticks;
    use std::time::Duration;

    #[test]
    fn a_wait_for_less_than_a_tick_ends() {
        assert_eq!(
            [0, 1, 62, 63, 125, 126].map(|ns| ticks(Duration::from_nanos(ns), 16_000_000)),
            [0, 1, 1, 2, 2, 3]
        );
    }
}
