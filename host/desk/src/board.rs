//! A board without an emulator: the firmware's machine on a simulated chip, with the interface of the emulated board.

mod power;

use std::collections::VecDeque;

use emulator::{Config, Part, Plant, Wiring};
use firmware::machine::Controller;
use firmware::machine::chip::Clock as _;
use firmware::machine::controller::Effect as UnderWay;
use firmware::modbus::Slave;
use lang::part::F5529;
use lang::profile::{self, Profile};
use lang::record::BoardRecord;

use super::port::Uart;
use super::{Desk, Noticed, PER_MS, PER_US, cost};

/// Rates by their code in the board's record, bit/s.
const RATES: [u32; 4] = [9_600, 19_200, 57_600, 115_200];
/// Milliseconds that are jumped over at once.
const MOST_JUMPED: u32 = 1 << 20;
/// Causes of a reset, as the firmware tells them: power-up, the RST pin, the watchdog.
const POWER_UP: u8 = 1 << 2;
const WATCHDOG: u8 = 1;

/// A board.
pub struct NativeBoard {
    desk: Desk,
    controller: Box<Controller<Desk>>,
    line: Uart,
    slave: Slave,
    address: u8,
    /// Bit/s of the line.
    rate: u32,
    /// The machine's millisecond in which the world acted last, until it has looked.
    disturbed: Option<u16>,
    /// Outputs when it was last looked whether there is something to do.
    outputs: u16,
    /// Inputs and buttons that were on then.
    contacts: u32,
    /// Voltages at the analog inputs at the last look, mV.
    volts: [u16; 4],
}

impl NativeBoard {
    /// A board in a wiring that holds the profile `mill` and nothing else, powered up.
    pub fn new(wiring: Wiring) -> NativeBoard {
        let plant = Plant::around(&Part::F5529, wiring);
        let desk = Desk::new(plant);
        desk.put(F5529.profiles[0], &BoardRecord::DEFAULT.sealed().to_bytes());
        let controller = Controller::boxed(desk.clone());
        let mut board = NativeBoard {
            desk,
            controller,
            line: Uart::default(),
            slave: Slave::default(),
            address: 1,
            rate: RATES[0],
            disturbed: None,
            outputs: 0,
            contacts: 0,
            volts: [0; 4],
        };
        board.boot(POWER_UP);
        board
    }

    /// A board that has the profile of a machine, powered up.
    pub fn with(profile: &Profile) -> NativeBoard {
        let mut board = NativeBoard::new(match profile.wiring {
            profile::Wiring::Direct => Wiring::Direct,
            profile::Wiring::Chain => Wiring::Chain,
        });
        let record = BoardRecord::of(profile, 1);
        board.desk.put(F5529.profiles[0], &record.to_bytes());
        let more = F5529.profiles[0] + BoardRecord::SIZE as u16;
        board.desk.put(more, &record.more.to_bytes());
        board.power_cycle();
        board
    }

    /// As [`NativeBoard::new`], wired as an emulated board is.
    pub fn of(config: &Config) -> NativeBoard {
        NativeBoard::new(config.wiring)
    }

    /// From a reset to the first pass, as `main` of the F5529's image does it.
    fn boot(&mut self, cause: u8) {
        let desk = self.desk.clone();
        desk.clear_ram();
        desk.reset();
        self.controller = Controller::boxed(desk.clone());
        let controller = &mut self.controller;
        let record = controller.record.clone();
        desk.set_up(&record);
        controller.motor.pwm.open(&desk, record.more());
        controller.open_aout();
        controller.open_analog();
        controller.motor.power = controller.full_power();
        controller.reset.cause = cause;
        // Stop held at reset: 9600 8N1, address 1, whatever the profile says.
        let stop = firmware::machine::chip::Pins::buttons(&desk) & 1 != 0;
        let (address, code) = if stop { (1, 0) } else { (record.address, record.rate) };
        self.address = address;
        self.rate = RATES[usize::from(code & 3)];
        self.line.open(self.rate);
        self.slave = Slave::default();
        controller.mount();
    }

    /// One pass of the main loop, and the time that it takes.
    fn pass(&mut self) {
        let from = self.desk.ticks();
        self.line.advance(from);
        let controller = &mut self.controller;
        controller.begin_pass();
        controller.serve_line(0, &mut self.line, &mut self.slave, self.address);
        controller.pass();
        if controller.wants_reset() {
            self.boot(WATCHDOG);
            return;
        }
        // The same pass goes on with what the engine asks for next.
        if self.desk.is_idle() {
            return;
        }
        let turned = self.desk.ticks() / PER_MS != from / PER_MS;
        self.desk.spend(cost::PASS + if turned { cost::MILLISECOND } else { 0 });
    }

