//! The link to an emulated board in this process: the client's time is the board's.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use emulator::{Format, Parity as LineParity};
use lang::profile::Parity;

use super::rig::{Rig, TICKS_PER_US};
use crate::link::{Link, Mode};

/// Time between two looks for characters: less than one takes at 115200.
const LOOK: u64 = 50 * TICKS_PER_US;

/// A link whose other end is the UART of a [`Rig`].
pub struct InProcess {
    rig: Rc<RefCell<Rig>>,
    received: VecDeque<u8>,
}

impl InProcess {
    /// A link to the rig.
    pub fn new(rig: Rc<RefCell<Rig>>) -> InProcess {
        InProcess { rig, received: VecDeque::new() }
    }

    fn run_until(&self, tick: u64) -> io::Result<()> {
        self.rig.borrow_mut().run_until(tick).map_err(io::Error::other)
    }

    fn collect(&mut self) {
        let mut rig = self.rig.borrow_mut();
        self.received.extend(rig.board().uart_take().into_iter().map(|(_, byte)| byte));
    }
}

/// A tick is 62.5 ns. Rounded up: a wait for less than a tick must end, too.
fn ticks(time: Duration) -> u64 {
    u64::try_from((time.as_nanos() * 2).div_ceil(125)).unwrap_or(u64::MAX)
}

impl Link for InProcess {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let gone = self.rig.borrow_mut().board().uart_send(bytes);
        self.run_until(gone)
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        let end = self.rig.borrow().now().saturating_add(ticks(patience));
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
            self.run_until(end.min(now + LOOK))?;
        }
    }

    fn now(&self) -> Duration {
        Duration::from_nanos(self.rig.borrow().now().saturating_mul(125) / 2)
    }

    fn pause(&mut self, time: Duration) {
        let end = self.rig.borrow().now().saturating_add(ticks(time));
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
            [0, 1, 62, 63, 125, 126].map(|ns| ticks(Duration::from_nanos(ns))),
            [0, 1, 1, 2, 2, 3]
        );
    }
}
