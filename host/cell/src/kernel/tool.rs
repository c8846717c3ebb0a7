//! What the tool does: takes and lets go, drills, lays glue.

use super::shake::Shake;
use super::{Action, Cell, Fall, Timer};
use crate::law::Steps;
use crate::log::What;
use crate::scene::{ToolKind, V3, Vacuum};
use crate::things::{Where, landing};

/// A drill that stands still may touch a stock that tells it so deep, mm: the way in which an axis stops.
const TOUCH_MM: f64 = 0.3;

/// A flute that is exactly as long as the hole is deep is long enough: less than a step, mm.
const DEEP_MM: f64 = 0.001;
/// A plunge is measured over so long, us: shorter ones are not judged.
const PLUNGE_US: u64 = 10_000;
/// Faster than this share of what a drill bears is too fast: times are whole microseconds.
const PLUNGE_SHARE: f64 = 1.01;

fn distance(a: V3, b: V3) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

impl Cell {
    /// The nozzle's numbers, if the tool is one.
    fn nozzle(&self) -> Option<Vacuum> {
        match &self.own()?.kind {
            ToolKind::Vacuum(vacuum) => Some(vacuum.clone()),
            _ => None,
        }
    }

    /// The tool's output changes.
    pub(super) fn switch(&mut self, on: bool, at: &Steps, us: u64) {
        let scene = self.scene.clone();
        let Some(tool) = scene.tools.get(self.hand) else { return };
        if self.tool.on == on {
            return;
        }
        self.tool.on = on;
        let tip = self.here(at);
        match &tool.kind {
            ToolKind::Vacuum(_) => self.aim(us),
            ToolKind::Gripper(_) => self.jaws(on, at, us),
            ToolKind::Drill { spin_us, .. } => {
                self.tool.turns_at = on.then_some(us + spin_us);
                if !on && self.tool.drills() {
                    self.broken("stopped turning in its hole", tip, us);
                }
            }
            ToolKind::Flow { flow_mg_s, open_us, close_us, reach, .. } => {
                if on {
                    self.tool.drawn = self.drawn.len();
                    self.drawn.push(vec![[tip[0], tip[1]]]);
                    self.tool.bead = Some((tip, us + open_us, 0.0));
                    self.tool.last = tip;
                    let above = tip[2] - self.surface(tip);
                    if above > *reach {
                        self.tell(us, What::Drip { at: tip, mm: above });
                    }
                } else if let Some((from, since, mm)) = self.tool.bead.take() {
                    let flows = (us + close_us).saturating_sub(since) as f64 / 1e6;
                    self.tell(us, What::Bead { from, to: tip, mm, mg: flows * flow_mg_s });
                }
            }
            _ => {}
        }
    }

    /// The highest top below a place, mm.
    fn surface(&self, at: V3) -> f64 {
        let stock = self.top_of_stock(at);
        let blocks = self
            .fixtures
            .iter()
            .flatten()
            .copied()
            .chain(self.things.iter().flat_map(|thing| thing.standing()));
        let tops = blocks
            .filter(|block| {
                (0..2).all(|axis| (block.low[axis]..=block.high[axis]).contains(&at[axis]))
                    && block.high[2] <= at[2] + 1.0
            })
            .map(|block| block.high[2]);
        tops.fold(stock.max(self.scene.table.unwrap_or(f64::NEG_INFINITY)), f64::max)
    }

    /// What a working tool has done on its way until now.
    pub(super) fn work(&mut self, at: &Steps, us: u64) {
        if !self.tool.is_working() {
            return;
        }
        let tip = self.here(at);
        if let Some((_, since, mm)) = &mut self.tool.bead
            && us >= *since
        {
            *mm += distance(self.tool.last, tip);
            if let Some(way) = self.drawn.get_mut(self.tool.drawn)
                && self.tool.last != tip
            {
                way.push([tip[0], tip[1]]);
            }
        }
        self.tool.last = tip;
        let top = self.top_of_stock(tip);
        let radius = self.own().map_or(0.0, |tool| match tool.kind {
            ToolKind::Drill { diameter, .. } => diameter / 2.0,
            _ => 0.0,
        });
        let turns = self.tool.turns_at.is_some_and(|turns| turns <= us);
        self.tool.probes &= !turns;
        let probes = self.tool.probes;
        if let Some((middle, depth)) = &mut self.tool.hole {
            if turns {
                *depth = depth.max(top - tip[2]);
            }
            if probes && top - tip[2] > TOUCH_MM {
                return self.broken("was pressed into the stock while it stood still", tip, us);
            }
            if (middle[0] - tip[0]).hypot(middle[1] - tip[1]) > radius {
                self.broken("moved sideways in its hole", tip, us);
            }
            if turns {
                self.bears(top - tip[2], tip, us);
            }
        }
    }

