//! A cell while it runs. The machine asks when the cell must be called next, calls it then, and takes the actions.
//!
//! A tool's and a part's contacts are [`regions`](super::region) of head places. They are made anew when something is
//! taken, let go, or moves by itself; between such moments a law that stays in the quiet box costs six comparisons.

mod around;
mod belt;
mod faults;
mod gripper;
mod hand;
mod regions;
mod shake;
mod state;
mod steps;
mod supply;
mod tool;
mod voltage;

pub use self::belt::sight;

use super::law::{Law, Steps};
use super::log::{Event, What};
use super::region::{Region, Scale, quiet};
use super::scene::{Block, Scene, V3, When};
use super::things::{self, Thing};
use std::collections::BTreeSet;
use std::sync::Arc;

use state::{Belt, Struck, ToolState};

/// What the cell does to the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// An input of the cell changes.
    Input(u32, bool),
    /// The Start button.
    Start(bool),
    /// The Stop button.
    Stop(bool),
    /// The emergency stop.
    Emergency(bool),
    /// The run is paused, or resumed.
    Pause(bool),
    /// The safety door is open.
    Door(bool),
    /// Who has closed the safety door presses Start.
    Resume(bool),
    /// A panel writes a register of an AT variable.
    Register(u32, i32),
    /// The motor of an axis (X: 0) loses its next steps.
    Stall(usize, i32),
    /// The host's client ends: nothing comes over the link any more.
    Gone,
}

/// The machine's frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Steps of X, Y, Z in a mm of the cell; negative where the axis counts the other way.
    pub scale: Scale,
    /// Where the head stands at power-up, mm: the place of step 0 of the true steps.
    pub start: V3,
}

/// Two blocks may touch: less than this is no collision, mm.
const TOUCH: f64 = 0.001;

/// What a region is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum About {
    /// The nozzle is at this thing's top.
    Contact(usize),
    /// The tool's body, or else what it holds, meets a fixture.
    Fixture(usize, bool),
    /// The same with a standing thing.
    Thing(usize, bool),
    /// The tip is below the top of the stock.
    Stock,
    /// A sensor sees the tool's body, or what it holds.
    Sensor(usize),
    /// A switch of an axis closes.
    Switch(usize),
}

struct Watch {
    about: About,
    /// Index of the tool that it is about.
    tool: usize,
    region: Region,
    inside: bool,
}

/// A run of a cell.
pub struct Cell {
    scene: Arc<Scene>,
    frame: Frame,
    things: Vec<Thing>,
    fixtures: Vec<Vec<Block>>,
    watches: Vec<Watch>,
    quiet: Option<Region>,
    /// The law that `next` was found for.
    law: Option<u64>,
    next: Option<u64>,
    timers: Vec<(u64, Timer)>,
    actions: Vec<Action>,
    log: Vec<Event>,
    /// Pairs that have collided.
    hits: BTreeSet<(String, String)>,
    /// The line that the script is in, for messages.
    line: u32,
    /// The tool that acts now, of those of the scene; the others wait in `parked`.
    hand: usize,
    tool: ToolState,
    parked: Vec<ToolState>,
    /// Sensors: whether each sees something, by what it sees now.
    seen: Vec<u32>,
    /// What each sensor saw at its last look.
    looked: Vec<Option<bool>>,
    /// What each sensor says; nothing before its first look.
    says: Vec<Option<bool>>,
    /// Doors that are on their way or open.
    open: Vec<bool>,
    done: Vec<u32>,
    struck: Struck,
    belts: Vec<Belt>,
    /// When something happens on a belt.
    next_belt: Option<u64>,
    /// When voltages are looked at again.
    next_look: Option<u64>,
    /// Parts that each feeder has brought.
    fed: Vec<u32>,
    /// What dispensers, lasers and pens drew, as ways of X and Y, mm.
    drawn: Vec<Vec<[f64; 2]>>,
}

/// A thing that falls off the tool later.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fall {
    which: usize,
    /// The tool on which it hangs.
    tool: usize,
    /// How often the thing had been taken: the fall belongs to this hold alone.
    taken: u32,
    /// Whether it stuck to a tool that let go; else a tool that holds loses it.
    stuck: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Timer {
    Act(Action),
    Sense(usize, bool),
    Door(usize, bool),
    /// A tool answers its output.
    Tool(usize, bool),
    /// The jaws of a tool have closed.
    Jaws(usize),
    /// A feeder brings the next part.
    Feed(usize),
    /// A person takes the thing of their row away, or puts it back.
    Hands(usize, bool),
    /// A thing falls off the tool.
    Falls(Fall),
}

