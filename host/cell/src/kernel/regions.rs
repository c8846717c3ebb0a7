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
        let mut regions: Vec<(usize, About, Region)> = Vec::new();
        self.each_tool(|cell| {
            let own = cell.regions_of_tool(at);
            regions.extend(own.into_iter().map(|(about, region)| (cell.hand, about, region)));
        });
        let name = |watch: &Watch| (watch.tool, watch.about);
        let was: BTreeSet<(usize, About)> =
            self.watches.iter().filter(|watch| watch.inside).map(name).collect();
        let known: BTreeSet<(usize, About)> = self.watches.iter().map(name).collect();
        self.watches = regions
            .into_iter()
            .map(|(tool, about, region)| {
                let here = region.holds(at);
                // What is put down stands where it hung: the tool leaves it, it does not run into it.
                let quiet = !known.contains(&(tool, about))
                    && matches!(about, About::Thing(..) | About::Fixture(..));
                // Sensors are counted below.
                let counts = matches!(about, About::Sensor(_) | About::Switch(_));
                let inside = here && (quiet || counts || was.contains(&(tool, about)));
                Watch { about, tool, region, inside }
            })
            .collect();
        self.quiet = None;
        self.law = None;
        self.count_seen(us);
        // A thing that was touched may be gone, or may have moved away.
        self.each_tool(|cell| {
            if cell.tool.touches().is_some_and(|which| !cell.is_inside(About::Contact(which))) {
                cell.contact_ends(us);
            }
        });
        // What the head is in now and was not before has changed.
        self.settle(at, us);
    }

    /// The regions of the tool that acts, and of what hangs on it.
    fn regions_of_tool(&self, at: &Steps) -> Vec<(About, Region)> {
        let scene = self.scene.clone();
        let mut regions: Vec<(About, Region)> = Vec::new();
        let body = self.own().map(|tool| tool.body.clone()).unwrap_or_default();
        let hanging: Vec<Block> = match self.tool.held() {
            Some(which) => {
                let under = self.struck.twins.get(&which);
                let held = std::iter::once(&which).chain(under);
                held.flat_map(|&which| self.things[which].hanging()).collect()
            }
            None => Vec::new(),
        };
        // A nozzle gives way by `press`, so what hangs on it may be pressed onto what it is put on.
        let press = self.own().map_or(0.0, |tool| match &tool.kind {
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
        // What hangs on a tool hangs from the tip of the first one.
        let moving = |own: bool| if own { (self.hand, &body) } else { (0, &lifted) };
        for (index, (fixture, blocks)) in scene.fixtures.iter().zip(&self.fixtures).enumerate() {
            if !fixture.solid {
                continue;
            }
            for own in [true, false] {
                let (tool, moving) = moving(own);
                for block in blocks {
                    let met =
                        |part| (About::Fixture(index, own), self.region(tool, block, part, TOUCH));
                    regions.extend(moving.iter().map(met));
                }
            }
        }
        for (index, thing) in self.things.iter().enumerate() {
            if self.rides(index) {
                continue;
            }
            let blocks = thing.standing();
            for own in [true, false] {
                let (tool, moving) = moving(own);
                for block in &blocks {
                    let met =
                        |part| (About::Thing(index, own), self.region(tool, block, part, TOUCH));
                    regions.extend(moving.iter().map(met));
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
            block.high[2] = self.top_of_stock(self.here(at));
            regions.push((About::Stock, self.tip_in(&block)));
        }
        for (index, sensor) in scene.sensors.iter().enumerate() {
            self.sensor_regions(index, sensor, &body, &hanging, &mut regions);
        }
        regions
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
        let own = |watch: &Watch| watch.about == about && watch.tool == self.hand;
        self.watches.iter().any(|watch| own(watch) && watch.inside)
    }

    /// A thing at whose top the nozzle is.
    pub(super) fn any_contact(&self) -> Option<usize> {
        self.watches.iter().find_map(|watch| match watch.about {
            About::Contact(which)
                if watch.inside
                    && watch.tool == self.hand
                    && matches!(self.things[which].place, Where::Stands(_)) =>
            {
                Some(which)
            }
            _ => None,
        })
    }

    /// The tops of a thing at which a nozzle is sealed by it.
    fn contact_block(&self, middle: V3, top: f64) -> Option<Block> {
        match &self.own()?.kind {
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
