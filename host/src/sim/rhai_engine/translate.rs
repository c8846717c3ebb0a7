//! Statements as basic blocks.

use lang::effect::{Effect, Read};
use lang::hir::{
    Block, CaseTest, Expr, ExprKind, GosubTarget, LabelId, LoopKind, Place, PrintPart, Program,
    RoutineId, Stmt, StmtKind, Storage,
};

use super::cycle::Plan;
use super::effects::{self, Template};
use super::emit::{Emitter, Script};

/// More lines than Rhai can number: each statement then announces itself.
const LINES: usize = 20_000;

/// A translated program.
#[derive(Debug)]
pub struct Translation {
    /// The script.
    pub script: Script,
    /// Its effects, by number.
    pub templates: Vec<Template>,
    /// Texts of PRINT, by number.
    pub texts: Vec<String>,
    /// Values of the tables, with their columns.
    pub tables: Vec<(i32, Vec<i32>)>,
    /// Canned cycles, by number.
    pub cycles: Vec<Plan>,
    /// Each statement announces itself; otherwise the source's lines tell them apart.
    pub precise: bool,
}

/// A loop that is being translated.
#[derive(Clone, Copy, Debug)]
pub struct Loop {
    /// Which EXIT and CONTINUE mean it.
    pub kind: LoopKind,
    /// Where EXIT goes.
    pub exit: usize,
    /// Where CONTINUE goes.
    pub again: usize,
}

/// See the module.
pub struct Translator<'p> {
    pub(super) program: &'p Program,
    pub(super) out: Emitter,
    pub(super) loops: Vec<Loop>,
    templates: Vec<Template>,
    texts: Vec<String>,
    pub(super) cycles: Vec<Plan>,
    entries: Vec<usize>,
    labels: Vec<usize>,
    routine: RoutineId,
    handles_errors: bool,
}

/// What the whole program uses.
#[derive(Default)]
struct Uses {
    interruptions: bool,
    errors: bool,
    statements: usize,
}

fn survey(block: &Block, uses: &mut Uses) {
    for stmt in block {
        uses.statements += 1;
        match &stmt.kind {
            StmtKind::OnInput { .. } | StmtKind::OnEvery { .. } | StmtKind::MoveSpeed { .. } => {
                uses.interruptions = true;
            }
            StmtKind::OnError(_) | StmtKind::ResumeNext | StmtKind::Resume => uses.errors = true,
            kind => kind.blocks().into_iter().for_each(|block| survey(block, uses)),
        }
    }
}

/// Translates a whole program.
pub fn translate(program: &Program) -> Translation {
    let mut uses = Uses::default();
    program.routines.iter().for_each(|routine| survey(&routine.body, &mut uses));
    let precise = uses.interruptions || uses.errors || uses.statements > LINES;
    let mut out = Emitter::new(precise);
    let entries = program.routines.iter().skip(1).map(|_| out.block()).collect();
    let labels = program.labels.iter().map(|_| out.block()).collect();
    let mut translator = Translator {
        program,
        out,
        loops: Vec::new(),
        templates: Vec::new(),
        texts: Vec::new(),
        cycles: Vec::new(),
        entries,
        labels,
        routine: RoutineId(0),
        handles_errors: uses.errors,
    };
    translator.routines();
    let mut declarations = Vec::new();
    for (index, var) in program.vars.iter().enumerate() {
        if matches!(var.storage, Storage::At(_) | Storage::Keep(_)) {
            // Shared with the world, or what an earlier run of the program left: in the scope.
            continue;
        }
        declarations.push(if var.array {
            format!("let v{index} = cells({});", var.len)
        } else {
            format!("let v{index} = 0;")
        });
    }
    let tables = program
        .tables
        .iter()
        .map(|table| (i32::try_from(table.columns).unwrap_or(i32::MAX), table.values.clone()))
        .collect();
    Translation {
        script: translator.out.finish(&declarations),
        templates: translator.templates,
        texts: translator.texts,
        tables,
        cycles: translator.cycles,
        precise,
    }
}

