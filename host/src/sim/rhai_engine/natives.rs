//! The functions that a translated script calls: operators with the language's own semantics,
//! cells, control flow, the machine.

use std::cell::RefCell;
use std::rc::Rc;

use lang::fault::Fault;
use lang::trig;
use rhai::{Array, Dynamic, Engine, EvalAltResult, Position};

use super::runtime::{Break, Runtime};
use crate::sim::machine::scaled;
use crate::sim::world::put;

type Shared = Rc<RefCell<Runtime>>;
type Out<T> = Result<T, Box<EvalAltResult>>;

/// A break as Rhai carries it: the end cannot be caught, everything else can.
fn raise<T>(runtime: &Shared, cause: Break) -> Out<T> {
    if cause == Break::Over {
        return Err(EvalAltResult::ErrorTerminated(Dynamic::UNIT, Position::NONE).into());
    }
    runtime.borrow_mut().keep(cause);
    Err(EvalAltResult::ErrorRuntime(Dynamic::UNIT, Position::NONE).into())
}

fn index(value: i32) -> usize {
    usize::try_from(value).unwrap_or(usize::MAX)
}

/// Registers everything.
pub fn register(engine: &mut Engine, runtime: &Shared, scales: [(u16, u16); 3]) {
    operators(engine, runtime);
    cells(engine, runtime);
    conversions(engine, runtime, scales);
    control(engine, runtime);
    machine(engine, runtime);
}

/// `a / b` toward zero.
fn quotient(a: i32, b: i32) -> Result<i32, Fault> {
    if b == 0 {
        return Err(Fault::DivisionByZero);
    }
    a.checked_div(b).ok_or(Fault::Overflow)
}

/// `a MOD b` with the sign of `a`; the least number MOD -1 is 0.
fn remainder(a: i32, b: i32) -> Result<i32, Fault> {
    if b == 0 { Err(Fault::DivisionByZero) } else { Ok(a.wrapping_rem(b)) }
}

fn shift_count(count: i32) -> Result<u32, Fault> {
    u32::try_from(count).ok().filter(|count| *count < 32).ok_or(Fault::BadShift)
}

/// Integer root.
fn root(a: i32) -> Result<i32, Fault> {
    u32::try_from(a).map(|a| a.isqrt() as i32).map_err(|_| Fault::ValueRange)
}

fn operators(engine: &mut Engine, runtime: &Shared) {
    type Unary = fn(i32) -> Result<i32, Fault>;
    type Binary = fn(i32, i32) -> Result<i32, Fault>;
    let one: [(&str, Unary); 7] = [
        ("sine", |a| Ok(trig::sin(a, trig::wide))),
        ("cosine", |a| Ok(trig::cos(a, trig::wide))),
        ("neg", |a| a.checked_neg().ok_or(Fault::Overflow)),
        ("mag", |a| a.checked_abs().ok_or(Fault::Overflow)),
        ("bnot", |a| Ok(!a)),
        ("sgn", |a| Ok(a.signum())),
        ("sqr", root),
    ];
    for (name, function) in one {
        let shared = runtime.clone();
        engine.register_fn(name, move |a: i32| -> Out<i32> {
            function(a).or_else(|fault| raise(&shared, fault.into()))
        });
    }
    let two: [(&str, Binary); 7] = [
        ("angle", |y, x| Ok(trig::atan2(y, x, trig::wide))),
        ("div", quotient),
        ("rem", remainder),
        ("shl", |a, b| Ok(((a as u32) << shift_count(b)?) as i32)),
        ("shr", |a, b| Ok(a >> shift_count(b)?)),
        ("least", |a, b| Ok(a.min(b))),
        ("most", |a, b| Ok(a.max(b))),
    ];
    for (name, function) in two {
        let shared = runtime.clone();
        engine.register_fn(name, move |a: i32, b: i32| -> Out<i32> {
            function(a, b).or_else(|fault| raise(&shared, fault.into()))
        });
    }
    let shared = runtime.clone();
    engine.register_fn("muldiv", move |value: i32, times: i32, over: i32| -> Out<i32> {
        trig::mul_div(value, times, over, trig::wide).or_else(|fault| raise(&shared, fault.into()))
    });
    let shared = runtime.clone();
    engine.register_fn("nz", move |a: i32| -> Out<()> {
        if a == 0 { raise(&shared, Fault::ValueRange.into()) } else { Ok(()) }
    });
}

