//! A checked program as text, close to the source, for snapshots.

use lang::effect::Frame;
use lang::hir::{
    ArcCenter, Block, CaseTest, Expr, ExprKind, GosubTarget, InWant, Place, PrintPart, ProbeSensor,
    Program, Stmt, StmtKind, Word,
};
use std::fmt::Write;

/// The whole program.
pub fn summary(program: &Program) -> String {
    let mut out = String::new();
    for (i, var) in program.vars.iter().enumerate() {
        let len = if var.array { format!("({})", var.len) } else { String::new() };
        let _ = writeln!(out, "v{i} {}{len}: {} {:?}", var.name, var.kind, var.storage);
    }
    for table in &program.tables {
        let kinds: Vec<_> = table.kinds.iter().map(|k| k.name()).collect();
        let _ = writeln!(out, "table {}({}) {:?}", table.name, kinds.join(", "), table.values);
    }
    for routine in &program.routines {
        let params: Vec<String> = routine.params.iter().map(|v| format!("v{}", v.0)).collect();
        let result = routine.result.map_or(String::new(), |k| format!(" -> {k}"));
        let unused = if routine.reachable { "" } else { " (unreachable)" };
        let _ = writeln!(out, "routine {}({}){result}{unused}", routine.name, params.join(", "));
        block(program, &routine.body, 1, &mut out);
    }
    let _ = writeln!(out, "{} statements, last line {}", program.statements, program.last_line);
    out
}

fn block(program: &Program, block: &Block, depth: usize, out: &mut String) {
    for stmt in block {
        let _ = write!(out, "{:>3}{}", stmt.line, "  ".repeat(depth));
        self::stmt(program, stmt, depth, out);
    }
}

