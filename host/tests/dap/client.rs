//! A debugger's side of the Debug Adapter Protocol, which holds the adapter to the specification:
//! framing, numbers, the fields that each message must have, and nothing asked that was not offered.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::Duration;

use serde_json::{Value, json};

/// Longest wait for a message.
const PATIENCE: Duration = Duration::from_secs(60);

/// Requests that want a capability.
const OFFERED: [(&str, &str); 8] = [
    ("configurationDone", "supportsConfigurationDoneRequest"),
    ("stepBack", "supportsStepBack"),
    ("reverseContinue", "supportsStepBack"),
    ("setVariable", "supportsSetVariable"),
    ("setExpression", "supportsSetExpression"),
    ("restart", "supportsRestartRequest"),
    ("terminate", "supportsTerminateRequest"),
    ("breakpointLocations", "supportsBreakpointLocationsRequest"),
];

/// A debugger.
pub struct Client {
    to: Box<dyn Write>,
    heard: Receiver<Value>,
    child: Option<Child>,
    seq: u64,
    /// Number of the adapter's last message.
    last: u64,
    capabilities: Value,
    /// Events that were not waited for yet.
    events: Vec<Value>,
}

/// Reads messages until the adapter goes; each must be framed as the specification has it.
pub fn listen(from: impl Read + Send + 'static) -> Receiver<Value> {
    let (say, heard) = mpsc::channel();
    std::thread::spawn(move || {
        let mut from = BufReader::new(from);
        loop {
            let mut length = None;
            loop {
                let mut line = String::new();
                if from.read_line(&mut line).unwrap_or(0) == 0 {
                    return;
                }
                // A head's lines end with CR LF; the head with an empty one.
                let line = line.strip_suffix("\r\n").expect("CR LF");
                if line.is_empty() {
                    break;
                }
                let (name, value) = line.split_once(": ").expect("a field of the head");
                assert_eq!(name, "Content-Length");
                length = Some(value.parse::<usize>().expect("a number"));
            }
            let mut body = vec![0; length.expect("a length")];
            from.read_exact(&mut body).expect("the whole body");
            if say.send(serde_json::from_slice(&body).expect("JSON")).is_err() {
                return;
            }
        }
    });
    heard
}

