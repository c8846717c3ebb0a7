//! Scenario worlds: everything around the controller, described by a Rhai script.
//!
//! A [`World`] is the checked text; [`World::start`] makes a [`Scenario`] of it, which any engine
//! drives: it asks when something happens next, lets it happen, and reports its outputs. The
//! scenario knows nothing of the engine, so the emulated board runs the same worlds.

mod functions;
mod plan;
mod registers;
#[cfg(test)]
mod tests;
mod things;

use std::cell::RefCell;
use std::fmt;
use std::io::Write as _;
use std::rc::Rc;

use lang::axis::Axis;
use rhai::{AST, Engine, EvalAltResult, Position, Scope};

pub use self::functions::FUNCTIONS;
use self::plan::{Job, Plan};
pub use self::registers::{Registers, put};
use self::things::Beside;
pub use self::things::{Found, Things};
use super::trace::PerAxis;
use crate::scene::Scene;

/// A press that is not held, us.
pub const PRESS_US: u64 = 100_000;
/// Operations that one callback may take: some 0.2 s of a desktop.
const CALLBACK_OPERATIONS: u64 = 1_000_000;
/// Operations that a scenario may take in all.
const TOTAL_OPERATIONS: u64 = 50_000_000;
/// Longest script, bytes.
const SOURCE_LIMIT: usize = 1_000_000;

/// What the world does to the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Input `n` (from 1) takes a state, polarity already applied.
    Input {
        /// Input number.
        n: i32,
        /// State.
        on: bool,
    },
    /// A button goes down or up.
    Button {
        /// Which.
        button: Button,
        /// Down.
        down: bool,
    },
    /// The voltage at an analog input, from 1.
    Analog {
        /// Its number.
        n: i32,
        /// mV, 0 to 3300.
        mv: u16,
    },
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The host sends a synchronisation character.
    Char(i32),
    /// The operator gives an AT variable a value; a simulation's has it already.
    Register {
        /// Its register.
        register: u16,
        /// The value.
        value: i32,
    },
    /// A motor loses steps: it stands behind its commanded place from now on.
    Stall {
        /// Axis.
        axis: Axis,
        /// Steps lost.
        steps: i32,
    },
}

/// A button of the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Start.
    Start,
    /// Stop.
    Stop,
}

/// A mistake in a world's script.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorldError {
    /// The script's name.
    pub file: String,
    /// Line from 1.
    pub line: usize,
    /// Column from 1.
    pub column: usize,
    /// `S001` for a script that cannot be read, `S002` for one that fails when run.
    pub code: &'static str,
    /// What is wrong and what to write instead.
    pub text: String,
}

impl fmt::Display for WorldError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let WorldError { file, line, column, code, text } = self;
        write!(f, "{file}:{line}:{column}: error[{code}]: {text}")
    }
}

impl std::error::Error for WorldError {}

impl WorldError {
    fn new(file: &str, code: &'static str, at: Position, text: String) -> WorldError {
        WorldError {
            file: file.to_owned(),
            line: at.line().unwrap_or(1),
            column: at.position().unwrap_or(1),
            code,
            text,
        }
    }
}

/// From the beginning of a wait for Start to the press in an unattended world, us.
const UNATTENDED_PRESS_US: u64 = 1_000_000;

/// The text of a world, known to parse.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct World {
    file: String,
    source: String,
    unattended: bool,
    /// Reference switches, steps from power-up; what the script says comes before.
    switches: [Option<i32>; 3],
    /// The cell that the machine stands in.
    scene: Option<Scene>,
}

impl World {
    /// The world without a script: no input ever changes and a probe meets nothing.
    pub fn empty() -> World {
        World::default()
    }

    /// The world of a run that was given none, so that a plain file of a CAM runs: no input ever
    /// changes and a probe meets nothing; the reference switches are out of the way until their
    /// axis is homed for the first time, and stand 20 mm beyond all that it reached by then; whoever
    /// waits for Start gets a press after a second.
    pub fn unattended() -> World {
        World { unattended: true, ..World::default() }
    }

    /// Whether it is [`World::unattended`].
    pub fn is_unattended(&self) -> bool {
        self.unattended
    }

    /// Its name in diagnostics.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Its script.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// See [`World::with_switches`].
    pub fn switches(&self) -> [Option<i32>; 3] {
        self.switches
    }

    /// Whether there is no script.
    pub fn is_empty(&self) -> bool {
        self.source.is_empty()
    }

    /// The same world with reference switches at these steps from power-up, where its script does
    /// not say.
    pub fn with_switches(self, switches: [Option<i32>; 3]) -> World {
        World { switches, ..self }
    }

    /// The same world with a cell around the machine.
    pub fn with_scene(self, scene: Option<Scene>) -> World {
        World { scene, ..self }
    }

    /// The cell around the machine.
    pub fn scene(&self) -> Option<&Scene> {
        self.scene.as_ref()
    }

