//! What a world asks of the cell beside it, and does to it.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use cell::problem::nearest;
use cell::scene::Scene;
use cell::things;
use rhai::FnPtr;

/// Where a thing of a cell is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// `stands`, `held` or `gone`.
    pub state: &'static str,
    /// Name of the place that it lies in; empty for none.
    pub place: String,
    /// Middle of its bottom in the cell's frame, um; 0 for what is gone.
    pub um: [i32; 3],
}

/// A cell that runs, as a world sees it. Times are us of the run, motors steps from power-up.
pub trait Things {
    /// Where a thing is; `None`: there is none of that name now.
    fn where_is(&self, name: &str, motors: [i64; 3]) -> Option<Found>;
    /// Somebody takes a thing away, or puts it where it was at the start.
    fn hands(&self, name: &str, puts: bool, us: u64, motors: [i64; 3]);
    /// What the cell gives to an input counts no more, until that is `None`.
    fn force(&self, n: i32, on: Option<bool>);
}

/// The cell's side of a world.
#[derive(Default)]
pub struct Beside {
    scene: Option<Arc<Scene>>,
    things: Option<Rc<dyn Things>>,
    /// Time, us, and motors of the call that is under way.
    present: (u64, [i64; 3]),
    /// Who waits for a thing to be taken.
    hooks: Vec<(String, FnPtr)>,
    /// Inputs that hang, from 1.
    forced: BTreeMap<i32, bool>,
    touched: bool,
}

impl std::fmt::Debug for Beside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Beside").field("forced", &self.forced).finish_non_exhaustive()
    }
}

impl Beside {
    /// The cell beside a world that begins.
    pub fn of(scene: Option<Arc<Scene>>) -> Self {
        Self { scene, ..Self::default() }
    }

    /// The cell runs now.
    pub fn join(&mut self, things: Rc<dyn Things>) {
        for (&n, &on) in &self.forced {
            things.force(n, Some(on));
        }
        self.things = Some(things);
    }

    /// Time, us, and motors of what comes next.
    pub fn stand(&mut self, us: u64, motors: [i64; 3]) {
        self.present = (us, motors);
    }

    /// Whether the cell was changed since the last call.
    pub fn take_touch(&mut self) -> bool {
        std::mem::take(&mut self.touched)
    }

    /// Whether a name is one that `at_take` may wait for: a feeder, a part, a conveyor or a thing.
    ///
    /// # Errors
    /// It is none: in words.
    pub fn source(&self, name: &str) -> Result<(), String> {
        let scene = self.cell()?;
        let feeders = scene.feeders.iter().map(|own| own.name.as_str());
        let parts = scene.parts.iter().map(|own| own.name.as_str());
        let belts = scene.conveyors.iter().map(|own| own.name.as_str());
        let all: Vec<&str> = feeders.chain(parts).chain(belts).collect();
        if all.contains(&name) { Ok(()) } else { self.thing(name, &all) }
    }

    fn cell(&self) -> Result<&Scene, String> {
        self.scene.as_deref().ok_or_else(|| {
            "there is no cell: write NAME.cell.toml beside the script, or give --cell FILE"
                .to_owned()
        })
    }

    /// Whether there is, or may come, a thing of this name; `others` may be meant, too.
    fn thing(&self, name: &str, others: &[&str]) -> Result<(), String> {
        let scene = self.cell()?;
        // Belts and feeders that advance bring things that nobody has counted.
        let comes = name.rsplit_once('.').is_some_and(|(from, n)| {
            let counts = n.parse::<u32>().is_ok_and(|n| n > 0);
            let feeders = scene.feeders.iter().filter(|own| own.advances());
            let belts = scene.conveyors.iter().filter(|own| own.feeds.is_some());
            counts
                && feeders
                    .map(|own| &own.name)
                    .chain(belts.map(|own| &own.name))
                    .any(|own| own == from)
        });
        let all = things::all(scene);
        if comes || all.iter().any(|thing| thing.name == name) {
            return Ok(());
        }
        let known = all.iter().map(|thing| thing.name.as_str()).chain(others.iter().copied());
        Err(match nearest(name, known) {
            Some(meant) => format!("the cell has no \"{name}\"; \"{meant}\" is meant?"),
            None => format!("the cell has no \"{name}\""),
        })
    }

