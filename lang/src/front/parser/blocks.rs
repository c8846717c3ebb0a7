//! Puts pieces together to blocks, with a stack of its own: depth costs no recursion, and what is
//! left open at the end is known with its line.

use super::piece::{Closer, ForHead, Opener, Piece, Placed, closing_words};
use crate::front::ast::{
    Arm, Block, Case, CaseTest, Expr, MAX_BLOCK_DEPTH, Routine, Script, Stmt, StmtKind,
};
use crate::front::codes::Code;
use crate::front::diag::{Diag, Diags};
use crate::front::span::Span;
use crate::front::words::Kw;

/// Builds the tree.
pub struct Builder<'a> {
    script: Script,
    frames: Vec<Frame>,
    diags: &'a mut Diags,
    /// An opening line was lost, so a closing line without block is its consequence.
    lost: bool,
    /// Blocks that were closed for want of their closing line, which may still come.
    forced: Vec<Kw>,
}

/// A block that is open.
struct Frame {
    opener: Opener,
    span: Span,
    line: u32,
    sections: Vec<Section>,
    head: Head,
    body: Block,
}

/// The part of a block that is being read.
enum Head {
    /// The only part, or of SELECT what stands before its first CASE.
    Body,
    /// IF or ELSEIF with its line.
    Arm(Expr, u32),
    /// CASE with its line.
    Case(Vec<CaseTest>, u32),
    /// ELSE or CASE ELSE.
    Otherwise,
}

/// A part of a block that is complete.
struct Section {
    head: Head,
    body: Block,
}

impl<'a> Builder<'a> {
    /// An empty script.
    pub fn new(diags: &'a mut Diags) -> Self {
        Self {
            script: Script::default(),
            frames: Vec::new(),
            diags,
            lost: false,
            forced: Vec::new(),
        }
    }

    /// Where complaints go.
    pub fn diags(&mut self) -> &mut Diags {
        self.diags
    }

    /// Whether a block that this word opens is open.
    pub fn has_open(&self, opener: Kw) -> bool {
        self.lost || self.frames.iter().any(|frame| frame.opener.word() == opener)
    }

    /// Says that a line was lost that may have opened a block.
    pub fn lose(&mut self) {
        self.lost = true;
    }

    /// Says that a declaration was lost that may have declared this name.
    pub fn lose_name(&mut self, key: String) {
        self.script.lost.insert(key);
    }

    /// Adds the next piece.
    pub fn add(&mut self, placed: Placed) {
        let Placed { piece, span, line } = placed;
        match piece {
            Piece::Stmt(kind) => self.push(Stmt { kind, span, line }),
            Piece::Several(kinds) => {
                kinds.into_iter().for_each(|kind| self.push(Stmt { kind, span, line }));
            }
            Piece::Profile(name) => {
                let first = self.script.body.is_empty()
                    && self.script.routines.is_empty()
                    && self.frames.is_empty()
                    && self.script.profile.is_none();
                if first {
                    self.script.profile = Some(name);
                } else {
                    let diag =
                        Diag::new(Code::Misplaced, span, "PROFILE is not the first statement")
                            .hint("move it to the top of the script");
                    self.diags.push(diag);
                }
            }
            Piece::Open(opener) => self.open(opener, span, line),
            Piece::ElseIf(cond) => self.section(Kw::If, Head::Arm(cond, line), "ELSEIF", span),
            Piece::Else => self.section(Kw::If, Head::Otherwise, "ELSE", span),
            Piece::Case(tests) => self.section(Kw::Select, Head::Case(tests, line), "CASE", span),
            Piece::CaseElse => self.section(Kw::Select, Head::Otherwise, "CASE ELSE", span),
            Piece::Close(closer) => self.close(closer, span, line),
        }
    }

    /// The script, which ends at an offset; whatever is still open is reported.
    pub fn finish(mut self, last_line: u32, end: u32) -> Script {
        while let Some(frame) = self.frames.pop() {
            self.unclosed(&frame, Err(end));
            self.complete(frame, None, last_line);
        }
        self.script.last_line = last_line;
        self.script
    }

    fn push(&mut self, stmt: Stmt) {
        match self.frames.last_mut() {
            Some(frame) => frame.body.push(stmt),
            None => self.script.body.push(stmt),
        }
    }

