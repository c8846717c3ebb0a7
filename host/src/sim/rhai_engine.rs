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
use std::rc::Rc;

use lang::hir::{Program, Storage};
use rhai::{Array, Engine, EvalAltResult, OptimizationLevel, Scope};

use self::runtime::{Final, Runtime};
use super::machine::Machine;
use super::world::{Registers, World};
use super::{Options, Outcome, SimError, Sink, VarValue, outcome};

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
    let translation = translate::translate(program);
    let texts = translation.texts.clone();
    let registers = Registers::of(program);
    let machine = Machine::new(&program.profile, world, options, texts, &registers, sink)?;
    let runtime = Runtime::new(machine, &translation, depth, options.statements);
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
    let mut scope = Scope::new();
    share(program, &registers, &mut scope);
    let ended = engine.run_ast_with_scope(&mut scope, &ast);
    let mut runtime = runtime.borrow_mut();
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
    let (fault, line) = match runtime.ended() {
        Final::End(line) => (None, line),
        // Without precise statements only the place in the Rhai source tells the line.
        Final::Stopped(line) => (None, place.unwrap_or(line)),
        Final::Fault(fault, line) => (Some(fault), place.unwrap_or(line)),
    };
    let vars = variables(program, &scope);
    outcome(&mut runtime.machine, fault, line, vars)
}

/// The AT variables, whose values the world shares.
fn share(program: &Program, registers: &Registers, scope: &mut Scope<'_>) {
    for (index, var) in program.vars.iter().enumerate() {
        let Storage::At(first) = var.storage else { continue };
        let own = (first..=u16::MAX).step_by(2).take(var.len as usize);
        let mut values: Array = own.filter_map(|register| registers.shared(register)).collect();
        let name = format!("v{index}");
        if var.array {
            scope.push_dynamic(name, values.into());
        } else if let Some(value) = values.pop() {
            scope.push_dynamic(name, value);
        }
    }
}

fn innermost(error: &EvalAltResult) -> &EvalAltResult {
    match error {
        EvalAltResult::ErrorInFunctionCall(_, _, inner, _) => innermost(inner),
        _ => error,
    }
}

/// Final values of globals and KEEPs.
fn variables(program: &Program, scope: &Scope<'_>) -> Vec<VarValue> {
    let mut values = Vec::new();
    for (index, var) in program.vars.iter().enumerate() {
        if matches!(var.storage, Storage::Local(_)) || var.name.contains(' ') {
            continue;
        }
        let name = format!("v{index}");
        let list = if var.array {
            let cells = scope.get_value::<Array>(&name).unwrap_or_default();
            cells.iter().map(|cell| cell.as_int().unwrap_or(0)).collect()
        } else {
            vec![scope.get_value::<i32>(&name).unwrap_or(0)]
        };
        values.push(VarValue { name: var.name.clone(), values: list });
    }
    values
}