    /// Takes a script; `file` is the name in diagnostics.
    ///
    /// # Errors
    /// The text is no Rhai script or too long.
    pub fn parse(file: &str, source: &str) -> Result<World, WorldError> {
        if source.len() > SOURCE_LIMIT {
            let text =
                format!("the world has {} bytes; at most {SOURCE_LIMIT} are read", source.len());
            return Err(WorldError::new(file, "S001", Position::new(1, 1), text));
        }
        let (file, source) = (file.to_owned(), source.to_owned());
        let world = World { file, source, ..World::default() };
        compile(&engine(), &world)?;
        Ok(world)
    }

    /// Runs the script at time 0, with the AT variables of the program.
    ///
    /// # Errors
    /// The script fails.
    pub fn start(&self, registers: &Registers) -> Result<Scenario, WorldError> {
        let plan = Rc::new(RefCell::new(Plan::default()));
        plan.borrow_mut().switches = self.switches;
        plan.borrow_mut().registers = registers.clone();
        plan.borrow_mut().beside = Beside::of(self.scene.as_ref().map(|scene| scene.cell.clone()));
        let (file, unattended, scene) = (self.file.clone(), self.unattended, self.scene.clone());
        if self.is_empty() {
            let (engine, ast) = (Engine::new_raw(), AST::empty());
            return Ok(Scenario { file, unattended, scene, engine, ast, plan });
        }
        let mut engine = engine();
        functions::register(&mut engine, &plan);
        let used = Rc::new(std::cell::Cell::new(0_u64));
        engine.on_progress(move |_| {
            used.set(used.get() + 1);
            (used.get() > TOTAL_OPERATIONS).then(rhai::Dynamic::default)
        });
        let ast = compile(&engine, self)?;
        let scenario = Scenario { file, unattended, scene, engine, ast, plan };
        scenario
            .engine
            .run_ast_with_scope(&mut Scope::new(), &scenario.ast)
            .map_err(|error| scenario.error(&error))?;
        Ok(scenario)
    }
}

/// An engine without files, modules or `eval`, bounded in time and memory.
fn engine() -> Engine {
    let mut engine = Engine::new();
    engine
        .set_max_operations(CALLBACK_OPERATIONS)
        .set_max_call_levels(32)
        .set_max_expr_depths(64, 32)
        .set_max_string_size(65_536)
        .set_max_array_size(10_000)
        .set_max_map_size(10_000)
        .set_max_variables(1_000)
        .set_max_functions(1_000)
        .disable_symbol("eval");
    // Time is the machine's: a callback takes none of the desktop's.
    engine.register_fn("sleep", |_time: i32| -> Result<(), Box<EvalAltResult>> {
        Err("a world cannot sleep: `at(ms, || ...)` does something at a simulated time".into())
    });
    engine.on_print(say);
    engine.on_debug(|text, _, _| say(text));
    engine
}

/// Standard output is the trace's. A standard error that is closed is no reason to end.
fn say(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "world: {text}");
}

fn compile(engine: &Engine, world: &World) -> Result<AST, WorldError> {
    engine.compile(&world.source).map_err(|error| {
        WorldError::new(&world.file, "S001", error.position(), error.err_type().to_string())
    })
}

/// A world in motion.
pub struct Scenario {
    file: String,
    unattended: bool,
    scene: Option<Scene>,
    engine: Engine,
    ast: AST,
    plan: Rc<RefCell<Plan>>,
}

impl Scenario {
    /// From now on these are the AT variables.
    pub fn set_registers(&mut self, registers: &Registers) {
        self.plan.borrow_mut().registers = registers.clone();
    }

    /// The AT variable at a register gets a value, if the program has one there that may have it.
    pub fn write_register(&mut self, register: u16, value: i32) {
        // What is refused stays as it is, as on a board.
        self.plan.borrow_mut().registers.set(register.into(), value).ok();
    }

    /// The host's client ends: what only that can do has no effect from now on.
    pub fn end_client(&mut self) {
        self.plan.borrow_mut().client_gone = true;
    }

    /// Whether the host's client has ended.
    pub fn client_is_gone(&self) -> bool {
        self.plan.borrow().client_gone
    }

    /// When something happens next, us; `None` when nothing is left.
    pub fn next_us(&self) -> Option<u64> {
        self.plan.borrow().next_us()
    }

    /// Lets everything happen that is due at `now_us` or before; gives what it does to the
    /// controller, in order.
    ///
    /// # Errors
    /// A callback fails or exceeds its limits.
    pub fn advance(&mut self, now_us: u64) -> Result<Vec<Action>, WorldError> {
        loop {
            let job = {
                let mut plan = self.plan.borrow_mut();
                match plan.take_due(now_us) {
                    Some(job) => job,
                    None => {
                        plan.now_us = plan.now_us.max(now_us);
                        return Ok(plan.take_actions());
                    }
                }
            };
            match job {
                Job::Call(function) => {
                    let called: Result<rhai::Dynamic, _> =
                        function.call(&self.engine, &self.ast, ());
                    let _value = called.map_err(|error| self.error(&error))?;
                }
                Job::Release(button) => self.plan.borrow_mut().release(button),
                Job::Press(button, hold_us) => self.plan.borrow_mut().press(button, hold_us),
                Job::Act(action) => self.plan.borrow_mut().act(action),
                Job::Hands(name, puts) => {
                    // That the thing is there was looked up when it was planned.
                    let _done = self.plan.borrow_mut().beside.hands(&name, puts);
                }
                // One step gives way to the next: there cannot be more than before.
                Job::Ramp(place, number) => {
                    let _planned = self.plan.borrow_mut().climb(place, number);
                }
            }
        }
    }

