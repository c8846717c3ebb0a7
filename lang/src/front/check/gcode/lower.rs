//! From a G-code block to statements, in the order of execution of RS274/NGC 3.8.

use super::block::{Block, Motion, Special};
use super::cycle;
use super::modal::{self, Group};
use super::word::Context;
use crate::axis::Axis;
use crate::effect::{Frame, Plane};
use crate::front::ast::{GWord, Stmt};
use crate::front::check::Checker;
use crate::front::check::expr::{number, value_of};
use crate::front::check::stmt::{Lowered, Then};
use crate::front::codes::Code;
use crate::front::diag::Diag;
use crate::front::span::Span;
use crate::hir::{ProbeSensor, StmtKind, Word};
use crate::kind::Kind;
use crate::plain::Plain;
use crate::profile::OutputRole;
use crate::record::FOLLOWS;

impl<'a> Checker<'a> {
    /// Lowers one block.
    pub(in crate::front::check) fn gcode_block(
        &mut self,
        words: &'a [GWord],
        stmt: &'a Stmt,
    ) -> Option<Lowered> {
        if words.is_empty() {
            return Some((Vec::new(), Then::GoesOn));
        }
        let index = *self.gcode.by_place.get(&stmt.span.start)?;
        let block = self.gcode.take(index)?;
        let lowered = if block.broken { None } else { self.lower_block(index, &block, stmt.line) };
        let then = if block.ends() { Then::Never } else { Then::GoesOn };
        self.gcode.put_back(index, block);
        Some((lowered?, then))
    }

    fn lower_block(&mut self, index: u32, block: &Block<'a>, line: u32) -> Option<Vec<StmtKind>> {
        let before = self.gcode.states.state(index);
        // A block that nothing reaches is checked as if it stood at the start.
        let mut state = before.unwrap_or_else(|| modal::State::start(true));
        self.gcode.apply(index, block, &mut state);
        let context = Context { state, span: block.span, line };
        let mut out = Vec::new();
        let mut ok = true;
        if let Some(f) = block.f {
            match self.feed_word(f, &context) {
                Some(feed) => {
                    self.check_feed(&feed, f.span);
                    out.push(StmtKind::SetFeed(feed));
                }
                None => ok = false,
            }
        }
        if let Some(s) = block.s {
            match self.number_word(s) {
                Some(speed) => {
                    self.check_power(&speed, s.span);
                    out.push(StmtKind::SetSpindle(speed));
                }
                None => ok = false,
            }
        }
        let (stops, switches): (Vec<_>, Vec<_>) =
            block.m.iter().partition(|(m, _)| matches!(m, 0..=2 | 30));
        for (m, span) in switches {
            let switched = match m {
                62..=65 => self.numbered(m, block, span),
                67 | 68 => self.analog_output(m, block, span),
                _ => self.switch(m, span),
            };
            match switched {
                Some(kind) => out.push(kind),
                None => ok = false,
            }
        }
        if block.dwell {
            match block.p {
                Some(p) => match self.seconds_word(p) {
                    Some(time) => out.push(StmtKind::Plain(Plain::Wait, vec![time])),
                    None => ok = false,
                },
                None => {
                    self.error(
                        Code::GcodeMissing,
                        block.span,
                        "G4 without its time",
                        "write `G4 P0.5`: seconds",
                    );
                    ok = false;
                }
            }
        }
        if block.tolerance
            && let Some(p) = block.p
        {
            ok &= self.tolerance(p, &context).is_some();
        }
        match self.motion_of(index, block, &context) {
            Some(motions) => out.extend(motions),
            None => ok = false,
        }
        if self.gcode.lets_go(index, block, &context.state) {
            let class = cycle::class_of(&context.state);
            out.extend(self.release(class));
        }
        for (m, _) in stops {
            match m {
                0 => out.push(StmtKind::Plain(Plain::WaitStart, Vec::new())),
                1 if self.profile.optional_stop => {
                    out.push(StmtKind::Plain(Plain::WaitStart, Vec::new()))
                }
                1 => {}
                _ => out.push(StmtKind::End),
            }
        }
        ok.then(|| self.block_in_order(out))
    }

    /// P of G64: the machine has one tolerance, its profile's. Another one here is told.
    fn tolerance(&mut self, word: &'a GWord, context: &Context) -> Option<()> {
        let value = self.distance_word(word, context, false)?;
        let corner = self.profile.corner_um;
        if value.kind != Kind::Length || value_of(&value) != Some(corner) {
            let name = &self.profile.name;
            let message = format!("P changes nothing: `{name}` rounds corners by up to {corner}um");
            let hint = "leave P out, or set `corner_um` in the profile";
            self.error(Code::GcodeTolerance, word.span, message, hint);
        }
        Some(())
    }

