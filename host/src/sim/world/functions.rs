//! The functions that a world's script may call.

use std::cell::RefCell;
use std::rc::Rc;

use lang::axis::Axis;
use lang::profile::ANALOGS;
use rhai::{Dynamic, Engine, EvalAltResult, FnPtr, Map, NativeCallContext};

use super::plan::{Expectation, Job, Plan};
use super::{Action, Button, PRESS_US};

/// Every function: how it is called, and what it does. The manual's table and the list in diagnostics
/// are made of it.
pub const FUNCTIONS: &[(&str, &str)] = &[
    (
        "at(ms, || ...)",
        "The function runs at this time, in milliseconds; a time that is past is now.",
    ),
    ("after(ms, || ...)", "The function runs so many milliseconds from now."),
    (
        "after_out(n, on, ms, || ...)",
        "Each time output `n` goes on (`true`) or off (`false`), the function runs so much later.",
    ),
    ("set_in(n, on)", "Input `n` goes on or off, as scripts see it: polarity is the profile's."),
    ("set_ain(n, mv)", "Analog input `n` has this voltage from now on, mV."),
    (
        "ramp_ain(n, mv, ms)",
        "Its voltage goes evenly from what it is to this one within so many ms, by a step each ms.",
    ),
    (
        "probe_at(\"Z\", steps[, side])",
        "The probe is on with the axis at this machine position and beyond it, seen from 0; side 1: there \
         and above, -1: there and below.",
    ),
    (
        "switch_at(\"X\", steps)",
        "The reference switch of the axis closes here, counted from where it stands at power-up.",
    ),
    ("press_start()", "Start is pressed for 100 ms."),
    ("press_stop()", "Stop is pressed for 100 ms."),
    ("press_estop()", "The emergency stop is pressed."),
    ("hold_stop(ms, for_ms)", "Stop goes down at `ms` and up again `for_ms` later."),
    ("send_char(c)", "The host sends this synchronisation character, 33 to 125."),
    (
        "fault_at(ms, \"stall\", \"Y\", steps)",
        "The motor loses so many steps: it stands behind its commanded place by them.",
    ),
    ("set_at(3000, value)", "The operator gives the `AT` variable at this register a value."),
    ("at_value(3000)", "The value of the `AT` variable at this register; engines rhai and vm."),
    (
        "unattended()",
        "All that the world does not say is as without one: Start is pressed for who waits for it, and reference \
         switches are out of the way until their axis is homed. On engine board they stand 20 mm off, as in every world.",
    ),
    ("force_in(n, on)", "Input `n` hangs in this state, whatever world and cell give to it."),
    ("free_in(n)", "It hangs no more."),
    (
        "at_take(\"tray\", || ...)",
        "Each time the tool takes a thing of this feeder, conveyor or part of the cell, or this thing (`tray.3`), the function runs.",
    ),
    ("remove(\"tray.3\")", "Somebody takes this thing of the cell away, unless the tool holds it."),
    ("put(\"tray.3\")", "Somebody puts it where it was at the start."),
    (
        "where_is(\"tray.3\")",
        "Where it is: a map with `state` (`stands`, `held`, `gone`), `place` (the place that it lies in, or an empty text) and \
         `x`, `y`, `z`, the middle of its bottom in the cell's frame in um.",
    ),
    ("expect_out(n, on)", "At the end of the run output `n` must be on or off."),
    (
        "expect_pos(\"X\", steps)",
        "At the end of the run the axis must be at this machine position.",
    ),
];

/// The functions in one line, for diagnostics.
pub fn names() -> String {
    FUNCTIONS.iter().map(|(call, _)| *call).collect::<Vec<_>>().join(", ")
}

/// Highest input and output number of any wiring.
const LINES: i32 = 17;
/// Highest voltage at a pin, mV: what lies above the supply is cut off by the pin.
const VOLTS: i32 = 3300;

