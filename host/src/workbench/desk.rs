//! The script that all pages work on: one text, its file, and the language server that reads it.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use lang::profile::Profile;
use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value, json};

use super::message::Text;
use crate::input;
use crate::lsp::{self, path};

/// Longest script that a page may send: what the compiler takes at most is far less.
pub const LONGEST: usize = 512 << 10;
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
            Some(name) => (read(Path::new(name))?, Some(PathBuf::from(name))),
        };
        let (lsp, capabilities) = serve(profile, heard);
        let on_disk = if file.is_some() { text.clone() } else { String::new() };
        let uri = uri(file.as_deref());
        let desk = Desk { number: 1, text, file, on_disk, conflict: false, uri, lsp, capabilities };
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
        }
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
    /// Another one was made from it meanwhile, or it is too long.
    pub fn set(&mut self, base: u64, text: String) -> Result<(), String> {
        if base != self.number {
            return Err("the script was changed by another page meanwhile".to_owned());
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
        let Some(disk) = self.file.as_deref().and_then(|file| read(file).ok()) else {
            return false;
        };
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
        if self.text != self.on_disk && self.file.is_some() {
            return Err("the script is not saved: save it, or undo its changes".to_owned());
        }
        let file = beside(self.file.as_deref(), name)?;
        let text = read(&file)?;
        self.file = Some(file);
        self.on_disk.clone_from(&text);
        self.conflict = false;
        self.replace(text);
        Ok(())
    }

    /// Writes a new script of the folder, and opens it.
    ///
    /// # Errors
    /// This one is not saved, the name is taken or none of a script, or it cannot be written.
    pub fn create(&mut self, name: &str, text: String) -> Result<(), String> {
        if self.text != self.on_disk && self.file.is_some() {
            return Err("the script is not saved: save it, or undo its changes".to_owned());
        }
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
        read(&beside(self.file.as_deref(), name)?)
    }

    /// Scripts of the folder.
    pub fn files(&self) -> Vec<String> {
        let folder = folder(self.file.as_deref());
        let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
        let names = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
        let mut names: Vec<String> =
            names.filter(|name| is_script(name)).take(MOST_FILES).collect();
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

fn read(file: &Path) -> Result<String, String> {
    let name = file.display().to_string();
    let bytes = input::read_bytes(&name, LONGEST).map_err(|note| note.line())?;
    let (source, wrong) = lang::front::source::Source::decode(&name, &bytes);
    match wrong.first() {
        Some(diag) if diag.is_error() => Err(format!("{name}: {}", diag.message)),
        _ => Ok(source.text().to_owned()),
    }
}

/// Replaces a file in one step, with the rights that it had; where it is a link, the file that it leads
/// to. What is written meanwhile has a name that nothing else has.
pub(super) fn write(file: &Path, text: &str) -> io::Result<()> {
    let file = fs::canonicalize(file).unwrap_or_else(|_| file.to_owned());
    let mut beside = beside_of(&file)?;
    beside.write_all(text.as_bytes())?;
    if let Ok(about) = fs::metadata(&file) {
        fs::set_permissions(beside.path(), about.permissions())?;
    }
    beside.persist(&file).map(drop).map_err(|error| error.error)
}

/// Writes a file that must not be there yet.
fn write_new(file: &Path, text: &str) -> io::Result<()> {
    let mut beside = beside_of(file)?;
    beside.write_all(text.as_bytes())?;
    beside.persist_noclobber(file).map(drop).map_err(|error| error.error)
}

/// A file without a lasting name in the folder of another one, with the rights of any new file.
fn beside_of(file: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pasapas-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder(Some(file)))
}

fn folder(file: Option<&Path>) -> PathBuf {
    match file.and_then(Path::parent) {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn is_script(name: &str) -> bool {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | ' ');
    name.len() <= 100
        && !name.starts_with('.')
        && name.chars().all(plain)
        && Path::new(name).extension().is_some_and(|end| end.eq_ignore_ascii_case("bas"))
}

/// A script in the folder of this one, and nowhere else.
fn beside(file: Option<&Path>, name: &str) -> Result<PathBuf, String> {
    if !is_script(name) {
        return Err(format!(
            "`{name}` is no name of a script: letters, digits and `.bas` at the end"
        ));
    }
    Ok(folder(file).join(name))
}

#[cfg(test)]
mod tests;
