//! The things of a cell while it runs: which there are, where each is, and where it falls.

use super::scene::{Block, Form, Scene, V3};

/// What the name of a second part ends in that came with a part by the fault `double`.
pub const TWIN: &str = ".double";

/// Where a thing is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Where {
    /// It stands with its bottom's middle here.
    Stands(V3),
    /// It hangs on a tool: from the tip to its bottom's middle, mm.
    Held(V3),
    /// Not there: missing, removed, or fallen where nothing is.
    Gone,
}

/// A thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// `chip`, or `tray.3` of a feeder.
    pub name: String,
    /// Index of its part.
    pub part: usize,
    /// Index of its feeder and of its pocket.
    pub feeder: Option<(usize, usize)>,
    /// Its form, turned as it lies.
    pub form: Form,
    /// Where it is.
    pub place: Where,
    /// Where it was at the start.
    pub home: Where,
    /// The deepest that it has fallen, mm.
    pub fell: f64,
    /// How often it was taken.
    pub taken: u32,
    /// It lies in a place that takes any number, and is out of everybody's way.
    pub stored: bool,
}

impl Thing {
    /// The boxes that cover it where it stands in the way of others.
    #[must_use]
    pub fn standing(&self) -> Vec<Block> {
        match self.place {
            Where::Stands(at) if !self.stored => self.form.blocks(at, SLICES),
            _ => Vec::new(),
        }
    }

    /// The boxes that cover it where it hangs, from the tip.
    #[must_use]
    pub fn hanging(&self) -> Vec<Block> {
        match self.place {
            Where::Held(offset) => self.form.blocks(offset, SLICES),
            _ => Vec::new(),
        }
    }
}

/// Boxes that a turned or round thing is cut into.
const SLICES: u32 = 8;

/// Things of one feeder beyond which a scene is refused.
pub const MOST: usize = 20_000;

/// The things of a scene, single parts first, then those of feeders row by row.
#[must_use]
pub fn all(scene: &Scene) -> Vec<Thing> {
    let mut things = Vec::new();
    for (index, part) in scene.parts.iter().enumerate() {
        let Some(at) = part.at else { continue };
        things.push(thing(part.name.clone(), index, None, part.form, Where::Stands(at)));
    }
    for (index, feeder) in scene.feeders.iter().enumerate() {
        let form = scene.parts[feeder.part].form;
        for (pocket, &(at, turn)) in feeder.pockets.iter().enumerate() {
            let place =
                if feeder.empty.contains(&pocket) { Where::Gone } else { Where::Stands(at) };
            let turned = Form { turn_deg: form.turn_deg + turn, ..form };
            things.push(thing(
                format!("{}.{}", feeder.name, pocket + 1),
                feeder.part,
                Some((index, pocket)),
                turned,
                place,
            ));
        }
    }
    things
}

/// A thing as it is at the start.
pub(super) fn thing(
    name: String,
    part: usize,
    feeder: Option<(usize, usize)>,
    form: Form,
    place: Where,
) -> Thing {
    Thing { name, part, feeder, form, place, home: place, fell: 0.0, taken: 0, stored: false }
}

/// Where a thing comes to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct Landing {
    /// Height of its bottom, mm; `None`: nothing is below.
    pub z: Option<f64>,
    /// What it lies on.
    pub on: String,
    /// Whether more than half of it stands over an edge.
    pub unstable: bool,
}

/// A thing whose bottom's middle is let go at `at` falls straight down onto the highest top below its middle. Nothing
/// bounces, rolls or tips. It may have been pressed into what it lies on by up to `press` mm.
#[must_use]
pub fn landing(
    scene: &Scene,
    fixtures: &[Vec<Block>],
    things: &[Thing],
    which: usize,
    at: V3,
    press: f64,
) -> Landing {
    let mut best: Option<(f64, String, Block)> = None;
    let mut look = |block: &Block, top: f64, name: &str| {
        let below = (0..2).all(|axis| (block.low[axis]..=block.high[axis]).contains(&at[axis]));
        if below && top <= at[2] + press && best.as_ref().is_none_or(|(z, ..)| top > *z) {
            best = Some((top, name.to_owned(), *block));
        }
    };
    for (fixture, blocks) in scene.fixtures.iter().zip(fixtures) {
        for block in blocks {
            look(block, block.high[2], &fixture.name);
        }
    }
    // A place's bottom carries what lies in it.
    for place in &scene.places {
        look(&place.block, place.at[2], &place.name);
    }
    for conveyor in &scene.conveyors {
        look(&conveyor.block, conveyor.block.high[2], &conveyor.name);
    }
    for (index, thing) in things.iter().enumerate() {
        if index != which {
            for block in thing.standing() {
                look(&block, block.high[2], &thing.name);
            }
        }
    }
    match best {
        Some((z, on, block)) => {
            Landing { z: Some(z), on, unstable: over_edge(&things[which].form, at, &block) }
        }
        None => Landing { z: scene.table, on: "table".to_owned(), unstable: false },
    }
}

/// Whether less than half of a form's width or depth lies on a block.
fn over_edge(form: &Form, at: V3, block: &Block) -> bool {
    let own = form.blocks(at, SLICES);
    let edge = |axis: usize, low: bool| {
        let ends = own.iter().map(|block| if low { block.low[axis] } else { block.high[axis] });
        if low {
            ends.fold(f64::INFINITY, f64::min)
        } else {
            ends.fold(f64::NEG_INFINITY, f64::max)
        }
    };
    (0..2).any(|axis| {
        let (low, high) = (edge(axis, true), edge(axis, false));
        let shared = high.min(block.high[axis]) - low.max(block.low[axis]);
        shared < (high - low) / 2.0 - 1e-9
    })
}
