//! A session over the protocol, in memory.

mod large;

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

    /// The open document's tokens: line, column, length, what they are.
    fn colours(&mut self) -> Vec<(u64, u64, u64, String)> {
        let document = json!({ "textDocument": { "uri": URI } });
        let tokens = self.ask("textDocument/semanticTokens/full", document);
        let data: Vec<u64> =
            tokens["data"].as_array().into_iter().flatten().filter_map(Value::as_u64).collect();
        let (mut line, mut column, mut seen) = (0, 0, Vec::new());
        for token in data.chunks(5) {
            column = if token[0] == 0 { column + token[1] } else { token[1] };
            line += token[0];
            let legend = super::look::legend();
            let name = legend.token_types[token[3] as usize].as_str().to_owned();
            seen.push((line, column, token[2], name));
        }
        seen
    }

    fn close(mut self) {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        self.thread.join().expect("no panic");
    }
}

#[test]
fn what_comes_between_shutdown_and_exit_is_no_broken_connection() {
    let mut editor = Editor::new();
    editor.open("Wait 5ms\n");
    assert_eq!(editor.ask("shutdown", Value::Null), Value::Null);
    editor.tell("textDocument/didClose", json!({ "textDocument": { "uri": URI } }));
    editor.tell("$/setTrace", json!({ "value": "off" }));
    assert!(editor.response("textDocument/foldingRange", json!({})).response_result.is_err());
    editor.tell("exit", Value::Null);
    editor.thread.join().expect("a clean end");
    // An editor that ends behind its `shutdown`.
    let mut gone = Editor::new();
    assert_eq!(gone.ask("shutdown", Value::Null), Value::Null);
    let Editor { client, thread, .. } = gone;
    drop(client);
    thread.join().expect("a clean end");
}