    /// Runs to a time in ticks of the step timer, or to the pass in which something is seen or an output changes.
    pub fn run_until(&mut self, limit: u64) {
        while self.desk.ticks() < limit {
            if !self.powered() {
                return self.lie(limit);
            }
            self.pass();
            if self.desk.has_seen() || self.desk.plant().output_has_changed() {
                return;
            }
            self.skip(limit);
        }
    }

    /// Where nothing can happen before the next millisecond, character or event of the engine, time goes on to there.
    fn skip(&mut self, limit: u64) {
        let now = self.desk.ticks();
        let controller = &self.controller;
        let waits = controller.motor.rests() && !controller.session.executes();
        if !waits || self.line.is_busy() {
            return;
        }
        let turn = (now / PER_MS + 1) * PER_MS;
        let next = self.line.next().map_or(turn, |next| next.min(turn)).min(limit);
        self.desk.spend(next.saturating_sub(now));
    }

    /// How far the statement under way has come, to see whether a pass has brought it further.
    fn progress(&self) -> (u8, u8, u8, u8) {
        let Controller { program, session, motor, .. } = &*self.controller;
        let UnderWay { code, phase, .. } = program.effect;
        (code, phase, session.state, motor.moving())
    }

    /// One pass of a driven program ([`super::driven`]). Where it has brought nothing further time goes on to the next
    /// millisecond or change of the step engine, but not beyond `limit`, ticks. Gives whether anything has come of it:
    /// in the program, at the step engine, at the outputs, or to be seen.
    pub fn drive(&mut self, limit: u64) -> bool {
        self.drive_by(limit, false)
    }

    /// The same for an engine that asks for nothing but that time goes on.
    pub fn drive_on(&mut self, limit: u64) -> bool {
        self.drive_by(limit, true)
    }

    fn drive_by(&mut self, limit: u64, waits: bool) -> bool {
        let (before, changes) = (self.progress(), self.desk.changes());
        let asked = self.desk.is_asked() || self.desk.owed() != 0;
        self.pass();
        // A statement that is done in the pass in which it begins leaves no trace of itself.
        let further = asked
            || self.progress() != before
            || self.desk.has_seen()
            || self.desk.changes() != changes && !self.controller.motor.is_fed();
        if further || !waits && self.desk.is_idle() {
            return true;
        }
        let now = self.desk.ticks();
        let turn = (now / PER_MS + 1) * PER_MS;
        self.desk.spend_to_change(turn.min(limit));
        self.jump(limit);
        self.desk.changes() != changes || self.desk.plant().output_has_changed()
    }

    /// The world has acted.
    pub fn disturb(&mut self) {
        self.disturbed = Some(self.controller.clock.tick);
    }

    /// Idle milliseconds are jumped over, but none that ends after `limit`, ticks; at the beginning of one.
    fn jump(&mut self, limit: u64) {
        let now = self.desk.ticks();
        let tick = self.controller.clock.tick;
        // New outputs come to the pins with the next millisecond, and the world may answer.
        let outputs = self.controller.io.outputs;
        if std::mem::replace(&mut self.outputs, outputs) != outputs
            || self.desk.plant().output_has_changed()
        {
            self.disturb();
        }
        // Motors and what is around them have changed inputs.
        let contacts = self.desk.plant().contacts();
        let volts = self.desk.plant().volts();
        if std::mem::replace(&mut self.contacts, contacts) != contacts
            || std::mem::replace(&mut self.volts, volts) != volts
        {
            self.disturb();
        }
        // The inputs that the machine knows are those of the world only when it has looked since that acted.
        let looked = self.disturbed.is_none_or(|at| tick.wrapping_sub(at) >= 2);
        // A pass that went on beyond the end of a millisecond has not begun the next one yet.
        let behind = u32::from(self.desk.millis().wrapping_sub(tick));
        if !now.is_multiple_of(PER_MS) || !(1..=2).contains(&behind) || !looked {
            return;
        }
        self.disturbed = None;
        let most = u32::try_from((limit.saturating_sub(now)) / PER_MS).unwrap_or(MOST_JUMPED);
        let most = most.min(MOST_JUMPED) + behind - 1;
        let ms = self.controller.idle_ms(most);
        if ms != 0 {
            self.desk.spend(u64::from(ms.saturating_sub(behind - 1)) * PER_MS);
            self.controller.skip(ms);
            return;
        }
        let ms = self.controller.moving_ms(most);
        if ms != 0 {
            let late = ms.min(behind - 1);
            self.controller.skip(late);
            self.ride(ms - late);
        }
    }

