//! The script that all pages work on: one text, its file, and the language server that reads it.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use lang::profile::Profile;
use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value, json};

use super::file::{
    LONGEST, beside, folder, free, is_listed, is_new_script, listed, opened, read, text_of, write,
    write_new,
};
use super::message::Text;
use crate::lsp::{self, path};

/// Scripts of a folder that are listed.
const MOST_FILES: usize = 200;
/// Requests of the language server that pages pass on. One server serves all pages: `shutdown` or a
/// change of the text by one of them would be everybody's.
const REQUESTS: [&str; 9] = [
    "textDocument/codeAction",
    "textDocument/completion",
    "textDocument/definition",
    "textDocument/formatting",
    "textDocument/hover",
    "textDocument/prepareRename",
    "textDocument/rename",
    "textDocument/semanticTokens/full",
    "textDocument/signatureHelp",
];
/// What a new script begins with.
const NEW: &str =
    "' A first script: a square of 20 mm.\nHome\nG0 X10 Y10\nG1 X30 F600\nG1 Y30\nG1 X10\nG1 Y10\n";

/// The script.
pub struct Desk {
    number: u64,
    text: String,
    file: Option<PathBuf>,
    /// What the file held when it was last read or written.
    on_disk: String,
    /// Time and length of the file at the last look: a long one is read again only when they change.
    seen: Option<(SystemTime, u64)>,
    conflict: bool,
    /// See [`uri`].
    uri: String,
    /// To the language server.
    lsp: Connection,
    /// What it can do.
    capabilities: Value,
}

/// The name by which the language server knows the text: any script of its folder, where the machines
/// are that a script can name.
fn uri(file: Option<&Path>) -> String {
    let script = folder(file).join("script.bas");
    path::uri(&std::path::absolute(&script).unwrap_or(script).to_string_lossy())
}

impl Desk {
    /// Opens a file, or begins a new script. What the language server says goes to `heard`.
    ///
    /// # Errors
    /// The file cannot be read; the text says why.
    pub fn open(
        file: Option<&str>,
        profile: Option<Profile>,
        heard: impl Fn(Value) + Send + 'static,
    ) -> Result<Desk, String> {
        let (text, file) = match file {
            None => (NEW.to_owned(), None),
            // An editor begins a new file of that name.
            Some(name) if is_new_script(name) => (NEW.to_owned(), Some(PathBuf::from(name))),
            Some(name) => opened(Path::new(name))?,
        };
        let (lsp, capabilities) = serve(profile, heard);
        let saved = file.as_deref().is_some_and(Path::exists);
        let on_disk = if saved { text.clone() } else { String::new() };
        let uri = uri(file.as_deref());
        let (number, seen, conflict) = (1, None, false);
        let desk = Desk { number, text, file, on_disk, seen, conflict, uri, lsp, capabilities };
        desk.note(
            "textDocument/didOpen",
            json!({ "textDocument": {
                "uri": desk.uri, "languageId": "pasapas", "version": 1, "text": desk.text
            } }),
        );
        Ok(desk)
    }

    /// As pages see it.
    pub fn shown(&self) -> Text {
        Text {
            number: self.number,
            file: self.name(),
            text: self.text.clone(),
            dirty: self.text != self.on_disk,
            conflict: self.conflict,
            fixed: self.is_fixed(),
        }
    }

