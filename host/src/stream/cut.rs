//! Jobs larger than a board's memory: cut into pieces that are programs of their own.
//!
//! For a board without a buffer that a running program could be fed through: each piece is stored,
//! started, and followed by the next when it has ended: motion stands in between. A run begins
//! without feed and with its outputs off, so each piece brings back what the statements before it
//! had set. Everything is cut and compiled before anything moves.

use lang::back::{self, Compiled, Sidecar};
use lang::effect::ActKind;
use lang::hir::{Block, Expr, ExprKind, Program, RoutineId, Stmt, StmtKind, Storage};
use lang::kind::Kind;
use lang::part::Part;
use lang::plain::{Plain, Touch};

use super::feed::{Refused, no_run};
use crate::course;
use crate::sim::chain;

/// Statements that the first try of a piece has.
const FIRST_TRY: usize = 200;
/// Calls within one another that are followed.
const MAX_DEPTH: usize = 16;

/// A part of a job.
#[derive(Debug)]
pub struct Piece {
    /// The program of it.
    pub image: Vec<u8>,
    /// Its code's places in the source.
    pub sidecar: Sidecar,
    /// Line of its first statement.
    pub first_line: u32,
    /// Line of its last statement.
    pub last_line: u32,
}

/// What statements leave behind for those that follow.
#[derive(Clone, Debug, Default)]
struct State {
    feed: Option<Stmt>,
    spindle: Option<Stmt>,
    /// Outputs that are on, each by the statement that switched it.
    outputs: Vec<(i32, Stmt)>,
    /// The same of analog outputs, whatever their value.
    aouts: Vec<(i32, Stmt)>,
}

/// Bytes of a piece that are left to its slow points, where the part takes them: few corners of a path bind.
const POINTS: usize = 200;

/// Cuts a job into pieces of at most `room` bytes for a part, each with slow points of its own where that takes them;
/// statements before line `from` are not executed, but what they set holds.
///
/// # Errors
/// The job does not fit and does what cannot be cut: jumps, handlers, values that live on, moves
/// that go on. Or one statement alone is larger than the board.
pub fn cut(
    mut program: Program,
    part: &Part,
    room: usize,
    from: u32,
) -> Result<Vec<Piece>, Refused> {
    if let Some(call) = chain::calls(&program).first() {
        return Err(no_run(call.line, &call.name));
    }
    if from <= 1
        && let Ok(compiled) = back::compile(&program)
        && compiled.image.len() <= room
    {
        let compiled = pointed(compiled, &program, part, room);
        return Ok(vec![Piece {
            first_line: 1,
            last_line: program.last_line,
            image: compiled.image,
            sidecar: compiled.sidecar,
        }]);
    }
    check(&program)?;
    let mut body = std::mem::take(&mut program.routines[0].body);
    if let Some(end) = body.iter().position(|stmt| matches!(stmt.kind, StmtKind::End)) {
        body.truncate(end);
    }
    // What the compiler put before the first statement belongs before each piece's.
    let prologue = body.iter().take_while(|stmt| stmt.span.is_empty()).count();
    let start: Block = body.drain(..prologue).collect();
    let mut state = State::default();
    let mut at = body.iter().position(|stmt| stmt.line >= from).unwrap_or(body.len());
    for stmt in &body[..at] {
        follow(&program, stmt, &mut state, 0)?;
    }
    let mut pieces = Vec::new();
    let mut guess = FIRST_TRY;
    while at < body.len() {
        let head: Block = start.iter().cloned().chain(preamble(&program, &state)).collect();
        let (piece, count) = fit(&mut program, &head, &body[at..], (part, room), guess)?;
        for stmt in &body[at..at + count] {
            follow(&program, stmt, &mut state, 0)?;
        }
        pieces.push(piece);
        guess = count;
        at += count;
    }
    Ok(pieces)
}

