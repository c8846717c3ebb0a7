//! Times of paths against a planner that knows the whole path.
//!
//! Each job of the set ([`jobs`]) runs on each part from its store, and streamed where the part can stream. The time between
//! the edges of output 1 is divided by that of the ideal planner ([`ideal`]) over the same points. Stored jobs run once more
//! with their trace, and the times of its events are compared with the simulator's, as those at the pins are. A checker
//! compares every step of every run with ramps, top rates and corners.

mod ideal;
mod jobs;
mod pace;
pub mod pictures;

use std::time::Duration;

use emulator::Edge;
use lang::back;
use lang::hir::Program;
use lang::image::Image;
use lang::profile::Profile;

use super::code::program;
use super::path::{between, simulated_trace};
use super::stand::{Stand, gate};
use super::{Sink, at_least, at_most};
use crate::board::engine::run_traced;
use crate::board::{Build, F5529, G2553};
use crate::course;
use crate::sim::Options;
use crate::sim::trace::{self, Event};
use crate::sim::world::World;
use crate::torture::times::{LATER_US, apart};
use ideal::{Best, Machine};
use jobs::Job;

/// The longest job, of the board's time.
const LIMIT: Duration = Duration::from_secs(300);
/// Blocks of which the small part is to make more than of others, s: planning one takes it 3 ms.
const LONG_BLOCK: f64 = 0.010;

/// Blocks of the loop that is planned as fast as the board can.
const BLOCKS: u32 = 1_000;

/// Ratios of a class of jobs: the name of its worst, what must be reached and what is aimed at of the
/// worst, then of the mean.
struct Class {
    name: &'static str,
    worst: [f64; 2],
    mean: [f64; 2],
}

const ON_F5529: Class = Class { name: "", worst: [1.05, 1.02], mean: [1.02, 1.01] };
const LONG: Class = Class { name: "_g2553_long", worst: [1.10, 1.05], mean: [1.10, 1.05] };
const OTHERS: Class = Class { name: "_g2553_others", worst: [1.5, 1.2], mean: [1.5, 1.2] };

/// The runs of the set on one part, one way.
struct Way {
    stand: Stand,
    build: &'static Build,
    streamed: bool,
}

/// Figures `path_over_ideal_worst` and `path_over_ideal_mean` of the F5529, stored and streamed,
/// those of the G2553 apart, stored, for blocks of 10 ms and more and for others; before them each job's. Behind
/// them `blocks_planned_f5529`, and `path_vm_off_worst`: how far a time of the simulator's is from that of a part,
/// stored, streamed or traced; and `path_events_off_worst`: the same of each event on the F5529, in what is allowed of it,
/// 1 ms or a thousandth of the time.
///
/// # Errors
/// A job does not run, tells another trace than the simulator, or makes steps that no motor of the profile follows.
pub fn run(sink: Sink<'_>) -> Result<(), String> {
    measure(&jobs::all(), sink)
}

/// The same with the few jobs that stand for all.
///
/// # Errors
/// As [`run`].
pub fn run_short(sink: Sink<'_>) -> Result<(), String> {
    let jobs: Vec<Job> = jobs::all().into_iter().filter(|job| job.short).collect();
    measure(&jobs, sink)
}

