//! The chip on a board: one of the families, each with its own core and bus.

use crate::bus::Bus;
use crate::cpu::Cpu;
use crate::f5::bus::Bus as BusX;
use crate::f5::cpu::CpuX;

/// MSP430x2xx.
#[derive(Clone)]
pub struct Msp430 {
    pub cpu: Cpu,
    pub bus: Bus,
}

/// MSP430x5xx.
#[derive(Clone)]
pub struct Msp430X {
    pub cpu: CpuX,
    pub bus: BusX,
}

/// A chip of either family.
#[derive(Clone)]
pub enum Chip {
    /// 16-bit core.
    Msp430(Box<Msp430>),
    /// 20-bit core.
    Msp430X(Box<Msp430X>),
}

/// Evaluates an expression on the chip, whichever it is: both have a `cpu` and a `bus` with fields
/// and methods of the same names, but of their own address widths.
macro_rules! with {
    ($chip:expr, $c:ident => $body:expr) => {
        match $chip {
            $crate::board::chip::Chip::Msp430($c) => $body,
            $crate::board::chip::Chip::Msp430X($c) => $body,
        }
    };
}
pub(super) use with;