impl Translator<'_> {
    fn routines(&mut self) {
        let program = self.program;
        for (index, routine) in program.routines.iter().enumerate() {
            self.routine = RoutineId(index as u32);
            if index > 0 {
                let entry = self.entries[index - 1];
                self.out.open(entry);
                for local in &routine.locals {
                    let var = program.var(*local);
                    self.out.line(if var.array {
                        format!("v{} = cells({});", local.0, var.len)
                    } else {
                        format!("v{} = 0;", local.0)
                    });
                }
            }
            self.block(&routine.body);
            if index == 0 {
                self.out.part(program.last_line, 0);
                self.out.close(format!("fin({});", program.last_line));
            } else {
                if routine.result.is_some() {
                    self.out.line("rv = 0;".to_owned());
                }
                self.out.close("pc = xt();".to_owned());
            }
        }
    }

    /// The block with which a routine begins.
    pub(super) fn entry(&self, routine: RoutineId) -> usize {
        match routine.0 {
            0 => 0,
            n => self.entries[n as usize - 1],
        }
    }

    fn label(&self, label: LabelId) -> usize {
        self.labels[label.0 as usize]
    }

    fn target(&self, target: GosubTarget) -> usize {
        match target {
            GosubTarget::Label(label) => self.label(label),
            GosubTarget::Sub(routine) => self.entry(routine),
        }
    }

    /// A number for an effect.
    pub(super) fn template(&mut self, template: Template) -> usize {
        self.templates.push(template);
        self.templates.len() - 1
    }

    pub(super) fn block(&mut self, block: &Block) {
        let outer = self.out.behind.take();
        for parts in block.chunk_by(Stmt::continues) {
            if parts.len() > 1 && self.out.precise {
                self.out.behind = Some(self.out.block());
            }
            for part in parts {
                self.statement(part);
            }
            if let Some(behind) = self.out.behind.take() {
                self.out.open(behind);
            }
        }
        self.out.behind = outer;
    }

    fn statement(&mut self, stmt: &Stmt) {
        match &stmt.kind {
            StmtKind::Label(label) => {
                let block = self.label(*label);
                self.out.open(block);
            }
            StmtKind::If { arms, otherwise, .. } => self.choice(stmt, arms, otherwise),
            StmtKind::Select { value, temp, cases, otherwise } => {
                self.select(stmt, value, *temp, cases, otherwise);
            }
            StmtKind::For { .. } => self.count(stmt),
            StmtKind::While { condition, body } => self.while_loop(stmt, condition, body),
            StmtKind::Do { before, body, after } => {
                self.do_loop(stmt, before.as_deref(), body, after.as_deref());
            }
            StmtKind::Repeat { count, temp, body } => self.repeat(stmt, count, *temp, body),
            _ => self.simple(stmt),
        }
    }

    /// A statement without blocks in it.
    fn simple(&mut self, stmt: &Stmt) {
        let next = self.out.block();
        self.out.begin(stmt.line, next);
        match &stmt.kind {
            StmtKind::Assign(place, value) => self.assign(place, value),
            StmtKind::Exit(kind) => {
                let to = self.loop_of(*kind).map_or(next, |inner| inner.exit);
                self.out.jump(to);
            }
            StmtKind::Continue(kind) => {
                let to = self.loop_of(*kind).map_or(next, |inner| inner.again);
                self.out.jump(to);
            }
            StmtKind::Goto(label) => {
                let to = self.label(*label);
                if self.handles_errors && self.routine.0 == 0 {
                    self.out.close(format!("pc = gt({to});"));
                } else {
                    self.out.jump(to);
                }
            }
            StmtKind::Gosub(target) => {
                let to = self.target(*target);
                let call = match target {
                    GosubTarget::Label(_) => "gs",
                    GosubTarget::Sub(_) => "cl",
                };
                self.out.close(format!("pc = {call}({next}, {to});"));
            }
            StmtKind::Return => self.out.close("pc = rt();".to_owned()),
            StmtKind::ReturnValue(value) => {
                let value = self.value(value);
                self.out.line(format!("rv = {value};"));
                self.out.close("pc = xt();".to_owned());
            }
            StmtKind::ExitRoutine => {
                self.out.line("rv = 0;".to_owned());
                self.out.close("pc = xt();".to_owned());
            }
            StmtKind::Call(routine, arguments) => self.call(*routine, arguments),
            StmtKind::End => self.out.close(format!("fin({});", stmt.line)),
            StmtKind::Run(name) => {
                let index = self.text(name);
                self.out.close(format!("run({}, {index});", stmt.line));
            }
            StmtKind::OnError(label) => {
                let to = label.map_or(-1, |label| self.label(label) as i32);
                self.out.line(format!("oe({to});"));
            }
            StmtKind::ResumeNext => self.out.close("pc = rn();".to_owned()),
            StmtKind::Resume => self.out.close("pc = ra();".to_owned()),
            StmtKind::Print(parts) => self.print(stmt.line, parts),
            StmtKind::Home { axes, query } => {
                for &axis in axes {
                    self.effect(stmt, Effect::Home { axis, query: *query }, &[]);
                }
            }
            StmtKind::Cycle(cycle) => self.cycle(stmt, cycle),
            kind => {
                if let Some((effect, values)) = effects::shape(kind) {
                    self.effect(stmt, effect, &values);
                }
                if let StmtKind::OnInput { slot, target, .. }
                | StmtKind::OnEvery { slot, target, .. } = kind
                {
                    let to = self.target(*target);
                    self.out.line(format!("ev({slot}, {to});"));
                }
            }
        }
        if self.out.precise || self.out.is_closed() {
            self.out.open(next);
        }
    }

    fn assign(&mut self, place: &Place, value: &Expr) {
        match place {
            Place::Var(var) => {
                let value = self.value(value);
                self.out.line(format!("v{} = {value};", var.0));
            }
            Place::Elem(var, index) => {
                let both = self.values(&[index, value]);
                self.out.line(format!("st(v{}, {}, {});", var.0, both[0], both[1]));
            }
        }
    }

    /// Index of a text.
    fn text(&mut self, text: &str) -> u16 {
        let index = self.texts.iter().position(|known| known == text);
        let index = index.unwrap_or_else(|| {
            self.texts.push(text.to_owned());
            self.texts.len() - 1
        });
        u16::try_from(index).unwrap_or(u16::MAX)
    }

    fn print(&mut self, line: u32, parts: &[PrintPart]) {
        // A FUNCTION may print: its value is there before the line begins.
        let call = parts.iter().find_map(|part| match part {
            PrintPart::Value(value, _) if value.has_call() => Some(value),
            _ => None,
        });
        let early = call.map(|value| {
            let value = self.value(value);
            let temp = self.out.temp();
            self.out.line(format!("{temp} = {value};"));
            temp
        });
        for part in parts {
            match part {
                PrintPart::Text(text) => {
                    let index = self.text(text);
                    self.plain(line, Effect::PrintText(index), Vec::new());
                }
                PrintPart::Value(value, unit) => {
                    let given = match &early {
                        Some(temp) if value.has_call() => temp.clone(),
                        _ => self.value(value),
                    };
                    self.plain(line, Effect::PrintValue(0, *unit), vec![given]);
                }
            }
        }
        self.plain(line, Effect::PrintEnd, Vec::new());
    }

    /// An effect whose values are plain numbers.
    fn plain(&mut self, line: u32, effect: Effect, values: Vec<String>) {
        let template = Template { effect, line, given: [true; 3], level: false, resume: 0 };
        let id = self.template(template);
        self.emit_effect(id, values);
    }

    fn emit_effect(&mut self, id: usize, mut arguments: Vec<String>) {
        let count = arguments.len();
        arguments.insert(0, id.to_string());
        self.out.flush();
        self.out.line(format!("f{count}({});", arguments.join(", ")));
    }

    /// A statement's effect; one that waits can be gone on with.
    fn effect(&mut self, stmt: &Stmt, effect: Effect, values: &[&Expr]) {
        let resume = if self.out.precise && effect.waits() { self.out.block() as i32 } else { 0 };
        let id = self.template(Template {
            effect,
            line: stmt.line,
            given: effects::given(&stmt.kind),
            level: effects::has_level(&stmt.kind),
            resume,
        });
        let values = self.values(values);
        self.emit_effect(id, values);
        if resume != 0 {
            let statement = self.out.id();
            let on = self.out.block();
            self.out.open(on);
            let after = self.out.block();
            self.out.jump(after);
            self.out.open(resume as usize);
            self.out.line(format!("r({statement}, {id});"));
            self.out.open(after);
        }
    }

    /// Whether `expr` is known before the run.
    pub(super) fn constant(expr: &Expr) -> Option<i32> {
        match expr.node {
            ExprKind::Const(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn case_test(&mut self, temp: u32, test: &CaseTest) -> String {
        match test {
            CaseTest::Equal(value) => format!("v{temp} == {}", self.value(value)),
            CaseTest::Range(low, high) => {
                let both = self.values(&[low, high]);
                // Both limits are evaluated: there is no short circuit here.
                format!("(v{temp} >= {}) & (v{temp} <= {})", both[0], both[1])
            }
            CaseTest::Is(op, value) => {
                let value = self.value(value);
                self.compare(*op, &format!("v{temp}"), &value)
            }
        }
    }

    /// A look at the machine as a Rhai expression.
    pub(super) fn look_at(&mut self, read: Read) -> String {
        self.out.flush();
        let line = self.out.script_line();
        let effect = Effect::Read(read);
        let id =
            self.template(Template { effect, line, given: [true; 3], level: false, resume: 0 });
        format!("g0({id})")
    }
}