    /// Output `n` changed at `now_us`: hooks that wait for it are scheduled.
    pub fn output_changed(&mut self, n: i32, on: bool, now_us: u64) {
        self.plan.borrow_mut().output_changed(n, on, now_us);
    }

    /// Whether nobody and nothing is there: see [`World::unattended`].
    pub fn is_unattended(&self) -> bool {
        self.unattended || self.plan.borrow().unattended
    }

    /// Whether nobody and nothing is there, and no file says more: who runs the program puts the reference switches.
    pub fn is_empty_and_unattended(&self) -> bool {
        self.unattended
    }

    /// The program waits for Start since `since_us`: in an unattended world it is pressed a second
    /// later, or now if that is past. Gives whether it will be.
    pub fn waits_for_start(&self, since_us: u64) -> bool {
        let press = Job::Press(Button::Start, PRESS_US);
        self.is_unattended()
            && self.plan.borrow_mut().schedule(since_us + UNATTENDED_PRESS_US, press).is_ok()
    }

    /// The cell around the machine.
    pub fn scene(&self) -> Option<&Scene> {
        self.scene.as_ref()
    }

    /// The cell runs: the world's functions ask and change it from now on.
    pub fn join(&self, things: Rc<dyn Things>) {
        self.plan.borrow_mut().beside.join(things);
    }

    /// Where the motors stand, steps from power-up, when the world acts next, at a time in us.
    pub fn stand(&self, us: u64, motors: [i64; 3]) {
        self.plan.borrow_mut().beside.stand(us, motors);
    }

    /// Whether the world has changed the cell since the last call: it must be asked anew.
    pub fn take_touch(&self) -> bool {
        self.plan.borrow_mut().beside.take_touch()
    }

    /// Things of the cell were taken at a time, us: what waits for them is due.
    pub fn taken(&self, things: &[String], us: u64) {
        let mut plan = self.plan.borrow_mut();
        for call in things.iter().flat_map(|thing| plan.beside.waits_for(thing)).collect::<Vec<_>>()
        {
            // A world with too many plans goes on without this one, as with those of outputs.
            let _planned = plan.schedule(us, Job::Call(call));
        }
    }

    /// Where `switch_at` put the axis's reference switch: steps from the place at power-up.
    pub fn switch_place(&self, axis: Axis) -> Option<i32> {
        self.plan.borrow().switches[axis.index()]
    }

    /// The plate that the axis's probe meets: its true machine position in steps, and on which
    /// side of it the probe is on (1: there and above, -1: there and below).
    pub fn probe_plate(&self, axis: Axis) -> Option<(i32, i32)> {
        self.plan.borrow().plates[axis.index()]
    }

    /// Whether the probe touches with the motors truly at these machine positions.
    pub fn probe_touches(&self, at: [i32; 3]) -> bool {
        let plan = self.plan.borrow();
        plan.plates.iter().zip(at).any(|(plate, at)| {
            plate.is_some_and(|(place, side)| if side > 0 { at >= place } else { at <= place })
        })
    }

    /// The expectations that do not hold at the end of a run.
    pub fn failures(&self, output: &dyn Fn(i32) -> bool, pos: &PerAxis) -> Vec<String> {
        self.plan.borrow().failures(&self.file, output, pos)
    }

    fn error(&self, error: &EvalAltResult) -> WorldError {
        let mut at = error.position();
        let mut inner = error;
        while let EvalAltResult::ErrorInFunctionCall(_, _, cause, _) = inner {
            inner = cause;
            if !inner.position().is_none() {
                at = inner.position();
            }
        }
        let text = match inner {
            EvalAltResult::ErrorFunctionNotFound(call, _) => {
                format!(
                    "there is no function `{call}` with these arguments; a world has {}",
                    functions::names()
                )
            }
            EvalAltResult::ErrorTooManyOperations(_) => format!(
                "a callback took more than {CALLBACK_OPERATIONS} operations; is there a loop \
                 without an end?"
            ),
            EvalAltResult::ErrorTerminated(..) => {
                format!("the world took more than {TOTAL_OPERATIONS} operations in all")
            }
            EvalAltResult::ErrorRuntime(value, _) if value.is_string() => value.to_string(),
            other => {
                let mut other = format!("{other}");
                if let Some(cut) = other.rfind(" (line ") {
                    other.truncate(cut);
                }
                other
            }
        };
        WorldError::new(&self.file, "S002", at, text)
    }
}

impl fmt::Debug for Scenario {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scenario").field("file", &self.file).finish_non_exhaustive()
    }
}
