//! A machine for sessions, without a board: lines take some steps each.

use std::collections::VecDeque;

use lang::fault::Fault;
use lang::profile::Profile;
use lang::wire::RunState;

use crate::grbl::desk::{Deed, View};
use crate::grbl::keep::Kept;
use crate::grbl::order::{Order, Target};
use crate::grbl::session::Session;

/// Steps of a ramp.
const RAMP: u32 = 2;
/// Motor steps of a millimetre of `mill`.
const SCALE: i32 = 100;

/// See the module.
pub struct Machine {
    pub view: View,
    pub queue: VecDeque<(u32, Vec<Order>)>,
    /// Steps that each line takes.
    pub pace: u32,
    left: u32,
    handed: u32,
    hold: bool,
    ramp: u32,
    stops: u32,
    stay: bool,
    /// Outputs that wait to be switched, as on the desk.
    coils: Vec<(u16, bool)>,
    /// Outputs that are on outside a run.
    pub on: Vec<u16>,
    /// What has been carried out.
    pub done: Vec<Order>,
    /// What a probe finds; none where it misses.
    pub contact: Option<[i32; 3]>,
}

impl Machine {
    pub fn new() -> Machine {
        let view = View { state: Some(RunState::Ready), homed: [true; 3], ..View::default() };
        Machine {
            view,
            queue: VecDeque::new(),
            pace: 2,
            left: 0,
            handed: 0,
            hold: false,
            ramp: 0,
            stops: 0,
            stay: false,
            coils: Vec::new(),
            on: Vec::new(),
            done: Vec::new(),
            contact: None,
        }
    }

    /// Takes what a session wants.
    pub fn take(&mut self, deeds: Vec<Deed>) {
        for deed in deeds {
            match deed {
                Deed::Line { number, epoch, orders } => {
                    assert!(!orders.is_empty(), "a line without orders");
                    if epoch == self.view.epoch {
                        assert!(self.stops == self.view.stops, "a line behind a stop");
                        let before = self.queue.back().map_or(self.view.done, |(n, _)| *n);
                        assert!(number > before, "line {number} behind {before}");
                        self.queue.push_back((number, orders));
                    }
                }
                Deed::Hold => self.hold = true,
                Deed::Unhold => self.hold = false,
                Deed::Resume => {
                    self.hold = false;
                    let waits =
                        matches!(self.view.state, Some(RunState::Paused | RunState::WaitStart));
                    if waits {
                        self.view.state = Some(RunState::Running);
                        self.left = self.left.min(1);
                        if self.halted() {
                            self.end_line();
                        }
                    }
                }
                Deed::Stop => {
                    self.queue.truncate(usize::from(self.view.ours && !self.queue.is_empty()));
                    (self.hold, self.ramp) = (false, RAMP);
                    self.stops += 1;
                    self.coils.clear();
                }
                Deed::Acknowledge => {
                    if self.view.state == Some(RunState::Fault) {
                        self.view.state = Some(RunState::Ready);
                    }
                }
                Deed::Stay(stay) => self.stay = stay,
                Deed::Feed(percent) => assert!((10..=200).contains(&percent)),
                Deed::Rapid(percent) => assert!([25, 50, 100].contains(&percent)),
                Deed::Coil(n, on) => self.coils.push((n, on)),
            }
        }
    }

    fn halted(&self) -> bool {
        self.queue.front().is_some_and(|(_, orders)| orders.contains(&Order::Halt))
    }

    /// Whether an output would stay on with nobody there.
    pub fn stays(&self) -> bool {
        self.stay
    }

    /// Whether nothing moves nor will.
    pub fn rests(&self) -> bool {
        self.queue.is_empty() && self.stops == self.view.stops && !self.view.moving
    }

    /// What ran has ended with a fault.
    pub fn fail(&mut self, fault: Fault) {
        self.queue.clear();
        let handed = self.handed;
        let view = &mut self.view;
        (view.faults, view.epoch) = (view.faults + 1, view.epoch + 1);
        (view.begun, view.done, view.fault) = (handed, handed, Some(fault));
        (view.state, view.ours, view.moving) = (Some(RunState::Fault), false, false);
        self.left = 0;
    }