fn stmt(program: &Program, stmt: &Stmt, depth: usize, out: &mut String) {
    let e = |e: &Expr| expr(program, e);
    let opt = |o: Option<&Expr>| o.map_or("-".to_owned(), |o| expr(program, o));
    let inner = |body: &Block, out: &mut String| block(program, body, depth + 1, out);
    match &stmt.kind {
        StmtKind::Assign(place, value) => {
            let place = match place {
                Place::Var(v) => format!("v{}", v.0),
                Place::Elem(v, i) => format!("v{}({})", v.0, e(i)),
            };
            let _ = writeln!(out, "{place} = {}", e(value));
        }
        StmtKind::If { arms, otherwise, one_line } => {
            let _ = writeln!(out, "if{}", if *one_line { " on one line" } else { "" });
            for arm in arms {
                let _ = writeln!(
                    out,
                    "{:>3}{}when {}",
                    arm.line,
                    "  ".repeat(depth),
                    e(&arm.condition)
                );
                inner(&arm.body, out);
            }
            if !otherwise.is_empty() {
                let _ = writeln!(out, "   {}else", "  ".repeat(depth));
                inner(otherwise, out);
            }
        }
        StmtKind::Select { value, temp, cases, otherwise } => {
            let _ = writeln!(out, "select v{} = {}", temp.0, e(value));
            for case in cases {
                let tests: Vec<String> = case
                    .tests
                    .iter()
                    .map(|test| match test {
                        CaseTest::Equal(v) => e(v),
                        CaseTest::Range(a, b) => format!("{} to {}", e(a), e(b)),
                        CaseTest::Is(op, v) => format!("{op:?} {}", e(v)),
                    })
                    .collect();
                let _ = writeln!(
                    out,
                    "{:>3}{}case {}",
                    case.line,
                    "  ".repeat(depth),
                    tests.join(", ")
                );
                inner(&case.body, out);
            }
            let _ = writeln!(out, "   {}else", "  ".repeat(depth));
            inner(otherwise, out);
        }
        StmtKind::For { var, from, to, step, to_temp, step_temp, body, next_line } => {
            let temps =
                [to_temp, step_temp].map(|t| t.map_or("-".to_owned(), |v| format!("v{}", v.0)));
            let _ = writeln!(
                out,
                "for v{} = {} to {} step {} [{}] next {next_line}",
                var.0,
                e(from),
                e(to),
                e(step),
                temps.join(" ")
            );
            inner(body, out);
        }
        StmtKind::While { condition, body } => {
            let _ = writeln!(out, "while {}", e(condition));
            inner(body, out);
        }
        StmtKind::Do { before, body, after } => {
            let test = |t: &Option<Box<lang::hir::DoTest>>| {
                t.as_ref().map_or("-".to_owned(), |t| {
                    format!("{} {}", if t.until { "until" } else { "while" }, e(&t.condition))
                })
            };
            let _ = writeln!(out, "do {} loop {}", test(before), test(after));
            inner(body, out);
        }
        StmtKind::Repeat { count, temp, body } => {
            let _ = writeln!(out, "repeat {} in v{}", e(count), temp.0);
            inner(body, out);
        }
        StmtKind::Label(id) => {
            let _ = writeln!(out, "{}:", program.labels[id.0 as usize].name);
        }
        StmtKind::Goto(id) => {
            let _ = writeln!(out, "goto {}", program.labels[id.0 as usize].name);
        }
        StmtKind::Gosub(target) => {
            let _ = writeln!(out, "gosub {}", self::target(program, *target));
        }
        StmtKind::OnInput { slot, n, want, target } => {
            let _ =
                writeln!(out, "on[{slot}] in {} {want:?} {}", e(n), self::target(program, *target));
        }
        StmtKind::OnEvery { slot, every, target } => {
            let _ =
                writeln!(out, "on[{slot}] every {} {}", e(every), self::target(program, *target));
        }
        StmtKind::Call(id, args) => {
            let args: Vec<String> = args.iter().map(e).collect();
            let _ = writeln!(out, "call {}({})", program.routine(*id).name, args.join(", "));
        }
        StmtKind::ReturnValue(value) => {
            let _ = writeln!(out, "return {}", e(value));
        }
        StmtKind::MoveAxe { axis, target, relative, start, speed, accel, decel } => {
            let _ = writeln!(
                out,
                "move{}{} {axis:?} {} {} {} {}",
                if *relative { "rel" } else { "" },
                if *start { " start" } else { "" },
                e(target),
                opt(speed.as_deref()),
                opt(accel.as_deref()),
                opt(decel.as_deref())
            );
        }
        StmtKind::MoveSpeed { axis, speed } => {
            let _ = writeln!(out, "movespeed {axis:?} {}", e(speed));
        }
        StmtKind::Probe { axis, limit, speed, sensor, query } => {
            let sensor = match &**sensor {
                ProbeSensor::Default => "default".to_owned(),
                ProbeSensor::Input(n, on) => format!("in {} is {}", e(n), e(on)),
                ProbeSensor::Mask(and, xor) => format!("mask {} {}", e(and), e(xor)),
            };
            let query = if *query { "?" } else { "" };
            let _ = writeln!(
                out,
                "probe{query} {axis:?} {} {} {sensor}",
                word(program, limit),
                opt(speed.as_deref())
            );
        }
        StmtKind::SetPos { axis, value } => {
            let _ = writeln!(out, "setpos {axis:?} {}", e(value));
        }
        StmtKind::Plain(statement, values) => {
            let name = format!("{statement:?}").to_lowercase();
            let values: String = values.iter().map(|value| format!(" {}", e(value))).collect();
            let _ = writeln!(out, "{name}{values}");
        }
        StmtKind::SetFeed(v) | StmtKind::SetSpindle(v) | StmtKind::OffInput(v) => {
            let name = format!("{:?}", stmt.kind);
            let name = name.split('(').next().unwrap_or("").to_lowercase();
            let _ = writeln!(out, "{name} {}", e(v));
        }
        StmtKind::Motors { on, axis } => {
            let _ = writeln!(out, "motors {} {axis:?}", e(on));
        }
        StmtKind::WaitIn { n, want, timeout, query } => {
            let want = match want {
                InWant::Level(level) => e(level),
                InWant::Edge(edge) => format!("{edge:?}"),
            };
            let query = if *query { "?" } else { "" };
            let _ = writeln!(out, "waitin{query} {} {want} {}", e(n), opt(timeout.as_deref()));
        }
        StmtKind::WaitChar { c, timeout, query } => {
            let query = if *query { "?" } else { "" };
            let _ = writeln!(out, "waitchar{query} {} {}", e(c), opt(timeout.as_deref()));
        }
        StmtKind::Print(parts) => {
            let parts: Vec<String> = parts
                .iter()
                .map(|part| match part {
                    PrintPart::Text(text) => format!("{text:?}"),
                    PrintPart::Value(value, unit) if *unit == value.kind.unit() => {
                        format!("{}:{}", e(value), value.kind)
                    }
                    PrintPart::Value(value, unit) => format!("{} in {}", e(value), unit.suffix()),
                })
                .collect();
            let _ = writeln!(out, "print {}", parts.join("; "));
        }
        StmtKind::Linear { rapid, to, exact } => {
            let name = if *rapid { "rapid" } else { "line" };
            let exact = if *exact { " exact" } else { "" };
            let _ = writeln!(out, "{name}{}{exact}", words(program, to));
        }
        StmtKind::Arc { clockwise, plane, to, center, exact } => {
            let center = match center {
                ArcCenter::Offsets(o) => {
                    o.iter().map(|o| opt(o.as_ref())).collect::<Vec<_>>().join(" ")
                }
                ArcCenter::Radius(r) => format!("r {}", e(r)),
            };
            let name = if *clockwise { "cw" } else { "ccw" };
            let exact = if *exact { " exact" } else { "" };
            let _ = writeln!(out, "{name} {plane:?}{} around {center}{exact}", words(program, to));
        }
        StmtKind::Cycle(cycle) => {
            let kind = match &cycle.kind {
                lang::hir::CycleKind::Drill => "drill".to_owned(),
                lang::hir::CycleKind::Dwell(p) => format!("drill and wait {}", e(p)),
                lang::hir::CycleKind::Peck(q) => format!("peck {}", e(q)),
            };
            let [x, y] = cycle.xy.clone();
            let back = match cycle.old_z {
                Some(v) => {
                    format!("back to v{}{}", v.0, if cycle.takes_z { " (taken)" } else { "" })
                }
                None => "back to r".to_owned(),
            };
            let _ = writeln!(
                out,
                "{kind}{} r {} z {} times {} {back}",
                words(program, &[x, y, None]),
                word(program, &cycle.r),
                word(program, &cycle.z),
                opt(cycle.repeats.as_ref())
            );
        }
        other => {
            let _ = writeln!(out, "{other:?}");
        }
    }
}

