//! The names that the pins and registers have in a recording.

use super::pins::high;
use super::{Plant, Wiring};
use crate::record::Signal;

impl Plant {
    /// Signal at a pin, if it has a name of its own.
    pub(super) fn signal(&self, pin: u8) -> Option<Signal> {
        let board = &self.board;
        let place = |list: &[u8]| list.iter().position(|p| *p == pin).map(|n| n as u8);
        if let Some(n) = place(&board.step) {
            return Some(Signal::Step(n));
        }
        if let Some(n) = place(&board.dir) {
            return Some(Signal::Dir(n));
        }
        let named = [
            (board.stop, Signal::Stop),
            (board.rx, Signal::Rx),
            (board.tx, Signal::Tx),
            (board.start, Signal::Start),
        ];
        if let Some((_, signal)) = named.iter().find(|(p, _)| *p == pin) {
            return Some(*signal);
        }
        if board.pwm == Some(pin) {
            return Some(Signal::Pwm);
        }
        if let Some([data, drive]) = board.rs485 {
            if pin == data {
                return Some(Signal::Rs485);
            }
            if pin == drive {
                return Some(Signal::Drive);
            }
        }
        if board.input(self.wiring, self.probe_input()) == Some(pin) {
            return Some(Signal::Probe);
        }
        match self.wiring {
            Wiring::Direct => place(&board.inputs).map(|n| Signal::In(n + 1)),
            Wiring::Chain => None,
        }
    }

    /// All signals with their present levels: the head of a recording.
    #[must_use]
    pub fn signals(&self) -> Vec<(Signal, bool)> {
        let mut all = Vec::new();
        for pin in 0..64 {
            if let Some(signal) = self.signal(pin) {
                all.push((signal, high(self.pins, pin)));
            }
        }
        let outputs = if self.wiring == Wiring::Direct { 2 } else { 16 };
        all.extend((1..=outputs).map(|n| (Signal::Out(n), self.output(n))));
        if self.wiring == Wiring::Chain {
            all.extend((1..=16).map(|n| (Signal::In(n), self.chain.inputs >> (n - 1) & 1 != 0)));
            all.push((Signal::In(17), high(self.pins, self.board.probe)));
        } else {
            all.push((Signal::In(4), high(self.pins, self.board.inputs[3])));
        }
        all.sort_unstable();
        all
    }
}