    fn open(&mut self, opener: Opener, span: Span, line: u32) {
        if matches!(opener.word(), Kw::Sub | Kw::Function) {
            while let Some(frame) = self.frames.pop() {
                self.unclosed(&frame, Ok((span, "stands outside of all blocks")));
                self.complete(frame, None, line);
            }
        }
        if self.frames.len() == MAX_BLOCK_DEPTH {
            let message = format!("blocks nest more than {MAX_BLOCK_DEPTH} deep");
            let diag = Diag::new(Code::TooDeep, span, message).hint("put inner blocks into a SUB");
            self.diags.push(diag);
        }
        let head = match &opener {
            Opener::If(cond) => Head::Arm(cond.clone(), line),
            _ => Head::Body,
        };
        let frame = Frame { opener, span, line, sections: Vec::new(), head, body: Vec::new() };
        self.frames.push(frame);
    }

    /// Pops what stands above the innermost open block of this sort, with complaints; false where
    /// there is none. Only closing lines of routines reach beyond a routine.
    fn reach(&mut self, opener: Kw, by: Span) -> bool {
        let routine = matches!(opener, Kw::Sub | Kw::Function);
        let mut found = None;
        for (n, frame) in self.frames.iter().enumerate().rev() {
            let word = frame.opener.word();
            if word == opener {
                found = Some(n);
                break;
            }
            if matches!(word, Kw::Sub | Kw::Function) && !routine {
                break;
            }
        }
        let Some(found) = found else { return false };
        while self.frames.len() > found + 1 {
            if let Some(frame) = self.frames.pop() {
                self.unclosed(&frame, Ok((by, "was found instead")));
                self.complete(frame, None, 0);
            }
        }
        true
    }

    fn section(&mut self, opener: Kw, head: Head, word: &str, span: Span) {
        if !self.reach(opener, span) {
            return self.unopened(word, opener, span);
        }
        let Some(frame) = self.frames.last_mut() else { return };
        if matches!(frame.head, Head::Otherwise) {
            let diag =
                Diag::new(Code::Misplaced, span, format!("`{word}` stands behind the last branch"))
                    .label(frame.span, format!("the {} is here", frame.opener.word().text()))
                    .hint("ELSE and CASE ELSE come last");
            self.diags.push(diag);
        }
        let body = core::mem::take(&mut frame.body);
        let first = core::mem::replace(&mut frame.head, head);
        if opener == Kw::Select
            && matches!(first, Head::Body)
            && let Some(stmt) = body.first()
        {
            let diag =
                Diag::new(Code::Misplaced, stmt.span, "a statement stands before the first CASE")
                    .hint("move it before SELECT or behind a CASE");
            self.diags.push(diag);
        }
        frame.sections.push(Section { head: first, body });
    }

    fn close(&mut self, closer: Closer, span: Span, line: u32) {
        let opener = closer.opener();
        if !self.reach(opener, span) {
            return self.unopened(closing_words(opener), opener, span);
        }
        let Some(frame) = self.frames.pop() else { return };
        if let (Closer::For(Some(named)), Opener::For(head)) = (&closer, &frame.opener)
            && named.key != head.var.key
        {
            let var = &head.var;
            let message = format!("NEXT {} closes the FOR of `{}`", named.text, var.text);
            let diag = Diag::new(Code::NextName, named.span, message)
                .label(var.span, "the innermost open FOR")
                .hint(format!("write `NEXT {}` or `NEXT`", var.text))
                .fix(named.span, &*var.text);
            self.diags.push(diag);
        }
        self.complete(frame, Some(closer), line);
    }

    /// Reports an open block: what was found instead of its end and what that does, or where the script ends.
    fn unclosed(&mut self, frame: &Frame, by: Result<(Span, &str), u32>) {
        let word = frame.opener.word();
        self.forced.push(word);
        if matches!(frame.opener, Opener::Broken(_)) {
            return;
        }
        let closing = closing_words(word);
        let message = format!("the {} of line {} has no {closing}", word.text(), frame.line);
        let mut diag = Diag::new(Code::UnclosedBlock, frame.span, message);
        diag = match by {
            Ok((span, text)) => diag
                .label(span, format!("this {text}"))
                .fix(Span::point(span.start), format!("{closing}\n")),
            Err(end) => diag.fix(Span::point(end), format!("\n{closing}")),
        };
        self.diags.push(diag.hint(format!("close it with `{closing}`")));
    }