/// The longest piece that fits, found by growing and halving the step.
fn fit(
    program: &mut Program,
    head: &[Stmt],
    rest: &[Stmt],
    (part, room): (&Part, usize),
    guess: usize,
) -> Result<(Piece, usize), Refused> {
    let plain = if part.course_pool > 0 { room.saturating_sub(POINTS) } else { room };
    let mut best = None;
    let mut count = guess.clamp(1, rest.len());
    let mut step = (count / 4).max(1);
    loop {
        match compile(program, head, &rest[..count], plain) {
            Some(_) => {
                best = Some(count);
                if count == rest.len() {
                    break;
                }
                count = (count + step).min(rest.len());
            }
            None if best.is_some() => break,
            None if count == 1 && compile(program, head, &rest[..1], room).is_some() => {
                best = Some(1);
                break;
            }
            None if count == 1 => {
                let text = "this statement alone is larger than the board's memory";
                return Err(Refused::new(rest[0].line, text, "split its loop or its table"));
            }
            None => {
                count = count.saturating_sub(step).max(1);
                step = (step / 2).max(1);
            }
        }
    }
    let count =
        best.ok_or_else(|| Refused::new(rest[0].line, "nothing fits into the board", ""))?;
    let compiled = compile(program, head, &rest[..count], room);
    let compiled = compiled.map(|own| pointed(own, program, part, room));
    let piece = compiled.map(|compiled| Piece {
        image: compiled.image,
        sidecar: compiled.sidecar,
        first_line: rest[0].line,
        last_line: rest[count - 1].line,
    });
    piece.map(|piece| (piece, count)).ok_or_else(|| Refused::new(rest[0].line, "nothing fits", ""))
}

/// With slow points, if they fit.
fn pointed(plain: Compiled, program: &Program, part: &Part, room: usize) -> Compiled {
    let with = course::put_into(plain.clone(), program, part);
    if with.image.len() <= room { with } else { plain }
}

fn compile(program: &mut Program, head: &[Stmt], body: &[Stmt], room: usize) -> Option<Compiled> {
    program.routines[0].body = head.iter().chain(body).cloned().collect();
    let last_line = body.last().map_or(1, |stmt| stmt.line);
    let whole = std::mem::replace(&mut program.last_line, last_line);
    let compiled = back::compile(program);
    program.last_line = whole;
    compiled.ok().filter(|compiled| compiled.image.len() <= room)
}

/// What a piece sets before its first statement.
fn preamble(program: &Program, state: &State) -> Block {
    let mut out: Block = state.feed.iter().chain(&state.spindle).cloned().collect();
    out.extend(state.outputs.iter().chain(&state.aouts).map(|(_, stmt)| stmt.clone()));
    let spin_up = i32::from(program.profile.run.spin_up_ms);
    if let Some((_, stmt)) = state.outputs.last().filter(|_| spin_up > 0) {
        let time =
            Expr { kind: Kind::Time, span: stmt.span.clone(), node: ExprKind::Const(spin_up) };
        out.push(Stmt { kind: StmtKind::Plain(Plain::Wait, vec![time]), ..stmt.clone() });
    }
    out
}

/// Refuses what a piece's end would break.
fn check(program: &Program) -> Result<(), Refused> {
    let counted: Vec<_> = loops(&program.routines[0].body);
    for (index, var) in program.vars.iter().enumerate() {
        let hidden = var.name.contains(' ');
        let counts = counted.iter().any(|id| id.0 as usize == index);
        if matches!(var.storage, Storage::Local(_)) || hidden || counts {
            continue;
        }
        let text = format!("`{}` would be 0 again in each piece", var.name);
        let hint = "a job larger than the board has no variables but those of FOR";
        return Err(Refused::new(1, text, hint));
    }
    program.routines.iter().try_for_each(|routine| routine.body.iter().try_for_each(possible))
}

fn loops(block: &[Stmt]) -> Vec<lang::hir::VarId> {
    let mut out = Vec::new();
    for stmt in block {
        if let StmtKind::For { var, .. } = &stmt.kind {
            out.push(*var);
        }
        for inner in inside(stmt) {
            out.extend(loops(inner));
        }
    }
    out
}

/// The blocks of a compound statement.
pub(super) fn inside(stmt: &Stmt) -> Vec<&[Stmt]> {
    match &stmt.kind {
        StmtKind::If { arms, otherwise, .. } => {
            arms.iter().map(|arm| &arm.body[..]).chain([&otherwise[..]]).collect()
        }
        StmtKind::Select { cases, otherwise, .. } => {
            cases.iter().map(|case| &case.body[..]).chain([&otherwise[..]]).collect()
        }
        StmtKind::For { body, .. }
        | StmtKind::While { body, .. }
        | StmtKind::Do { body, .. }
        | StmtKind::Repeat { body, .. } => vec![body],
        _ => Vec::new(),
    }
}