fn measure(jobs: &[Job], sink: Sink<'_>) -> Result<(), String> {
    let mill = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let machine = Machine::of(&mill);
    let mut ways = [(&F5529, false), (&F5529, true), (&G2553, false)]
        .map(|(build, streamed)| Way::on(build, &mill, streamed))
        .into_iter()
        .collect::<Result<Vec<Way>, String>>()?;
    let classes = [ON_F5529, LONG, OTHERS];
    let mut ratios: [Vec<f64>; 3] = Default::default();
    let mut vm_off = (0.0, String::new());
    let mut events_off = (0.0, String::new());
    let mut wrong = Vec::new();
    for job in jobs {
        let best = machine.best(&job.legs);
        let (checked, _) = program(&job.name, &job.text)?;
        for way in &mut ways {
            let name = format!("{}/{}", job.name, way.name());
            let seconds = match way.seconds(&checked) {
                Ok(Some(seconds)) => seconds,
                Ok(None) => continue,
                Err(error) => {
                    wrong.push(format!("{name}: {error}"));
                    way.stand = Stand::on(way.build, &mill)?;
                    continue;
                }
            };
            let told = simulated_trace(&checked, &way.build.part)?;
            let planned = between(&told)?;
            let mut times = vec![(name.clone(), seconds)];
            if !way.streamed {
                match way.traced(&checked, &told) {
                    Ok((seconds, (off, place))) => {
                        times.push((format!("{name}_traced"), seconds));
                        if way.build.part == F5529.part && off > events_off.0 {
                            events_off = (off, format!("{name}: {place}"));
                        }
                    }
                    Err(error) => wrong.push(format!("{name}, traced: {error}")),
                }
            }
            for (name, seconds) in times {
                let off = (seconds - planned).abs() / planned * 100.0;
                if off > vm_off.0 {
                    vm_off = (off, format!("{name}: {planned:.3} s for {seconds:.3}"));
                }
            }
            let class = way.class(&best);
            let [must, aim] = classes[class].worst;
            let ratio = seconds / best.seconds;
            ratios[class].push(ratio);
            let mut figure = at_most(name, "of ideal", ratio, must, aim);
            figure.note = format!("{seconds:.3} s of {:.3}", best.seconds);
            sink(figure)?;
        }
    }
    for (class, ratios) in classes.iter().zip(&ratios).filter(|(_, ratios)| !ratios.is_empty()) {
        let worst = ratios.iter().copied().fold(0.0, f64::max);
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        let [must, aim] = class.worst;
        let name = |what: &str| format!("path_over_ideal_{what}{}", class.name);
        sink(at_most(name("worst"), "of ideal", worst, must, aim))?;
        let [must, aim] = class.mean;
        sink(at_most(name("mean"), "of ideal", mean, must, aim))?;
    }
    if let Some(stored) = ways.first_mut() {
        sink(at_least("blocks_planned_f5529", "blocks/s", stored.planned()?, 800.0, 1_500.0))?;
    }
    let mut figure = at_most("path_vm_off_worst", "%", vm_off.0, 0.5, 0.2);
    figure.note = vm_off.1;
    sink(figure)?;
    let mut figure = at_most("path_events_off_worst", "of 1 ms or 0.1 %", events_off.0, 10.0, 1.0);
    figure.note = events_off.1;
    sink(figure)?;
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("; ")) }
}

impl Way {
    fn on(build: &'static Build, mill: &Profile, streamed: bool) -> Result<Way, String> {
        Ok(Way { stand: Stand::on(build, mill)?, build, streamed })
    }

    fn name(&self) -> String {
        let how = if self.streamed { "streamed" } else { "stored" };
        format!("{}_{how}", self.build.part.name)
    }

    /// Index of the class of a job's ratio.
    fn class(&self, best: &Best) -> usize {
        match self.build.part == G2553.part {
            false => 0,
            true if best.leg >= LONG_BLOCK => 1,
            true => 2,
        }
    }

    /// Blocks a second that the board plans, of one step of two axes each, in a loop.
    fn planned(&mut self) -> Result<f64, String> {
        let text = format!(
            "G90\nG0 X0 Y0 Z0\nF4800\nSetOut 1, ON\nG91\nREPEAT {BLOCKS}\nG1 X0.01 Y0.01\n\
             END REPEAT\nSetOut 1, OFF\n"
        );
        let (checked, _) = program("blocks", &text)?;
        let seconds = self.seconds(&checked)?.ok_or("this board has no room for a loop")?;
        Ok(f64::from(BLOCKS) / seconds)
    }

    /// What a job takes at the pins; `None` where the part lacks what it needs, or room for it.
    fn seconds(&mut self, checked: &Program) -> Result<Option<f64>, String> {
        let Some(edges) = self.edges(checked)? else { return Ok(None) };
        Ok(Some(gate(&edges)? as f64 / emulator::TICKS_PER_SECOND as f64))
    }

    /// Seconds between the outputs' events in the trace of a run on the emulated board, which has to tell what the
    /// simulator `told`, event by event, and how far these are [`apart`].
    fn traced(&self, checked: &Program, told: &[Event]) -> Result<(f64, (f64, String)), String> {
        let part = self.build.part;
        let compiled = back::compile(checked).map_err(|excesses| format!("{excesses:?}"))?;
        let compiled = course::put_into(compiled, checked, &part);
        let options = Options { record: false, part, ..Options::default() };
        let (image, sidecar) = (&compiled.image, &compiled.sidecar);
        let (run, trace) =
            run_traced(self.build, checked, image, sidecar, &World::empty(), &options)
                .map_err(|error| error.to_string())?;
        if let Some(failure) = run.outcome.failures.first() {
            return Err(failure.clone());
        }
        if trace::to_text(&trace) != trace::to_text(told) {
            return Err("the board's trace is not the simulator's".to_owned());
        }
        Ok((between(&trace)?, apart(told, &trace, LATER_US)?))
    }

