//! An editor's session: its requests, and the events of the run.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, Sender};
use std::time::Duration;

use lang::hir::Limits;
use serde_json::{Value, json};

use super::eval::{eval, place};
use super::launch::{self, Launch};
use super::program::Loaded;
use super::show::{self, Group};
use super::sim::Ear;
use super::snapshot::{Break, Order, Pace, Report, Snapshot};
use super::wire::Mouth;
use crate::lsp::quantity;

/// The one thread that a program has.
const THREAD: u64 = 1;
/// Longest wait for a run that is to end: a ramp down from the top rate.
const LEAVE: Duration = Duration::from_secs(6);

/// What a halted run shows, and what the editor was told of it.
struct Halted {
    at: Box<Snapshot>,
    groups: Vec<Group>,
}

/// See the module.
pub struct Session<W> {
    mouth: Mouth<W>,
    ear: Ear,
    setup: launch::Setup,
    loaded: Option<Arc<Loaded>>,
    launch: Option<Launch>,
    orders: Option<Sender<Order>>,
    /// Ends with the run's thread.
    ended: Option<Receiver<()>>,
    halted: Option<Halted>,
    breaks: BTreeMap<u32, Break>,
    faults: bool,
    /// Lines and columns count from 1 for the editor.
    from_one: bool,
    configured: bool,
    over: bool,
}

impl<W: Write> Session<W> {
    /// A session that has not begun; what runs speaks to `ear`.
    pub fn new(to: W, setup: launch::Setup, ear: Ear) -> Session<W> {
        Session {
            mouth: Mouth::new(to),
            ear,
            setup,
            loaded: None,
            launch: None,
            orders: None,
            ended: None,
            halted: None,
            breaks: BTreeMap::new(),
            faults: true,
            from_one: true,
            configured: false,
            over: false,
        }
    }

    /// Serves a request; `false` when the session is over.
    ///
    /// # Errors
    /// The editor has gone.
    pub fn serve(&mut self, request: &Value) -> io::Result<bool> {
        if request["type"] != "request" {
            return Ok(true);
        }
        let arguments = &request["arguments"];
        let command = request["command"].as_str().unwrap_or("");
        let result = match command {
            "initialize" => Ok(self.initialize(arguments)),
            "launch" | "attach" => self.launch(command == "attach", arguments),
            "setBreakpoints" => self.set_breakpoints(arguments),
            "setExceptionBreakpoints" => self.set_faults(arguments),
            "configurationDone" => self.configured(),
            "breakpointLocations" => self.locations(arguments),
            "threads" => Ok(json!({ "threads": [{ "id": THREAD, "name": "program" }] })),
            "stackTrace" => self.stack(arguments),
            "scopes" => self.scopes(arguments),
            "variables" => self.variables(arguments),
            "setVariable" => self.set_variable(arguments),
            "evaluate" => self.evaluate(arguments),
            "setExpression" => self.set_expression(arguments),
            "continue" => self.go(Pace::Go).map(|()| json!({ "allThreadsContinued": true })),
            "next" => self.go(Pace::Over).map(|()| json!({})),
            "stepIn" => self.go(Pace::Into).map(|()| json!({})),
            "stepOut" => self.go(Pace::Out).map(|()| json!({})),
            "stepBack" => self.go_back(Pace::Back),
            "reverseContinue" => self.go_back(Pace::Reverse),
            "pause" => self.order(Order::Pause).map(|()| json!({})),
            "restart" => self.restart(arguments),
            "terminate" | "disconnect" => {
                let attached = self.launch.as_ref().is_some_and(|launch| launch.attach);
                let ends = arguments["terminateDebuggee"].as_bool().unwrap_or(!attached);
                let order = if command == "terminate" || ends { Order::End } else { Order::Leave };
                // A run that is over already hears nothing.
                let _ = self.order(order);
                self.close();
                Ok(json!({}))
            }
            _ => Err(format!("`{command}` is not served")),
        };
        let began = matches!(command, "launch" | "attach") && result.is_ok();
        self.mouth.answer(request, result)?;
        match command {
            "disconnect" => return Ok(false),
            "terminate" => self.mouth.event("terminated", json!({}))?,
            _ if began => self.began()?,
            _ => {}
        }
        Ok(true)
    }