    /// Milliseconds of a motion, at the beginning of one: as many as told, but only until a segment of the step engine is
    /// taken or ends, or an input changes.
    fn ride(&mut self, most: u32) {
        let (now, changes) = (self.desk.ticks(), self.desk.changes());
        let due = self.desk.plant().due();
        let mut begun = 0;
        for n in 1..=most {
            self.desk.spend_to_change(now + u64::from(n) * PER_MS);
            begun = n;
            let plant = self.desk.plant();
            if self.desk.changes() != changes
                || plant.contacts() != self.contacts
                || plant.due() != due
            {
                break;
            }
        }
        self.controller.skip(begun);
    }

    /// The chip.
    pub fn desk(&self) -> &Desk {
        &self.desk
    }

    /// The machine.
    pub fn controller(&self) -> &Controller<Desk> {
        &self.controller
    }

    /// See [`NativeBoard::controller`].
    pub fn controller_mut(&mut self) -> &mut Controller<Desk> {
        &mut self.controller
    }

    /// What was seen since the last call.
    pub fn take_seen(&mut self) -> VecDeque<Noticed> {
        self.desk.take_seen()
    }

    /// Time since power-up, ticks of the plant.
    pub fn cycles(&self) -> u64 {
        self.desk.ticks() * self.unit()
    }

    /// Ticks of the plant in a second.
    pub fn ticks_per_second(&self) -> u64 {
        self.desk.plant().ticks_per_second()
    }

    /// Ticks of the plant in one of the step timer.
    pub fn unit(&self) -> u64 {
        self.desk.0.unit
    }

    /// What is around the pins.
    pub fn plant(&self) -> std::cell::Ref<'_, Plant> {
        self.desk.plant()
    }

    /// See [`NativeBoard::plant`].
    pub fn plant_mut(&mut self) -> std::cell::RefMut<'_, Plant> {
        self.desk.plant_mut()
    }

    /// The host sends bytes on the line; returns when they are through, in ticks of the plant.
    pub fn send(&mut self, bytes: &[u8]) -> u64 {
        self.line.send(self.desk.ticks(), bytes) * self.unit()
    }

    /// What the host has received, with its times in ticks of the plant.
    pub fn take(&mut self) -> Vec<(u64, u8)> {
        let unit = self.unit();
        let taken = self.line.take(self.desk.ticks());
        taken.into_iter().map(|(at, byte)| (at * unit, byte)).collect()
    }

    /// Bit/s of the line.
    pub fn rate(&self) -> u32 {
        self.rate
    }

    /// The profile in use.
    pub fn record(&self) -> &BoardRecord {
        &self.controller.record
    }

    /// Pulls the RST pin.
    pub fn reset_pin(&mut self) {
        self.boot(0);
    }

    /// The program area and the information memory.
    pub fn flash_contents(&self) -> Vec<u8> {
        self.desk.flash()
    }
}

impl Desk {
    /// What a reset makes of the chip: steps cease, pins are at rest.
    fn reset(&self) {
        self.rest_pins();
        self.0.guard.set(super::Guarded::default());
        self.0.reset.set(self.ticks() / PER_MS * PER_MS);
    }

    /// Steps cease, and pins are at rest.
    pub(super) fn rest_pins(&self) {
        *self.0.engine.borrow_mut() = super::Engine::default();
        self.0.falls.set([None; 3]);
        self.0.turn.set(None);
        self.plant_mut().cut_short();
        self.reset_pins();
    }

    /// What the profile says of pulses and of inputs that stop the engine.
    fn set_up(&self, record: &BoardRecord) {
        let width = u64::from(record.pulse.max(lang::part::SHORT_PULSE_US));
        self.0.pulse.set(width * PER_US);
        self.0.setup.set(u64::from(record.setup) * PER_US);
        let steps = self.0.pins.step.iter().fold(0, |pins, pin| pins | 1 << pin);
        self.0.turned.set(if record.flags & BoardRecord::STEP_LOW != 0 { steps } else { 0 });
        let mut guard = self.0.guard.get();
        (guard.falling, guard.invert) = (record.falling(), record.input_invert);
        self.0.guard.set(guard);
        self.0.set_dirs(&mut self.plant_mut(), self.ticks(), 0);
    }

    fn has_seen(&self) -> bool {
        !self.0.seen.borrow().is_empty()
    }

    fn forget_run(&self) {
        self.0.marked.set(false);
    }