impl Client {
    /// An adapter on its standard input and output.
    pub fn start() -> Client {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pasapas"))
            .args(["dap", "--stdio"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        let to = Box::new(child.stdin.take().expect("an input"));
        let heard = listen(child.stdout.take().expect("an output"));
        Client::begin(to, heard, Some(child))
    }

    /// An adapter at a port.
    pub fn connect(address: &str) -> Client {
        let stream = TcpStream::connect(address).expect("it listens");
        let heard = listen(stream.try_clone().expect("a second hand"));
        Client::begin(Box::new(stream), heard, None)
    }

    fn begin(to: Box<dyn Write>, heard: Receiver<Value>, child: Option<Child>) -> Client {
        let mut client = Client {
            to,
            heard,
            child,
            seq: 0,
            last: 0,
            capabilities: Value::Null,
            events: Vec::new(),
        };
        let arguments = json!({
            "clientID": "test", "adapterID": "pasapas", "linesStartAt1": true,
            "columnsStartAt1": true, "pathFormat": "path",
        });
        client.capabilities = client.ask("initialize", arguments);
        client
    }

    /// Sends bytes as they are.
    pub fn send(&mut self, bytes: &[u8]) {
        self.to.write_all(bytes).and_then(|()| self.to.flush()).expect("it takes them");
    }

    fn hear(&mut self) -> Value {
        let message = self.heard.recv_timeout(PATIENCE).expect("a message");
        let seq = message["seq"].as_u64().expect("a number");
        assert_eq!(seq, self.last + 1, "{message}");
        self.last = seq;
        match message["type"].as_str() {
            Some("event") => check_event(&message),
            Some("response") => {
                assert!(message["request_seq"].is_u64() && message["command"].is_string());
                assert!(message["success"].is_boolean(), "{message}");
                if message["success"] == false {
                    assert!(message["message"].is_string(), "{message}");
                    let error = &message["body"]["error"];
                    assert!(error["id"].is_u64() && error["format"].is_string(), "{message}");
                }
            }
            _ => panic!("{message}"),
        }
        message
    }

    /// Asks; gives the answer.
    pub fn response(&mut self, command: &str, arguments: Value) -> Value {
        if let Some((_, capability)) = OFFERED.iter().find(|(name, _)| *name == command) {
            assert_eq!(self.capabilities[capability], true, "{command} is not offered");
        }
        self.seq += 1;
        let request = json!({
            "seq": self.seq, "type": "request", "command": command, "arguments": arguments
        });
        let text = request.to_string();
        self.send(format!("Content-Length: {}\r\n\r\n{text}", text.len()).as_bytes());
        loop {
            let message = self.hear();
            if message["type"] == "event" {
                self.note(message);
                continue;
            }
            assert_eq!(
                (&message["request_seq"], &message["command"]),
                (&json!(self.seq), &json!(command))
            );
            return message;
        }
    }

    fn note(&mut self, event: Value) {
        if event["event"] == "capabilities" {
            for (name, value) in event["body"]["capabilities"].as_object().into_iter().flatten() {
                self.capabilities[name] = value.clone();
            }
        }
        self.events.push(event);
    }

    /// Asks for something that is done; gives the answer's body.
    pub fn ask(&mut self, command: &str, arguments: Value) -> Value {
        let mut response = self.response(command, arguments);
        assert_eq!(response["success"], true, "{response}");
        let body = response["body"].take();
        check_body(command, &body);
        body
    }

    /// Asks for something that is refused; gives the words.
    pub fn refused(&mut self, command: &str, arguments: Value) -> String {
        let response = self.response(command, arguments);
        assert_eq!(response["success"], false, "{response}");
        response["message"].as_str().expect("words").to_owned()
    }

    /// The next event of that name; those before it stay.
    pub fn event(&mut self, name: &str) -> Value {
        loop {
            if let Some(at) = self.events.iter().position(|event| event["event"] == name) {
                return self.events.remove(at)["body"].take();
            }
            let message = self.hear();
            assert_eq!(message["type"], "event", "{message}");
            assert!(name == "terminated" || message["event"] != "terminated", "{:?}", self.events);
            self.note(message);
        }
    }

    /// Everything printed so far.
    pub fn output(&mut self, category: &str) -> String {
        let own =
            |event: &&Value| event["event"] == "output" && event["body"]["category"] == category;
        let texts =
            self.events.iter().filter(own).filter_map(|event| event["body"]["output"].as_str());
        let text: String = texts.collect();
        let category = category.to_owned();
        self.events
            .retain(|e| e["event"] != "output" || e["body"]["category"] != category.as_str());
        text
    }

    /// Launches with these breakpoints, as an editor does.
    pub fn launch(&mut self, arguments: Value, breakpoints: Value) -> Value {
        let program = arguments["program"].clone();
        let command = if arguments["attach"] == true { "attach" } else { "launch" };
        self.ask(command, arguments);
        self.event("initialized");
        let arguments = json!({ "source": { "path": program }, "breakpoints": breakpoints });
        let set = self.ask("setBreakpoints", arguments);
        self.ask("setExceptionBreakpoints", json!({ "filters": ["faults"] }));
        self.ask("configurationDone", json!({}));
        set["breakpoints"].clone()
    }

    /// Waits for a halt; gives its reason and the lines of the open calls.
    pub fn halt(&mut self) -> (String, Vec<u64>) {
        let stopped = self.event("stopped");
        let calls = self.ask("stackTrace", json!({ "threadId": 1 }));
        let frames = calls["stackFrames"].as_array().expect("calls");
        let lines = frames.iter().filter_map(|frame| frame["line"].as_u64()).collect();
        (stopped["reason"].as_str().expect("a reason").to_owned(), lines)
    }

    /// Goes on; gives where it halts.
    pub fn go(&mut self, command: &str) -> (String, Vec<u64>) {
        self.ask(command, json!({ "threadId": 1 }));
        self.halt()
    }

    /// A list's entries as `name=value`.
    pub fn list(&mut self, scope: &str) -> Vec<String> {
        let scopes = self.ask("scopes", json!({ "frameId": 1 }));
        let own = scopes["scopes"].as_array().into_iter().flatten().find(|s| s["name"] == scope);
        let reference = own.unwrap_or_else(|| panic!("{scopes}"))["variablesReference"].clone();
        let found = self.ask("variables", json!({ "variablesReference": reference }));
        let entry = |v: &Value| {
            format!("{}={}", v["name"].as_str().unwrap_or(""), v["value"].as_str().unwrap_or(""))
        };
        found["variables"].as_array().into_iter().flatten().map(entry).collect()
    }

    /// A watch's result.
    pub fn watch(&mut self, expression: &str) -> String {
        let arguments = json!({ "expression": expression, "frameId": 1, "context": "watch" });
        let found = self.ask("evaluate", arguments);
        found["result"].as_str().expect("a result").to_owned()
    }

    /// Names of the open calls.
    pub fn calls(&mut self) -> Vec<String> {
        let calls = self.ask("stackTrace", json!({ "threadId": 1 }));
        let name = |frame: &Value| frame["name"].as_str().unwrap_or("").to_owned();
        calls["stackFrames"].as_array().into_iter().flatten().map(name).collect()
    }

    /// Says good-bye; the adapter ends.
    pub fn close(mut self) {
        self.ask("disconnect", json!({}));
        if let Some(mut child) = self.child.take() {
            drop(self.to);
            assert!(child.wait().expect("an end").success());
        }
    }
}

fn check_event(message: &Value) {
    let body = &message["body"];
    let good = match message["event"].as_str().unwrap_or("") {
        "initialized" | "terminated" => true,
        "continued" => body["threadId"].is_u64(),
        "stopped" => {
            let reasons =
                ["step", "breakpoint", "exception", "pause", "entry", "goto", "data breakpoint"];
            reasons.iter().any(|reason| body["reason"] == *reason) && body["threadId"].is_u64()
        }
        "output" => {
            let categories = ["console", "important", "stdout", "stderr", "telemetry"];
            categories.iter().any(|name| body["category"] == *name) && body["output"].is_string()
        }
        "exited" => body["exitCode"].is_u64(),
        "capabilities" => body["capabilities"].is_object(),
        _ => false,
    };
    assert!(good, "{message}");
}

fn check_body(command: &str, body: &Value) {
    let each = |list: &Value, good: &dyn Fn(&Value) -> bool| {
        list.as_array().is_some_and(|list| list.iter().all(good))
    };
    let good = match command {
        "threads" => each(&body["threads"], &|t| t["id"].is_u64() && t["name"].is_string()),
        "setBreakpoints" => each(&body["breakpoints"], &|b| b["verified"].is_boolean()),
        "stackTrace" => each(&body["stackFrames"], &|f| {
            f["id"].is_u64()
                && f["name"].is_string()
                && f["line"].is_u64()
                && f["column"].is_u64()
                && (f["source"]["path"].is_string() || f["presentationHint"] == "label")
        }),
        "scopes" => each(&body["scopes"], &|s| {
            s["name"].is_string() && s["variablesReference"].is_u64() && s["expensive"].is_boolean()
        }),
        "variables" => each(&body["variables"], &|v| {
            v["name"].is_string() && v["value"].is_string() && v["variablesReference"].is_u64()
        }),
        "evaluate" => body["result"].is_string() && body["variablesReference"].is_u64(),
        "setVariable" | "setExpression" => body["value"].is_string(),
        "breakpointLocations" => each(&body["breakpoints"], &|b| b["line"].is_u64()),
        _ => true,
    };
    assert!(good, "{command}: {body}");
}
