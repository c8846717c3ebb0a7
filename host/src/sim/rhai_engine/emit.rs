//! The text that becomes the Rhai script: basic blocks of one `loop { switch pc { ... } }`.

/// A statement of the program as the run needs it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Info {
    /// Line of the script.
    pub line: u32,
    /// Block that begins with it; only where each statement has a block of its own.
    pub start: i32,
    /// Block with which RESUME NEXT goes on.
    pub resume: i32,
}

/// Number of a statement in [`Script::infos`].
pub type Id = usize;

#[derive(Debug, Default)]
struct Body {
    /// Lines with the statements that they belong to and those begun that no `t` has counted.
    lines: Vec<(String, Id, u32)>,
    closed: bool,
}

/// The finished script.
#[derive(Debug)]
pub struct Script {
    /// Rhai source.
    pub source: String,
    /// Statement of each line of the source, from line 1.
    pub ids: Vec<Id>,
    /// Statements begun at each line that no `t` has counted: a fault there leaves none that will.
    pub uncounted: Vec<u32>,
    /// The statements.
    pub infos: Vec<Info>,
}

/// Collects blocks.
#[derive(Debug)]
pub struct Emitter {
    /// Each statement has a block of its own, which it enters by a poll; otherwise blocks are as
    /// long as they can be and only count.
    pub precise: bool,
    bodies: Vec<Body>,
    infos: Vec<Info>,
    current: usize,
    id: Id,
    /// Statements begun that no `t` has counted yet.
    pending: u32,
    temps: usize,
    max_temps: usize,
    /// Where RESUME NEXT goes on from each part of the statement at hand.
    pub behind: Option<usize>,
}

impl Emitter {
    /// An emitter in block 0.
    pub fn new(precise: bool) -> Emitter {
        Emitter {
            precise,
            bodies: vec![Body::default()],
            infos: vec![Info::default()],
            current: 0,
            id: 0,
            pending: 0,
            temps: 0,
            max_temps: 0,
            behind: None,
        }
    }

    /// A block that will be opened later.
    pub fn block(&mut self) -> usize {
        self.bodies.push(Body::default());
        self.bodies.len() - 1
    }

    /// Adds a line to the block that is open; nothing after a jump is ever reached.
    pub fn line(&mut self, text: String) {
        let id = self.id;
        let body = &mut self.bodies[self.current];
        if !body.closed {
            body.lines.push((text, id, self.pending));
        }
    }

    /// Counts the statements begun since the last time.
    pub fn flush(&mut self) {
        if self.pending > 0 {
            let count = std::mem::take(&mut self.pending);
            self.line(format!("t({count});"));
        }
    }

    /// Ends the block with a statement that sets `pc`.
    pub fn close(&mut self, text: String) {
        self.flush();
        self.line(text);
        self.bodies[self.current].closed = true;
    }

    /// Ends the block by a jump.
    pub fn jump(&mut self, to: usize) {
        self.close(format!("pc = {to};"));
    }

    /// Ends the block by a choice.
    pub fn branch(&mut self, condition: &str, yes: usize, no: usize) {
        self.close(format!("if {condition} {{ pc = {yes}; }} else {{ pc = {no}; }}"));
    }

    /// Goes on in `block`, into which the open one falls.
    pub fn open(&mut self, block: usize) {
        if !self.bodies[self.current].closed {
            self.jump(block);
        }
        self.pending = 0;
        self.current = block;
    }

    /// Whether the open block has ended in a jump.
    pub fn is_closed(&self) -> bool {
        self.bodies[self.current].closed
    }

    /// A statement begins; RESUME NEXT behind it goes on with `resume`.
    pub fn begin(&mut self, line: u32, resume: usize) -> Id {
        self.temps = 0;
        if self.precise {
            if !self.bodies[self.current].lines.is_empty() || self.bodies[self.current].closed {
                let block = self.block();
                self.open(block);
            }
            let id = self.part(line, resume);
            self.infos[id].start = self.current as i32;
            self.line(format!("p({id});"));
            id
        } else {
            let id = self.part(line, resume);
            self.pending += 1;
            id
        }
    }

    /// A further line of a statement (ELSEIF, CASE) begins: faults are its own.
    pub fn part(&mut self, line: u32, resume: usize) -> Id {
        let resume = self.behind.unwrap_or(resume);
        self.infos.push(Info { line, start: 0, resume: resume as i32 });
        self.id = self.infos.len() - 1;
        self.id
    }

    /// A further test of a statement, in a block of its own: RESUME begins there again.
    pub fn test(&mut self, line: u32, resume: usize) {
        if self.precise && !self.bodies[self.current].lines.is_empty() {
            let block = self.block();
            self.open(block);
        }
        let id = self.part(line, resume);
        self.infos[id].start = self.current as i32;
        self.belongs_to(id);
    }

    /// What follows belongs to statement `id` again.
    pub fn belongs_to(&mut self, id: Id) {
        self.id = id;
        if self.precise {
            self.line(format!("c({id});"));
        }
    }

    /// The statement that is being translated.
    pub fn id(&self) -> Id {
        self.id
    }

    /// Its line.
    pub fn script_line(&self) -> u32 {
        self.infos[self.id].line
    }

    /// A scratch variable, free until the next statement.
    pub fn temp(&mut self) -> String {
        self.temps += 1;
        self.max_temps = self.max_temps.max(self.temps);
        format!("t{}", self.temps)
    }

    /// Puts everything together; `declarations` stand before the loop.
    pub fn finish(self, declarations: &[String]) -> Script {
        let mut script = Script {
            source: String::new(),
            ids: Vec::new(),
            uncounted: Vec::new(),
            infos: self.infos,
        };
        let mut counted = |text: &str, id: Id, pending: u32| {
            script.source.push_str(text);
            script.source.push('\n');
            script.ids.push(id);
            script.uncounted.push(pending);
        };
        let mut line = |text: &str, id: Id| counted(text, id, 0);
        for text in declarations {
            line(text, 0);
        }
        for n in 1..=self.max_temps {
            line(&format!("let t{n} = 0;"), 0);
        }
        line("let rv = 0; let pc = 0;", 0);
        let (head, tail) = if self.precise {
            ("loop { try { loop { switch pc {", "} } } catch (e) { pc = caught(e); } }")
        } else {
            ("loop { switch pc {", "} }")
        };
        line(head, 0);
        for (n, body) in self.bodies.iter().enumerate() {
            counted(&format!("{n} => {{"), 0, 0);
            for (text, id, pending) in &body.lines {
                counted(text, *id, *pending);
            }
            counted("},", 0, 0);
        }
        counted(tail, 0, 0);
        script
    }
}