    /// Where a thing is.
    ///
    /// # Errors
    /// There is no such thing, or no cell: in words.
    pub fn where_is(&self, name: &str) -> Result<Found, String> {
        self.thing(name, &[])?;
        if let Some(things) = &self.things {
            return Ok(things.where_is(name, self.present.1).unwrap_or_else(Found::gone));
        }
        // Before the run everything is where the file says.
        let scene = self.cell()?;
        let thing = things::all(scene).into_iter().find(|thing| thing.name == name);
        Ok(thing.map_or_else(Found::gone, |thing| Found::of(scene, &thing.place, [0.0; 3])))
    }

    /// Somebody takes a thing away, or puts it back. Gives whether the cell runs: else it is done when it does.
    ///
    /// # Errors
    /// There is no such thing, or no cell: in words.
    pub fn hands(&mut self, name: &str, puts: bool) -> Result<bool, String> {
        self.thing(name, &[])?;
        let Some(things) = &self.things else { return Ok(false) };
        let (us, motors) = self.present;
        things.hands(name, puts, us, motors);
        self.touched = true;
        Ok(true)
    }

    /// From now on the input hangs in this state; with `None` no more.
    pub fn force(&mut self, n: i32, on: Option<bool>) {
        match on {
            Some(on) => self.forced.insert(n, on),
            None => self.forced.remove(&n),
        };
        if let Some(things) = &self.things {
            things.force(n, on);
            self.touched = true;
        }
    }

    /// Whether an input hangs.
    pub fn is_forced(&self, n: i32) -> bool {
        self.forced.contains_key(&n)
    }

    /// Remembers an `at_take`.
    ///
    /// # Errors
    /// There are too many, no such source, or no cell.
    pub fn hook(&mut self, name: &str, call: FnPtr) -> Result<(), String> {
        self.source(name)?;
        if self.hooks.len() >= 1_000 {
            return Err("more than 1000 at_take hooks".to_owned());
        }
        self.hooks.push((name.to_owned(), call));
        Ok(())
    }

    /// Functions that wait for a thing of this name, which was taken.
    pub fn waits_for(&self, thing: &str) -> Vec<FnPtr> {
        let feeder = thing.rsplit_once('.').map(|(feeder, _)| feeder);
        let part = self.scene.as_deref().and_then(|scene| {
            let own = scene.feeders.iter().find(|own| Some(own.name.as_str()) == feeder)?;
            scene.parts.get(own.part)
        });
        let is = |name: &str| {
            name == thing || Some(name) == feeder || part.is_some_and(|part| part.name == name)
        };
        self.hooks.iter().filter(|(name, _)| is(name)).map(|(_, call)| call.clone()).collect()
    }
}

impl Found {
    fn gone() -> Self {
        Self { state: "gone", place: String::new(), um: [0; 3] }
    }

    /// Of a thing in a cell, whose tool has its tip there, mm.
    pub fn of(scene: &Scene, place: &things::Where, tip: [f64; 3]) -> Self {
        let um = |at: [f64; 3]| at.map(|mm| (mm * 1000.0).round() as i32);
        match *place {
            things::Where::Stands(at) => {
                let lies = scene.places.iter().find(|own| own.block.holds(at));
                let place = lies.map(|own| own.name.clone()).unwrap_or_default();
                Self { state: "stands", place, um: um(at) }
            }
            things::Where::Held(offset) => {
                let at = std::array::from_fn(|axis| tip[axis] + offset[axis]);
                Self { state: "held", place: String::new(), um: um(at) }
            }
            things::Where::Gone => Self::gone(),
        }
    }
}