impl Cell {
    /// A cell at power-up.
    #[must_use]
    pub fn new(scene: Arc<Scene>, frame: Frame) -> Self {
        let things = things::all(&scene);
        let fixtures = scene
            .fixtures
            .iter()
            .map(|fixture| fixture.form.blocks(fixture.at, fixture.slices))
            .collect();
        let mut cell = Self {
            frame,
            things,
            fixtures,
            watches: Vec::new(),
            quiet: None,
            law: None,
            next: None,
            timers: Vec::new(),
            actions: Vec::new(),
            log: Vec::new(),
            hits: BTreeSet::new(),
            line: 0,
            hand: 0,
            tool: ToolState::new(),
            // A scene without a tool has a head all the same.
            parked: (0..scene.tools.len().max(1)).map(|_| ToolState::new()).collect(),
            seen: vec![0; scene.sensors.len()],
            looked: vec![None; scene.sensors.len()],
            says: vec![None; scene.sensors.len()],
            open: vec![false; scene.fixtures.len()],
            done: vec![0; scene.persons.len()],
            struck: Struck::default(),
            belts: Belt::all(&scene),
            next_belt: None,
            next_look: None,
            fed: Vec::new(),
            drawn: Vec::new(),
            scene,
        };
        cell.begin();
        cell
    }

    fn begin(&mut self) {
        let scene = self.scene.clone();
        for (index, sensor) in scene.sensors.iter().enumerate() {
            if sensor.invert
                && let Some(input) = sensor.input
            {
                self.actions.push(Action::Input(input, true));
            }
            self.look(index, 0);
        }
        for (index, person) in scene.persons.iter().enumerate() {
            if let When::At(us) = person.when {
                self.person(index, us);
            }
        }
        self.begin_feeders();
        self.rebuild(&[0; 4], 0);
        // What a belt feeds at the begin.
        self.next_belt = Some(0);
        self.belts(&[0; 4], 0);
    }

    /// The things as they are.
    #[must_use]
    pub fn things(&self) -> &[Thing] {
        &self.things
    }

    /// What dispensers, lasers and pens drew, as ways of X and Y, mm.
    #[must_use]
    pub fn drawn(&self) -> &[Vec<[f64; 2]>] {
        &self.drawn
    }

    /// What happened so far.
    #[must_use]
    pub fn log(&self) -> &[Event] {
        &self.log
    }

