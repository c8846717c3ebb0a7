//! The state of a board between two passes of the main loop, one field for each group that changes together.

mod act;
mod analog;
mod command;
mod control;
mod effect;
mod events;
mod handlers;
#[cfg(any(test, feature = "physics"))]
mod idle;
mod io;
mod keep;
mod library;
mod light;
mod power;
mod program;
mod run;
mod seek;
mod session;
mod talk;
mod tick;
pub mod trace;

pub use effect::{END, Effect, PULSE_BEGUN};
pub use events::{Event, PENDING, is_in_handler};
pub(super) use program::init;
pub use seek::Plan;

use crate::machine::chip::Chip;
use crate::machine::flash::{Area, Image};
use crate::machine::lines::Lines;
use crate::machine::lock::Lock;
use crate::machine::motor::Motor;
use crate::machine::reset;
use crate::machine::reset::Reset;
use crate::machine::stream::Stream;
use crate::machine::vm::Vm;
use crate::session::Session;
use crate::store::Store;
use crate::verify::{CODE, MACHINE};
use command::Command;
use io::Io;
use keep::{Carried, LEFT, Left};
use library::{Incoming, Library};
use light::Light;
use program::Program;
use seek::Seek;
use talk::Talk;
use tick::Clock;
use trace::Trace;

/// The board.
pub struct Controller<C: Chip> {
    /// What it runs on.
    pub chip: C,
    /// Registers of the VM.
    pub vm: Vm<C>,
    /// The profile.
    pub record: C::Profile,
    /// The lock of program and profile.
    pub lock: Lock,
    /// The last reset, and the next one.
    pub reset: Reset,
    /// The lines of the link.
    pub lines: Lines,
    /// Milliseconds.
    pub clock: Clock,
    /// Inputs and outputs.
    pub io: Io,
    /// A laser without a PWM.
    light: Light,
    /// Positions and what moves.
    pub motor: Motor<C>,
    /// Run state.
    pub session: Session,
    /// The program that runs.
    pub program: Program,
    /// What it and the host say to each other.
    pub talk: Talk,
    /// What a host in trace mode is told.
    pub trace: Trace,
    /// What a reference run or a probe move looks for.
    pub seek: Seek,
    /// InterpCNC commands.
    pub command: Command,
    /// Program store.
    pub store: Store,
    /// Which of its programs is meant.
    pub library: Library,
    /// What comes into it.
    pub incoming: Incoming,
    /// A job that is fed over the link.
    pub stream: Stream,
    /// KEEP values of the program that an upload replaces.
    carried: Carried,
    /// Those of programs that RUN has left.
    left: [Left; LEFT],
}

impl<C: Chip> Controller<C> {
    /// After a reset: outputs, program, what was going on.
    pub fn mount(&mut self) {
        self.io.outputs = self.record.reset_on;
        self.store.mount(&mut Area(self.chip.clone()));
        self.reselect();
        self.stored();
        if let Some([number, pc, _]) = reset::logged(&self.chip) {
            self.session.fault = number as u8;
            self.program.fault_input = (number >> 8) as u8;
            self.vm.fault = number as u8;
            if self.vm.code != 0 {
                self.vm.fault_pc = self.vm.code.wrapping_add(pc);
            }
        }
        if let Some(fault) = reset::interrupted(&self.chip, self.reset.cause) {
            self.session.latch(fault);
        }
    }

    /// Address of the stored image.
    pub fn image(&self) -> Option<u16> {
        self.store.image::<Area<C>>().map(|offset| C::AREA + offset)
    }

    /// The program area.
    pub(super) fn area(&self) -> Area<C> {
        Area(self.chip.clone())
    }

    /// What lies at an address.
    pub(super) fn image_at(&self, address: u16) -> Image<C> {
        Image(self.chip.clone(), address)
    }

    /// The verified program at an address is the stored one, or none is (0): see [`Vm::attach`].
    pub(super) fn attach(&mut self, image: u16) {
        self.vm.attach(image);
        self.take_axes();
    }

    /// The VM stands at the beginning of the verified image at an address: see [`Vm::begin`].
    pub(super) fn begin_image(&mut self, image: u16, kept: u16) {
        self.vm.begin(image, kept);
        self.take_axes();
    }

    /// The motor's axes are those of the program that the VM stands in.
    pub(super) fn take_axes(&mut self) {
        let machine = match self.vm.code {
            0 => self.chip.free_axes(),
            code => self.chip.axes_at(code - CODE + MACHINE),
        };
        self.motor.take(machine);
    }
}