    /// What a turning drill bears: no deeper than its flute, no faster than it cuts. `deep` is below the top, mm.
    fn bears(&mut self, deep: f64, tip: V3, us: u64) {
        let Some(ToolKind::Drill { flute, plunge_mm_s, .. }) =
            self.own().map(|tool| tool.kind.clone())
        else {
            return;
        };
        if flute.is_some_and(|flute| deep > flute + DEEP_MM) {
            self.broken("went deeper than its flute", tip, us);
        }
        let Some(most) = plunge_mm_s else { return };
        match self.tool.plunge {
            // From step to step, so that the speed is exact.
            Some((from, since)) if tip[2] < from => {
                let took = us.saturating_sub(since);
                if took >= PLUNGE_US {
                    if (from - tip[2]) / took as f64 * 1e6 > most * PLUNGE_SHARE {
                        self.broken("was plunged faster than it bears", tip, us);
                    }
                    self.tool.plunge = Some((tip[2], us));
                }
            }
            Some((from, _)) if tip[2] == from => {}
            _ => self.tool.plunge = Some((tip[2], us)),
        }
    }

    fn broken(&mut self, why: &'static str, pos: V3, us: u64) {
        let tool = self.own().map(|tool| tool.name.clone()).unwrap_or_default();
        if self.hits.insert((tool.clone(), why.to_owned())) {
            let line = self.line;
            self.tell(us, What::Broke { tool, why, pos, line });
        }
    }

    /// The tip goes into the stock or comes out of it.
    pub(super) fn stock(&mut self, inside: bool, at: &Steps, us: u64) {
        let scene = self.scene.clone();
        if let Some(input) = scene.stock.as_ref().and_then(|stock| stock.touch) {
            self.actions.push(Action::Input(input, inside));
        }
        let tip = self.here(at);
        match scene.tools.get(self.hand).map(|tool| &tool.kind) {
            Some(ToolKind::Drill { .. }) if inside => {
                if self.tool.turns_at.is_some_and(|turns| turns <= us) {
                    self.tool.hole = Some(([tip[0], tip[1]], 0.0));
                    (self.tool.plunge, self.tool.last) = (Some((tip[2], us)), tip);
                } else if scene.stock.as_ref().is_some_and(|stock| stock.touch.is_some()) {
                    // The stock tells that it is touched: a drill may probe it.
                    self.tool.hole = Some(([tip[0], tip[1]], 0.0));
                    (self.tool.probes, self.tool.last) = (true, tip);
                } else {
                    self.broken("met the stock while it stood still", tip, us);
                }
            }
            Some(ToolKind::Drill { diameter, .. }) => {
                let drilled = !std::mem::take(&mut self.tool.probes);
                if let Some((at, depth)) = self.tool.hole.take().filter(|_| drilled) {
                    self.hole(at, depth, diameter / 2.0, us);
                }
            }
            Some(ToolKind::Probe { input: Some(input), delay_us, .. }) => {
                self.timers.push((us + delay_us, Timer::Act(Action::Input(*input, inside))));
            }
            _ => {}
        }
    }

    /// Pecks at one place are one hole, as deep as the deepest.
    fn hole(&mut self, at: [f64; 2], depth: f64, near: f64, us: u64) {
        let old = self.log.iter_mut().find_map(|event| match &mut event.what {
            What::Hole { at: other, depth }
                if (other[0] - at[0]).hypot(other[1] - at[1]) < near =>
            {
                Some(depth)
            }
            _ => None,
        });
        match old {
            Some(deepest) => *deepest = deepest.max(depth),
            None => self.tell(us, What::Hole { at, depth }),
        }
    }

    /// The nozzle comes to a thing's top or leaves it.
    pub(super) fn contact(&mut self, which: usize, inside: bool, us: u64) {
        if inside {
            self.tool.contact = Some(which);
        } else if self.tool.contact == Some(which) {
            self.tool.contact = self.any_contact();
        }
        self.aim(us);
    }