fn cells(engine: &mut Engine, runtime: &Shared) {
    engine.register_fn("cells", |len: i32| -> Array { vec![Dynamic::from(0_i32); index(len)] });
    let shared = runtime.clone();
    engine.register_fn("ld", move |cells: &mut Array, at: i32| -> Out<i32> {
        match cells.get(index(at)) {
            Some(value) => Ok(value.as_int().unwrap_or(0)),
            None => raise(&shared, Fault::ArrayIndex.into()),
        }
    });
    let shared = runtime.clone();
    engine.register_fn("st", move |cells: &mut Array, at: i32, value: i32| -> Out<()> {
        match cells.get_mut(index(at)) {
            Some(cell) => {
                // An AT variable's element is shared with the world.
                put(cell, value);
                Ok(())
            }
            None => raise(&shared, Fault::ArrayIndex.into()),
        }
    });
    let shared = runtime.clone();
    engine.register_fn("tb", move |table: i32, row: i32, column: i32| -> Out<i32> {
        let value = shared.borrow().table(index(table), row, column);
        value.or_else(|cause| raise(&shared, cause))
    });
    let shared = runtime.clone();
    engine.register_fn("pu", move |value: i32| shared.borrow_mut().put(value));
    let shared = runtime.clone();
    engine.register_fn("po", move || shared.borrow_mut().take());
}

fn conversions(engine: &mut Engine, runtime: &Shared, scales: [(u16, u16); 3]) {
    let shared = runtime.clone();
    engine.register_fn("ts", move |axis: i32, um: i32| -> Out<i32> {
        let (steps, per) = scales[index(axis).min(2)];
        scaled(um, steps, per).or_else(|fault| raise(&shared, fault.into()))
    });
    let shared = runtime.clone();
    engine.register_fn("tl", move |axis: i32, count: i32| -> Out<i32> {
        let (steps, per) = scales[index(axis).min(2)];
        scaled(count, per, steps).or_else(|fault| raise(&shared, fault.into()))
    });
}