    /// M3 to M9.
    fn switch(&mut self, m: i64, span: Span) -> Option<StmtKind> {
        let (role, what, on) = match m {
            6 => return Some(StmtKind::Plain(Plain::WaitStart, Vec::new())),
            4 if self.profile.follows_speed() => (OutputRole::Spindle, "spindle", FOLLOWS),
            3 | 4 => (OutputRole::Spindle, "spindle", 1),
            5 => (OutputRole::Spindle, "spindle", 0),
            7 | 8 => (OutputRole::Coolant, "coolant", 1),
            _ => (OutputRole::Coolant, "coolant", 0),
        };
        let n = match role {
            OutputRole::Spindle => self.profile.switched(),
            _ => self.profile.output_with(role).map(|output| output.n),
        };
        let Some(n) = n else {
            let message = format!("the machine `{}` has no {what} output", self.profile.name);
            let hint =
                format!("give an output of the profile the role {what}, or write `SetOut n, ON`");
            self.error(Code::NoPort, span, message, hint);
            return None;
        };
        let values = vec![number(n, Kind::Number, span), number(on, Kind::Truth, span)];
        Some(StmtKind::Plain(Plain::SetOut, values))
    }

    /// What the axis words of the block ask for.
    fn motion_of(
        &mut self,
        index: u32,
        block: &Block<'a>,
        context: &Context,
    ) -> Option<Vec<StmtKind>> {
        match block.special {
            Some(special) => {
                self.no_meaning(block, &[], takes_p(block))?;
                match special {
                    Special::Home => self.reference(block, context),
                    Special::Offset => self.offset(block, context),
                    Special::Probe { quiet } => self.probe_block(block, context, quiet),
                }
            }
            None => self.modal_motion(index, block, context),
        }
    }

    fn modal_motion(
        &mut self,
        index: u32,
        block: &Block<'a>,
        context: &Context,
    ) -> Option<Vec<StmtKind>> {
        let asks = block.has_axis()
            || block.offsets.iter().any(Option::is_some)
            || [block.r, block.q, block.l].iter().any(Option::is_some)
            || (block.p.is_some() && !takes_p(block))
            || block.machine;
        if !asks {
            return Some(Vec::new());
        }
        let motion = Motion::from_value(self.modal(context, Group::Motion)?);
        if motion == Motion::None {
            return self.no_motion(block);
        }
        let letters: &[char] = match motion {
            Motion::ArcCw | Motion::ArcCcw => &['I', 'J', 'K', 'R'],
            Motion::Drill => &['R', 'L', 'P', 'Q'],
            Motion::DrillDwell | Motion::Peck => &['R', 'L', 'P', 'Q'],
            _ => &[],
        };
        self.no_meaning(block, letters, takes_p(block))?;
        if block.machine && !matches!(motion, Motion::Rapid | Motion::Line) {
            let message = format!("G53 with {}", motion.word());
            self.error(Code::GcodeNoMeaning, block.span, message, "G53 goes with G0 or G1");
            return None;
        }
        if !block.moves(motion) && !motion.is_cycle() {
            return self.nothing_moves(block, motion);
        }
        match motion {
            Motion::Rapid | Motion::Line => {
                let to = self.axis_words(block, context)?;
                let rapid = motion == Motion::Rapid;
                let mut out = if rapid { Vec::new() } else { self.need_feed(context)? };
                let exact = !rapid && self.modal(context, Group::Exact)? == 1;
                self.gcode.follow(&to);
                let to = Box::new(without_idle_words(to));
                if !rapid {
                    let moved = Axis::ALL.into_iter().filter(|axis| to[axis.index()].is_some());
                    self.note_path(moved, false);
                }
                out.push(StmtKind::Linear { rapid, to, exact });
                Some(out)
            }
            Motion::ArcCw | Motion::ArcCcw => self.arc(block, context, motion == Motion::ArcCw),
            _ => self.cycle(index, block, context, motion),
        }
    }

    /// Offsets or a centre without a move.
    fn nothing_moves(&mut self, block: &Block<'a>, motion: Motion) -> Option<Vec<StmtKind>> {
        let message = format!("{} without axis words moves nothing", motion.word());
        self.error(Code::GcodeMissing, block.span, message, "write where to go: X, Y or Z");
        None
    }

