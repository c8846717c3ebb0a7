//! The regions of head places in which something happens, made of where everything is.

use std::collections::BTreeSet;

use super::{About, Cell, TOUCH, Watch};
use crate::law::Steps;
use crate::region::Region;
use crate::scene::{Block, ToolKind, V3};
use crate::things::Where;

impl Cell {
    /// All regions anew. A region that was there keeps whether the head was in it; of a new one it is looked up, so that
    /// what is in one another from the begin is no event.
    pub(super) fn rebuild(&mut self, at: &Steps, us: u64) {
        let scene = self.scene.clone();
        let mut regions: Vec<(About, Region)> = Vec::new();
        let body = scene.tools.first().map(|tool| tool.body.clone()).unwrap_or_default();
        let hanging: Vec<Block> = match self.tool.held() {
            Some(which) => {
                let under = self.struck.twins.get(&which);
                let held = std::iter::once(&which).chain(under);
                held.flat_map(|&which| self.things[which].hanging()).collect()
            }
            None => Vec::new(),
        };
        // A nozzle gives way by `press`, so what hangs on it may be pressed onto what it is put on.
        let press = scene.tools.first().map_or(0.0, |tool| match &tool.kind {
            ToolKind::Vacuum(vacuum) => vacuum.press,
            _ => 0.0,
        });
        let lifted: Vec<Block> = hanging
            .iter()
            .map(|block| Block {
                low: [block.low[0], block.low[1], block.low[2] + press],
                high: block.high,
            })
            .collect();
        let moving = |own: bool| if own { &body } else { &lifted };
        for (index, (fixture, blocks)) in scene.fixtures.iter().zip(&self.fixtures).enumerate() {
            if !fixture.solid {
                continue;
            }
            for own in [true, false] {
                for block in blocks {
                    regions.extend(
                        moving(own).iter().map(|part| {
                            (About::Fixture(index, own), self.region(block, part, TOUCH))
                        }),
                    );
                }
            }
        }
        for (index, thing) in self.things.iter().enumerate() {
            if self.rides(index) {
                continue;
            }
            let blocks = thing.standing();
            for own in [true, false] {
                for block in &blocks {
                    regions.extend(
                        moving(own).iter().map(|part| {
                            (About::Thing(index, own), self.region(block, part, TOUCH))
                        }),
                    );
                }
            }
            if let (Some(block), Where::Stands(middle)) = (blocks.first(), thing.place)
                && let Some(reach) = self.contact_block(middle, block.high[2])
            {
                regions.push((About::Contact(index), self.tip_in(&reach)));
            }
        }
        if let Some(stock) = &scene.stock {
            let mut block = Block::standing(stock.at, stock.size);
            block.low[2] = -1e6;
            block.high[2] = self.top_of_stock(self.tip(at));
            regions.push((About::Stock, self.tip_in(&block)));
        }
        for (index, sensor) in scene.sensors.iter().enumerate() {
            self.sensor_regions(index, sensor, &body, &hanging, &mut regions);
        }
        let was: BTreeSet<About> =
            self.watches.iter().filter(|watch| watch.inside).map(|watch| watch.about).collect();
        let known: BTreeSet<About> = self.watches.iter().map(|watch| watch.about).collect();
        self.watches = regions
            .into_iter()
            .map(|(about, region)| {
                let here = region.holds(at);
                // What is put down stands where it hung: the tool leaves it, it does not run into it.
                let quiet = !known.contains(&about)
                    && matches!(about, About::Thing(..) | About::Fixture(..));
                // Sensors are counted below.
                let counts = matches!(about, About::Sensor(_) | About::Switch(_));
                let inside = here && (quiet || counts || was.contains(&about));
                Watch { about, region, inside }
            })
            .collect();
        self.quiet = None;
        self.law = None;
        self.count_seen(us);
        // A thing that was touched may be gone, or may have moved away.
        if self.tool.touches().is_some_and(|which| !self.is_inside(About::Contact(which))) {
            self.contact_ends(us);
        }
        // What the head is in now and was not before has changed.
        self.settle(at, us);
    }

    /// Sets for each sensor the number of its regions that the head is in: regions come and go with what hangs on the
    /// tool.
    fn count_seen(&mut self, us: u64) {
        for index in 0..self.seen.len() {
            let is_own = |watch: &&Watch| {
                watch.inside
                    && matches!(watch.about, About::Sensor(n) | About::Switch(n) if n == index)
            };
            let count = self.watches.iter().filter(is_own).count() as u32;
            let was = std::mem::replace(&mut self.seen[index], count);
            if (was > 0) != (count > 0) {
                self.look(index, us);
            }
        }
    }

    fn is_inside(&self, about: About) -> bool {
        self.watches.iter().any(|watch| watch.about == about && watch.inside)
    }

    /// A thing at whose top the nozzle is.
    pub(super) fn any_contact(&self) -> Option<usize> {
        self.watches.iter().find_map(|watch| match watch.about {
            About::Contact(which)
                if watch.inside && matches!(self.things[which].place, Where::Stands(_)) =>
            {
                Some(which)
            }
            _ => None,
        })
    }

    /// The tops of a thing at which a nozzle is sealed by it.
    fn contact_block(&self, middle: V3, top: f64) -> Option<Block> {
        match &self.scene.tools.first()?.kind {
            ToolKind::Vacuum(vacuum) => Some(Block {
                low: [middle[0] - vacuum.reach, middle[1] - vacuum.reach, top - vacuum.press],
                high: [middle[0] + vacuum.reach, middle[1] + vacuum.reach, top + vacuum.gap],
            }),
            _ => None,
        }
    }

    pub(super) fn top_of_stock(&self, at: V3) -> f64 {
        self.scene.stock.as_ref().map_or(f64::NEG_INFINITY, |stock| {
            let slope =
                stock.tilt[0] * (at[0] - stock.at[0]) + stock.tilt[1] * (at[1] - stock.at[1]);
            stock.at[2] + stock.size[2] + slope
        })
    }
}
