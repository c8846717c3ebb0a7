//! The Rhai engine: a second implementation of the language.
//!
//! The checked program becomes a Rhai script: variables are Rhai variables, expressions are Rhai
//! expressions over functions of our own, and control flow is one `loop { switch pc { ... } }`
//! over basic blocks, since Rhai has no GOTO and its functions see no outer variables. Nothing of
//! the VM is used.

mod control;
mod cycle;
mod effects;
mod emit;
mod expr;
mod natives;
mod runtime;
mod translate;

#[cfg(test)]
mod tests;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use lang::hir::{Program, Storage, Var};
use rhai::{Array, Dynamic, Engine, EvalAltResult, OptimizationLevel, Scope};

use self::runtime::{Final, Runtime};
use super::chain::{Chain, RUN_STATEMENTS};
use super::controlled::Machine;
use super::world::{Registers, World};
use super::{Options, Outcome, SimError, Sink, VarValue, outcome};
use crate::course;

/// Deepest expression that Rhai is given.
const EXPRESSION_DEPTH: usize = 400;

/// The Rhai source of a program, for inspection.
pub fn source(program: &Program) -> String {
    translate::translate(program).script.source
}

/// Runs a program; `depth` calls may be open at once.
///
/// # Errors
/// As [`super::run`].
pub fn run(
    program: &Program,
    world: &World,
    options: &Options,
    depth: usize,
    sink: Sink,
) -> Result<Outcome, SimError> {
    run_chain(&Chain::alone(program), world, options, &[depth], sink)
}

/// Runs the first program of a chain, and those that RUN begins; of each so many calls may be open at once.
///
/// # Errors
/// As [`super::run`].
pub fn run_chain(
    chain: &Chain<'_>,
    world: &World,
    options: &Options,
    depths: &[usize],
    sink: Sink,
) -> Result<Outcome, SimError> {
    let refused = |error: &dyn std::fmt::Display| SimError::Engine(format!("rhai: {error}"));
    let [first, ..] = chain.programs() else { return Err(refused(&"no program")) };
    let mut registers = Registers::of(first);
    let mut translation = translate::translate(first);
    let texts = translation.texts.clone();
    let mut machine = Machine::new(&first.profile, world, options, texts, &registers, sink)?;
    machine.set_ends(course::ends(first, &options.part));
    let mut keeps = vec![BTreeMap::new(); chain.programs().len()];
    let (mut left, mut number) = (options.statements, 0);
    loop {
        let Some(program) = chain.programs().get(number) else {
            return Err(refused(&"a program that there is not"));
        };
        let depth = depths.get(number).copied().unwrap_or_default();
        let runtime = Runtime::new(machine, &translation, depth, left, chain.names().to_vec());
        let mut scope = Scope::new();
        share(program, &registers, &keeps[number], &mut scope);
        let (mut runtime, ended) = execute(program, &translation, runtime, &mut scope)?;
        let (fault, line) = match ended {
            Final::End(line) | Final::Stopped(line) => (None, line),
            Final::Fault(fault, line) => (Some(fault), line),
            Final::Run(next) => {
                keeps[number] = kept(program, &scope);
                let other = chain.programs().get(next).copied().unwrap_or(program);
                if next != number {
                    registers = Registers::of(other);
                    translation = translate::translate(other);
                }
                runtime.machine.set_out_anew(translation.texts.clone(), &registers);
                left = runtime.left.saturating_sub(RUN_STATEMENTS);
                machine = runtime.machine;
                number = next;
                continue;
            }
        };
        let vars = variables(program, &scope);
        let mut outcome = outcome(&mut runtime.machine, fault, line, vars)?;
        outcome.program = number;
        outcome.onward = runtime.onward.take();
        return Ok(outcome);
    }
}

