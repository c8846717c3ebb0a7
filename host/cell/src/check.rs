//! What of a scene cannot be, or is doubtful: things that stand in one another, places outside the travel, inputs
//! that two things drive, names that nothing has.

mod inert;
pub mod strikes;

pub use inert::inert;

use super::build::meant;
use super::keys;
use super::problem::Problem;
use super::scene::{Block, Eye, Scene, Spread, ToolKind, Vary};
use std::collections::BTreeMap;

/// Two boxes that share less than this are taken to touch, mm.
const TOUCH: f64 = 0.001;

/// The travel of an axis, mm, if the profile bounds it.
pub type Travel<'a> = &'a dyn Fn(char) -> Option<(f64, f64)>;

/// Checks a scene as a whole. `text` is the file, in which the problems are looked up by the names of things.
#[must_use]
pub fn check(scene: &Scene, text: &str, profile: &str, travel: Travel<'_>) -> Vec<Problem> {
    let mut checker = Checker { scene, text, problems: Vec::new() };
    checker.overlaps();
    checker.start();
    checker.travel(profile, travel);
    checker.inputs();
    checker.expectations();
    checker.varies();
    checker.problems.sort_by_key(|problem| (problem.span.start, !problem.error));
    checker.problems
}

/// A number with the least and greatest that it may be.
type Bounded = (f64, f64);

struct Checker<'a> {
    scene: &'a Scene,
    text: &'a str,
    problems: Vec<Problem>,
}

/// A standing thing: its name and its boxes.
type Standing = (String, Vec<Block>);

