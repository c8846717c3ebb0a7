//! A session over the protocol, in memory.

use lsp_server::{Connection, Message, Notification, Request, RequestId, Response};
use serde_json::{Value, json};

use super::serve;

/// Runs the server in a thread and talks to it as an editor does.
struct Editor {
    client: Connection,
    thread: std::thread::JoinHandle<()>,
    next_id: i32,
}

const URI: &str = "file:///scripts/a.bas";

impl Editor {
    fn new() -> Editor {
        let (server, client) = Connection::memory();
        let thread = std::thread::spawn(move || serve(&server, None).expect("a clean end"));
        let mut editor = Editor { client, thread, next_id: 0 };
        let capabilities = editor.ask("initialize", json!({ "capabilities": {} }));
        assert_eq!(capabilities["capabilities"]["hoverProvider"], json!(true));
        editor.tell("initialized", json!({}));
        editor
    }

    fn tell(&self, method: &str, params: Value) {
        let note = Notification { method: method.to_owned(), params };
        self.client.sender.send(Message::Notification(note)).expect("a server");
    }

    fn response(&mut self, method: &str, params: Value) -> Response {
        self.next_id += 1;
        let id = RequestId::from(self.next_id);
        let request = Request { id, method: method.to_owned(), params };
        self.client.sender.send(Message::Request(request)).expect("a server");
        match self.client.receiver.recv().expect("an answer") {
            Message::Response(response) => response,
            other => panic!("{other:?}"),
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.response(method, params).response_result.expect("an answer")
    }

    /// Opens a text; gives the diagnostics.
    fn open(&self, text: &str) -> Value {
        let document = json!({ "uri": URI, "languageId": "basic", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        match self.client.receiver.recv().expect("diagnostics") {
            Message::Notification(note) => note.params["diagnostics"].clone(),
            other => panic!("{other:?}"),
        }
    }

    fn at(&mut self, method: &str, line: u32, character: u32) -> Value {
        let position = json!({ "line": line, "character": character });
        self.ask(method, json!({ "textDocument": { "uri": URI }, "position": position }))
    }

    fn close(mut self) {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        self.thread.join().expect("no panic");
    }
}

#[test]
fn diagnostics_have_places_in_utf16() {
    let editor = Editor::new();
    let shown = editor.open("' \u{1F600}\nPRINT \"\u{1F600}\" : DELAY 5\n");
    assert_eq!(shown[0]["code"], "P010");
    assert_eq!(shown.as_array().map(Vec::len), Some(1));
    assert_eq!(shown[0]["range"]["start"], json!({ "line": 1, "character": 13 }));
    assert!(shown[0]["message"].as_str().is_some_and(|m| m.contains("Wait 500ms")));
    editor.close();
}

#[test]
fn the_checker_speaks_too() {
    let editor = Editor::new();
    let shown = editor.open("DIM n\nn = 3mm + 2s\n");
    assert_eq!(shown[0]["code"], "K001");
    editor.close();
}

#[test]
fn words_complete_where_they_may_stand() {
    let mut editor = Editor::new();
    editor.open("DIM count_of AS LENGTH\ncount_of = \n\nSUB go(depth)\n  \nEND SUB\n' \n");
    let mut labels = |line, character| -> Vec<String> {
        let items = editor.at("textDocument/completion", line, character);
        let items = items.as_array().cloned().unwrap_or_default();
        items.iter().filter_map(|i| i["label"].as_str().map(str::to_owned)).collect()
    };
    let statement = labels(2, 0);
    assert!(statement.contains(&"MoveAxe".to_owned()) && statement.contains(&"go".to_owned()));
    assert!(!statement.contains(&"POSST".to_owned()) && !statement.contains(&"depth".to_owned()));
    let expression = labels(1, 11);
    assert!(
        expression.contains(&"POSST".to_owned()) && expression.contains(&"count_of".to_owned())
    );
    assert!(!expression.contains(&"MoveAxe".to_owned()));
    assert!(labels(4, 2).contains(&"depth".to_owned()));
    assert!(labels(6, 2).is_empty());
    editor.close();
}

#[test]
fn hover_and_definition_know_words_and_names() {
    let mut editor = Editor::new();
    editor.open("DIM n ' parts\nMoveAxe X, 5mm\nn = 2\n' F07\n");
    let hover = editor.at("textDocument/hover", 1, 3);
    assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains("axis, target")));
    let hover = editor.at("textDocument/hover", 2, 0);
    assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains("DIM n ' parts")));
    assert!(editor.at("textDocument/hover", 3, 3)["contents"]["value"].is_string());
    let definition = editor.at("textDocument/definition", 2, 1);
    assert_eq!(definition["range"]["start"], json!({ "line": 0, "character": 4 }));
    assert_eq!(editor.at("textDocument/hover", 99, 99), Value::Null);
    editor.close();
}

#[test]
fn outline_and_formatting() {
    let mut editor = Editor::new();
    editor.open("dim n\nsub go(depth)\ndim k\nend sub\n");
    let document = json!({ "textDocument": { "uri": URI } });
    let outline = editor.ask("textDocument/documentSymbol", document);
    assert_eq!(outline[0]["name"], "n");
    assert_eq!(outline[1]["name"], "go");
    assert_eq!(outline[1]["children"][1]["name"], "k");
    let options = json!({ "tabSize": 4, "insertSpaces": true });
    let params = json!({ "textDocument": { "uri": URI }, "options": options });
    let edits = editor.ask("textDocument/formatting", params);
    assert_eq!(edits[0]["newText"], "DIM n\nSUB go(depth)\n  DIM k\nEND SUB\n");
    editor.close();
}

#[test]
fn wrong_requests_get_errors_and_do_no_harm() {
    let mut editor = Editor::new();
    assert!(
        editor.response("textDocument/hover", json!({ "position": 5 })).response_result.is_err()
    );
    assert!(editor.response("no/such", Value::Null).response_result.is_err());
    editor.tell("textDocument/didOpen", json!([1]));
    assert_eq!(editor.at("textDocument/hover", 0, 0), Value::Null);
    editor.close();
}