    /// Tells the editor what the run says.
    ///
    /// # Errors
    /// The editor has gone.
    pub fn report(&mut self, report: Report) -> io::Result<()> {
        match report {
            Report::Halted { reason, text, at } => {
                self.halted = Some(Halted { at, groups: Vec::new() });
                let mut body = json!({
                    "reason": reason, "threadId": THREAD, "allThreadsStopped": true
                });
                if let Some(text) = text {
                    body["description"] = json!(text.clone());
                    body["text"] = json!(text);
                }
                self.mouth.event("stopped", body)
            }
            Report::GoesOn => {
                self.halted = None;
                let body = json!({ "threadId": THREAD, "allThreadsContinued": true });
                self.mouth.event("continued", body)
            }
            Report::Said(category, text) => {
                self.mouth.event("output", json!({ "category": category, "output": text }))
            }
            Report::Over(code, text) => {
                self.halted = None;
                self.orders = None;
                self.over = true;
                let category = if code == 0 { "console" } else { "stderr" };
                self.mouth.event("output", json!({ "category": category, "output": text }))?;
                self.mouth.event("exited", json!({ "exitCode": code }))?;
                self.mouth.event("terminated", json!({}))
            }
        }
    }

    fn initialize(&mut self, arguments: &Value) -> Value {
        self.from_one = arguments["linesStartAt1"].as_bool().unwrap_or(true);
        json!({
            "supportsConfigurationDoneRequest": true,
            "supportsConditionalBreakpoints": true,
            "supportsHitConditionalBreakpoints": true,
            "supportsLogPoints": true,
            "supportsEvaluateForHovers": true,
            "supportsSetVariable": true,
            "supportsSetExpression": true,
            "supportsStepBack": true,
            "supportsRestartRequest": true,
            "supportsTerminateRequest": true,
            "supportTerminateDebuggee": true,
            "supportsBreakpointLocationsRequest": true,
            "exceptionBreakpointFilters": [{
                "filter": "faults", "label": "Faults", "default": true,
                "description": "Halt at a statement that fails, before its axes ramp down"
            }],
        })
    }

    fn launch(&mut self, attach: bool, arguments: &Value) -> Result<Value, String> {
        if self.launch.is_some() {
            return Err("a program is being debugged already".to_owned());
        }
        let launch = Launch::read(attach, arguments)?;
        self.loaded = Some(Arc::new(launch.load(&self.setup)?));
        self.launch = Some(launch);
        Ok(json!({}))
    }

    /// Behind the answer to launch: what is possible here, and that breakpoints may come.
    fn began(&mut self) -> io::Result<()> {
        let simulated = self.launch.as_ref().is_some_and(Launch::is_simulated);
        let mut capabilities = json!({ "supportsStepBack": simulated });
        if !simulated {
            // A board takes its axes down at once.
            capabilities["exceptionBreakpointFilters"] = json!([]);
        }
        self.mouth.event("capabilities", json!({ "capabilities": capabilities }))?;
        self.mouth.event("initialized", json!({}))
    }

    fn start(&mut self) -> Result<(), String> {
        let (Some(launch), Some(loaded)) = (&self.launch, &self.loaded) else {
            return Err("nothing was launched".to_owned());
        };
        let (orders, heard) = mpsc::channel();
        let breaks = self.breaks.values().cloned().collect();
        // Known before the first statement.
        let _ = orders.send(Order::Breaks(breaks, self.faults));
        self.ended = Some(launch.start(loaded.clone(), heard, self.ear.clone())?);
        self.orders = Some(orders);
        self.over = false;
        Ok(())
    }

    /// Waits until the run's thread has left the machine in order.
    pub fn close(&mut self) {
        self.orders = None;
        if let Some(ended) = self.ended.take() {
            // Nothing is ever sent: it ends, or it takes too long.
            let _ = ended.recv_timeout(LEAVE);
        }
    }

    fn configured(&mut self) -> Result<Value, String> {
        if !std::mem::replace(&mut self.configured, true) {
            self.start()?;
        }
        Ok(json!({}))
    }

    fn loaded(&self) -> Result<&Loaded, String> {
        self.loaded.as_deref().ok_or_else(|| "nothing was launched".to_owned())
    }

    fn line(&self, told: &Value) -> u32 {
        let line = told.as_u64().and_then(|line| u32::try_from(line).ok()).unwrap_or(0);
        line.saturating_add(u32::from(!self.from_one))
    }

    fn told(&self, line: u32) -> u32 {
        line.saturating_sub(u32::from(!self.from_one))
    }