    /// The nozzle no longer touches what it touched.
    pub(super) fn contact_ends(&mut self, us: u64) {
        self.tool.contact = self.any_contact();
        self.aim(us);
    }

    /// The pressure goes somewhere else from now on.
    fn aim(&mut self, us: u64) {
        let Some(vacuum) = self.nozzle() else { return };
        let sealed = self.tool.held.is_some() || self.tool.contact.is_some();
        self.tool.pressure = self.tool.pressure.toward(&vacuum, self.tool.on, sealed, us);
        self.plan(&vacuum, us);
    }

    /// When the pressure next crosses a level that means something.
    fn plan(&mut self, vacuum: &Vacuum, us: u64) {
        let pressure = self.tool.pressure;
        let rises = pressure.target() > pressure.at(us);
        let level = if self.tool.switched { vacuum.off_kpa } else { vacuum.on_kpa };
        let switch = (rises != self.tool.switched).then(|| pressure.crosses(level, us)).flatten();
        let hold = match (self.tool.held, self.tool.contact) {
            (Some(_), _) if !rises => pressure.crosses(vacuum.hold_kpa, us),
            (None, Some(_)) if rises && self.tool.on => pressure.crosses(vacuum.hold_kpa, us),
            _ => None,
        };
        self.tool.due = [switch, hold].into_iter().flatten().min();
    }

    /// Levels that the pressure has come to.
    pub(super) fn pressure(&mut self, at: &Steps, us: u64) {
        if self.tool.due.is_none_or(|due| due > us) {
            return;
        }
        let Some(vacuum) = self.nozzle() else { return };
        let kpa = self.tool.pressure.at(us);
        let on = if self.tool.switched { kpa >= vacuum.off_kpa } else { kpa >= vacuum.on_kpa };
        if on != self.tool.switched {
            self.tool.switched = on;
            if let Some(input) = vacuum.input {
                self.actions.push(Action::Input(input, on));
            }
        }
        match (self.tool.held, self.tool.contact) {
            (None, Some(which)) if self.tool.on && kpa >= vacuum.hold_kpa => {
                self.take(which, at, us)
            }
            (Some(which), _) if kpa < vacuum.hold_kpa => self.loosens(which, at, us),
            _ => self.plan(&vacuum, us),
        }
    }

    pub(super) fn take(&mut self, which: usize, at: &Steps, us: u64) {
        let tip = self.tip(at);
        let Where::Stands(middle) = self.things[which].place else {
            return self.contact_ends(us);
        };
        self.things[which].place =
            Where::Held(std::array::from_fn(|axis| middle[axis] - tip[axis]));
        self.things[which].taken += 1;
        self.tool.held = Some(which);
        self.tool.contact = None;
        self.left_feeder(which, us);
        let by = self.own().map(|tool| tool.name.clone()).unwrap_or_default();
        let thing = self.things[which].name.clone();
        self.tell(us, What::Take { thing, by });
        self.doubles(which);
        if let Some(after) = self.struck.lost.remove(&which) {
            self.falls_after(which, after, false, us);
        }
        self.aim(us);
        self.rebuild(at, us);
        self.look_again(us);
    }

    /// The pressure holds a thing no more: it falls, unless it sticks.
    fn loosens(&mut self, which: usize, at: &Steps, us: u64) {
        match self.struck.stuck.get(&which) {
            None | Some(0) => self.let_go(which, at, us),
            Some(&for_us) => {
                self.falls_after(which, for_us, true, us);
                if let Some(vacuum) = self.nozzle() {
                    self.plan(&vacuum, us);
                    // What sticks does not fall at each look at the pressure.
                    let pressure = self.tool.pressure;
                    let level = if self.tool.switched { vacuum.off_kpa } else { vacuum.on_kpa };
                    let changes = (pressure.target() > pressure.at(us)) != self.tool.switched;
                    self.tool.due = changes.then(|| pressure.crosses(level, us)).flatten();
                }
            }
        }
    }

    /// What hangs on the tool falls later; what sticks to it does so once.
    fn falls_after(&mut self, which: usize, after: u64, stuck: bool, us: u64) {
        let timer =
            Timer::Falls(Fall { which, tool: self.hand, taken: self.things[which].taken, stuck });
        if !self.timers.iter().any(|own| own.1 == timer) {
            self.timers.push((us + after, timer));
        }
    }

