//! Output of a run: trace, record for plots, summary.

use lang::axis::Axis;
use lang::effect::{Coord, Dist, Effect, Frame};
use lang::fault::Fault;
use lang::record::AxisRecord;

use crate::sim::record::{
    Away, Begun, Edge, OutputUse, Printed, RECORD_LIMIT, Record, Segment, StopReason, Summary,
};
use crate::sim::trace::{Event, What};
use crate::sim::{End, Options, Sink};

#[derive(Clone, Copy, Debug, Default)]
struct Use {
    since: Option<u64>,
    switched_on: u32,
    on_us: u64,
}

/// See the module.
pub struct Log {
    sink: Sink,
    times: bool,
    keep: bool,
    axes: [AxisRecord; 3],
    record: Record,
    uses: [Use; 17],
    /// Times in which a program ran that is not shown.
    aways: Vec<Away>,
    /// The last effect, with its line.
    last: Option<(u32, Effect)>,
}

impl Log {
    /// Empty books.
    pub fn new(options: &Options, axes: [AxisRecord; 3], sink: Sink) -> Log {
        Log {
            sink,
            times: options.times,
            keep: options.record,
            axes,
            record: Record::default(),
            uses: [Use::default(); 17],
            aways: Vec::new(),
            last: None,
        }
    }

    /// A statement of this line has this effect; `None`: one that no fault may be laid to.
    pub const fn effect(&mut self, own: Option<(u32, Effect)>) {
        self.last = own;
    }

    /// Another program begins: one that is not shown, by RUN in this line, or the one that is.
    pub fn turn(&mut self, now: u64, away: Option<u32>) {
        let open = self.aways.last_mut().filter(|last| last.to_us == u64::MAX);
        match (away, open) {
            (None, Some(last)) => last.to_us = now,
            (Some(line), None) => self.aways.push(Away { from_us: now, to_us: u64::MAX, line }),
            _ => {}
        }
    }

    /// The line of the program that is shown for this one of the program that runs.
    pub fn shown(&self, line: u32) -> u32 {
        self.aways.last().filter(|last| last.to_us == u64::MAX).map_or(line, |last| last.line)
    }

    /// A line of the trace.
    pub fn write(&mut self, now: u64, what: What) {
        if let What::Print { line, text } = &what
            && self.room()
        {
            self.record.printed.push(Printed { us: now, line: *line, text: text.clone() });
        }
        (self.sink)(&Event { what, us: self.times.then_some(now) });
    }

    /// A statement of `line` begins.
    pub fn begin(&mut self, us: u64, line: u32) {
        match self.record.begun.last_mut() {
            Some(last) if last.line == line => return,
            // What took no time is not seen.
            Some(last) if last.us == us => return last.line = line,
            _ => {}
        }
        if self.room() {
            self.record.begun.push(Begun { us, line });
        }
    }

    /// An input changed behind its filter.
    pub fn input(&mut self, us: u64, n: i32, on: bool) {
        if self.room() {
            self.record.inputs.push(Edge { us, n, on });
        }
    }

    /// An output changed at its terminal.
    pub fn output(&mut self, us: u64, n: i32, on: bool) {
        if self.room() {
            self.record.outputs.push(Edge { us, n, on });
        }
        let Some(line) = usize::try_from(n).ok().and_then(|n| self.uses.get_mut(n)) else { return };
        if on {
            line.since = Some(us);
            line.switched_on += 1;
        } else if let Some(since) = line.since.take() {
            line.on_us += us.saturating_sub(since);
        }
    }

    fn room(&mut self) -> bool {
        let record = &mut self.record;
        let edges = record.inputs.len() + record.outputs.len();
        let used = record.path.len() + edges + record.begun.len() + record.printed.len();
        record.truncated |= self.keep && used >= RECORD_LIMIT;
        self.keep && used < RECORD_LIMIT
    }

    /// A piece of the path begins; gives its number for [`Log::segment`].
    pub fn begin_segment(&mut self, segment: Segment) -> Option<usize> {
        self.room().then(|| {
            self.record.path.push(segment);
            self.record.path.len() - 1
        })
    }

    /// A piece of the path, to complete it.
    pub fn segment(&mut self, number: Option<usize>) -> Option<&mut Segment> {
        number.and_then(|number| self.record.path.get_mut(number))
    }

    /// The run is over: these outputs, which stay on, count until now.
    pub fn close(&mut self, now: u64, on: impl Iterator<Item = i32>) {
        for n in on {
            if let Some(line) = self.uses.get_mut(n as usize)
                && let Some(since) = line.since.take()
            {
                line.on_us += now.saturating_sub(since);
            }
        }
    }

    /// Where a move was to go whose target lies outside the travel, in words.
    fn asked(&self, end: &End) -> Option<String> {
        let (_, effect) = self.last.filter(|(line, _)| *line == end.line)?;
        let word = |(axis, to): (Axis, Coord)| {
            let value = match to.value {
                Dist::Um(um) => format!("{:.3} mm", f64::from(um) / 1000.0),
                Dist::Steps(steps) => format!("{steps} steps"),
            };
            let frame = match to.frame {
                Frame::Work => "to",
                Frame::Machine => "to machine position",
                Frame::Relative => "by",
            };
            format!("{} {frame} {value}", axis.letter())
        };
        let arc = matches!(effect, Effect::Arc { .. }).then(|| "an arc".to_owned());
        let words = effect.targets().into_iter().flatten().map(word);
        let words: Vec<String> = arc.into_iter().chain(words).collect();
        let outside = end.fault == Some(Fault::SoftLimit) && !words.is_empty();
        outside.then(|| words.join(", "))
    }

    /// The numbers and the record.
    pub fn results(
        &mut self,
        end: &End,
        stopped: Option<StopReason>,
        now: u64,
        statements: u64,
        steps: [u64; 3],
    ) -> (Summary, Record) {
        let used = |(n, line): (usize, &Use)| {
            (line.switched_on > 0).then_some(OutputUse {
                n: n as i32,
                switched_on: line.switched_on,
                on_us: line.on_us,
            })
        };
        let travel_um = [0, 1, 2].map(|index: usize| {
            let axis = &self.axes[index];
            steps[index] * u64::from(axis.um) / u64::from(axis.steps.max(1))
        });
        let summary = Summary {
            status: end.status,
            fault: end.fault.map(|fault| fault.to_string()),
            stopped,
            line: end.line,
            program: None,
            asked: self.asked(end),
            us: now,
            statements,
            steps,
            travel_um,
            outputs: self.uses.iter().enumerate().filter_map(used).collect(),
        };
        let mut record = std::mem::take(&mut self.record);
        record.show(&self.aways);
        (summary, record)
    }
}