    fn set_breakpoints(&mut self, arguments: &Value) -> Result<Value, String> {
        let loaded = self.loaded()?;
        let own = arguments["source"]["path"].as_str().is_none_or(|path| same(path, &loaded.file));
        let simulated = self.launch.as_ref().is_some_and(Launch::is_simulated);
        let mut breaks = BTreeMap::new();
        let mut told = Vec::new();
        for wanted in arguments["breakpoints"].as_array().into_iter().flatten() {
            let asked = self.line(&wanted["line"]);
            let line = loaded.line_from(asked, !simulated).filter(|_| own);
            let Some(line) = line else {
                let message =
                    if own { "nothing runs from here on" } else { "not the file that runs" };
                told.push(json!({ "verified": false, "line": wanted["line"], "message": message }));
                continue;
            };
            let text = |name: &str| {
                let text = wanted[name].as_str().map(str::trim).filter(|text| !text.is_empty());
                text.map(str::to_owned)
            };
            let hits = text("hitCondition").map(|hits| {
                let digits = hits.trim_start_matches(|c: char| !c.is_ascii_digit());
                digits.parse().map_err(|_| format!("`{hits}` is no number of hits"))
            });
            let mut answer = json!({ "verified": true, "line": self.told(line) });
            if !simulated {
                answer["message"] = json!("a board halts before effects: this is a line with one");
            }
            match hits.transpose() {
                Ok(hits) => {
                    let (condition, log) = (text("condition"), text("logMessage"));
                    breaks.insert(line, Break { line, condition, hits, log });
                }
                Err(words) => answer = json!({ "verified": false, "message": words }),
            }
            told.push(answer);
        }
        if own {
            self.breaks = breaks;
            self.tell_breaks();
        }
        Ok(json!({ "breakpoints": told }))
    }

    fn set_faults(&mut self, arguments: &Value) -> Result<Value, String> {
        let filters = arguments["filters"].as_array();
        self.faults = filters.is_some_and(|list| list.iter().any(|name| name == "faults"));
        self.tell_breaks();
        Ok(json!({}))
    }

    fn tell_breaks(&self) {
        let breaks = self.breaks.values().cloned().collect();
        // Before the start they are told with it.
        let _ = self.order(Order::Breaks(breaks, self.faults));
    }

    fn locations(&self, arguments: &Value) -> Result<Value, String> {
        let first = self.line(&arguments["line"]);
        let last = match &arguments["endLine"] {
            Value::Null => first,
            line => self.line(line),
        };
        let lines = self.loaded()?.lines.iter().filter(|line| (first..=last).contains(line));
        let places: Vec<Value> = lines.map(|line| json!({ "line": self.told(*line) })).collect();
        Ok(json!({ "breakpoints": places }))
    }

    fn halted(&self) -> Result<&Halted, String> {
        self.halted.as_ref().ok_or_else(|| "the program is not halted".to_owned())
    }

    fn order(&self, order: Order) -> Result<(), String> {
        let orders = self.orders.as_ref().ok_or_else(|| "nothing runs".to_owned())?;
        orders.send(order).map_err(|_| "the run is over".to_owned())
    }

    fn go(&mut self, pace: Pace) -> Result<(), String> {
        self.halted()?;
        self.halted = None;
        self.order(Order::Go(pace))
    }

    fn go_back(&mut self, pace: Pace) -> Result<Value, String> {
        if !self.launch.as_ref().is_some_and(Launch::is_simulated) {
            return Err("only a simulated run goes backwards".to_owned());
        }
        self.go(pace).map(|()| json!({}))
    }

    /// Begins anew, with the file as it is now.
    fn restart(&mut self, arguments: &Value) -> Result<Value, String> {
        let Some(launch) = &mut self.launch else { return Err("nothing was launched".to_owned()) };
        if arguments["arguments"].is_object() {
            *launch = Launch::read(launch.attach, &arguments["arguments"])?;
        }
        let loaded = launch.load(&self.setup)?;
        let same =
            self.loaded.as_ref().is_some_and(|old| old.compiled.image == loaded.compiled.image);
        self.halted = None;
        if same && self.order(Order::Restart).is_ok() {
            return Ok(json!({}));
        }
        let _ = self.order(Order::End);
        self.close();
        self.loaded = Some(Arc::new(loaded));
        self.start()?;
        Ok(json!({}))
    }

    fn stack(&self, arguments: &Value) -> Result<Value, String> {
        let (halted, loaded) = (self.halted()?, self.loaded()?);
        let path = std::path::absolute(&loaded.file).unwrap_or_else(|_| loaded.file.clone().into());
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let source = json!({ "name": name, "path": path.display().to_string() });
        let frame = |(n, frame): (usize, &super::snapshot::Frame)| {
            json!({
                "id": n + 1,
                "name": format!("{}{}", loaded.names.routine_name(frame.line), frame.by()),
                "line": self.told(frame.line),
                "column": u32::from(self.from_one),
                "source": source,
            })
        };
        let from = arguments["startFrame"].as_u64().unwrap_or(0) as usize;
        let levels = arguments["levels"].as_u64().filter(|n| *n > 0).unwrap_or(u64::MAX);
        let mut all: Vec<Value> = halted.at.frames.iter().enumerate().map(frame).collect();
        if !halted.at.known {
            // A board that does not tell who called.
            all.push(json!({
                "id": all.len() + 1, "name": "its callers: not known on this board",
                "line": 0, "column": 0, "presentationHint": "label",
            }));
        }
        let total = all.len();
        let some: Vec<Value> = all
            .into_iter()
            .skip(from)
            .take(usize::try_from(levels).unwrap_or(usize::MAX))
            .collect();
        Ok(json!({ "stackFrames": some, "totalFrames": total }))
    }