    fn unopened(&mut self, word: &str, opener: Kw, span: Span) {
        if self.lost {
            return;
        }
        if let Some(n) = self.forced.iter().rposition(|&kw| kw == opener) {
            self.forced.remove(n);
            return;
        }
        let message = format!("`{word}` has no {}", opener.text());
        let diag = Diag::new(Code::UnopenedBlock, span, message);
        let diag = match self.frames.last() {
            Some(frame) => {
                let open = frame.opener.word();
                diag.label(frame.span, format!("open is this {}", open.text())).hint(format!(
                    "{} is closed by `{}`",
                    open.text(),
                    closing_words(open)
                ))
            }
            None => match self.script.body.last() {
                Some(Stmt { kind: StmtKind::If { one_line: true, .. }, line, .. })
                    if opener == Kw::If =>
                {
                    diag.hint(format!(
                        "the IF of line {line} ends with its line: delete this, or begin a new line \
                         behind its THEN"
                    ))
                }
                _ => diag.hint("no block is open here: delete it"),
            },
        };
        self.diags.push(diag);
    }

    /// Turns a block that is closed into a statement or a routine.
    fn complete(&mut self, frame: Frame, closer: Option<Closer>, end_line: u32) {
        let deep = self.frames.len() >= MAX_BLOCK_DEPTH;
        let Frame { opener, span, line, mut sections, head, body } = frame;
        if deep || matches!(opener, Opener::Broken(_)) {
            // An error was reported; its statements go on in the block around it.
            let statements = sections.into_iter().flat_map(|s| s.body).chain(body);
            match self.frames.last_mut() {
                Some(outer) => outer.body.extend(statements),
                None => self.script.body.extend(statements),
            }
            return;
        }
        if let Opener::Routine { name, is_function, params, result } = opener {
            let routine = Routine { name, is_function, params, result, body, span, line, end_line };
            return self.script.routines.push(routine);
        }
        let kind = match opener {
            Opener::If(_) => {
                sections.push(Section { head, body });
                if_from(sections)
            }
            Opener::Select(value) => {
                sections.push(Section { head, body });
                select_from(value, sections)
            }
            Opener::For(head) => {
                let ForHead { var, from, to, step } = *head;
                let (from, to, step) = (Box::new(from), Box::new(to), step.map(Box::new));
                let next = match closer {
                    Some(Closer::For(next)) => next.map(Box::new),
                    _ => None,
                };
                StmtKind::For { var, from, to, step, body, next_line: end_line, next }
            }
            Opener::While(cond) => StmtKind::While { cond, body, end_line },
            Opener::Do(before) => {
                let after = match closer {
                    Some(Closer::Do(after)) => after,
                    _ => None,
                };
                let (before, after) = (before.map(Box::new), after.map(Box::new));
                StmtKind::Do { before, body, after, loop_line: end_line }
            }
            Opener::Repeat(count) => StmtKind::Repeat { count, body, end_line },
            Opener::Routine { .. } | Opener::Broken(_) => return,
        };
        self.push(Stmt { kind, span, line });
    }
}

fn if_from(sections: Vec<Section>) -> StmtKind {
    let mut arms = Vec::new();
    let mut otherwise = None;
    for Section { head, body } in sections {
        match head {
            Head::Arm(cond, line) => arms.push(Arm { cond, body, line }),
            _ => otherwise = Some(body),
        }
    }
    StmtKind::If { arms, otherwise, one_line: false }
}

fn select_from(value: Expr, sections: Vec<Section>) -> StmtKind {
    let mut cases = Vec::new();
    let mut otherwise = None;
    for Section { head, body } in sections {
        match head {
            Head::Case(tests, line) => cases.push(Case { tests, body, line }),
            Head::Otherwise => otherwise = Some(body),
            Head::Body | Head::Arm(..) => {}
        }
    }
    StmtKind::Select { value, cases, otherwise }
}