fn control(engine: &mut Engine, runtime: &Shared) {
    let shared = runtime.clone();
    engine.register_fn("t", move |count: i32| -> Out<()> {
        let passed = shared.borrow_mut().pass(count.unsigned_abs());
        passed.or_else(|cause| raise(&shared, cause))
    });
    let shared = runtime.clone();
    engine.register_fn("p", move |id: i32| -> Out<()> {
        let polled = shared.borrow_mut().poll(index(id));
        polled.or_else(|cause| raise(&shared, cause))
    });
    let shared = runtime.clone();
    engine.register_fn("c", move |id: i32| shared.borrow_mut().set_current(index(id)));
    for (name, sub) in [("cl", true), ("gs", false)] {
        let shared = runtime.clone();
        engine.register_fn(name, move |back: i32, to: i32| -> Out<i32> {
            let called = shared.borrow_mut().call(sub, back);
            called.map(|()| to).or_else(|cause| raise(&shared, cause))
        });
    }
    for (name, whole) in [("rt", false), ("xt", true)] {
        let shared = runtime.clone();
        engine.register_fn(name, move || -> Out<i32> {
            let left = shared.borrow_mut().leave(whole);
            left.or_else(|cause| raise(&shared, cause))
        });
    }
    for (name, again) in [("rn", false), ("ra", true)] {
        let shared = runtime.clone();
        engine.register_fn(name, move || -> Out<i32> {
            let resumed = shared.borrow_mut().resume(again);
            resumed.or_else(|cause| raise(&shared, cause))
        });
    }
    let shared = runtime.clone();
    engine.register_fn("gt", move |to: i32| -> i32 {
        shared.borrow_mut().goto();
        to
    });
    let shared = runtime.clone();
    engine.register_fn("oe", move |to: i32| shared.borrow_mut().set_on_error(to));
    let shared = runtime.clone();
    engine.register_fn("ev", move |slot: i32, to: i32| shared.borrow_mut().set_handler(slot, to));
    let shared = runtime.clone();
    engine.register_fn("er", move || shared.borrow().last_fault().0);
    let shared = runtime.clone();
    engine.register_fn("el", move || shared.borrow().last_fault().1);
    let shared = runtime.clone();
    engine.register_fn("fin", move |line: i32| -> Out<()> {
        let cause = shared.borrow_mut().end(line.unsigned_abs());
        raise(&shared, cause)
    });
    let shared = runtime.clone();
    engine.register_fn("run", move |line: i32, name: i32| -> Out<()> {
        let cause = shared.borrow_mut().run_other(line.unsigned_abs(), name.unsigned_abs());
        raise(&shared, cause)
    });
    let shared = runtime.clone();
    engine.register_fn("caught", move |error: Dynamic| -> Out<i32> {
        // Rhai's own errors come as a map; only its checked arithmetic may fail.
        if let Some(map) = error.read_lock::<rhai::Map>() {
            let name = map.get("error").map(ToString::to_string).unwrap_or_default();
            if name != "ErrorArithmetic" {
                let text = map.get("message").map(ToString::to_string).unwrap_or(name);
                return Err(EvalAltResult::ErrorSystem(text, "translation".into()).into());
            }
        }
        let caught = shared.borrow_mut().caught();
        caught.or_else(|cause| raise(&shared, cause))
    });
}

fn machine(engine: &mut Engine, runtime: &Shared) {
    let run = |shared: &Shared, id: i32, values: &[i32]| -> Out<i32> {
        let done = shared.borrow_mut().effect(index(id), values);
        done.or_else(|cause| raise(shared, cause))
    };
    let s = runtime.clone();
    engine.register_fn("g0", move |id: i32| run(&s, id, &[]));
    let s = runtime.clone();
    engine.register_fn("g1", move |id: i32, a: i32| run(&s, id, &[a]));
    let s = runtime.clone();
    engine.register_fn("f0", move |id: i32| run(&s, id, &[]));
    let s = runtime.clone();
    engine.register_fn("f1", move |id: i32, a: i32| run(&s, id, &[a]));
    let s = runtime.clone();
    engine.register_fn("f2", move |id: i32, a: i32, b: i32| run(&s, id, &[a, b]));
    let s = runtime.clone();
    engine.register_fn("f3", move |id: i32, a: i32, b: i32, c: i32| run(&s, id, &[a, b, c]));
    let s = runtime.clone();
    engine.register_fn("f4", move |id: i32, a: i32, b: i32, c: i32, d: i32| {
        run(&s, id, &[a, b, c, d])
    });
    let s = runtime.clone();
    engine.register_fn("f5", move |id: i32, a: i32, b: i32, c: i32, d: i32, e: i32| {
        run(&s, id, &[a, b, c, d, e])
    });
    let s = runtime.clone();
    engine.register_fn("f6", move |id: i32, a: i32, b: i32, c: i32, d: i32, e: i32, f: i32| {
        run(&s, id, &[a, b, c, d, e, f])
    });
    let shared = runtime.clone();
    engine.register_fn("r", move |statement: i32, id: i32| -> Out<()> {
        let resumed = shared.borrow_mut().go_on(index(statement), index(id));
        resumed.or_else(|cause| raise(&shared, cause))
    });
    let shared = runtime.clone();
    engine.register_fn("cy", move |id: i32, values: Array| -> Out<()> {
        let values: Vec<i32> = values.iter().map(|value| value.as_int().unwrap_or(0)).collect();
        let done = shared.borrow_mut().cycle(index(id), &values);
        done.or_else(|cause| raise(&shared, cause))
    });
}