/// Runs one program to where it ends.
fn execute(
    program: &Program,
    translation: &translate::Translation,
    runtime: Runtime,
    scope: &mut Scope<'_>,
) -> Result<(Runtime, Final), SimError> {
    let runtime = Rc::new(RefCell::new(runtime));
    // Without Rhai's own library: the script calls nothing but what is registered here.
    let mut engine = Engine::new_raw();
    engine
        .set_optimization_level(OptimizationLevel::None)
        .set_max_expr_depths(EXPRESSION_DEPTH, EXPRESSION_DEPTH)
        .set_max_variables(usize::MAX)
        .set_max_operations(0);
    let mut scales = [(1, 1); 3];
    for (axis, part) in program.profile.axes() {
        scales[axis.index()] = (part.scale.steps, part.scale.um);
    }
    natives::register(&mut engine, &runtime, scales);
    let refused = |error: &dyn std::fmt::Display| SimError::Engine(format!("rhai: {error}"));
    let ast = engine.compile(&translation.script.source).map_err(|error| refused(&error))?;
    let ended = engine.run_ast_with_scope(scope, &ast);
    drop(engine);
    let Ok(runtime) = Rc::try_unwrap(runtime) else {
        return Err(refused(&"the script is still there"));
    };
    let mut runtime = runtime.into_inner();
    let mut place = None;
    match ended {
        Ok(()) => {}
        Err(error) => match innermost(&error) {
            EvalAltResult::ErrorTerminated(..)
            | EvalAltResult::ErrorRuntime(..)
            | EvalAltResult::ErrorArithmetic(..) => {
                if let Some(line) = error.position().line()
                    && !translation.precise
                    && let Some(id) = translation.script.ids.get(line - 1)
                {
                    runtime.set_current(*id);
                    place = Some(runtime.line());
                    // The failing statement has taken its time too.
                    let uncounted = translation.script.uncounted.get(line - 1);
                    runtime.begun(uncounted.copied().unwrap_or(0));
                }
            }
            _ => return Err(refused(&error)),
        },
    }
    // Without precise statements only the place in the Rhai source tells the line.
    let ended = match runtime.ended() {
        Final::Stopped(line) => Final::Stopped(place.unwrap_or(line)),
        Final::Fault(fault, line) => Final::Fault(fault, place.unwrap_or(line)),
        ended => ended,
    };
    Ok((runtime, ended))
}

/// The AT variables, whose values the world shares, and the KEEP values that the program left.
fn share(
    program: &Program,
    registers: &Registers,
    keeps: &BTreeMap<usize, Vec<i32>>,
    scope: &mut Scope<'_>,
) {
    for (index, var) in program.vars.iter().enumerate() {
        let name = format!("v{index}");
        let first = match var.storage {
            Storage::Keep(_) => {
                let mut values = keeps.get(&index).cloned().unwrap_or_default();
                values.resize(var.len as usize, 0);
                match var.array {
                    true => {
                        scope.push(name, values.into_iter().map(Dynamic::from).collect::<Array>())
                    }
                    false => scope.push(name, values[0]),
                };
                continue;
            }
            Storage::At(first) => first,
            _ => continue,
        };
        let own = (first..=u16::MAX).step_by(2).take(var.len as usize);
        let mut values: Array = own.filter_map(|register| registers.shared(register)).collect();
        if var.array {
            scope.push_dynamic(name, values.into());
        } else if let Some(value) = values.pop() {
            scope.push_dynamic(name, value);
        }
    }
}

/// The KEEP values, by the numbers of their variables.
fn kept(program: &Program, scope: &Scope<'_>) -> BTreeMap<usize, Vec<i32>> {
    let keeps = program.vars.iter().enumerate();
    keeps
        .filter(|(_, var)| matches!(var.storage, Storage::Keep(_)))
        .map(|(index, var)| (index, values(var, index, scope)))
        .collect()
}

/// The values of a variable at the end of a run.
fn values(var: &Var, index: usize, scope: &Scope<'_>) -> Vec<i32> {
    let name = format!("v{index}");
    if !var.array {
        return vec![scope.get_value::<i32>(&name).unwrap_or(0)];
    }
    let cells = scope.get_value::<Array>(&name).unwrap_or_default();
    cells.iter().map(|cell| cell.as_int().unwrap_or(0)).collect()
}

fn innermost(error: &EvalAltResult) -> &EvalAltResult {
    match error {
        EvalAltResult::ErrorInFunctionCall(_, _, inner, _) => innermost(inner),
        _ => error,
    }
}

/// Final values of globals and KEEPs.
fn variables(program: &Program, scope: &Scope<'_>) -> Vec<VarValue> {
    let mut list = Vec::new();
    for (index, var) in program.vars.iter().enumerate() {
        if matches!(var.storage, Storage::Local(_)) || var.name.contains(' ') {
            continue;
        }
        let values = values(var, index, scope);
        list.push(VarValue { name: var.name.clone(), values });
    }
    list
}