#[test]
fn diagnostics_have_places_in_utf16() {
    let editor = Editor::new();
    let shown = editor.open("' \u{1F600}\nPRINT \"\u{1F600}\" : DELAY 5\n");
    assert_eq!(shown[0]["code"], "P010");
    assert_eq!(shown.as_array().map(Vec::len), Some(1));
    assert_eq!(shown[0]["range"]["start"], json!({ "line": 1, "character": 13 }));
    assert!(shown[0]["message"].as_str().is_some_and(|m| m.contains("Wait 5ms")));
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

/// The text after edits of one document.
fn edited(text: &str, edits: &Value) -> String {
    let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
    let mut edits: Vec<Value> = edits.as_array().cloned().expect("edits");
    let number = |v: &Value| v.as_u64().expect("a number") as usize;
    edits.sort_by_key(|e| {
        let start = &e["range"]["start"];
        std::cmp::Reverse((number(&start["line"]), number(&start["character"])))
    });
    for edit in edits {
        let (start, end) = (&edit["range"]["start"], &edit["range"]["end"]);
        assert_eq!(start["line"], end["line"], "edits of one line");
        let line = &mut lines[number(&start["line"])];
        let new = edit["newText"].as_str().expect("a text");
        line.replace_range(number(&start["character"])..number(&end["character"]), new);
    }
    lines.join("\n")
}

#[test]
fn names_are_found_marked_and_renamed() {
    let mut editor = Editor::new();
    let text = "DIM n, m\nFOR n = 1 TO 3\n  PRINT n\nNEXT n\nm = n\nPRINT m\n";
    editor.open(text);
    let at = json!({ "textDocument": { "uri": URI }, "position": { "line": 2, "character": 8 } });
    let mut params = at.clone();
    params["context"] = json!({ "includeDeclaration": false });
    let places = editor.ask("textDocument/references", params);
    assert_eq!(places.as_array().map(Vec::len), Some(4));
    let marks = editor.ask("textDocument/documentHighlight", at.clone());
    let kinds: Vec<_> = marks.as_array().into_iter().flatten().map(|m| m["kind"].clone()).collect();
    // Declared, counted, printed, NEXT, read.
    assert_eq!(kinds, [3, 3, 2, 2, 2]);
    let name = editor.ask("textDocument/prepareRename", at.clone());
    assert_eq!(name["placeholder"], "n");
    let mut params = at.clone();
    params["newName"] = json!("hole");
    let edit = editor.ask("textDocument/rename", params);
    assert_eq!(
        edited(text, &edit["changes"][URI]),
        "DIM hole, m\nFOR hole = 1 TO 3\n  PRINT hole\nNEXT hole\nm = hole\nPRINT m\n"
    );
    let mut params = at;
    params["newName"] = json!("m");
    let refused = editor.response("textDocument/rename", params).response_result;
    assert!(refused.expect_err("a clash").message.contains("declared already"));
    editor.close();
}

#[test]
fn remedies_come_as_quick_fixes() {
    let mut editor = Editor::new();
    let text = "MoveAx X, 5 mm\nDIM n\nn == 2\nPRINT n\n";
    let shown = editor.open(text);
    assert!(shown.as_array().is_some_and(|list| list.len() >= 2), "{shown}");
    let range = json!({
        "start": { "line": 0, "character": 0 }, "end": { "line": 3, "character": 0 }
    });
    let params = json!({
        "textDocument": { "uri": URI }, "range": range, "context": { "diagnostics": [] }
    });
    let actions = editor.ask("textDocument/codeAction", params);
    let titles: Vec<_> =
        actions.as_array().into_iter().flatten().map(|a| a["title"].clone()).collect();
    assert_eq!(titles, ["Write `MoveAxe`", "Write `=`"]);
    let edits = json!([
        actions[0]["edit"]["changes"][URI][0].clone(),
        actions[1]["edit"]["changes"][URI][0].clone()
    ]);
    assert_eq!(edited(text, &edits), "MoveAxe X, 5 mm\nDIM n\nn = 2\nPRINT n\n");
    assert_eq!(actions[0]["diagnostics"][0]["code"], "P001");
    editor.close();
}

/// The commonest slips: a comma, a unit, the end of a block.
#[test]
fn the_commonest_slips_are_mended_by_one_click() {
    for (wrong, title, right) in [
        ("MoveAxe X 10mm\n", "Insert `,`", "MoveAxe X, 10mm\n"),
        ("SetOut 1 ON\n", "Insert `,`", "SetOut 1, ON\n"),
        ("MoveAxe Y, -2\n", "Write `-2mm`", "MoveAxe Y, -2mm\n"),
        ("MoveAxe Y, 2mm, 5\n", "Write `5mm/min`", "MoveAxe Y, 2mm, 5mm/min\n"),
        ("Wait 500\n", "Write `500ms`", "Wait 500ms\n"),
        ("REPEAT 3\n  Wait 1s", "Insert `END REPEAT`", "REPEAT 3\n  Wait 1s\nEND REPEAT"),
        (
            "DO\n  IF IN(3) THEN\n    Wait 1s\nLOOP\n",
            "Insert `END IF`",
            "DO\n  IF IN(3) THEN\n    Wait 1s\nEND IF\nLOOP\n",
        ),
    ] {
        let mut editor = Editor::new();
        editor.open(wrong);
        let range = json!({
            "start": { "line": 0, "character": 0 }, "end": { "line": 4, "character": 0 }
        });
        let params = json!({
            "textDocument": { "uri": URI }, "range": range, "context": { "diagnostics": [] }
        });
        let actions = editor.ask("textDocument/codeAction", params);
        assert_eq!(actions[0]["title"], title, "{wrong}: {actions}");
        let edits = actions[0]["edit"]["changes"][URI].clone();
        assert_eq!(edited(wrong, &edits), right);
        editor.close();
    }
}

#[test]
fn signatures_follow_the_argument() {
    let mut editor = Editor::new();
    editor.open(
        "SUB go(depth, times)\n  MoveAxe Z, depth, MIN(1mm/s, \n  PRINT times\nEND SUB\ngo 3mm, \nCALL go(3mm, \ngo\n",
    );
    let mut help = |line, character| {
        let help = editor.at("textDocument/signatureHelp", line, character);
        let label = help["signatures"][0]["label"].as_str().unwrap_or("").to_owned();
        (label.split([' ', '(']).next().unwrap_or("").to_owned(), help["activeParameter"].as_u64())
    };
    assert_eq!(help(1, 10), ("MoveAxe".to_owned(), Some(0)));
    assert_eq!(help(1, 18), ("MoveAxe".to_owned(), Some(1)));
    assert_eq!(help(1, 31), ("MIN".to_owned(), Some(1)));
    assert_eq!(help(4, 8), ("SUB".to_owned(), Some(1)));
    assert_eq!(help(5, 13), ("SUB".to_owned(), Some(1)));
    assert_eq!(help(6, 1), (String::new(), None));
    // At the end of a text without a last line end.
    editor.open("MoveAxe X, ");
    let help = editor.at("textDocument/signatureHelp", 0, 11);
    assert_eq!(help["activeParameter"], 1);
    editor.close();
}

#[test]
fn completion_knows_what_a_place_wants() {
    let mut editor = Editor::new();
    editor.open(
        "DIM hole AS \nOUTPUT pump = 1\nTABLE pads = 1mm\nagain: \nGOTO \nPRINT POS(\nPRINT COUNT(\nMoveAxe \nEXIT \nON \nPROFILE \"\nSUB drill\nEND SUB\nGOSUB \nhole = \nPRINT hole IN \nhole = Cos(\n",
    );
    let mut labels = |line, character| -> Vec<String> {
        let items = editor.at("textDocument/completion", line, character);
        let items = items.as_array().cloned().unwrap_or_default();
        items.iter().filter_map(|i| i["label"].as_str().map(str::to_owned)).collect()
    };
    assert!(labels(0, 12).contains(&"Length".to_owned()));
    assert_eq!(labels(4, 5), ["again"]);
    assert_eq!(labels(5, 10), ["X", "Y", "Z"]);
    assert_eq!(labels(6, 12), ["pads"]);
    assert_eq!(labels(7, 8), ["X", "Y", "Z"]);
    assert!(labels(8, 5).contains(&"WHILE".to_owned()));
    assert_eq!(labels(9, 3), ["ERROR", "IN", "EVERY"]);
    assert!(labels(10, 9).contains(&"charly".to_owned()));
    assert_eq!(labels(13, 6), ["drill", "again"]);
    let value = labels(14, 7);
    assert!(value.contains(&"pump".to_owned()) && !value.contains(&"drill".to_owned()));
    assert!(value.contains(&"ATAN2".to_owned()));
    let units = labels(15, 14);
    assert!(units.contains(&"mm/min".to_owned()) && !units.contains(&"hole".to_owned()));
    let hover = editor.at("textDocument/hover", 16, 8);
    assert!(hover["contents"]["value"].as_str().is_some_and(|v| v.contains("COS(angle)")));
    editor.close();
}

/// What the place wants comes first, and in the order of `sortText`, which editors go by.
#[test]
fn completion_begins_with_what_the_place_wants() {
    let mut editor = Editor::new();
    editor.open(
        "DIM px AS LENGTH\nOUTPUT pump = 3\nINPUT door = 4\nSetOut \nSetOut pump, \npx = \nWaitIn \nWaitIn 1, \npx = px \nIF IN(1) \npx = 2mm + \nWaitIn door, RISE\n",
    );
    let mut labels = |line, character| -> Vec<String> {
        let items = editor.at("textDocument/completion", line, character);
        let items = items.as_array().cloned().unwrap_or_default();
        let text = |item: &Value, key: &str| item[key].as_str().expect("a text").to_owned();
        let sorts: Vec<_> = items.iter().map(|item| text(item, "sortText")).collect();
        assert!(sorts.is_sorted(), "{sorts:?}");
        items.iter().map(|item| text(item, "label")).collect()
    };
    let before = |list: &[String], first: &str, then: &str| {
        let at = |label: &str| list.iter().position(|own| own == label).expect("it is there");
        at(first) < at(then)
    };
    assert_eq!(labels(3, 7)[0], "pump");
    assert!(before(&labels(3, 7), "pump", "door"));
    assert_eq!(labels(4, 13)[..2], ["ON", "OFF"]);
    assert_eq!(labels(5, 5)[0], "px");
    assert_eq!(labels(6, 7)[0], "door");
    assert_eq!(labels(7, 10)[..4], ["ON", "OFF", "RISE", "FALL"]);
    for (line, character) in [(3, 7), (4, 13), (5, 5), (6, 7), (7, 10), (10, 11)] {
        let list = labels(line, character);
        assert!(
            !list.iter().any(|label| ["AND", "OR", "XOR", "MOD", "THEN"].contains(&&**label)),
            "{list:?}"
        );
        let mut once = list.clone();
        once.sort();
        once.dedup();
        assert_eq!(once.len(), list.len(), "one of them is there twice: {list:?}");
    }
    // Behind a value no other one begins.
    assert_eq!(labels(8, 8)[..3], ["AND", "OR", "XOR"]);
    assert!(labels(9, 9).contains(&"THEN".to_owned()) && !labels(9, 9).contains(&"px".to_owned()));
    editor.close();
}

#[test]
fn hover_tells_kinds_values_and_registers() {
    let mut editor = Editor::new();
    editor.open(
        "CONST pitch = 2.54mm\nDIM spot, qty(4) AT 3008\nKEEP parts\nspot = pitch\nqty(0) = 1\nparts = 1\nMoveAxe X, spot\nPRINT qty(0); parts\n",
    );
    let mut says = |line, character| {
        let hover = editor.at("textDocument/hover", line, character);
        hover["contents"]["value"].as_str().unwrap_or("").to_owned()
    };
    assert!(says(3, 8).contains("Length: 2.54mm"), "{}", says(3, 8));
    assert!(says(3, 1).contains("Length, stored in um"), "{}", says(3, 1));
    assert!(says(3, 1).contains("holding registers 30"), "{}", says(3, 1));
    assert!(says(4, 0).contains("holding registers from 3008 on"), "{}", says(4, 0));
    assert!(says(5, 0).contains("holding registers 4000 and 4001"), "{}", says(5, 0));
    editor.close();
}

#[test]
fn colours_folds_and_hints() {
    let mut editor = Editor::new();
    editor.open("DIM n\nFOR n = 1 TO 3 ' \u{1F600}\n  G1 X[n * 1mm]\nNEXT\n");
    let document = json!({ "textDocument": { "uri": URI } });
    let seen = editor.colours();
    let seen: Vec<(u64, u64, u64, &str)> =
        seen.iter().map(|(l, c, n, t)| (*l, *c, *n, t.as_str())).collect();
    assert_eq!(
        seen,
        [
            (0, 0, 3, "keyword"),
            (0, 4, 1, "variable"),
            (1, 0, 3, "keyword"),
            (1, 4, 1, "variable"),
            (1, 8, 1, "number"),
            (1, 10, 2, "keyword"),
            (1, 13, 1, "number"),
            (1, 15, 4, "comment"),
            (2, 2, 2, "macro"),
            (2, 5, 1, "macro"),
            (2, 7, 1, "variable"),
            (2, 11, 3, "number"),
            (3, 0, 4, "keyword"),
        ]
    );
    let folds = editor.ask("textDocument/foldingRange", document);
    assert_eq!((&folds[0]["startLine"], &folds[0]["endLine"]), (&json!(1), &json!(2)));
    let range = json!({
        "start": { "line": 0, "character": 0 }, "end": { "line": 4, "character": 0 }
    });
    let params = json!({ "textDocument": { "uri": URI }, "range": range });
    let hints = editor.ask("textDocument/inlayHint", params);
    assert_eq!(hints[0]["label"], "AS NUMBER");
    editor.close();
}

/// LENGTH and STEPS name functions, too.
#[test]
fn a_kind_is_a_kind_behind_as_and_a_function_elsewhere() {
    let mut editor = Editor::new();
    editor.open("DIM a AS LENGTH, b AS STEPS, c AS SPEED\na = LENGTH(X, b)\nb = STEPS(X, a)\n");
    let mut seen = editor.colours();
    seen.retain(|(_, _, length, _)| *length >= 5);
    let seen: Vec<(u64, u64, &str)> =
        seen.iter().map(|(l, c, _, t)| (*l, *c, t.as_str())).collect();
    let functions = [(1, 4, "function"), (2, 4, "function")];
    assert_eq!(seen[..3], [(0, 9, "type"), (0, 22, "type"), (0, 34, "type")]);
    assert_eq!(seen[3..], functions);
    editor.close();
}

#[test]
fn programs_of_other_systems_are_not_read_as_basic() {
    let mut editor = Editor::new();
    for (name, text) in [
        ("a.nc", "G21 G90\nG1 X10 F300\nM30\n"),
        ("b.isel", "@07\n@0i\n"),
        ("c.drl", "M48\nMETRIC\nT1C0.8\n%\nT1\nX10Y10\nM30\n"),
    ] {
        let uri = format!("file:///jobs/{name}");
        let document = json!({ "uri": uri, "languageId": "basic", "version": 1, "text": text });
        editor.tell("textDocument/didOpen", json!({ "textDocument": document }));
        let Ok(Message::Notification(note)) = editor.client.receiver.recv() else {
            panic!("no diagnostics")
        };
        for diag in note.params["diagnostics"].as_array().into_iter().flatten() {
            let code = diag["code"].as_str().unwrap_or("");
            assert!(code.starts_with('X'), "{name}: {diag}");
        }
        let place = json!({ "line": 0, "character": 0 });
        let params = json!({ "textDocument": { "uri": uri }, "position": place });
        assert_eq!(editor.ask("textDocument/completion", params), json!([]));
        let params = json!({ "textDocument": { "uri": uri } });
        assert_eq!(editor.ask("textDocument/semanticTokens/full", params)["data"], json!([]));
    }
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