    /// Words that need a motion mode where none holds.
    fn no_motion(&mut self, block: &Block<'a>) -> Option<Vec<StmtKind>> {
        let message = "no motion mode holds here, so these words have no meaning";
        self.error(Code::GcodeNoMeaning, block.span, message, "write G0, G1, G2 or G3 before them");
        None
    }

    /// An error for each of I J K R P Q L that is not among `letters`.
    fn no_meaning(&mut self, block: &Block<'a>, letters: &[char], p_taken: bool) -> Option<()> {
        let words = block
            .offsets
            .iter()
            .flatten()
            .chain([&block.r, &block.q, &block.l].into_iter().flatten());
        let p = block.p.iter().filter(|_| !p_taken);
        let mut clean = true;
        for word in words.chain(p) {
            if letters.contains(&word.letter) {
                continue;
            }
            let hint = match word.letter {
                'I' | 'J' | 'K' => "I J K belong to G2 and G3",
                'R' => "R belongs to G2, G3 and the canned cycles",
                'P' => "P belongs to G4 and G82",
                'Q' => "Q belongs to G83",
                _ => "L belongs to the canned cycles",
            };
            let message = format!("{} has no meaning in this block", word.letter);
            self.error(Code::GcodeNoMeaning, word.span, message, hint);
            clean = false;
        }
        clean.then_some(())
    }

    /// The axis words as targets.
    pub(super) fn axis_words(
        &mut self,
        block: &Block<'a>,
        context: &Context,
    ) -> Option<[Option<Word>; 3]> {
        let mut to = [None, None, None];
        let mut ok = true;
        for axis in Axis::ALL {
            if let Some(word) = block.axes[axis.index()] {
                to[axis.index()] = self.axis_word(axis, word, context, block.machine);
                ok &= to[axis.index()].is_some();
            }
        }
        ok.then_some(to)
    }

    /// A move with feed: says so where none reaches it, or brings the profile's.
    pub(super) fn need_feed(&mut self, context: &Context) -> Option<Vec<StmtKind>> {
        let feed = context.state.get(Group::Feed);
        let Some([low, high]) = feed.written else { return Some(Vec::new()) };
        let default = self.profile.default_feed_um_s;
        if low.0 == modal::NO_FEED {
            if high.0 == modal::NO_FEED
                && let Some(default) = default
            {
                self.tell_default_feed(context.span, default);
                return Some(vec![StmtKind::SetFeed(number(default, Kind::Speed, context.span))]);
            }
            let mut diag = if high.0 == modal::NO_FEED {
                Diag::new(Code::GcodeFeed, context.span, "no F reaches this block")
            } else {
                Diag::new(Code::GcodeFeed, context.span, "no F reaches this block on one way")
                    .label(high.1, "an F comes from here on another")
            };
            if low.1 != Span::default() {
                diag = diag.label(low.1, "a handler begins from here, without F");
            }
            self.diags
                .push(diag.hint("write the feed in this block: `F300` is 300 mm/min under G21"));
            return None;
        }
        if low.0 == modal::DEFAULT_FEED
            && let Some(default) = default
        {
            self.tell_default_feed(context.span, default);
        }
        Some(Vec::new())
    }

    fn tell_default_feed(&mut self, span: Span, um_s: i32) {
        if !core::mem::replace(&mut self.gcode.default_feed_told, true) {
            let message = format!("no F reaches this block: the profile's {um_s}um/s holds");
            self.error(Code::GcodeDefaultFeed, span, message, "write F to say so");
        }
    }

    /// G28: a rapid through the given point to machine 0.
    fn reference(&mut self, block: &Block<'a>, context: &Context) -> Option<Vec<StmtKind>> {
        let zero =
            |span| Some(Word { value: number(0, Kind::Length, span), frame: Frame::Machine });
        let mut home = [None, None, None];
        let mut out = Vec::new();
        if block.has_axis() {
            let through = self.axis_words(block, context)?;
            for (home, word) in home.iter_mut().zip(&through) {
                *home = word.as_ref().and_then(|_| zero(block.span));
            }
            let to = Box::new(through);
            out.push(StmtKind::Linear { rapid: true, to, exact: false });
        } else {
            for (axis, _) in self.profile.axes() {
                home[axis.index()] = zero(block.span);
            }
        }
        self.gcode.forget_position();
        out.push(StmtKind::Linear { rapid: true, to: Box::new(home), exact: false });
        Some(out)
    }