    /// Whether something has collided in a scene that ends a run then.
    #[must_use]
    pub fn must_end(&self) -> bool {
        !self.hits.is_empty() && self.scene.stop_on.iter().any(|class| class == "collision")
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The script comes to a line; messages name it.
    pub fn line(&mut self, line: u32) {
        self.line = line;
    }

    /// Gives each collision the line that the script was in at its time.
    pub fn set_lines(&mut self, line_at: &dyn Fn(u64) -> u32) {
        for event in &mut self.log {
            if let What::Hit { line, .. } | What::Broke { line, .. } = &mut event.what {
                *line = line_at(event.us);
            }
        }
    }

    fn tell(&mut self, us: u64, what: What) {
        self.log.push(Event { us, what });
    }

    /// When the cell must be called next, not before `now`; `None`: never by itself.
    pub fn next_us(&mut self, law: &dyn Law, now: u64) -> Option<u64> {
        if !self.actions.is_empty() {
            return Some(now);
        }
        if self.law != Some(law.id()) || self.next.is_some_and(|when| when <= now) {
            self.law = Some(law.id());
            self.next = self.next_change(law, now);
        }
        let timer = self.timers.iter().map(|timer| timer.0).min();
        let tools = self.states().flat_map(|tool| [tool.due(), tool.shake.due()]).flatten().min();
        [self.next, timer, tools, self.next_belt, self.next_look]
            .into_iter()
            .flatten()
            .min()
            .map(|when| when.max(now))
    }

    fn next_change(&mut self, law: &dyn Law, now: u64) -> Option<u64> {
        let until = law.until()?;
        let (at, end) = (law.at(now), law.at(until));
        // A hole's depth and a bead's length are taken at the end of each law.
        let works = self.states().any(ToolState::is_working);
        let mut first = works.then_some(until).filter(|&when| when > now);
        self.tilt(&at, &end);
        if let Some(quiet) = &self.quiet
            && quiet.holds(&at)
            && quiet.holds(&end)
        {
            return first;
        }
        self.quiet =
            Some(quiet(self.watches.iter().map(|watch| (&watch.region, watch.inside)), &at));
        for watch in &self.watches {
            let when = watch.region.changes(law, &at, &end, now, watch.inside);
            first = [first, when].into_iter().flatten().min();
        }
        first
    }

    /// A tilted top of the stock has the height at the end of the way.
    fn tilt(&mut self, at: &Steps, end: &Steps) {
        let tilted = self.scene.stock.as_ref().is_some_and(|stock| stock.tilt != [0.0; 2]);
        if !tilted || at[..2] == end[..2] {
            return;
        }
        let tops: Vec<f64> =
            (0..self.parked.len()).map(|tool| self.top_in_steps(tool, [end[0], end[1]])).collect();
        for watch in self.watches.iter_mut().filter(|watch| watch.about == About::Stock) {
            let top = tops[watch.tool];
            if self.frame.scale[2] > 0.0 {
                watch.region.high[2] = top.floor() as i32
            } else {
                watch.region.low[2] = top.ceil() as i32
            }
        }
        self.quiet = None;
    }

    /// Lets everything happen until `now`, where the axes are by this law, and gives what is done to the machine.
    pub fn advance(&mut self, law: &dyn Law, now: u64) -> Vec<Action> {
        let at = law.at(now);
        self.each_tool(|cell| {
            cell.work(&at, now);
            cell.shaken(&at, now);
        });
        if law.until().is_none() {
            self.tilt_here(&at);
        }
        self.settle(&at, now);
        self.each_tool(|cell| cell.pressure(&at, now));
        self.belts(&at, now);
        while let Some(index) = self.timers.iter().position(|timer| timer.0 <= now) {
            let (_, timer) = self.timers.remove(index);
            self.timer(timer, &at, now);
        }
        if self.next.is_some_and(|when| when <= now) {
            self.law = None;
        }
        self.look_at_voltages(now);
        let actions = std::mem::take(&mut self.actions);
        self.without_forced(actions)
    }

    /// Regions whose answer is another one now.
    fn settle(&mut self, at: &Steps, us: u64) {
        let (mut index, before) = (0, self.hand);
        while let Some(watch) = self.watches.get_mut(index) {
            let inside = watch.region.holds(at);
            index += 1;
            if inside != watch.inside {
                watch.inside = inside;
                let (about, tool) = (watch.about, watch.tool);
                self.turn_to(tool);
                self.quiet = None;
                self.law = None;
                self.changed(about, inside, at, us);
            }
        }
        self.turn_to(before);
    }

    /// What follows of a region that the head enters or leaves.
    fn changed(&mut self, about: About, inside: bool, at: &Steps, us: u64) {
        match about {
            About::Contact(which) => self.contact(which, inside, us),
            About::Fixture(which, own) if inside => {
                let with = self.scene.fixtures[which].name.clone();
                self.hit(own, with, at, us);
            }
            About::Thing(which, own) if inside => {
                let with = self.things[which].name.clone();
                self.hit(own, with, at, us);
            }
            About::Fixture(..) | About::Thing(..) => {}
            About::Stock => self.stock(inside, at, us),
            About::Sensor(index) | About::Switch(index) => {
                self.seen[index] =
                    if inside { self.seen[index] + 1 } else { self.seen[index].saturating_sub(1) };
                self.look(index, us);
            }
        }
    }

    fn hit(&mut self, own: bool, with: String, at: &Steps, us: u64) {
        let thing = match self.tool.held() {
            Some(which) if !own => self.things[which].name.clone(),
            _ => self.own().map(|own| own.name.clone()).unwrap_or_default(),
        };
        if self.hits.insert((thing.clone(), with.clone())) {
            let (pos, line) = (self.here(at), self.line);
            self.tell(us, What::Hit { thing, with, pos, line });
        }
    }

    fn timer(&mut self, timer: Timer, at: &Steps, us: u64) {
        match timer {
            Timer::Act(action) => self.actions.push(action),
            Timer::Sense(index, sees) => {
                let sensor = &self.scene.sensors[index];
                let (name, on) = (sensor.name.clone(), sees != sensor.invert);
                let said = self.says[index].replace(on);
                // A sensor that sees nothing at the begin has said nothing.
                if said == Some(on) || said.is_none() && !on {
                    return;
                }
                if let Some(input) = sensor.input {
                    self.actions.push(Action::Input(input, on));
                }
                self.tell(us, What::Sense { name, v: on });
            }
            Timer::Tool(tool, on) => {
                self.turn_to(tool);
                self.switch(on, at, us);
            }
            Timer::Falls(fall) => {
                self.turn_to(fall.tool);
                self.falls(fall, at, us);
            }
            Timer::Jaws(tool) => {
                self.turn_to(tool);
                self.closed(at, us);
            }
            Timer::Feed(index) => self.feed(index, at, us),
            Timer::Hands(index, puts) => {
                let name = self.scene.persons[index].thing.clone().unwrap_or_default();
                self.hands(&name, puts, at, us);
            }
            Timer::Door(index, open) => {
                let fixture = &self.scene.fixtures[index];
                if let Some((_, open_at, _)) = fixture.door {
                    let place = if open { open_at } else { fixture.at };
                    self.fixtures[index] = fixture.form.blocks(place, fixture.slices);
                    self.rebuild(at, us);
                }
            }
        }
    }

    /// An output changes; the axes are where `law` says.
    pub fn output(&mut self, output: u32, on: bool, law: &dyn Law, us: u64) {
        let at = law.at(us);
        self.each_tool(|cell| {
            cell.work(&at, us);
            if cell.own().is_none_or(|tool| tool.output != Some(output)) {
                return;
            }
            match cell.struck.slow_us.get(&cell.hand) {
                Some(late) => cell.timers.push((us + late, Timer::Tool(cell.hand, on))),
                None => cell.switch(on, &at, us),
            }
        });
        if on {
            self.advance_feeders(output, us);
        }
        self.drive(output, on, &at, us);
        for (index, fixture) in self.scene.clone().fixtures.iter().enumerate() {
            if let Some((opens_by, _, move_us)) = fixture.door
                && opens_by == output
                && self.open[index] != on
            {
                self.open[index] = on;
                self.timers.push((us + move_us, Timer::Door(index, on)));
            }
        }
        self.law = None;
    }
}