    /// Whether the text is too long to be changed by a page.
    const fn is_fixed(&self) -> bool {
        self.text.len() > LONGEST
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Counts the changes of the text.
    pub const fn number(&self) -> u64 {
        self.number
    }

    /// Name of the file without its folder.
    pub fn name(&self) -> Option<String> {
        let name = self.file.as_ref()?.file_name()?;
        Some(name.to_string_lossy().into_owned())
    }

    /// What the language server can do.
    pub const fn capabilities(&self) -> &Value {
        &self.capabilities
    }

    /// Takes another text that was made from number `base`.
    ///
    /// # Errors
    /// Another one was made from it meanwhile, or one of them is too long.
    pub fn set(&mut self, base: u64, text: String) -> Result<(), String> {
        if base != self.number {
            return Err("the script was changed by another page meanwhile".to_owned());
        }
        if self.is_fixed() {
            return Err("this script is too long to be changed here".to_owned());
        }
        if text.len() > LONGEST {
            return Err(format!(
                "a script has at most {LONGEST} bytes; `pasapas stream` runs longer jobs"
            ));
        }
        self.replace(text);
        Ok(())
    }

    fn replace(&mut self, text: String) {
        self.number += 1;
        self.seen = None;
        self.text = text;
        self.refresh();
    }

    /// Has the diagnostics told once more, for a page that is new.
    pub fn refresh(&self) {
        self.note(
            "textDocument/didChange",
            json!({
                "textDocument": { "uri": self.uri, "version": self.number },
                "contentChanges": [{ "text": self.text }]
            }),
        );
    }

    /// Looks whether another program changed the file; a text without changes of its own follows it.
    /// Whether there is something to tell.
    pub fn look(&mut self) -> bool {
        let Some(file) = self.file.as_deref() else { return false };
        let about = fs::metadata(file).and_then(|own| Ok((own.modified()?, own.len())));
        let about = about.ok().filter(|(_, length)| *length > LONGEST as u64);
        if about.is_some() && about == self.seen {
            return false;
        }
        let Ok(disk) = read(file) else { return false };
        self.seen = about;
        if disk == self.on_disk {
            return false;
        }
        let unchanged = self.text == self.on_disk;
        let same = self.text == disk;
        self.on_disk.clone_from(&disk);
        if unchanged && !same {
            self.replace(disk);
        }
        self.conflict = !unchanged && !same;
        true
    }

    /// Ends a conflict: by the file's text, or by this one, which the next save writes.
    pub fn settle(&mut self, from_disk: bool) {
        self.conflict = false;
        if from_disk {
            let disk = self.on_disk.clone();
            self.replace(disk);
        }
    }

    /// Writes the text to its file, or to another one of the folder.
    ///
    /// # Errors
    /// There is no name, it is no script's, or the file cannot be written.
    pub fn save(&mut self, name: Option<&str>) -> Result<(), String> {
        let file = match (name, &self.file) {
            (Some(name), own) => beside(own.as_deref(), name)?,
            (None, Some(file)) => file.clone(),
            (None, None) => return Err("the script has no name yet: give it one".to_owned()),
        };
        let shown = |error: io::Error| format!("{}: {error}", file.display());
        if self.file.as_ref() == Some(&file) {
            // What another program wrote a moment ago must not be lost: the look at the file may be
            // half a second old.
            self.look();
            if self.conflict {
                return Err(
                    "another program changed the file: take its text or keep this one first"
                        .to_owned(),
                );
            }
            write(&file, &self.text).map_err(shown)?;
        } else {
            write_new(&file, &self.text).map_err(|error| match error.kind() {
                io::ErrorKind::AlreadyExists => {
                    format!("{} exists already: open it, or take another name", file.display())
                }
                _ => shown(error),
            })?;
        }
        self.file = Some(file);
        self.on_disk.clone_from(&self.text);
        Ok(())
    }

    /// Opens another script of the folder.
    ///
    /// # Errors
    /// This one is not saved, or the other cannot be read.
    pub fn change(&mut self, name: &str) -> Result<(), String> {
        self.may_leave()?;
        let (text, file) = opened(&listed(self.file.as_deref(), name)?)?;
        let saved = file.as_deref().is_some_and(Path::exists);
        self.file = file;
        self.on_disk = if saved { text.clone() } else { String::new() };
        self.conflict = false;
        self.replace(text);
        Ok(())
    }

    /// Takes a file that a page brings, which is in no folder of this tool: a script, or a program of
    /// another system, which becomes one. It is not saved yet.
    ///
    /// # Errors
    /// This one is not saved, or the file is nothing that can be read.
    pub fn take(&mut self, name: &str, bytes: &[u8]) -> Result<(), String> {
        self.may_leave()?;
        let name = Path::new(name).file_name().map(|own| own.to_string_lossy().into_owned());
        let name = name.unwrap_or_default();
        let text = text_of(&name, bytes)?;
        self.file = Some(free(&self.folder().join(name)));
        self.on_disk.clear();
        self.conflict = false;
        self.replace(text);
        Ok(())
    }

    fn may_leave(&self) -> Result<(), String> {
        if self.text != self.on_disk && self.file.is_some() {
            return Err("the script is not saved: save it, or undo its changes".to_owned());
        }
        Ok(())
    }

    /// Keeps a text that was never saved in a file beside it, `a.bas~`, when the tool ends. Its name,
    /// if there was something to keep.
    pub fn keep(&self) -> Option<PathBuf> {
        let lost = self.text != self.on_disk && self.text != NEW;
        let own = self.file.clone().unwrap_or_else(|| PathBuf::from("script.bas"));
        let mut name = own.into_os_string();
        name.push("~");
        let file = PathBuf::from(name);
        (lost && write(&file, &self.text).is_ok()).then_some(file)
    }

    /// Writes a new script of the folder, and opens it.
    ///
    /// # Errors
    /// This one is not saved, the name is taken or none of a script, or it cannot be written.
    pub fn create(&mut self, name: &str, text: String) -> Result<(), String> {
        self.may_leave()?;
        let file = beside(self.file.as_deref(), name)?;
        if text.len() > LONGEST {
            return Err(format!("a script has at most {LONGEST} bytes"));
        }
        write_new(&file, &text).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists => format!("{name} exists already: take another name"),
            _ => format!("{}: {error}", file.display()),
        })?;
        self.file = Some(file);
        self.on_disk.clone_from(&text);
        self.conflict = false;
        self.replace(text);
        Ok(())
    }

    /// The text of a script of the folder, which stays closed.
    ///
    /// # Errors
    /// There is none of that name, or it cannot be read.
    pub fn read(&self, name: &str) -> Result<String, String> {
        if self.name().as_deref() == Some(name) {
            return Ok(self.text.clone());
        }
        opened(&listed(self.file.as_deref(), name)?).map(|(text, _)| text)
    }

    /// Scripts of the folder, and programs of other systems.
    pub fn files(&self) -> Vec<String> {
        let folder = folder(self.file.as_deref());
        let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> =
            names.filter(|name| is_listed(name)).take(MOST_FILES).collect();
        names.sort();
        names
    }

    /// The folder of the script.
    pub fn folder(&self) -> PathBuf {
        folder(self.file.as_deref())
    }

    /// Passes a page's request on; the answer carries the page's number in its own.
    ///
    /// # Errors
    /// It is none that a page may make: one that asks about this text, with an object of parameters.
    pub fn request(&self, page: u64, message: &Value) -> Result<(), String> {
        let id = format!("{page}/{}", message["id"]);
        let method = message["method"].as_str().unwrap_or_default();
        if !REQUESTS.contains(&method) {
            return Err("this request is none that a page may make".to_owned());
        }
        let Value::Object(mut params) = message["params"].clone() else {
            return Err(format!("{method} needs an object of parameters"));
        };
        params.insert("textDocument".to_owned(), json!({ "uri": self.uri }));
        let params = Value::Object(params);
        let request = Request { id: RequestId::from(id), method: method.to_owned(), params };
        // A server that has ended answers nobody.
        let _ = self.lsp.sender.send(Message::Request(request));
        Ok(())
    }

    fn note(&self, method: &str, params: Value) {
        let note = Notification { method: method.to_owned(), params };
        let _ = self.lsp.sender.send(Message::Notification(note));
    }
}

/// A language server in a thread of its own, over the same connection as an editor's.
fn serve(profile: Option<Profile>, heard: impl Fn(Value) + Send + 'static) -> (Connection, Value) {
    let (server, own) = Connection::memory();
    std::thread::spawn(move || lsp::serve(&server, profile.as_ref()));
    let hello = Request {
        id: RequestId::from("hello".to_owned()),
        method: "initialize".to_owned(),
        params: json!({ "capabilities": {} }),
    };
    let _ = own.sender.send(Message::Request(hello));
    let answer = own.receiver.recv().ok();
    let answer = answer.and_then(|answer| serde_json::to_value(answer).ok()).unwrap_or_default();
    let capabilities = answer["result"]["capabilities"].clone();
    let ready = Notification { method: "initialized".to_owned(), params: json!({}) };
    let _ = own.sender.send(Message::Notification(ready));
    let answers = own.receiver.clone();
    std::thread::spawn(move || {
        for message in answers {
            if let Ok(value) = serde_json::to_value(&message) {
                heard(value);
            }
        }
    });
    (own, capabilities)
}

#[cfg(test)]
mod tests;
