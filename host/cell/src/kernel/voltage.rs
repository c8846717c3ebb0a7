//! Voltages that a cell gives to analog inputs: those of a nozzle's pressure sensor, and of sensors of distance. While one
//! of them changes as time goes by the machine asks each millisecond, as its converter does.

use super::Cell;
use crate::law::Steps;
use crate::pressure::MOST_MV;
use crate::scene::{Block, Eye, Sensor, ToolKind, V3};
use crate::things::Where;

/// Between two looks at a voltage that changes, us.
const LOOK_US: u64 = 1_000;
fn millivolts(volts: f64) -> u16 {
    (volts * 1000.0).round().clamp(0.0, MOST_MV) as u16
}

/// The first place of the way between two places at which it comes into a block, as a part of the way.
fn enters(from: V3, to: V3, block: &Block) -> Option<f64> {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let way = to[axis] - from[axis];
        let [low, high] = [block.low[axis], block.high[axis]];
        if way == 0.0 {
            if !(low..=high).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let [a, b] = [(low - from[axis]) / way, (high - from[axis]) / way];
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    (first <= last).then_some(first)
}

impl Cell {
    /// The voltages that the cell gives, with the numbers of their inputs, from 1, mV.
    #[must_use]
    pub fn voltages(&self, at: &Steps, us: u64) -> Vec<(u32, u16)> {
        let mut all = Vec::new();
        for (tool, state) in self.scene.tools.iter().zip(self.states()) {
            if let ToolKind::Vacuum(vacuum) = &tool.kind
                && let Some(analog) = vacuum.analog
            {
                let kpa = state.vacuum().at(us);
                all.push((analog, millivolts(vacuum.volts_at(kpa))));
            }
        }
        for sensor in &self.scene.sensors {
            if let (Eye::Distance(from, to, volts), Some(analog)) = (&sensor.eye, sensor.analog) {
                let share = self.first_in_sight(sensor, *from, *to, at);
                all.push((analog, millivolts(volts[0] + share * (volts[1] - volts[0]))));
            }
        }
        all
    }

    /// Where the first thing between two places stands that a sensor sees, as a part of the way; 1 for nothing.
    fn first_in_sight(&self, sensor: &Sensor, from: V3, to: V3, at: &Steps) -> f64 {
        let tip = self.tip(at);
        let [parts, tools, held] = sensor.sees;
        let mut blocks: Vec<Block> = Vec::new();
        for (index, tool) in self.scene.tools.iter().enumerate().filter(|_| tools) {
            let own = self.tip_of(index, at);
            blocks.extend(tool.body.iter().map(|block| block.moved(own)));
        }
        for thing in &self.things {
            match thing.place {
                Where::Stands(_) if parts => blocks.extend(thing.standing()),
                Where::Held(_) if parts || held => {
                    blocks.extend(thing.hanging().iter().map(|block| block.moved(tip)));
                }
                _ => {}
            }
        }
        blocks.iter().filter_map(|block| enters(from, to, block)).fold(1.0, f64::min)
    }

    /// The time of the next look at voltages that change while nothing else happens; `None`: they rest.
    pub(super) fn next_look(&self, us: u64) -> Option<u64> {
        let gauges =
            self.scene.tools.iter().zip(self.states()).any(|(tool, state)| match &tool.kind {
                ToolKind::Vacuum(vacuum) if vacuum.analog.is_some() => {
                    let pressure = state.vacuum();
                    let [now, end] = [pressure.at(us), pressure.target()]
                        .map(|kpa| millivolts(vacuum.volts_at(kpa)));
                    now != end
                }
                _ => false,
            });
        let runs = self.belts.iter().any(|belt| belt.runs.is_some());
        let sights = self.scene.sensors.iter().zip(&self.seen).any(|(sensor, &seen)| {
            sensor.analog.is_some()
                && matches!(sensor.eye, Eye::Distance(..))
                && (seen > 0 || runs && sensor.sees[0])
        });
        (gauges || sights).then_some((us / LOOK_US + 1) * LOOK_US)
    }

    /// Things on belts are where they are now, for sensors of distance.
    pub(super) fn look_at_voltages(&mut self, us: u64) {
        if self.next_look.is_some_and(|when| when <= us) {
            self.belts_until(us);
        }
        self.next_look = self.next_look(us);
    }
}

#[cfg(test)]
mod tests {
    use super::enters;
    use crate::scene::Block;

    #[test]
    fn a_way_enters_a_block_at_its_near_face() {
        let block = Block { low: [10.0, -1.0, 0.0], high: [20.0, 1.0, 5.0] };
        assert_eq!(enters([0.0, 0.0, 1.0], [40.0, 0.0, 1.0], &block), Some(0.25));
        assert_eq!(enters([40.0, 0.0, 1.0], [0.0, 0.0, 1.0], &block), Some(0.5));
        assert_eq!(enters([0.0, 0.0, 6.0], [40.0, 0.0, 6.0], &block), None);
        assert_eq!(enters([15.0, 0.0, 1.0], [15.0, 0.0, 9.0], &block), Some(0.0));
        assert_eq!(enters([0.0, 0.0, 1.0], [5.0, 0.0, 1.0], &block), None);
    }
}
