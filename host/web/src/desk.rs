//! What the page has: a script, its world, and the language server that reads it.

use lang::front::ProfileChoice;
use lang::part::F5529;
use lsp_server::{Message, Notification, Request, RequestId};
use pasapas::lsp::{self, Server};
use pasapas::sim::world::World;
use pasapas::trial;
use pasapas::trial::budget::Budget;
use pasapas::trial::pulses::{self, Pulse};
use serde::Deserialize;
use serde_json::{Value, json};

/// The name by which the language server knows the text.
const URI: &str = "file:///script.bas";
/// Longest script that the page may send: what the compiler takes at most is far less.
const LONGEST: usize = 512 << 10;

/// Something for the page.
#[derive(Debug)]
pub enum Said {
    /// A JSON object of one name and its values, as the workbench's server sends it.
    Text(String),
    /// A path, as [`trial::Trial::path`] has it.
    Bytes(Vec<u8>),
}

/// What the page says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FromPage {
    /// Comes back with the answer.
    #[serde(default)]
    ask: u32,
    /// What it wants.
    #[serde(rename = "do")]
    wish: Wish,
}

/// What the page wants: the workbench's wishes that need no board and no disk.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Wish {
    /// What it needs to begin; the first message.
    Hello {
        /// Names of the examples.
        files: Vec<String>,
    },
    /// A request of the Language Server Protocol.
    Lsp(Value),
    /// The script's text, made from the one with number `base`.
    Text {
        /// Number of the text that it was made from.
        base: u64,
        /// All of it.
        text: String,
    },
    /// Another script, or a program of another system, with the world that belongs to it.
    Open {
        /// Its file's name.
        name: String,
        /// What the file holds.
        text: String,
        /// The world's script; empty for none.
        world: String,
    },
    /// The pulses of inputs that are drawn in the simulation now, all of them.
    Pulses(Vec<Pulse>),
    /// Simulate the text for a moment, and show the first turns of an endless loop.
    Simulate,
    /// Simulate the text as long as that is bearable, and show all of it.
    SimulateAll,
}

/// The script.
pub struct Desk {
    number: u64,
    name: String,
    text: String,
    world: World,
    server: Server<'static>,
}

impl Default for Desk {
    fn default() -> Desk {
        let server = Server::new(None);
        Desk { number: 1, name: String::new(), text: String::new(), world: World::empty(), server }
    }
}

fn text(message: &Value) -> Said {
    Said::Text(message.to_string())
}

impl Desk {
    /// Takes a message of the page.
    pub fn hear(&mut self, message: &[u8]) -> Vec<Said> {
        let FromPage { ask, wish } = match serde_json::from_slice(message) {
            Ok(message) => message,
            Err(error) => return vec![refused(0, &error.to_string())],
        };
        match self.do_it(wish) {
            Ok(mut said) => {
                said.insert(0, text(&json!({ "done": { "ask": ask, "words": "" } })));
                said
            }
            Err(words) => vec![refused(ask, &words)],
        }
    }

    fn do_it(&mut self, wish: Wish) -> Result<Vec<Said>, String> {
        match wish {
            Wish::Hello { files } => {
                let mut said = vec![text(&json!({ "welcome": {
                    "version": env!("CARGO_PKG_VERSION"),
                    "words": trial::words(),
                    "lsp": lsp::capabilities(),
                    "files": files,
                    "text": self.shown(),
                } }))];
                said.extend(self.told("textDocument/didOpen"));
                Ok(said)
            }
            Wish::Lsp(request) => Ok(self.request(&request).into_iter().collect()),
            Wish::Text { base, text } => {
                if base != self.number {
                    return Err("the script was changed meanwhile".to_owned());
                }
                self.set(text)
            }
            Wish::Open { name, text: program, world } => {
                let program = script(&name, program)?;
                self.world =
                    World::parse("world.rhai", &world).map_err(|error| error.to_string())?;
                self.name = name;
                let diagnostics = self.set(program)?;
                let mut said = vec![text(&json!({ "text": self.shown() }))];
                said.extend(diagnostics);
                Ok(said)
            }
            Wish::Pulses(drawn) => {
                let drawn = pulses::tidy(drawn)?;
                let text = pulses::join(&pulses::split(self.world.source()).0, &drawn);
                self.world =
                    World::parse("world.rhai", &text).map_err(|error| error.to_string())?;
                Ok(self.simulate(false))
            }
            Wish::Simulate => Ok(self.simulate(false)),
            Wish::SimulateAll => Ok(self.simulate(true)),
        }
    }

    fn shown(&self) -> Value {
        let file = Some(&self.name).filter(|name| !name.is_empty());
        json!({ "number": self.number, "file": file, "text": self.text, "dirty": false, "conflict": false })
    }

    fn set(&mut self, text: String) -> Result<Vec<Said>, String> {
        if text.len() > LONGEST {
            return Err(format!("a script has at most {LONGEST} bytes"));
        }
        self.number += 1;
        self.text = text;
        Ok(self.told("textDocument/didOpen").into_iter().collect())
    }

    /// Gives the language server the text; its diagnostics.
    fn told(&mut self, method: &str) -> Option<Said> {
        let params = json!({ "textDocument": {
            "uri": URI, "languageId": "pasapas", "version": self.number, "text": self.text
        } });
        let note = Notification { method: method.to_owned(), params };
        let answer = self.server.hear(Message::Notification(note))?;
        serde_json::to_value(answer).ok().map(|answer| text(&json!({ "lsp": answer })))
    }

    fn request(&mut self, message: &Value) -> Option<Said> {
        let mut params = message["params"].clone();
        params["textDocument"] = json!({ "uri": URI });
        let request = Request {
            id: RequestId::from(i32::try_from(message["id"].as_i64()?).ok()?),
            method: message["method"].as_str()?.to_owned(),
            params,
        };
        let answer = self.server.hear(Message::Request(request))?;
        serde_json::to_value(answer).ok().map(|answer| text(&json!({ "lsp": answer })))
    }

    /// The run of the text, on the part that has all of the language.
    fn simulate(&self, all: bool) -> Vec<Said> {
        let loaded = trial::load(&self.text, ProfileChoice::built_in()).map(Box::new);
        let budget = if all { Budget::long(|_| false) } else { Budget::live(|_| false) };
        let run = trial::simulate(self.number, &loaded, &self.world, &F5529, &budget);
        let mut about = run.about;
        about["pulses"] = json!(pulses::split(self.world.source()).1);
        if !self.world.is_empty() {
            about["world_file"] = json!(("world.rhai", self.world.source()));
        }
        vec![text(&json!({ "simulated": about })), Said::Bytes(run.path.to_vec())]
    }
}

fn refused(ask: u32, words: &str) -> Said {
    text(&json!({ "refused": { "ask": ask, "words": words } }))
}

/// A program of another system becomes a script.
fn script(name: &str, program: String) -> Result<String, String> {
    if !import::is_importable(name, program.as_bytes()) {
        return Ok(program);
    }
    match import::import(name, program.as_bytes(), &import::Options::default()) {
        Ok(imported) => Ok(imported.script),
        Err(diags) => {
            let first = diags.first().map(|diag| format!("line {}: {}", diag.line, diag.text));
            Err(first.unwrap_or_else(|| "it cannot be imported".to_owned()))
        }
    }
}