    /// A thing that stuck or is lost falls now, unless it was let go or taken again since.
    pub(super) fn falls(&mut self, fall: Fall, at: &Steps, us: u64) {
        let Fall { which, taken, stuck, .. } = fall;
        if self.tool.held != Some(which) || self.things[which].taken != taken {
            return;
        }
        if stuck {
            self.struck.stuck.remove(&which);
        }
        // A nozzle needs its pressure again; jaws need only be closed.
        let holds = self.nozzle().is_none_or(|own| self.tool.pressure.at(us) >= own.hold_kpa);
        // The tool has come back in time.
        if !(stuck && self.tool.on && holds) {
            self.let_go(which, at, us);
            self.slipped();
        }
    }

    fn let_go(&mut self, which: usize, at: &Steps, us: u64) {
        let tip = self.tip(at);
        self.belts_until(us);
        self.tool.held = None;
        // What hangs lowest falls first.
        let under = self.struck.twins.remove(&which);
        for which in under.into_iter().chain([which]) {
            self.lands(which, tip, us);
        }
        self.aim(us);
        self.plan_belts(us);
        self.rebuild(at, us);
        self.look_again(us);
    }

    /// The most that holds what hangs on the tool, N, if there is a limit and something hangs.
    pub(super) fn hold_n(&self) -> Option<f64> {
        self.holds(self.hand)
    }

    /// The same of a tool.
    pub(super) fn holds(&self, tool: usize) -> Option<f64> {
        self.state_of(tool).held()?;
        match &self.scene.tools.get(tool)?.kind {
            ToolKind::Vacuum(vacuum) => vacuum.hold_n,
            _ => None,
        }
    }

    /// What hangs on the tool is lost where its mass times the acceleration is more than holds it.
    pub(super) fn shaken(&mut self, at: &Steps, us: u64) {
        let Some((which, holds)) = self.tool.held().zip(self.hold_n()) else {
            self.tool.shake = Shake::default();
            return;
        };
        let Some(found) = self.tool.shake.look(at, us, self.frame.scale) else { return };
        let mass = |which: usize| self.scene.parts[self.things[which].part].mass_g;
        let grams = mass(which) + self.struck.twins.get(&which).map_or(0.0, |&twin| mass(twin));
        let newton = grams / 1e3 * found / 1e3;
        if newton > holds {
            self.tool.shake = Shake::default();
            self.shaken_off(which, at, us);
        }
    }

    /// The head was too quick for what hangs on it.
    pub(super) fn shaken_off(&mut self, which: usize, at: &Steps, us: u64) {
        let thing = self.things[which].name.clone();
        let why = "was accelerated by more than `hold_n` holds";
        self.tell(us, What::Lost { thing, why });
        self.let_go(which, at, us);
    }

    /// A thing falls from where it hangs.
    fn lands(&mut self, which: usize, tip: V3, us: u64) {
        let Where::Held(offset) = self.things[which].place else { return };
        let from: V3 = std::array::from_fn(|axis| tip[axis] + offset[axis]);
        let press = self.nozzle().map_or(0.0, |vacuum| vacuum.press);
        let landing = landing(&self.scene, &self.fixtures, &self.things, which, from, press);
        let thing = self.things[which].name.clone();
        match landing.z {
            Some(z) => {
                let fell = (from[2] - z).max(0.0);
                self.things[which].fell = self.things[which].fell.max(fell);
                self.things[which].place = Where::Stands([from[0], from[1], z]);
                self.tell(us, What::Drop { thing: thing.clone(), mm: fell });
                self.things[which].stored =
                    self.scene.places.iter().any(|own| own.room == 0 && own.name == landing.on);
                self.tell(us, What::Rest { thing: thing.clone(), on: landing.on });
                self.filled([from[0], from[1], z], us);
                if landing.unstable {
                    self.tell(us, What::Unstable { thing });
                }
            }
            None => {
                self.things[which].place = Where::Gone;
                self.tell(us, What::Lost { thing, why: "fell where nothing is below" });
            }
        }
    }

    /// Jaws let a thing go.
    pub(super) fn release(&mut self, which: usize, at: &Steps, us: u64) {
        match self.struck.stuck.get(&which) {
            None | Some(0) => self.let_go(which, at, us),
            Some(&for_us) => self.falls_after(which, for_us, true, us),
        }
    }

    /// Sensors that see standing parts look again.
    pub(super) fn look_again(&mut self, us: u64) {
        for index in 0..self.scene.sensors.len() {
            if self.scene.sensors[index].sees[0] {
                self.look(index, us);
            }
        }
    }
}
