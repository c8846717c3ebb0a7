//! The two kinds of board behind a [`rig`](super::rig): the emulated one, and the firmware's machine on the desktop's chip.

use std::ops::{Deref, DerefMut};

use emulator::{Board, Edge, Format, Parity as LineParity, Plant, Stop};

use super::health::{self, Health};
use super::observe::{Observed, Observer, Sight};
use super::uart;
use crate::client::identity::Identity;
use desk::board::NativeBoard;
use desk::{Noticed, Sight as Noted};

/// A board with its plant. Times are in ticks since power-up, [`Hardware::ticks_per_second`] of them.
pub trait Hardware: Sized {
    /// Who sees what the firmware does.
    type Observer;

    /// Watches what the firmware does from now on; `None` when this image cannot be watched.
    fn observer(&mut self) -> Option<Self::Observer>;
    /// Runs to a time, or to the next thing that happens.
    fn run_until(&mut self, limit: u64) -> Stop;
    /// What the observer has seen where the board stopped.
    fn look(&mut self, observer: Option<&mut Self::Observer>, stop: Stop) -> Vec<Observed>;
    /// A board in the same state that can be asked on the side; `None` where asking changes nothing that counts.
    fn aside(&self) -> Option<Box<Self>>;

    /// Present time.
    fn cycles(&self) -> u64;
    /// Ticks in a second.
    fn ticks_per_second(&self) -> u64;
    /// Whether it has power.
    fn powered(&self) -> bool;

    /// Pulls the RST pin.
    fn reset_pin(&mut self);

    /// What is around the pins.
    fn plant(&self) -> impl Deref<Target = Plant>;
    /// See [`Hardware::plant`].
    fn plant_mut(&mut self) -> impl DerefMut<Target = Plant>;
    /// Keeps the edges of all signals from now on, or no more.
    fn record(&mut self, on: bool);
    /// Edges since the last call.
    fn take_edges(&mut self) -> Vec<Edge>;

    /// The host sends bytes on the line; returns when they are through.
    fn uart_send(&mut self, bytes: &[u8]) -> u64;
    /// What the host has received, and when.
    fn uart_take(&mut self) -> Vec<(u64, u8)>;
    /// Rate and parity of the host's end of the line.
    fn set_uart_format(&mut self, format: Format);
    /// Rate and parity of the board's end.
    fn uart_format(&mut self) -> Format;

    /// What broke the rules of the chip, for people.
    fn warnings(&self) -> Vec<String>;
    /// Forgets that.
    fn clear_warnings(&mut self);
    /// How the board fared.
    fn health(&self, identity: &Identity) -> Health;
}

impl Hardware for Board {
    type Observer = Observer;

    fn observer(&mut self) -> Option<Observer> {
        Observer::of(self)
    }
    fn run_until(&mut self, limit: u64) -> Stop {
        Board::run_until(self, limit)
    }
    fn look(&mut self, observer: Option<&mut Observer>, stop: Stop) -> Vec<Observed> {
        let Stop::Watched(at) = stop else { return Vec::new() };
        observer.and_then(|own| own.look(self, at)).into_iter().collect()
    }
    fn aside(&self) -> Option<Box<Board>> {
        Some(Box::new(self.clone()))
    }
    fn cycles(&self) -> u64 {
        Board::cycles(self)
    }
    fn ticks_per_second(&self) -> u64 {
        Board::ticks_per_second(self)
    }
    fn powered(&self) -> bool {
        Board::powered(self)
    }
    fn reset_pin(&mut self) {
        Board::reset_pin(self);
    }
    fn plant(&self) -> impl Deref<Target = Plant> {
        Board::plant(self)
    }
    fn plant_mut(&mut self) -> impl DerefMut<Target = Plant> {
        Board::plant_mut(self)
    }
    fn record(&mut self, on: bool) {
        Board::record(self, on);
    }
    fn take_edges(&mut self) -> Vec<Edge> {
        Board::take_edges(self)
    }
    fn uart_send(&mut self, bytes: &[u8]) -> u64 {
        Board::uart_send(self, bytes)
    }
    fn uart_take(&mut self) -> Vec<(u64, u8)> {
        Board::uart_take(self)
    }
    fn set_uart_format(&mut self, format: Format) {
        Board::set_uart_format(self, format);
    }
    fn uart_format(&mut self) -> Format {
        uart::format(self)
    }
    fn warnings(&self) -> Vec<String> {
        Board::warnings(self).iter().map(ToString::to_string).collect()
    }
    fn clear_warnings(&mut self) {
        Board::clear_warnings(self);
    }
    fn health(&self, identity: &Identity) -> Health {
        Health::of(self, identity)
    }
}

impl Hardware for NativeBoard {
    type Observer = ();

    fn observer(&mut self) -> Option<()> {
        self.take_seen();
        Some(())
    }
    fn run_until(&mut self, limit: u64) -> Stop {
        let unit = self.unit();
        NativeBoard::run_until(self, limit.div_ceil(unit));
        if self.cycles() >= limit { Stop::Time } else { Stop::Output }
    }
    fn look(&mut self, observer: Option<&mut ()>, _: Stop) -> Vec<Observed> {
        let (seen, unit) = (self.take_seen(), self.unit());
        let told = |noticed: Noticed| Observed {
            tick: noticed.tick * unit,
            pc: noticed.pc,
            sight: match noticed.sight {
                Noted::Event(kind, argument, value, commanded) => {
                    Sight::Event { kind, argument, value, commanded }
                }
                Noted::Beside(seen, byte) => Sight::Beside(seen, byte),
            },
        };
        observer.map(|()| seen.into_iter().map(told).collect()).unwrap_or_default()
    }
    // A request is served between two passes: it takes time of the line and changes nothing of the run.
    fn aside(&self) -> Option<Box<NativeBoard>> {
        None
    }
    fn cycles(&self) -> u64 {
        NativeBoard::cycles(self)
    }
    fn ticks_per_second(&self) -> u64 {
        NativeBoard::ticks_per_second(self)
    }
    fn powered(&self) -> bool {
        NativeBoard::powered(self)
    }
    fn reset_pin(&mut self) {
        NativeBoard::reset_pin(self);
    }
    fn plant(&self) -> impl Deref<Target = Plant> {
        NativeBoard::plant(self)
    }
    fn plant_mut(&mut self) -> impl DerefMut<Target = Plant> {
        NativeBoard::plant_mut(self)
    }
    fn record(&mut self, on: bool) {
        self.plant_mut().record(on);
    }
    fn take_edges(&mut self) -> Vec<Edge> {
        self.plant_mut().take_edges()
    }
    fn uart_send(&mut self, bytes: &[u8]) -> u64 {
        self.send(bytes)
    }
    fn uart_take(&mut self) -> Vec<(u64, u8)> {
        self.take()
    }
    // Both ends have the rate of the profile in use.
    fn set_uart_format(&mut self, _: Format) {}
    fn uart_format(&mut self) -> Format {
        Format { baud: self.rate(), parity: LineParity::None }
    }
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }
    fn clear_warnings(&mut self) {}
    fn health(&self, identity: &Identity) -> Health {
        health::Health {
            stack_free: identity.stack_free,
            stack_left: None,
            missed_deadlines: identity.missed_deadlines,
            late_events: 0,
            warnings: Vec::new(),
            violations: self.plant().violation_count,
        }
    }
}
