//! Named signals of the board and the record of their edges.

use std::fmt;

/// Letters of the axes.
const AXES: [char; 3] = ['x', 'y', 'z'];

/// A signal of the board, named as in a VCD file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Signal {
    /// STEP of an axis, 0 for X.
    Step(u8),
    /// DIR of an axis.
    Dir(u8),
    /// Output n as the world sees it: behind the 74HC595 and its output enable, or at the pin.
    Out(u8),
    /// Input n, the level at the 74HC165 or at the pin.
    In(u8),
    /// The Start button's pin, low when pressed.
    Start,
    /// The Stop button's pin, low when pressed.
    Stop,
    /// The probe's pin, low when it touches.
    Probe,
    /// The chip's receive pin.
    Rx,
    /// The chip's transmit pin.
    Tx,
    /// The pin of the PWM.
    Pwm,
    /// The pin of the analog output.
    Aout,
    /// Data to the RS-485 transceiver.
    Rs485,
    /// High while that drives its line.
    Drive,
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = |n: &u8| AXES.get(usize::from(*n)).copied().unwrap_or('?');
        match self {
            Signal::Step(n) => write!(f, "step_{}", axis(n)),
            Signal::Dir(n) => write!(f, "dir_{}", axis(n)),
            Signal::Out(n) => write!(f, "out_{n}"),
            Signal::In(n) => write!(f, "in_{n}"),
            Signal::Start => f.write_str("start"),
            Signal::Stop => f.write_str("stop"),
            Signal::Probe => f.write_str("probe"),
            Signal::Rx => f.write_str("rx"),
            Signal::Tx => f.write_str("tx"),
            Signal::Pwm => f.write_str("pwm"),
            Signal::Aout => f.write_str("aout"),
            Signal::Rs485 => f.write_str("rs485"),
            Signal::Drive => f.write_str("rs485_drive"),
        }
    }
}

/// A change of a signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// When, in ticks of the board since power-up.
    pub cycle: u64,
    /// Which signal.
    pub signal: Signal,
    /// Its level from then on.
    pub level: bool,
}

/// Something that is told of every edge as it happens.
pub type EdgeSink = Box<dyn FnMut(Edge) + Send>;

/// Edges kept in memory at most; a longer run must take them in time or use a sink.
const LIMIT: usize = 16 << 20;

/// Recorder of edges.
#[derive(Default)]
pub struct Recorder {
    /// Whether edges are kept.
    pub(crate) on: bool,
    pub(crate) sink: Option<EdgeSink>,
    pub(crate) edges: Vec<Edge>,
    /// Edges that were dropped because nobody took the earlier ones.
    pub dropped: u64,
}

impl Clone for Recorder {
    /// A copy without the sink, which belongs to one board.
    fn clone(&self) -> Self {
        let Recorder { on, ref edges, dropped, .. } = *self;
        Recorder { on, sink: None, edges: edges.clone(), dropped }
    }
}

impl Recorder {
    #[inline]
    pub(crate) fn active(&self) -> bool {
        self.on || self.sink.is_some()
    }

    pub(crate) fn add(&mut self, cycle: u64, signal: Signal, level: bool) {
        let edge = Edge { cycle, signal, level };
        if let Some(sink) = &mut self.sink {
            sink(edge);
        }
        if self.on {
            if self.edges.len() < LIMIT {
                self.edges.push(edge);
            } else {
                self.dropped += 1;
            }
        }
    }
}