    /// A moment passes.
    pub fn step(&mut self) {
        for (n, on) in std::mem::take(&mut self.coils) {
            self.on.retain(|other| *other != n);
            self.on.extend(on.then_some(n));
        }
        if self.stops != self.view.stops {
            if self.ramp > 0 && self.view.ours {
                self.ramp -= 1;
                self.view.state = Some(RunState::Stopping);
                return;
            }
            self.queue.clear();
            let view = &mut self.view;
            (view.stops, view.epoch) = (self.stops, view.epoch + 1);
            (view.begun, view.done) = (self.handed, self.handed);
            (view.ours, view.moving) = (false, false);
            if view.state != Some(RunState::Fault) {
                view.state = Some(RunState::Ready);
            }
            self.left = 0;
            return;
        }
        if matches!(self.view.state, Some(RunState::Fault | RunState::WaitStart)) {
            return;
        }
        if self.hold {
            self.view.state = match self.view.state {
                Some(RunState::Running) => Some(RunState::Stopping),
                Some(RunState::Stopping) => Some(RunState::Paused),
                other => other,
            };
            self.view.moving = false;
            return;
        }
        let Some((number, orders)) = self.queue.front() else {
            (self.view.ours, self.view.state) = (false, Some(RunState::Ready));
            self.view.moving = false;
            return;
        };
        let number = *number;
        self.handed = number;
        (self.view.ours, self.view.moving) = (true, true);
        self.view.begun = number;
        self.view.state = Some(RunState::Running);
        if orders.contains(&Order::Halt) {
            self.view.state = Some(RunState::WaitStart);
            self.view.moving = false;
            return;
        }
        if self.left == 0 {
            self.left = self.pace;
        }
        self.left -= 1;
        if self.left == 0 {
            self.end_line();
        }
    }

    fn end_line(&mut self) {
        let Some((number, orders)) = self.queue.pop_front() else { return };
        for order in &orders {
            match order {
                Order::Rapid(to) | Order::Line { to, .. } | Order::Arc { to, .. } => self.go(to),
                Order::Home => self.view.steps = [0; 3],
                Order::Probe { axis, limit, .. } => {
                    self.view.met = self.contact.is_some();
                    match self.contact {
                        Some(place) => (self.view.probed, self.view.steps) = (place, place),
                        None => self.view.steps[*axis] = limit * SCALE / 1000,
                    }
                }
                _ => {}
            }
        }
        self.done.extend(orders);
        self.view.done = number;
        if self.queue.is_empty() {
            self.view.moving = false;
        }
    }

    fn go(&mut self, to: &Target) {
        for (steps, um) in self.view.steps.iter_mut().zip(to) {
            if let Some(um) = um {
                *steps = um * SCALE / 1000;
            }
        }
    }
}

/// A session and its machine.
pub struct Bench {
    pub session: Session,
    pub machine: Machine,
    /// All that the client has read.
    pub heard: String,
}

impl Bench {
    /// A client that has just come to `mill`.
    pub fn new() -> Bench {
        Bench::on("mill")
    }

    pub fn on(name: &str) -> Bench {
        let profile = Profile::built_in(name).expect("built in");
        let mut bench = Bench {
            session: Session::new(&profile, Kept::default()),
            machine: Machine::new(),
            heard: String::new(),
        };
        let view = bench.machine.view.clone();
        bench.session.open(&view);
        bench.pass();
        bench
    }

    fn pass(&mut self) {
        self.machine.take(self.session.deeds());
        let out = self.session.outgoing();
        self.heard += std::str::from_utf8(&out).expect("ASCII");
    }

    /// The client sends bytes.
    pub fn send(&mut self, bytes: &[u8]) {
        let view = self.machine.view.clone();
        self.session.take(bytes, &view);
        self.pass();
    }

    /// A moment passes.
    pub fn step(&mut self) {
        self.machine.step();
        let view = self.machine.view.clone();
        self.session.tick(&view);
        self.pass();
    }

    /// Many moments pass.
    pub fn wait(&mut self) {
        for _ in 0..400 {
            self.step();
        }
    }

    /// What the client hears in answer to a line, with all that it waits for.
    pub fn ask(&mut self, line: &str) -> String {
        self.heard.clear();
        self.send(format!("{line}\n").as_bytes());
        self.wait();
        std::mem::take(&mut self.heard)
    }

    /// The report.
    pub fn status(&mut self) -> String {
        let before = std::mem::take(&mut self.heard);
        self.send(b"?");
        std::mem::replace(&mut self.heard, before)
    }

    /// The state in the report.
    pub fn state(&mut self) -> String {
        let report = self.status();
        let end = report.find('|').unwrap_or(report.len());
        report.get(1..end).unwrap_or_default().to_owned()
    }
}