    /// The line of a frame by its number; of none the innermost's.
    fn frame_line(&self, id: &Value) -> Result<u32, String> {
        let frames = &self.halted()?.at.frames;
        let n = id.as_u64().unwrap_or(1).saturating_sub(1) as usize;
        frames.get(n).map(|frame| frame.line).ok_or_else(|| "there is no such call".to_owned())
    }

    fn scopes(&mut self, arguments: &Value) -> Result<Value, String> {
        let line = self.frame_line(&arguments["frameId"])?;
        let loaded = self.loaded.clone().ok_or("nothing was launched")?;
        let halted = self.halted.as_mut().ok_or("the program is not halted")?;
        let mut told = Vec::new();
        for (name, hint, group) in show::groups(&loaded.names, line) {
            halted.groups.push(group);
            told.push(json!({
                "name": name, "presentationHint": hint, "expensive": false,
                "variablesReference": halted.groups.len(),
            }));
        }
        Ok(json!({ "scopes": told }))
    }

    fn group(&self, reference: &Value) -> Result<Group, String> {
        let n = reference.as_u64().unwrap_or(0) as usize;
        let found = n.checked_sub(1).and_then(|n| self.halted.as_ref()?.groups.get(n));
        found.cloned().ok_or_else(|| "there is no such list any more".to_owned())
    }

    fn variables(&mut self, arguments: &Value) -> Result<Value, String> {
        let group = self.group(&arguments["variablesReference"])?;
        let loaded = self.loaded.clone().ok_or("nothing was launched")?;
        let halted = self.halted.as_mut().ok_or("the program is not halted")?;
        let mut told = Vec::new();
        for entry in show::entries(&group, &loaded.names, &halted.at) {
            let reference = entry.inside.map_or(0, |inside| {
                halted.groups.push(inside);
                halted.groups.len()
            });
            told.push(json!({
                "name": entry.name, "value": entry.value, "type": entry.kind,
                "evaluateName": entry.evaluate, "variablesReference": reference,
            }));
        }
        Ok(json!({ "variables": told }))
    }

    fn set_variable(&mut self, arguments: &Value) -> Result<Value, String> {
        let group = self.group(&arguments["variablesReference"])?;
        let name = arguments["name"].as_str().unwrap_or("");
        let loaded = self.loaded()?;
        let at = &self.halted()?.at;
        let entries = show::entries(&group, &loaded.names, at);
        let entry = entries.iter().find(|entry| entry.name == name);
        let target = entry.and_then(|entry| entry.evaluate.clone());
        let target = target.ok_or_else(|| format!("`{name}` cannot be set"))?;
        self.set(&target, group.line(), arguments)
    }

    fn set_expression(&mut self, arguments: &Value) -> Result<Value, String> {
        let line = self.frame_line(&arguments["frameId"])?;
        let target = arguments["expression"].as_str().unwrap_or("").to_owned();
        self.set(&target, line, arguments)
    }

    fn set(&mut self, target: &str, line: u32, arguments: &Value) -> Result<Value, String> {
        let loaded = self.loaded.clone().ok_or("nothing was launched")?;
        let at = &self.halted()?.at;
        let text = arguments["value"].as_str().unwrap_or("");
        let (cell, kind) = place(target, line, &loaded.names, at)?;
        let (own, value) = eval(text, line, &loaded.names, at)?;
        if own != kind && own != lang::kind::Kind::Number {
            return Err(format!("`{target}` is a {kind}, this is a {own}"));
        }
        let Limits { least, greatest } = loaded.names.limits(cell);
        if !(least..=greatest).contains(&value) {
            let [least, greatest] = [least, greatest].map(|limit| quantity(kind, limit));
            return Err(format!("`{target}` is {least} to {greatest}, by its MIN and MAX"));
        }
        self.order(Order::Set(cell, value))?;
        if let Some(own) = self.halted.as_mut().and_then(|halted| halted.at.cells.get_mut(cell)) {
            *own = value;
        }
        Ok(json!({ "value": quantity(kind, value), "type": kind.name(), "variablesReference": 0 }))
    }

    fn evaluate(&self, arguments: &Value) -> Result<Value, String> {
        let line = self.frame_line(&arguments["frameId"])?;
        let text = arguments["expression"].as_str().unwrap_or("");
        let (kind, value) = eval(text, line, &self.loaded()?.names, &self.halted()?.at)?;
        Ok(json!({ "result": quantity(kind, value), "type": kind.name(), "variablesReference": 0 }))
    }
}

/// Whether two paths name one file.
fn same(a: &str, b: &str) -> bool {
    let real = |path: &str| std::fs::canonicalize(path);
    a == b || matches!((real(a), real(b)), (Ok(a), Ok(b)) if a == b)
}
