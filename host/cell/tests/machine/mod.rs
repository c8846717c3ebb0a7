//! A machine that goes straight ways at constant speed, for whole runs of a cell.

use cell::kernel::{Action, Cell, Frame};
use cell::law::{Law, Rest, Steps, Straight};
use cell::{Names, Port};
use std::sync::Arc;

/// Ports by number alone.
pub struct Plain;

impl Names for Plain {
    fn input(&self, _: &str) -> Option<u32> {
        None
    }
    fn output(&self, _: &str) -> Option<u32> {
        None
    }
    fn analog(&self, _: &str) -> Option<u32> {
        None
    }
    fn counter(&self, _: &str) -> Option<u32> {
        None
    }
    fn known(&self, _: Port) -> Vec<String> {
        Vec::new()
    }
    fn profile(&self) -> &str {
        "plain"
    }
    fn has_analog(&self) -> bool {
        true
    }
    fn has(&self, port: Port, n: u32) -> bool {
        port != Port::Counter && (port != Port::Analog || n < 5)
    }
    fn axes(&self) -> &str {
        "XYZ"
    }
}

/// 40 steps a mm in X, 50 in Y, and Z that counts downward with 100.
pub const SCALE: [f64; 3] = [40.0, 50.0, -100.0];

pub struct Machine {
    pub cell: Cell,
    pub now: u64,
    pub at: Steps,
    laws: u64,
    pub inputs: Vec<(u64, u32, bool)>,
}

impl Machine {
    pub fn new(text: &str) -> Self {
        let (scene, _) = cell::read(text, &Plain, &|_| None, &|_| Err("none".to_owned()))
            .unwrap_or_else(|problems| {
                panic!(
                    "{}",
                    problems.iter().map(|problem| problem.render("c", text)).collect::<String>()
                )
            });
        let cell = Cell::new(Arc::new(scene), Frame { scale: SCALE, start: [0.0; 3] });
        Self { cell, now: 0, at: [0; 4], laws: 0, inputs: Vec::new() }
    }

    fn take(&mut self, actions: Vec<Action>) {
        for action in actions {
            if let Action::Input(input, on) = action {
                self.inputs.push((self.now, input, on));
            }
        }
    }

    fn play(&mut self, law: &dyn Law, until: u64) {
        let mut calls = 0;
        while let Some(when) = self.cell.next_us(law, self.now).filter(|&when| when <= until) {
            assert!(when >= self.now);
            calls = if when == self.now { calls + 1 } else { 0 };
            assert!(calls < 100, "the cell wants to be called at {when} us again and again");
            self.now = when;
            let actions = self.cell.advance(law, when);
            self.take(actions);
        }
        self.now = until;
        let actions = self.cell.advance(law, until);
        self.take(actions);
    }

    /// Goes to a place in mm at a speed in mm/s.
    pub fn go(&mut self, to: [f64; 3], mm_s: f64) {
        let target: Steps =
            std::array::from_fn(
                |axis| if axis < 3 { (to[axis] * SCALE[axis]).round() as i32 } else { 0 },
            );
        let way = (0..3)
            .map(|axis| (f64::from(target[axis] - self.at[axis]) / SCALE[axis]).powi(2))
            .sum::<f64>()
            .sqrt();
        if way == 0.0 {
            return;
        }
        self.laws += 1;
        let takes = (way / mm_s * 1e6).ceil() as u64;
        let law = Straight { id: self.laws, from: self.at, to: target, begins: self.now, takes };
        self.play(&law, self.now + takes);
        self.at = target;
    }

    pub fn wait(&mut self, ms: u64) {
        self.play(&Rest(self.at), self.now + ms * 1000);
    }

    pub fn output(&mut self, output: u32, on: bool) {
        self.cell.output(output, on, &Rest(self.at), self.now);
        self.wait(0);
    }

    pub fn said(&self) -> Vec<String> {
        self.cell.log().iter().map(|event| event.json()).collect()
    }
}