fn target(program: &Program, target: GosubTarget) -> String {
    match target {
        GosubTarget::Label(id) => program.labels[id.0 as usize].name.clone(),
        GosubTarget::Sub(id) => format!("sub {}", program.routine(id).name),
    }
}

fn words(program: &Program, to: &[Option<Word>; 3]) -> String {
    let mut out = String::new();
    for (letter, at) in ["X", "Y", "Z"].iter().zip(to) {
        if let Some(at) = at {
            let _ = write!(out, " {letter} {}", word(program, at));
        }
    }
    out
}

fn word(program: &Program, word: &Word) -> String {
    let frame = match word.frame {
        Frame::Work => "",
        Frame::Machine => "machine ",
        Frame::Relative => "by ",
    };
    format!("{frame}{}", expr(program, &word.value))
}

fn expr(program: &Program, value: &Expr) -> String {
    let e = |e: &Expr| expr(program, e);
    match &value.node {
        ExprKind::Const(v) => format!("{v}{}", value.kind.unit().suffix()),
        ExprKind::Var(v) => format!("v{}", v.0),
        ExprKind::Elem(v, i) => format!("v{}({})", v.0, e(i)),
        ExprKind::Table { table, row, column } => {
            format!("{}({}, {})", program.table(*table).name, e(row), e(column))
        }
        ExprKind::Unary(op, a) => format!("{op:?}({})", e(a)),
        ExprKind::Binary(op, a, b) => format!("({} {op:?} {})", e(a), e(b)),
        ExprKind::AndAlso(a, b) => format!("({} andalso {})", e(a), e(b)),
        ExprKind::OrElse(a, b) => format!("({} orelse {})", e(a), e(b)),
        ExprKind::Call(id, args) => {
            let args: Vec<String> = args.iter().map(e).collect();
            format!("{}({})", program.routine(*id).name, args.join(", "))
        }
        ExprKind::ToSteps(axis, a) => format!("steps({axis:?}, {})", e(a)),
        ExprKind::MulDiv(parts) => {
            let parts: Vec<String> = parts.iter().map(e).collect();
            format!("muldiv({})", parts.join(", "))
        }
        ExprKind::ToLength(axis, a) => format!("length({axis:?}, {})", e(a)),
        ExprKind::Read(lang::hir::ReadKind::In(n)) => format!("in({})", e(n)),
        ExprKind::Read(lang::hir::ReadKind::Out(n)) => format!("out({})", e(n)),
        ExprKind::Read(read) => format!("{read:?}").to_lowercase(),
        ExprKind::Err => "err".to_owned(),
        ExprKind::Erl => "erl".to_owned(),
    }
}