    fn plant(&self) -> std::cell::Ref<'_, Plant> {
        self.0.plant.borrow()
    }

    fn plant_mut(&self) -> std::cell::RefMut<'_, Plant> {
        self.0.plant.borrow_mut()
    }

    fn flash(&self) -> Vec<u8> {
        self.0.memory.borrow().flash()
    }

    fn set_flash(&self, contents: &[u8]) {
        self.0.memory.borrow_mut().set_flash(contents);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::driven::{self, Request};
    use emulator::plant::Contact;
    use lang::axis::Axis;
    use lang::effect::{Coord, Dist, Effect, Frame, Rate};
    use lang::plain::Plain;
    use lang::vm::encode::encode;
    use lang::wire::{CRC_START, crc16};

    #[test]
    fn two_boards_in_one_process_know_nothing_of_each_other() {
        let [mut one, mut other] = [Wiring::Chain; 2].map(NativeBoard::new);
        // Function 5: output 1 on.
        let body = [1, 5, 0, 0, 0xFF, 0];
        let crc = body.iter().fold(CRC_START, |crc, &byte| crc16(crc, byte));
        let frame = [&body[..], &crc.to_le_bytes()].concat();
        one.send(&frame);
        for ms in 1..=100 {
            for board in [&mut one, &mut other] {
                while board.desk.ticks() < ms * PER_MS {
                    board.run_until(ms * PER_MS);
                    board.plant_mut().take_output_changes();
                }
            }
        }
        assert!(one.plant().output(1));
        assert!(!other.plant().output(1));
        let heard: Vec<u8> = one.take().into_iter().map(|(_, byte)| byte).collect();
        assert_eq!(heard, frame);
        assert!(other.take().is_empty());
    }

    /// Runs effects one after the other, `most` ticks at a time; the places at the end and the ticks at which each was
    /// done.
    fn drives(effects: &[Effect], most: u64) -> ([i32; 3], Vec<u64>) {
        let mill = profile::Profile::built_in("mill").unwrap();
        let mut board = NativeBoard::with(&mill);
        board.plant_mut().switches[0] = Some(Contact { axis: 0, position: -700, above: false });
        board.desk.drive(&mill);
        board.controller_mut().begin_at(driven::IMAGE);
        let mut done = Vec::new();
        for effect in effects {
            let own = encode(effect).unwrap();
            let (mut code, mut values) = ([0; 4], [0; 5]);
            code[..own.code().len()].copy_from_slice(own.code());
            values[..own.values().len()].copy_from_slice(own.values());
            let (length, count) = (own.code().len(), own.values().len());
            board.desk.ask(Request::Code { code, length, values, count, more: false });
            while !board.desk.is_idle() {
                let now = board.desk.ticks();
                assert!(now < 60_000 * PER_MS, "{effect:?} has no end");
                board.drive(now + most);
            }
            done.push(board.desk.ticks());
        }
        (board.desk.0.engine.borrow().count, done)
    }

    /// Few passes: what Miri looks at, the controller that is written into zeros and what it then does.
    #[test]
    fn a_short_move_comes_to_its_place() {
        let to = Some(Coord { value: Dist::Um(500), frame: Frame::Work });
        let effects = [
            Effect::SetFeed(Rate::Um(20_000)),
            Effect::Linear { rapid: false, to: [to, None, to], exact: true },
            Effect::StopAxe(Axis::X),
        ];
        let ([x, y, z], done) = drives(&effects, u64::MAX / 2);
        assert!(x > 0 && y == 0 && z > 0, "{x} {y} {z}");
        assert!(done[1] > 25 * PER_MS, "{done:?}");
    }

    #[test]
    #[cfg_attr(miri, ignore = "takes an hour")]
    fn milliseconds_of_a_motion_that_are_ridden_over_are_those_of_passes() {
        let at = |um| Some(Coord { value: Dist::Um(um), frame: Frame::Work });
        let line = |x, y, rapid| Effect::Linear { rapid, to: [at(x), at(y), None], exact: false };
        let effects = [
            Effect::Home { axis: Axis::X, query: false },
            Effect::SetFeed(Rate::Um(20_000)),
            line(30_000, 10_000, false),
            line(31_000, 12_000, false),
            line(31_000, 40_000, false),
            Effect::Plain(Plain::Wait, [321, 0]),
            line(0, 0, true),
            Effect::StopAxe(Axis::Y),
            Effect::WaitMove(None),
        ];
        let (at_once, ridden) = drives(&effects, u64::MAX / 2);
        let (by_passes, passed) = drives(&effects, PER_MS);
        assert_eq!(at_once, by_passes);
        assert!(at_once == [0; 3] && ridden.len() == effects.len());
        for (n, (ridden, passed)) in ridden.iter().zip(&passed).enumerate() {
            assert!(ridden.abs_diff(*passed) < PER_MS, "{n}: {ridden} for {passed}");
        }
    }
}
