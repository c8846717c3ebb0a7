//! Value Change Dump (IEEE 1364, clause 18) of the board's signals.

use std::io::{self, Write};

use vcd::{IdCode, SimulationCommand, TimescaleUnit, Value, Writer};

use crate::record::{Edge, Signal};

/// Units of 100 ps in a second: a whole number of them is a tick of every part.
const UNITS_PER_SECOND: u64 = 10_000_000_000;

/// Writes edges as they come.
pub struct VcdWriter<W: Write> {
    writer: Writer<W>,
    ids: Vec<(Signal, IdCode)>,
    units_per_tick: u64,
    time: Option<u64>,
}

impl<W: Write> VcdWriter<W> {
    /// Writes the head and the levels at `cycle`, as `Plant::signals` gives them, for a board with
    /// `ticks_per_second`, as `Board::ticks_per_second` tells.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(
        out: W,
        signals: &[(Signal, bool)],
        cycle: u64,
        ticks_per_second: u64,
    ) -> io::Result<Self> {
        let units_per_tick = UNITS_PER_SECOND / ticks_per_second.clamp(1, UNITS_PER_SECOND);
        let mut writer = Writer::new(out);
        writer.timescale(100, TimescaleUnit::PS)?;
        writer.add_module("board")?;
        let mut ids = Vec::with_capacity(signals.len());
        for (signal, _) in signals {
            ids.push((*signal, writer.add_wire(1, &signal.to_string())?));
        }
        writer.upscope()?;
        writer.enddefinitions()?;
        writer.timestamp(cycle * units_per_tick)?;
        writer.begin(SimulationCommand::Dumpvars)?;
        for ((_, level), (_, id)) in signals.iter().zip(&ids) {
            writer.change_scalar(*id, *level)?;
        }
        writer.end()?;
        Ok(VcdWriter { writer, ids, units_per_tick, time: Some(cycle) })
    }

    /// Writes edges; they must be in the order of time.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&mut self, edges: &[Edge]) -> io::Result<()> {
        for edge in edges {
            let known = self.ids.iter().find(|(signal, _)| *signal == edge.signal);
            let Some((_, id)) = known.copied() else {
                continue;
            };
            self.at(edge.cycle)?;
            self.writer.change_scalar(id, Value::from(edge.level))?;
        }
        Ok(())
    }

    fn at(&mut self, cycle: u64) -> io::Result<()> {
        if self.time != Some(cycle) {
            self.time = Some(cycle);
            self.writer.timestamp(cycle * self.units_per_tick)?;
        }
        Ok(())
    }

    /// Marks the end of the recording at `cycle` and flushes.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self, cycle: u64) -> io::Result<()> {
        self.at(cycle)?;
        self.writer.flush()
    }
}