fn possible(stmt: &Stmt) -> Result<(), Refused> {
    let wrong = match &stmt.kind {
        StmtKind::Goto(_) | StmtKind::Label(_) | StmtKind::Gosub(_) => {
            Some(("a jump cannot leave its piece", "use loops and SUBs"))
        }
        StmtKind::OnError(_) | StmtKind::OnInput { .. } | StmtKind::OnEvery { .. } => Some((
            "a handler would end with its piece",
            "stream the job without --stored to a board that can be fed (the virtual part), or \
                 test IN(n) or TIMER() between the statements and write Probe?, Home?, WaitIn?",
        )),
        StmtKind::MoveAxe { start: true, .. } | StmtKind::MoveSpeed { .. } => {
            Some(("a move that goes on would end with its piece", "wait for each move"))
        }
        StmtKind::SetPos { .. } => {
            Some(("the work zero would be lost at the piece's end", "set it before the job"))
        }
        _ => None,
    };
    if let Some((text, hint)) = wrong {
        return Err(Refused::new(stmt.line, text, hint));
    }
    inside(stmt).into_iter().flatten().try_for_each(possible)
}

/// Follows a statement as far as it sets what holds on.
fn follow(program: &Program, stmt: &Stmt, state: &mut State, depth: usize) -> Result<(), Refused> {
    let unknown = || {
        let text = "what this sets is not known beforehand, so the next piece cannot set it again";
        Refused::new(stmt.line, text, "write constants for F, S and outputs")
    };
    let constant = |e: &Expr| match e.node {
        ExprKind::Const(value) => Ok(value),
        _ => Err(unknown()),
    };
    match &stmt.kind {
        StmtKind::SetFeed(value) => {
            constant(value)?;
            state.feed = Some(stmt.clone());
        }
        StmtKind::SetSpindle(value) => {
            constant(value)?;
            state.spindle = Some(stmt.clone());
        }
        StmtKind::Plain(plain, values) => match (plain.touches(), &values[..]) {
            (Touch::Output, [n, on]) => {
                let n = constant(n)?;
                state.outputs.retain(|(other, _)| *other != n);
                if constant(on)? != 0 {
                    state.outputs.push((n, stmt.clone()));
                }
            }
            (Touch::Output | Touch::Port, _) => return Err(unknown()),
            // Whichever it is, it is off already.
            (Touch::Off, _) if state.outputs.is_empty() => {}
            (Touch::Off, [n, ..]) => {
                let n = constant(n)?;
                state.outputs.retain(|(other, _)| *other != n);
            }
            (Touch::Off | Touch::Axes | Touch::Nothing, _) => {}
        },
        // The output is as that of SetOut where the next piece begins.
        StmtKind::Sync(own) if own.kind == ActKind::Analog => {
            let kind = StmtKind::SetAout(own.n.clone(), own.value.clone());
            follow(program, &Stmt { kind, ..stmt.clone() }, state, depth)?;
        }
        StmtKind::SetAout(n, value) => {
            let n = constant(n)?;
            constant(value)?;
            state.aouts.retain(|(other, _)| *other != n);
            state.aouts.push((n, stmt.clone()));
        }
        StmtKind::Sync(own) => {
            let n = constant(&own.n)?;
            state.outputs.retain(|(other, _)| *other != n);
            if own.kind == ActKind::Set && constant(&own.value)? != 0 {
                let values = vec![own.n.clone(), own.value.clone()];
                let kind = StmtKind::Plain(Plain::SetOut, values);
                state.outputs.push((n, Stmt { kind, ..stmt.clone() }));
            }
        }
        StmtKind::Motors { .. } => return Err(unknown()),
        StmtKind::Call(RoutineId(id), _) if depth < MAX_DEPTH => {
            let body = program.routines.get(*id as usize).map(|routine| &routine.body[..]);
            for stmt in body.unwrap_or_default() {
                follow(program, stmt, state, depth + 1)?;
            }
        }
        _ => {
            for stmt in inside(stmt).into_iter().flatten() {
                follow(program, stmt, state, depth)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Piece, Refused, cut};
    use lang::front::source::Source;
    use lang::front::{ProfileChoice, compile};
    use lang::image::{FORMAT, Image};
    use lang::part::{F5529, G2553};
    use lang::profile::Profile;
    use std::time::Duration;

    use crate::bench::stand::Stand;

    fn pieces(text: &str, room: usize, from: u32) -> Result<Vec<Piece>, Refused> {
        let source = Source::new("a.bas", text.to_owned());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        cut(program.unwrap_or_else(|| panic!("{}", diags.render(&source))), &F5529, room, from)
    }

    fn long() -> String {
        let mut text = "F600\nM3\n".to_owned();
        for i in 0..2000 {
            text += &format!("G1 X{} Y{}.5\n", i % 90, i % 70);
        }
        text + "M5\n"
    }

    #[test]
    fn a_long_job_is_cut_and_nothing_is_lost() {
        let list = pieces(&long(), 3068, 1).expect("pieces");
        assert!(list.len() > 3);
        for pair in list.windows(2) {
            assert_eq!(pair[0].last_line + 1, pair[1].first_line);
        }
        assert_eq!(list[0].first_line, 1);
        assert_eq!(list.last().map(|piece| piece.last_line), Some(2003));
        for piece in &list {
            assert!(piece.image.len() <= 3068 && piece.image[0] == FORMAT);
            assert!(Image::new(&piece.image).is_ok());
            // Each begins with the feed and the spindle that the first lines set.
            let lines: Vec<u32> = piece.sidecar.marks.iter().map(|mark| mark.line).collect();
            assert!(lines.contains(&1) && lines.contains(&2), "{:?}", &lines[..4]);
        }
    }

    /// Each piece goes through its corners by slow points of its own, on a board that knows no line ahead.
    #[test]
    fn pieces_of_a_path_have_slow_points_where_the_part_takes_them() {
        let mut text = "G90\nG0 X0 Y0\nF1500\n".to_owned();
        for i in 1..=400 {
            text += &format!("G1 X{}.{} Y{}.{}\n", i / 5, i % 5 * 2, i / 10, i % 10);
        }
        let mill = Profile::built_in("mill").expect("the mill");
        let mut board = Stand::on(&crate::board::G2553, &mill).expect("a board");
        let mut seconds = |part| {
            let source = Source::new("a.bas", text.clone());
            let (program, _) = compile(&source, ProfileChoice::built_in());
            let list = cut(program.expect("a script"), part, 1530, 1).expect("pieces");
            assert!(list.len() > 1 && list.iter().all(|piece| piece.image.len() <= 1530));
            let mut seconds = 0.0;
            for piece in &list {
                board.upload(&piece.image).expect("taken");
                let from = board.seconds();
                board.run(Duration::from_secs(120)).expect("a run");
                seconds += board.seconds() - from;
            }
            assert_eq!(board.motors(), [8_000, 4_000, 0]);
            seconds
        };
        let (rests, goes) = (seconds(&F5529), seconds(&G2553));
        assert!(goes < 0.5 * rests, "{goes:.1} s of {rests:.1}");
    }

    #[test]
    fn a_job_begins_anew_at_a_line() {
        let list = pieces(&long(), 3068, 1990).expect("pieces");
        assert_eq!((list.len(), list[0].first_line, list[0].last_line), (1, 1990, 2003));
    }

    #[test]
    fn what_a_piece_would_break_is_refused() {
        let job = |line: &str| long() + line;
        for (line, what) in [
            ("again:\nG1 X1\nGOTO again\n", "jump"),
            ("G92 X0\n", "work zero"),
            ("START MoveAxe X, 5mm\nWaitMove\n", "goes on"),
        ] {
            let refused = pieces(&job(line), 3068, 1).expect_err(line);
            assert!(refused.text.contains(what), "{refused:?}");
        }
        let refused = pieces(&format!("DIM n\nn = 3\n{}PRINT n\n", long()), 3068, 1);
        assert!(refused.expect_err("a variable").text.contains('n'));
    }
}