type Done = Result<(), Box<EvalAltResult>>;

fn fail<T>(context: &NativeCallContext<'_>, text: String) -> Result<T, Box<EvalAltResult>> {
    Err(EvalAltResult::ErrorRuntime(text.into(), context.call_position()).into())
}

fn us(context: &NativeCallContext<'_>, ms: i32) -> Result<u64, Box<EvalAltResult>> {
    match u64::try_from(ms) {
        Ok(ms) => Ok(ms * 1_000),
        Err(_) => fail(context, format!("a time of {ms} ms; times are 0 or more")),
    }
}

fn axis(context: &NativeCallContext<'_>, name: &str) -> Result<Axis, Box<EvalAltResult>> {
    let mut letters = name.chars();
    match (letters.next().and_then(Axis::from_letter), letters.next()) {
        (Some(axis), None) => Ok(axis),
        _ => fail(context, format!("`{name}` is no axis; write \"X\", \"Y\" or \"Z\"")),
    }
}

fn line(context: &NativeCallContext<'_>, n: i32) -> Result<i32, Box<EvalAltResult>> {
    if (1..=LINES).contains(&n) {
        return Ok(n);
    }
    fail(context, format!("number {n}; inputs and outputs are 1..{LINES}"))
}

/// An analog input and a voltage at it, mV.
fn analog(
    context: &NativeCallContext<'_>,
    n: i32,
    mv: i32,
) -> Result<(i32, u16), Box<EvalAltResult>> {
    if !(1..=ANALOGS).contains(&n) {
        return fail(context, format!("analog input {n}; they are 1..{ANALOGS}"));
    }
    match u16::try_from(mv) {
        Ok(volts) if mv <= VOLTS => Ok((n, volts)),
        _ => fail(context, format!("{mv} mV; a pin has 0..{VOLTS} mV")),
    }
}

/// A state as scripts write it: `true`, `false` or a number.
fn state(context: &NativeCallContext<'_>, value: &Dynamic) -> Result<bool, Box<EvalAltResult>> {
    match (value.as_bool(), value.as_int()) {
        (Ok(on), _) => Ok(on),
        (_, Ok(number)) => Ok(number != 0),
        _ => fail(context, "a state is true or false".to_owned()),
    }
}

/// Adds the functions to `engine`; they write into `plan`.
pub fn register(engine: &mut Engine, plan: &Rc<RefCell<Plan>>) {
    time(engine, plan);
    stimuli(engine, plan);
    things(engine, plan);
    expectations(engine, plan);
}

fn time(engine: &mut Engine, shared: &Rc<RefCell<Plan>>) {
    let plan = shared.clone();
    engine.register_fn("unattended", move || plan.borrow_mut().unattended = true);
    let plan = shared.clone();
    engine.register_fn("at", move |c: NativeCallContext<'_>, ms: i32, f: FnPtr| -> Done {
        let at = us(&c, ms)?;
        let planned = plan.borrow_mut().schedule(at, Job::Call(f));
        planned.or_else(|text| fail(&c, text))
    });
    let plan = shared.clone();
    engine.register_fn("after", move |c: NativeCallContext<'_>, ms: i32, f: FnPtr| -> Done {
        let delay = us(&c, ms)?;
        let mut plan = plan.borrow_mut();
        let at = plan.now_us + delay;
        plan.schedule(at, Job::Call(f)).or_else(|text| fail(&c, text))
    });
    let plan = shared.clone();
    engine.register_fn(
        "after_out",
        move |c: NativeCallContext<'_>, n: i32, on: Dynamic, ms: i32, f: FnPtr| -> Done {
            let (n, on, delay) = (line(&c, n)?, state(&c, &on)?, us(&c, ms)?);
            plan.borrow_mut().hook(n, on, delay, f).or_else(|text| fail(&c, text))
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "fault_at",
        move |c: NativeCallContext<'_>, ms: i32, kind: &str, name: &str, steps: i32| -> Done {
            let (at, axis) = (us(&c, ms)?, axis(&c, name)?);
            if kind != "stall" {
                return fail(&c, format!("`{kind}` is no fault of a world; \"stall\" is"));
            }
            let job = Job::Act(Action::Stall { axis, steps });
            plan.borrow_mut().schedule(at, job).or_else(|text| fail(&c, text))
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "hold_stop",
        move |c: NativeCallContext<'_>, ms: i32, hold_ms: i32| -> Done {
            let (at, hold) = (us(&c, ms)?, us(&c, hold_ms)?);
            let job = Job::Press(Button::Stop, hold);
            plan.borrow_mut().schedule(at, job).or_else(|text| fail(&c, text))
        },
    );
}