    /// G92
    fn offset(&mut self, block: &Block<'a>, context: &Context) -> Option<Vec<StmtKind>> {
        let mut out = Vec::new();
        for axis in Axis::ALL {
            let Some(word) = block.axes[axis.index()] else { continue };
            if !self.has_axis(axis, word.span) {
                return None;
            }
            let value = self.distance_word(word, context, false)?;
            if value.kind != Kind::Length {
                let hint = "convert it: `LENGTH(X, steps)`";
                self.error(Code::ArgumentKind, word.span, "G92 needs a Length", hint);
                return None;
            }
            self.note_offset(axis);
            out.push(StmtKind::SetPos { axis, value });
        }
        if out.is_empty() {
            self.error(
                Code::GcodeMissing,
                block.span,
                "G92 without axis words",
                "write `G92 X0 Y0`",
            );
            return None;
        }
        self.gcode.forget_position();
        Some(out)
    }

    /// G38.2, G38.3
    fn probe_block(
        &mut self,
        block: &Block<'a>,
        context: &Context,
        query: bool,
    ) -> Option<Vec<StmtKind>> {
        let mut words =
            Axis::ALL.into_iter().filter_map(|axis| Some((axis, block.axes[axis.index()]?)));
        let (Some((axis, word)), None) = (words.next(), words.next()) else {
            let message = "a probe move needs one axis word";
            self.error(Code::GcodeMissing, block.span, message, "write `G38.2 Z-20 F60`");
            return None;
        };
        let limit = self.axis_word(axis, word, context, false);
        let mut out = self.need_feed(context)?;
        self.gcode.forget_position();
        let (limit, sensor) = (Box::new(limit?), Box::new(ProbeSensor::Default));
        out.push(StmtKind::Probe { axis, limit, speed: None, sensor, query });
        Some(out)
    }

    /// The active plane.
    pub(super) fn plane(&mut self, context: &Context) -> Option<Plane> {
        Some(match self.modal(context, Group::Plane)? {
            0 => Plane::Xy,
            1 => Plane::Zx,
            _ => Plane::Yz,
        })
    }
}

/// Leaves out relative words that are 0, as long as another word remains: they move nothing and
/// would cost the device an argument each.
fn without_idle_words(mut to: [Option<Word>; 3]) -> [Option<Word>; 3] {
    let idle = |word: &Word| word.frame == Frame::Relative && value_of(&word.value) == Some(0);
    for axis in 0..to.len() {
        if to.iter().flatten().count() > 1 && to[axis].as_ref().is_some_and(idle) {
            to[axis] = None;
        }
    }
    to
}

impl<'a> super::Blocks<'a> {
    /// Takes a block out to look at it while the checker works.
    fn take(&mut self, index: u32) -> Option<Block<'a>> {
        let slot = self.list.get_mut(index as usize)?;
        let span = slot.span;
        Some(core::mem::replace(slot, Block::new(span)))
    }

    /// Whether a Z may be held before the block and none is behind it.
    fn lets_go(&self, index: u32, block: &Block<'_>, after: &modal::State) -> bool {
        let before = self.states.state(index);
        let held = before.and_then(|s| s.get(Group::Held).single());
        let moves =
            block.special.is_some() || block.has_axis() || block.motion == Some(Motion::None);
        moves && held != Some(0) && after.get(Group::Held).single() == Some(0)
    }

    fn put_back(&mut self, index: u32, block: Block<'a>) {
        if let Some(slot) = self.list.get_mut(index as usize) {
            *slot = block;
        }
    }

    /// The commanded position is not known any more.
    pub(in crate::front::check) fn forget_position(&mut self) {
        self.position = [None; 3];
    }

    /// Follows a move as far as its words are constant.
    pub(super) fn follow(&mut self, to: &[Option<Word>; 3]) {
        for (known, word) in self.position.iter_mut().zip(to) {
            let Some(word) = word else { continue };
            let value = value_of(&word.value).filter(|_| word.value.kind == Kind::Length);
            *known = match word.frame {
                Frame::Work => value,
                Frame::Relative => known.and_then(|at| at.checked_add(value?)),
                Frame::Machine => None,
            };
        }
    }
}

/// Whether another word of the block takes its P.
fn takes_p(block: &Block<'_>) -> bool {
    block.dwell || block.tolerance || block.m.iter().any(|(m, _)| matches!(m, 62..=65))
}
