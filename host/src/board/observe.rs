//! Observes the firmware's effects at its own code: the emulated chip stops in front of the routines that
//! report an effect, and their arguments are read. The chip executes the same instructions in the same
//! time, so an observed run is equal to an unobserved one.

use emulator::Board;
use lang::wire::{Seen, TraceKind};

/// Routine of the images in Rust (`firmware/f5529/observe.rs`).
const ROUTINE: &str = "pasapas_observe";

/// What was seen, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observed {
    /// Ticks since power-up.
    pub tick: u64,
    /// Address of the statement's instruction in the code of the program.
    pub pc: u16,
    /// What.
    pub sight: Sight,
}

/// What an observer sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sight {
    /// An event of the trace.
    Event {
        /// Its kind.
        kind: TraceKind,
        /// Its argument, [`lang::wire::TRACE_OK`] included.
        argument: u8,
        /// Its value.
        value: i32,
        /// Commanded machine positions of X, Y and Z at that instant, steps.
        commanded: [i32; 3],
    },
    /// A line of a course is taken that is joined to the next one: its end, um. No event tells of it, as nobody traces.
    Joined([i32; 3]),
    /// Something beside the events; the byte is that of [`Seen::Byte`].
    Beside(Seen, u8),
}

/// Where an image is looked at.
#[derive(Clone, Debug)]
pub enum Observer {
    /// An image in Rust: its one routine.
    Routine(u16),
    /// An image in assembly: its own labels and variables.
    Labels {
        /// An event, in registers.
        emit: u16,
        /// A byte of a line, in R12.
        print_taken: u16,
        /// A statement failed.
        raise: u16,
        /// A run begins.
        run_begun: u16,
        /// Variable: address of the effect's instruction.
        effect_pc: u16,
        /// Variable: address of the code.
        code: u16,
        /// Variable: commanded places, steps.
        steps: u16,
        /// Joined lines, of images that have them.
        joins: Option<Joins>,
    },
}

/// What tells of joined lines (`lang::image::course`): each takes its axes from those that are left.
#[derive(Clone, Debug)]
pub struct Joins {
    /// An effect has been looked at.
    done: u16,
    /// Variable: how many axes of joined lines are left, negative.
    left: u16,
    /// Variable: commanded places, um.
    um: u16,
    /// What was left at the last look.
    seen: i8,
}

impl Joins {
    fn of(board: &mut Board) -> Option<Joins> {
        let [done, left, um] = ["run_done", "JOINS", "UM"].map(|name| board.symbol(name));
        let joins = Joins { done: done?, left: left?, um: um?, seen: 0 };
        board.watch(joins.done);
        Some(joins)
    }

    fn look(&mut self, board: &Board) -> Option<Sight> {
        let left = board.peek8(self.left).cast_signed();
        let before = std::mem::replace(&mut self.seen, left);
        (left > before).then(|| Sight::Joined(places(board, self.um)))
    }
}

impl Observer {
    /// Watches the board's image from now on; `None` when it lacks a symbol that this takes.
    pub fn of(board: &mut Board) -> Option<Observer> {
        if let Some(routine) = board.symbol(ROUTINE) {
            board.watch(routine);
            return Some(Observer::Routine(routine));
        }
        let symbol = |name| board.symbol(name);
        let [emit, print_taken] = [symbol("emit")?, symbol("print_taken")?];
        let [raise, run_begun] = [symbol("raise")?, symbol("run_begun")?];
        let [effect_pc, code, steps] = [symbol("EFFECT_PC")?, symbol("VM_CODE")?, symbol("STEPS")?];
        for label in [emit, print_taken, raise, run_begun] {
            board.watch(label);
        }
        let joins = Joins::of(board);
        Some(Observer::Labels {
            emit,
            print_taken,
            raise,
            run_begun,
            effect_pc,
            code,
            steps,
            joins,
        })
    }

    /// What happens at `at`, where the board has stopped.
    pub fn look(&mut self, board: &Board, at: u32) -> Option<Observed> {
        let at = u16::try_from(at).ok()?;
        let (pc, sight) = match self {
            Observer::Routine(routine) if at == *routine => called(board)?,
            Observer::Labels {
                emit,
                print_taken,
                raise,
                run_begun,
                effect_pc,
                code,
                steps,
                joins,
            } => {
                let sight = if at == *emit {
                    let places = places(board, *steps);
                    event(board.reg(14) as u8, board.reg(15) as u8, long(board, 12), places)?
                } else if at == *print_taken {
                    Sight::Beside(Seen::Byte, board.reg(12) as u8)
                } else if at == *raise {
                    Sight::Beside(Seen::Abandoned, 0)
                } else if at == *run_begun {
                    if let Some(joins) = joins {
                        joins.seen = 0;
                    }
                    Sight::Beside(Seen::Begun, 0)
                } else {
                    joins.as_mut().filter(|joins| joins.done == at)?.look(board)?
                };
                (board.peek16(*effect_pc).wrapping_sub(board.peek16(*code)), sight)
            }
            Observer::Routine(_) => return None,
        };
        Some(Observed { tick: board.cycles(), pc, sight })
    }
}

/// The arguments of the routine: R12 kind and argument, R14:R13 value, R15 where the commanded places
/// stand, and behind the return address on the stack the instruction's address.
fn called(board: &Board) -> Option<(u16, Sight)> {
    let [kind, argument] = board.reg(12).to_le_bytes();
    let pc = board.peek16(board.reg(1).wrapping_add(2));
    let value = long(board, 13);
    let sight = if kind == TraceKind::None as u8 {
        Sight::Beside(Seen::from_number(u16::try_from(value).ok()?)?, argument)
    } else {
        event(kind, argument, value, places(board, board.reg(15)))?
    };
    Some((pc, sight))
}

fn event(kind: u8, argument: u8, value: i32, commanded: [i32; 3]) -> Option<Sight> {
    let kind = TraceKind::from_number(kind.into())?;
    Some(Sight::Event { kind, argument, value, commanded })
}

/// A value in two registers, the low word in `low`.
fn long(board: &Board, low: usize) -> i32 {
    (u32::from(board.reg(low)) | u32::from(board.reg(low + 1)) << 16).cast_signed()
}

/// Three long words of memory.
fn places(board: &Board, at: u16) -> [i32; 3] {
    [0, 4, 8].map(|offset| {
        let at = at.wrapping_add(offset);
        let words = u32::from(board.peek16(at)) | u32::from(board.peek16(at.wrapping_add(2))) << 16;
        words.cast_signed()
    })
}