fn stimuli(engine: &mut Engine, shared: &Rc<RefCell<Plan>>) {
    let plan = shared.clone();
    engine.register_fn("set_in", move |c: NativeCallContext<'_>, n: i32, on: Dynamic| -> Done {
        let (n, on) = (line(&c, n)?, state(&c, &on)?);
        plan.borrow_mut().act(Action::Input { n, on });
        Ok(())
    });
    let plan = shared.clone();
    engine.register_fn("set_ain", move |c: NativeCallContext<'_>, n: i32, mv: i32| -> Done {
        let (n, mv) = analog(&c, n, mv)?;
        plan.borrow_mut().ramp(n, mv, 0).or_else(|text| fail(&c, text))
    });
    let plan = shared.clone();
    engine.register_fn(
        "ramp_ain",
        move |c: NativeCallContext<'_>, n: i32, mv: i32, ms: i32| -> Done {
            let ((n, mv), time) = (analog(&c, n, mv)?, us(&c, ms)?);
            plan.borrow_mut().ramp(n, mv, time).or_else(|text| fail(&c, text))
        },
    );
    let plan = shared.clone();
    engine.register_fn("press_start", move || plan.borrow_mut().press(Button::Start, PRESS_US));
    let plan = shared.clone();
    engine.register_fn("press_stop", move || plan.borrow_mut().press(Button::Stop, PRESS_US));
    let plan = shared.clone();
    engine.register_fn("press_estop", move || plan.borrow_mut().act(Action::EmergencyStop));
    let plan = shared.clone();
    engine.register_fn("send_char", move |c: NativeCallContext<'_>, code: i32| -> Done {
        if !(33..=125).contains(&code) {
            return fail(&c, format!("character {code}; synchronisation characters are 33..125"));
        }
        plan.borrow_mut().act(Action::Char(code));
        Ok(())
    });
    let plan = shared.clone();
    engine.register_fn(
        "set_at",
        move |c: NativeCallContext<'_>, register: i32, value: i32| -> Done {
            let mut plan = plan.borrow_mut();
            if plan.client_gone {
                return Ok(());
            }
            let register = plan.registers.set(register, value).or_else(|text| fail(&c, text))?;
            plan.act(Action::Register { register, value });
            Ok(())
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "at_value",
        move |c: NativeCallContext<'_>, register: i32| -> Result<i32, Box<EvalAltResult>> {
            plan.borrow().registers.get(register).or_else(|text| fail(&c, text))
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "switch_at",
        move |c: NativeCallContext<'_>, name: &str, steps: i32| -> Done {
            let axis = axis(&c, name)?;
            plan.borrow_mut().switches[axis.index()] = Some(steps);
            Ok(())
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "probe_at",
        move |c: NativeCallContext<'_>, name: &str, steps: i32| -> Done {
            let axis = axis(&c, name)?;
            if steps == 0 {
                let text = "a plate at 0 has no side seen from 0; add 1 (on above) or -1 (below)";
                return fail(&c, text.to_owned());
            }
            plan.borrow_mut().plates[axis.index()] = Some((steps, steps.signum()));
            Ok(())
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "probe_at",
        move |c: NativeCallContext<'_>, name: &str, steps: i32, side: i32| -> Done {
            let axis = axis(&c, name)?;
            if side != 1 && side != -1 {
                return fail(&c, format!("side {side}; write 1 (on above) or -1 (on below)"));
            }
            plan.borrow_mut().plates[axis.index()] = Some((steps, side));
            Ok(())
        },
    );
}

