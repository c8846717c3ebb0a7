//! A cell from above, for the pictures of a run: outlines in mm of the machine's X and Y, each with the time in which it
//! is there.

use cell::kernel::Cell;
use cell::log::What;
use cell::scene::{Block, Form};
use cell::things::Where;
use serde::Serialize;

/// What a shape is drawn as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The stock.
    Stock,
    /// A place for parts.
    Place,
    /// A conveyor.
    Belt,
    /// A fixture.
    Fixture,
    /// A thing.
    Thing,
    /// What a sensor looks at.
    Sensor,
    /// A hole.
    Hole,
    /// What was laid or drawn along a way.
    Bead,
    /// Where something ran into something.
    Hit,
}

impl Kind {
    /// Its word, in classes and data.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Kind::Stock => "stock",
            Kind::Place => "place",
            Kind::Belt => "belt",
            Kind::Fixture => "fixture",
            Kind::Thing => "thing",
            Kind::Sensor => "sensor",
            Kind::Hole => "hole",
            Kind::Bead => "bead",
            Kind::Hit => "hit",
        }
    }
}

/// An outline from above.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shape {
    /// What it is.
    pub kind: Kind,
    /// Its name, or what happened.
    pub name: String,
    /// Corners or points of the way, mm.
    pub points: Vec<[f64; 2]>,
    /// From when on it is there, us.
    pub from: u64,
    /// Until when, us.
    pub to: u64,
}

/// Shapes beyond this are left out: nobody tells so many apart.
const MOST: usize = 20_000;
/// Half of the cross at a collision, mm.
const CROSS: f64 = 3.0;

/// Everything in a cell at the end of a run that took so long, us.
#[must_use]
pub fn shapes(cell: &Cell, end: u64) -> Vec<Shape> {
    let scene = cell.scene();
    let mut all = Vec::new();
    let mut add = |kind, name: &str, points: Vec<[f64; 2]>, from: u64, to: u64| {
        all.push(Shape { kind, name: name.to_owned(), points, from, to });
    };
    if let Some(stock) = &scene.stock {
        add(Kind::Stock, "stock", rectangle(&Block::standing(stock.at, stock.size)), 0, end);
    }
    for belt in &scene.conveyors {
        add(Kind::Belt, &belt.name, rectangle(&belt.block), 0, end);
    }
    for place in &scene.places {
        add(Kind::Place, &place.name, rectangle(&place.block), 0, end);
    }
    for fixture in &scene.fixtures {
        add(Kind::Fixture, &fixture.name, outline(&fixture.form, fixture.at), 0, end);
    }
    for sensor in &scene.sensors {
        if let Some(block) = cell::kernel::sight(&sensor.eye) {
            add(Kind::Sensor, &sensor.name, rectangle(&block), 0, end);
        }
    }
    for thing in cell.things() {
        let of = |what: &What| match what {
            What::Take { thing: own, .. } | What::Rest { thing: own, .. } => *own == thing.name,
            _ => false,
        };
        let mut own = cell.log().iter().filter(|event| of(&event.what));
        let left = own.next().map_or(end, |event| event.us);
        let came = own.next_back().map_or(left, |event| event.us);
        if let Where::Stands(at) = thing.home {
            // What stays is there to the end.
            let to = if thing.home == thing.place { end } else { left };
            add(Kind::Thing, &thing.name, outline(&thing.form, at), 0, to);
        }
        if let Where::Stands(at) = thing.place
            && thing.home != thing.place
        {
            add(Kind::Thing, &thing.name, outline(&thing.form, at), came, end);
        }
    }
    let radius = scene.tools.first().map_or(0.5, |tool| match tool.kind {
        cell::scene::ToolKind::Drill { diameter, .. } => diameter / 2.0,
        _ => 0.5,
    });
    let mut ways = cell.drawn().iter();
    for event in cell.log() {
        match &event.what {
            What::Hole { at, depth } => {
                let form = Form { size: [radius * 2.0; 3], round: true, turn_deg: 0.0 };
                let name = format!("hole {depth:.2} mm deep");
                add(Kind::Hole, &name, outline(&form, [at[0], at[1], 0.0]), event.us, end);
            }
            What::Bead { mg, .. } => {
                let way = ways.next().cloned().unwrap_or_default();
                add(Kind::Bead, &format!("bead of {mg:.2} mg"), way, event.us, end);
            }
            What::Hit { thing, with, pos, line } => {
                add(
                    Kind::Hit,
                    &format!("{thing} hit {with} in line {line}"),
                    cross(pos),
                    event.us,
                    end,
                );
            }
            What::Broke { tool, why, pos, line } => {
                add(Kind::Hit, &format!("{tool} {why} in line {line}"), cross(pos), event.us, end);
            }
            _ => {}
        }
    }
    all.truncate(MOST);
    all
}

fn rectangle(block: &Block) -> Vec<[f64; 2]> {
    let ([x, y, _], [right, back, _]) = (block.low, block.high);
    vec![[x, y], [right, y], [right, back], [x, back], [x, y]]
}

fn outline(form: &Form, at: [f64; 3]) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> =
        form.outline().iter().map(|corner| [at[0] + corner[0], at[1] + corner[1]]).collect();
    points.extend(points.first().copied());
    points
}

fn cross(pos: &[f64; 3]) -> Vec<[f64; 2]> {
    let [x, y, _] = *pos;
    let arm = |dx: f64, dy: f64| [x + dx * CROSS, y + dy * CROSS];
    vec![arm(-1.0, -1.0), arm(1.0, 1.0), [x, y], arm(-1.0, 1.0), arm(1.0, -1.0)]
}
