//! Commanded positions of the axes, as far as the text of a program determines them: numbers that hold whenever
//! and however often a statement runs.

use lang::axis::{Axis, AxisSet};
use lang::effect::Frame;
use lang::hir::{Block, Expr, GosubTarget, Program, RoutineId, StmtKind, Word};
use lang::kind::Kind;
use lang::plain::Touch;

/// All axes.
const ALL: AxisSet = AxisSet(0b111);

/// A constant Length, um.
pub fn length(value: &Expr) -> Option<i32> {
    value.constant().filter(|_| value.kind == Kind::Length)
}

/// Work positions of the axes, um.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Known(pub [Option<i32>; 3]);

impl Known {
    /// What is known on both ways that lead to a place.
    pub fn join(&mut self, other: Known) {
        for (own, other) in self.0.iter_mut().zip(other.0) {
            *own = own.filter(|_| *own == other);
        }
    }

    /// These axes are anywhere.
    pub fn forget(&mut self, axes: AxisSet) {
        for axis in Axis::ALL.into_iter().filter(|axis| axes.contains(*axis)) {
            self.0[axis.index()] = None;
        }
    }

    fn follow(&mut self, axis: Axis, frame: Frame, value: &Expr) {
        let known = &mut self.0[axis.index()];
        let value = length(value);
        *known = match frame {
            Frame::Work => value,
            Frame::Relative => known.and_then(|at| at.checked_add(value?)),
            Frame::Machine => None,
        };
    }

    fn follow_words(&mut self, words: &[Option<Word>; 3]) {
        for axis in Axis::ALL {
            if let Some(word) = &words[axis.index()] {
                self.follow(axis, word.frame, &word.value);
            }
        }
    }

    /// A statement without blocks was executed.
    pub fn pass(&mut self, kind: &StmtKind, movers: &Movers) {
        match kind {
            StmtKind::Linear { to, .. } | StmtKind::Arc { to, .. } => self.follow_words(to),
            StmtKind::MoveAxe { axis, target, relative, start: false, .. } => {
                let frame = if *relative { Frame::Relative } else { Frame::Work };
                self.follow(*axis, frame, target);
            }
            StmtKind::SetPos { axis, value } => self.follow(*axis, Frame::Work, value),
            // Whoever jumps here comes from anywhere.
            StmtKind::Label(_) => self.forget(ALL),
            _ => self.forget(movers.moved_by(kind)),
        }
        self.forget(movers.any_time);
    }
}

/// Which axes a routine moves.
#[derive(Debug, Default)]
pub struct Movers {
    /// With all that it calls; `None` while it is not known.
    routines: Vec<Option<AxisSet>>,
    /// Axes that event handlers move.
    pub handlers: AxisSet,
    /// Axes that move at places where no statement says so: handlers', those of a FUNCTION in an
    /// expression, all where a program goes on behind a fault.
    any_time: AxisSet,
}

impl Movers {
    /// Those of a program.
    pub fn of(program: &Program) -> Movers {
        let mut movers =
            Movers { routines: vec![None; program.routines.len()], ..Movers::default() };
        for (n, routine) in program.routines.iter().enumerate() {
            movers.learn(program, RoutineId(n as u32));
            if routine.reachable && routine.result.is_some() {
                movers.any_time = join(movers.any_time, movers.routine(RoutineId(n as u32)));
            }
        }
        for routine in program.routines.iter().filter(|routine| routine.reachable) {
            movers.look(&routine.body);
        }
        movers.any_time = join(movers.any_time, movers.handlers);
        movers
    }

    fn routine(&self, id: RoutineId) -> AxisSet {
        self.routines.get(id.0 as usize).copied().flatten().unwrap_or(ALL)
    }

    /// Finds the routine's axes, behind those of the routines that it calls. No routine calls itself.
    fn learn(&mut self, program: &Program, id: RoutineId) {
        if self.routines[id.0 as usize].is_some() {
            return;
        }
        let mut called = Vec::new();
        calls(&program.routine(id).body, &mut called);
        for other in called {
            self.learn(program, other);
        }
        self.routines[id.0 as usize] = Some(self.moved_in(&program.routine(id).body));
    }

    /// Axes that the statements of a block move.
    pub fn moved_in(&self, block: &Block) -> AxisSet {
        block.iter().fold(AxisSet::default(), |axes, stmt| {
            let inner = stmt.kind.blocks().into_iter();
            let inner =
                inner.fold(AxisSet::default(), |axes, block| join(axes, self.moved_in(block)));
            join(axes, join(inner, self.moved_by(&stmt.kind)))
        })
    }

    /// Axes that a statement moves, or whose work zero it sets; without its blocks.
    fn moved_by(&self, kind: &StmtKind) -> AxisSet {
        let one = |axis: &Axis| AxisSet::default().with(*axis);
        let words = |words: &[Option<Word>]| {
            let given = Axis::ALL.into_iter().zip(words).filter(|(_, word)| word.is_some());
            given.fold(AxisSet::default(), |axes, (axis, _)| axes.with(axis))
        };
        match kind {
            StmtKind::Linear { to, .. } | StmtKind::Arc { to, .. } => words(&to[..]),
            StmtKind::Cycle(cycle) => words(&cycle.xy).with(Axis::Z),
            StmtKind::MoveAxe { axis, .. }
            | StmtKind::MoveSpeed { axis, .. }
            | StmtKind::StopAxe(axis)
            | StmtKind::Probe { axis, .. }
            | StmtKind::SetPos { axis, .. } => one(axis),
            StmtKind::Home { axes, .. } => {
                axes.iter().fold(AxisSet::default(), |set, axis| set.with(*axis))
            }
            StmtKind::Plain(plain, _) if plain.touches() == Touch::Axes => ALL,
            StmtKind::Gosub(GosubTarget::Label(_)) => ALL,
            StmtKind::Call(id, _) | StmtKind::Gosub(GosubTarget::Sub(id)) => self.routine(*id),
            _ => AxisSet::default(),
        }
    }

    /// Handlers that the statements of a block name.
    fn look(&mut self, block: &Block) {
        for stmt in block {
            match &stmt.kind {
                StmtKind::OnInput { target, .. } | StmtKind::OnEvery { target, .. } => {
                    let moved = match target {
                        GosubTarget::Sub(id) => self.routine(*id),
                        GosubTarget::Label(_) => ALL,
                    };
                    self.handlers = join(self.handlers, moved);
                }
                StmtKind::ResumeNext | StmtKind::Resume => self.any_time = ALL,
                _ => {}
            }
            for inner in stmt.kind.blocks() {
                self.look(inner);
            }
        }
    }
}

/// Routines that the statements of a block call.
fn calls(block: &Block, out: &mut Vec<RoutineId>) {
    for stmt in block {
        if let StmtKind::Call(id, _) | StmtKind::Gosub(GosubTarget::Sub(id)) = &stmt.kind {
            out.push(*id);
        }
        stmt.kind.blocks().into_iter().for_each(|inner| calls(inner, out));
    }
}

/// Axes of either set.
pub fn join(a: AxisSet, b: AxisSet) -> AxisSet {
    AxisSet(a.0 | b.0)
}