    /// The edges at the pins in a run of a job, at cycles of 16 MHz; `None` as of [`Way::seconds`].
    fn edges(&mut self, checked: &Program) -> Result<Option<Vec<Edge>>, String> {
        let compiled = back::compile(checked).map_err(|excesses| format!("{excesses:?}"))?;
        if self.streamed {
            Ok(Some(self.stand.stream(&compiled)?.0))
        } else {
            let compiled = course::put_into(compiled, checked, &self.build.part);
            let image = Image::new(&compiled.image).map_err(|flaw| format!("{flaw:?}"))?;
            let small = compiled.image.len() > self.build.part.room_for(false);
            if small || self.build.part.lacks(&image, &checked.profile).is_some() {
                return Ok(None);
            }
            self.stand.upload(&compiled.image)?;
            Ok(Some(self.stand.run(LIMIT)?))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lang::wire::OVERRIDES;

    fn stored(mill: &Profile) -> Way {
        Way::on(&F5529, mill, false).expect("a board")
    }

    /// Seconds of a job's script.
    fn run(way: &mut Way, name: &str, text: &str) -> Option<f64> {
        let (checked, _) = program(name, text).expect("a script");
        way.seconds(&checked).expect("a run")
    }

    /// Look-ahead brings the F5529 within 5 % of what a planner that knows all of a path can, under an override of one
    /// that would have that feed: up to F3000, for which the ring is deep enough.
    #[test]
    fn stored_paths_take_hardly_longer_than_the_ideal_planners() {
        let mill = Profile::built_in("mill").expect("the mill");
        let machine = Machine::of(&mill);
        let mut way = stored(&mill);
        for percent in [100, 50, 200] {
            way.stand.client().write(OVERRIDES, percent).expect("taken");
            for job in jobs::all().into_iter().filter(|job| job.short) {
                let mut legs = job.legs.clone();
                legs.iter_mut().for_each(|leg| leg.feed *= f64::from(percent) / 100.0);
                if legs.iter().any(|leg| leg.feed > 50_000.0) {
                    continue;
                }
                // Of a feed that its radius does not allow, an arc takes the percentage of what it allows.
                if percent < 100 && job.name.contains("arcs") {
                    continue;
                }
                let best = machine.best(&legs);
                let Some(seconds) = run(&mut way, &job.name, &job.text) else { continue };
                let ratio = seconds / best.seconds;
                let fits = (0.99..=ON_F5529.worst[0]).contains(&ratio);
                assert!(fits, "{} at {percent} %: {ratio:.3}", job.name);
            }
        }
    }

    /// Lines as short as slow points make them come in time on the small chip, whatever a host asks meanwhile.
    #[test]
    fn lines_of_a_course_come_in_time_while_a_host_asks_for_all_it_can() {
        let mill = Profile::built_in("mill").expect("the mill");
        let alone = |words: [&str; 2]| {
            let line = |words: &str| format!("way = way + 0.1mm\nG1 {words}\n");
            let body: String = words.map(line).concat();
            format!(
                "DIM i\nDIM way AS LENGTH\nG90\nG0 X0 Y0 Z0\nF3000\nSetOut 1, ON\n\
                 FOR i = 1 TO 150\n{body}NEXT\nSetOut 1, OFF\n"
            )
        };
        let joined = |words: &str| {
            format!(
                "G90\nG0 X0 Y0 Z0\nF3000\nSetOut 1, ON\nG91\nREPEAT 800\nG1 {words}\nEND REPEAT\n\
                 G90\nSetOut 1, OFF\n"
            )
        };
        let texts = [
            alone(["X[way]", "X[way] Y0"]),
            alone(["X[way] Y[way]", "X[way] Y[way] Z0"]),
            joined("X0.05"),
            joined("X0.05 Y0.04"),
            joined("X0.06 Y0.05 Z-0.02"),
        ];
        let mut stand = Stand::on(&G2553, &mill).expect("a board");
        for text in texts {
            let (checked, _) = program("short", &text).expect("a script");
            let compiled = back::compile(&checked).expect("it fits");
            let compiled = course::put_into(compiled, &checked, &G2553.part);
            stand.upload(&compiled.image).expect("taken");
            for rest in 0..4 {
                let rest = Duration::from_millis(rest);
                stand.run_asking(LIMIT, rest).unwrap_or_else(|error| panic!("{error}: {text}"));
            }
        }
    }

    /// With G61 each line goes from rest to rest, and what comes between takes some 3 ms.
    #[test]
    fn exact_stops_are_made_on_every_path() {
        let mill = Profile::built_in("mill").expect("the mill");
        let machine = Machine::of(&mill);
        let mut way = stored(&mill);
        let lines =
            |job: &Job| job.short && job.legs.iter().all(|leg| leg.kind != ideal::Kind::Arc);
        for job in jobs::all().into_iter().filter(lines) {
            let (mut from, mut best) = ([0.0; 3], 0.0);
            for leg in &job.legs {
                let to = std::array::from_fn(|n| leg.to[n] - from[n]);
                best += machine.best(&[ideal::Leg { to, ..*leg }]).seconds;
                from = leg.to;
            }
            let text = job.text.replacen("G90\n", "G90\nG61\n", 1);
            let Some(seconds) = run(&mut way, &job.name, &text) else { continue };
            let between = (seconds - best) / job.legs.len() as f64;
            assert!((0.0..0.004).contains(&between), "{}: {between:.4} s between lines", job.name);
        }
    }
}