impl Checker<'_> {
    /// Bytes of the first place where the file writes this text in quotes; its begin where it does not.
    fn span(&self, name: &str) -> std::ops::Range<usize> {
        let quoted = [format!("\"{name}\""), format!("'{name}'")];
        let found = quoted
            .iter()
            .find_map(|quoted| self.text.find(quoted.as_str()).map(|at| at..at + quoted.len()));
        found.unwrap_or(0..0)
    }

    /// Things of a feeder are named after it.
    fn span_of_thing(&self, thing: &str) -> std::ops::Range<usize> {
        self.span(thing.split('.').next().unwrap_or(thing))
    }

    fn fixtures(&self) -> Vec<Standing> {
        self.scene
            .fixtures
            .iter()
            .map(|fixture| (fixture.name.clone(), fixture.form.blocks(fixture.at, fixture.slices)))
            .collect()
    }

    fn parts(&self) -> Vec<Standing> {
        let scene = self.scene;
        let single = scene
            .parts
            .iter()
            .filter_map(|part| part.at.map(|at| (part.name.clone(), part.form.blocks(at, 1))));
        let fed = scene.feeders.iter().flat_map(|feeder| {
            let form = scene.parts[feeder.part].form;
            let pockets = feeder
                .pockets
                .iter()
                .enumerate()
                .filter(|(pocket, _)| !feeder.empty.contains(pocket));
            pockets.map(move |(pocket, &(at, turn))| {
                let turned = super::scene::Form { turn_deg: form.turn_deg + turn, ..form };
                (format!("{}.{}", feeder.name, pocket + 1), turned.blocks(at, 1))
            })
        });
        single.chain(fed).collect()
    }

    fn overlaps(&mut self) {
        let fixtures = self.fixtures();
        let parts = self.parts();
        let mut found = Vec::new();
        // Parts by their X, so that only neighbours are compared.
        let mut sorted: Vec<&Standing> = parts.iter().collect();
        sorted.sort_by(|a, b| a.1[0].low[0].total_cmp(&b.1[0].low[0]));
        for (index, part) in sorted.iter().enumerate() {
            for other in
                sorted[index + 1..].iter().take_while(|other| other.1[0].low[0] < part.1[0].high[0])
            {
                let depth = part.1[0].overlap(&other.1[0]);
                if depth > TOUCH {
                    found.push((
                        part.0.clone(),
                        format!(
                            "part \"{}\" overlaps part \"{}\" by {}",
                            part.0,
                            other.0,
                            mm(depth)
                        ),
                    ));
                }
            }
            for fixture in &fixtures {
                let depth =
                    fixture.1.iter().map(|block| block.overlap(&part.1[0])).fold(0.0, f64::max);
                if depth > TOUCH {
                    found.push((
                        part.0.clone(),
                        format!(
                            "part \"{}\" overlaps fixture \"{}\" by {}",
                            part.0,
                            fixture.0,
                            mm(depth)
                        ),
                    ));
                }
            }
        }
        // One message for each thing: a tray that is too low says it once.
        let mut said = Vec::new();
        for (thing, text) in found {
            let feeder = thing.split('.').next().unwrap_or(&thing).to_owned();
            if !said.contains(&feeder) {
                self.problems.push(Problem::error("C010", self.span_of_thing(&thing), text));
                said.push(feeder);
            }
        }
    }

    /// The tools where the head stands at power-up.
    fn start(&mut self) {
        let Some([x, y, z, _]) = self.scene.start else { return };
        let fixtures = self.fixtures();
        for tool in &self.scene.tools {
            let tip = [x + tool.tip[0], y + tool.tip[1], z + tool.tip[2]];
            for (name, blocks) in &fixtures {
                let inside =
                    tool.body.iter().any(|body| {
                        blocks.iter().any(|block| body.moved(tip).overlap(block) > TOUCH)
                    }) || blocks
                        .iter()
                        .any(|block| block.holds(tip) && block.high[2] - tip[2] > TOUCH);
                if inside {
                    let text = format!(
                        "tool \"{}\" stands inside fixture \"{name}\" at the start",
                        tool.name
                    );
                    self.problems.push(
                        Problem::error("C009", self.span(name), text)
                            .hint("move the fixture, or `start`"),
                    );
                }
            }
        }
    }

    fn travel(&mut self, profile: &str, travel: Travel<'_>) {
        let mut outside: Vec<(String, String)> = Vec::new();
        let places = self.scene.places.iter().map(|place| (&place.name, place.at, "place"));
        let feeders = self.scene.feeders.iter().flat_map(|feeder| {
            feeder.pockets.iter().map(move |pocket| (&feeder.name, pocket.0, "feeder"))
        });
        for (name, at, word) in places.chain(feeders) {
            for (axis, letter) in ['X', 'Y'].into_iter().enumerate() {
                let Some((least, most)) = travel(letter) else { continue };
                let end = if at[axis] < least {
                    Some(("begins", least))
                } else if at[axis] > most {
                    Some(("ends", most))
                } else {
                    None
                };
                if let Some((verb, end)) = end
                    && !outside.iter().any(|(other, _)| other == name)
                {
                    let text = format!(
                        "{word} \"{name}\" lies outside the travel: {letter} {}, the profile \"{profile}\" {verb} at {end}",
                        at[axis]
                    );
                    outside.push((name.clone(), text));
                }
            }
        }
        for (name, text) in outside {
            self.problems.push(Problem::warning("C008", self.span(&name), text));
        }
    }

    /// An input has one driver.
    fn inputs(&mut self) {
        let mut drivers: BTreeMap<u32, (String, &str)> = BTreeMap::new();
        let mut all: Vec<(Option<u32>, &str, &str)> = Vec::new();
        for tool in &self.scene.tools {
            match &tool.kind {
                ToolKind::Vacuum(vacuum) => all.push((vacuum.input, &tool.name, "tool")),
                ToolKind::Gripper(gripper) => {
                    all.push((gripper.input_closed, &tool.name, "tool"));
                    all.push((gripper.input_gripped, &tool.name, "tool"));
                }
                ToolKind::Probe { input, .. } => all.push((*input, &tool.name, "tool")),
                _ => {}
            }
        }
        all.extend(
            self.scene.sensors.iter().map(|sensor| (sensor.input, sensor.name.as_str(), "sensor")),
        );
        all.extend(
            self.scene.feeders.iter().map(|feeder| (feeder.input, feeder.name.as_str(), "feeder")),
        );
        for (input, name, word) in all {
            let Some(input) = input else { continue };
            if let Some((other, kind)) = drivers.get(&input)
                && other != name
            {
                let text = format!(
                    "input {input} is driven by {kind} \"{other}\" and by {word} \"{name}\""
                );
                self.problems.push(
                    Problem::error("C007", self.span(name), text).hint("give each its own input"),
                );
            }
            drivers.entry(input).or_insert((name.to_owned(), word));
        }
    }

    fn expectations(&mut self) {
        let scene = self.scene;
        let places: Vec<&str> = scene.places.iter().map(|place| place.name.as_str()).collect();
        let sources: Vec<&str> = scene
            .feeders
            .iter()
            .map(|feeder| feeder.name.as_str())
            .chain(scene.parts.iter().map(|part| part.name.as_str()))
            .chain(scene.conveyors.iter().map(|conveyor| conveyor.name.as_str()))
            .collect();
        let sensors: Vec<&str> = scene.sensors.iter().map(|sensor| sensor.name.as_str()).collect();
        let mut wrong = Vec::new();
        for expect in &scene.expects {
            let mut look = |key: &str, word: &str, names: Vec<String>, known: &[&str]| {
                for name in names {
                    if !known.contains(&name.as_str()) {
                        let text =
                            format!("expectation names {word} \"{name}\"{}", meant(&name, known));
                        wrong.push(Problem::error("C011", expect.entry.span_of(key), text));
                    }
                }
            };
            look("place", "place", expect.entry.text("place").into_iter().collect(), &places);
            look("places", "place", expect.entry.texts("places"), &places);
            look("of", "feeder or part", expect.entry.text("of").into_iter().collect(), &sources);
            look("sensor", "sensor", expect.entry.text("sensor").into_iter().collect(), &sensors);
        }
        self.problems.append(&mut wrong);
        for conveyor in &scene.conveyors {
            if let Some(place) = &conveyor.takes
                && !places.contains(&place.as_str())
            {
                let text = format!(
                    "conveyor \"{}\" names place \"{place}\"{}",
                    conveyor.name,
                    meant(place, &places)
                );
                self.problems.push(Problem::error("C011", self.span(place), text));
            }
        }
    }

    /// Each `vary` names a number that there is, and stays within what is possible.
    fn varies(&mut self) {
        for vary in &self.scene.varies {
            let Vary::Number { key, spread, each } = vary else { continue };
            let known = self.numbers();
            if !known.iter().any(|(name, _)| name == key) {
                let near = known.iter().map(|(name, _)| name.as_str());
                let meant = super::problem::nearest(key, near).map(|other| {
                    let word = if other.split('.').next() == key.split('.').next() {
                        other.split('.').nth(1).unwrap_or(other)
                    } else {
                        other
                    };
                    format!("; {word} is meant?")
                });
                let text = format!("`vary` key \"{key}\": no number{}", meant.unwrap_or_default());
                self.problems.push(Problem::error("C012", self.span(key), text));
                continue;
            }
            self.idle(key, *spread, *each);
            let bounds = known.iter().find(|(name, _)| name == key).and_then(|(_, bounds)| *bounds);
            let (Some((floor, ceiling)), [value]) =
                (bounds, &super::vary::values(self.scene, key)[..])
            else {
                continue;
            };
            // A tolerance is cut at four standard deviations, and a number that would fall below 0 stays there.
            let [least, most] = match *spread {
                Spread::Range(least, most) => [value + least, value + most],
                Spread::Sigma(sigma) => [(value - 4.0 * sigma).max(floor), value + 4.0 * sigma],
                Spread::Share(share) => [floor, value * (1.0 + 4.0 * share)],
            };
            if least < floor || most > ceiling {
                let text = format!(
                    "`vary` of \"{key}\" leaves what is possible: {value} may become {least} to {most}"
                );
                self.problems.push(
                    Problem::error("C004", self.span(key), text)
                        .hint(format!("it must lie between {floor} and {ceiling}")),
                );
            }
        }
    }

    /// A variation of a number that changes nothing.
    fn idle(&mut self, key: &str, spread: Spread, each: bool) {
        let name = key.split('.').next().unwrap_or_default();
        let scene = self.scene;
        if let Spread::Share(_) = spread
            && super::vary::value(scene, key) == 0.0
        {
            let text =
                format!("`share` of \"{key}\" is a part of nothing: only numbers of tools above 0");
            let problem = Problem::error("C004", self.span(key), text);
            self.problems.push(problem.hint("write `sigma`, in the unit of the key"));
        }
        let zero = match spread {
            Spread::Sigma(sigma) => sigma == 0.0,
            Spread::Range(least, most) => least == 0.0 && most == 0.0,
            Spread::Share(share) => share == 0.0,
        };
        let mut warn = |text: String, hint: &str| {
            let span = self.span(key);
            self.problems.push(Problem::warning("C016", span, text).hint(hint));
        };
        if zero {
            warn(format!("`vary` of \"{key}\" changes by 0: it has no effect"), "write how much");
        }
        if !strikes::changes(scene, key) {
            warn(format!("`vary` of \"{key}\" has no effect yet"), "leave it out");
        }
        if each && !scene.feeders.iter().any(|feeder| feeder.name == name) {
            warn(
                format!("`each` of \"{key}\" has no effect: \"{name}\" is no feeder"),
                "leave `each` out",
            );
        }
    }

    /// Every number of the scene that may vary, as `thing.key`, with its bounds where it is a single number.
    fn numbers(&self) -> Vec<(String, Option<Bounded>)> {
        let scene = self.scene;
        let mut things: Vec<(&str, &str, &str)> = Vec::new();
        things.extend(
            scene.tools.iter().map(|tool| (tool.name.as_str(), "tool", tool.word.as_str())),
        );
        things.extend(scene.parts.iter().map(|part| (part.name.as_str(), "part", "")));
        things.extend(scene.feeders.iter().map(|feeder| (feeder.name.as_str(), "feeder", "")));
        things.extend(scene.places.iter().map(|place| (place.name.as_str(), "place", "")));
        things.extend(scene.fixtures.iter().map(|fixture| (fixture.name.as_str(), "fixture", "")));
        things.extend(
            scene.conveyors.iter().map(|conveyor| (conveyor.name.as_str(), "conveyor", "")),
        );
        things.extend(scene.sensors.iter().map(|sensor| (sensor.name.as_str(), "sensor", "")));
        if scene.stock.is_some() {
            things.push(("stock", "stock", ""));
        }
        let mut all = vec![("start".to_owned(), None)];
        for (name, section, variant) in things {
            for key in keys::keys_of(section, variant) {
                let bounds = match key.kind {
                    keys::Kind::Number(least, most) => Some((least, most)),
                    keys::Kind::Point2
                    | keys::Kind::Point3
                    | keys::Kind::Size
                    | keys::Kind::Range => None,
                    _ => continue,
                };
                all.push((format!("{name}.{}", key.name), bounds));
            }
        }
        all
    }
}

/// Millimetres as a person writes them.
fn mm(length: f64) -> String {
    format!("{} mm", (length * 1000.0).round() / 1000.0)
}

/// Whether any sensor or tool of the scene drives an input, an analog input or a counter. A scene that drives none
/// never changes what a script does.
#[must_use]
pub fn drives_anything(scene: &Scene) -> bool {
    let tool = |kind: &ToolKind| match kind {
        ToolKind::Vacuum(vacuum) => vacuum.input.is_some() || vacuum.analog.is_some(),
        ToolKind::Gripper(gripper) => {
            gripper.input_closed.is_some() || gripper.input_gripped.is_some()
        }
        ToolKind::Probe { .. } => true,
        _ => false,
    };
    scene.tools.iter().any(|one| tool(&one.kind))
        || scene.sensors.iter().any(|sensor| {
            sensor.input.is_some()
                || sensor.analog.is_some()
                || matches!(sensor.eye, Eye::Switch(..))
        })
        || scene.feeders.iter().any(|feeder| feeder.input.is_some())
        || scene.stock.as_ref().is_some_and(|stock| stock.touch.is_some())
        || scene.conveyors.iter().any(|conveyor| conveyor.counter.is_some())
        || !scene.persons.is_empty()
}