/// What is about the cell beside the world.
fn things(engine: &mut Engine, shared: &Rc<RefCell<Plan>>) {
    let plan = shared.clone();
    engine.register_fn("force_in", move |c: NativeCallContext<'_>, n: i32, on: Dynamic| -> Done {
        let (n, on) = (line(&c, n)?, state(&c, &on)?);
        plan.borrow_mut().force(n, Some(on));
        Ok(())
    });
    let plan = shared.clone();
    engine.register_fn("free_in", move |c: NativeCallContext<'_>, n: i32| -> Done {
        let n = line(&c, n)?;
        plan.borrow_mut().force(n, None);
        Ok(())
    });
    let plan = shared.clone();
    engine.register_fn("at_take", move |c: NativeCallContext<'_>, name: &str, f: FnPtr| -> Done {
        plan.borrow_mut().beside.hook(name, f).or_else(|text| fail(&c, text))
    });
    let plan = shared.clone();
    engine.register_fn("remove", move |c: NativeCallContext<'_>, name: &str| -> Done {
        plan.borrow_mut().hands(name, false).or_else(|text| fail(&c, text))
    });
    let plan = shared.clone();
    engine.register_fn("put", move |c: NativeCallContext<'_>, name: &str| -> Done {
        plan.borrow_mut().hands(name, true).or_else(|text| fail(&c, text))
    });
    let plan = shared.clone();
    engine.register_fn(
        "where_is",
        move |c: NativeCallContext<'_>, name: &str| -> Result<Map, Box<EvalAltResult>> {
            let found = plan.borrow().beside.where_is(name).or_else(|text| fail(&c, text))?;
            let [x, y, z] = found.um;
            let mut map = Map::new();
            map.insert("state".into(), found.state.into());
            map.insert("place".into(), found.place.into());
            for (axis, um) in [("x", x), ("y", y), ("z", z)] {
                map.insert(axis.into(), um.into());
            }
            Ok(map)
        },
    );
}

fn expectations(engine: &mut Engine, shared: &Rc<RefCell<Plan>>) {
    let plan = shared.clone();
    engine.register_fn(
        "expect_out",
        move |c: NativeCallContext<'_>, n: i32, on: Dynamic| -> Done {
            let what = Expectation::Out(line(&c, n)?, state(&c, &on)?);
            let at = c.call_position().line().unwrap_or(1);
            plan.borrow_mut().expect(at, what).or_else(|text| fail(&c, text))
        },
    );
    let plan = shared.clone();
    engine.register_fn(
        "expect_pos",
        move |c: NativeCallContext<'_>, name: &str, steps: i32| -> Done {
            let what = Expectation::Pos(axis(&c, name)?, steps);
            let at = c.call_position().line().unwrap_or(1);
            plan.borrow_mut().expect(at, what).or_else(|text| fail(&c, text))
        },
    );
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::FUNCTIONS;

    #[test]
    fn the_table_names_every_function_that_is_registered() {
        // This test itself is no registration.
        let text = include_str!("functions.rs");
        let text = text.split("mod tests {").next().unwrap_or_default();
        let calls = text.split("register_fn(").skip(1);
        let registered: BTreeSet<&str> = calls
            .filter_map(|rest| rest.trim_start().strip_prefix('"')?.split('"').next())
            .collect();
        let told: BTreeSet<&str> =
            FUNCTIONS.iter().filter_map(|(call, _)| call.split('(').next()).collect();
        assert_eq!(registered, told);
    }
}
