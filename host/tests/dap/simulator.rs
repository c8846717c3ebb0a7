//! Runs on the simulated machine.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use serde_json::json;

use crate::client::Client;

/// Lines: 1 DIM, 2 OUTPUT, 3 FOR, 4 drill, 5 NEXT, 6 PRINT, 7 END; 8 SUB to 13 END SUB.
pub const DRILL: &str = "DIM i, sum, seen(3)\nOUTPUT pump = 1\nFOR i = 1 TO 3\n  drill i\nNEXT\n\
                     PRINT \"sum \"; sum\nEND\nSUB drill(n)\n  DIM depth AS LENGTH\n  \
                     depth = n * 1mm\n  SetOut pump, ON : sum = sum + n\n  seen(n - 1) = sum\nEND SUB\n";

/// A script in a folder of its own.
pub fn script(text: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("a.bas");
    std::fs::write(&file, text).expect("a file");
    let file = file.display().to_string();
    (folder, file)
}

fn stop(reason: &str, lines: &[u64]) -> (String, Vec<u64>) {
    (reason.to_owned(), lines.to_vec())
}

#[test]
fn breakpoints_steps_calls_and_variables() {
    let (_folder, file) = script(DRILL);
    let mut client = Client::start();
    // Nothing runs of line 9 (a declaration): the next one is taken.
    let set = client.launch(json!({ "program": file }), json!([{ "line": 9 }, { "line": 99 }]));
    assert_eq!((&set[0]["verified"], &set[0]["line"]), (&json!(true), &json!(10)));
    assert_eq!(set[1]["verified"], false);
    assert_eq!(client.halt(), stop("breakpoint", &[10, 4]));
    assert_eq!(client.ask("threads", json!({}))["threads"][0]["id"], 1);
    let calls = client.ask("stackTrace", json!({ "threadId": 1, "levels": 1 }));
    assert_eq!(calls["stackFrames"][0]["name"], "drill");
    assert_eq!(calls["totalFrames"], 2);
    assert!(client.list("Globals").contains(&"i=1".to_owned()));
    assert_eq!(client.list("Locals"), ["n=1", "depth=0mm"]);
    assert_eq!(client.go("next"), stop("step", &[11, 4]));
    assert_eq!(client.watch("depth"), "1mm");
    assert_eq!(client.watch("depth * 2 + 500um"), "2.5mm");
    assert_eq!(client.watch("n = 1 ANDALSO NOT OUT(pump)"), "1");
    assert_eq!(client.watch("STEPS(X, depth)"), "100st");
    // Two statements of a line are one step.
    assert_eq!(client.go("next"), stop("step", &[12, 4]));
    assert!(client.list("Outputs").iter().any(|entry| entry == "1 pump=ON"));
    assert_eq!(client.go("stepOut"), stop("step", &[5]));
    assert_eq!(client.watch("seen(0)"), "1");
    assert_eq!(client.go("next"), stop("step", &[4]));
    assert_eq!(client.go("stepIn"), stop("breakpoint", &[10, 4]));
    assert_eq!(client.go("continue"), stop("breakpoint", &[10, 4]));
    assert_eq!(client.watch("i"), "3");
    assert!(client.refused("evaluate", json!({ "expression": "nonsense" })).contains("nonsense"));
    client.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(client.event("exited")["exitCode"], 0);
    client.event("terminated");
    assert_eq!(client.output("stdout"), "sum 6\n");
    client.close();
}

#[test]
fn conditions_hits_and_log_points() {
    let (_folder, file) = script(DRILL);
    let mut client = Client::start();
    let breaks = json!([
        { "line": 4, "logMessage": "hole {i}: {sum + 1}" },
        { "line": 5, "hitCondition": "3" },
        { "line": 10, "condition": "n = 2" },
    ]);
    client.launch(json!({ "program": file }), breaks);
    assert_eq!(client.halt(), stop("breakpoint", &[10, 4]));
    assert_eq!(client.watch("n"), "2");
    assert_eq!(client.go("continue"), stop("breakpoint", &[5]));
    assert_eq!(client.watch("i"), "3");
    assert_eq!(client.output("console"), "hole 1: 1\nhole 2: 2\nhole 3: 4\n");
    client.close();
}

#[test]
fn a_run_goes_backwards() {
    let (_folder, file) = script(DRILL);
    let mut client = Client::start();
    client.launch(json!({ "program": file }), json!([{ "line": 6 }, { "line": 10 }]));
    assert_eq!(client.halt(), stop("breakpoint", &[10, 4]));
    assert_eq!(client.go("continue"), stop("breakpoint", &[10, 4]));
    let sum = client.list("Globals");
    assert_eq!(client.go("continue"), stop("breakpoint", &[10, 4]));
    assert_eq!(client.go("continue"), stop("breakpoint", &[6]));
    assert_eq!(client.watch("sum"), "6");
    assert_eq!(client.go("stepBack"), stop("step", &[5]));
    // To the third, then to the second call.
    assert_eq!(client.go("reverseContinue"), stop("step", &[10, 4]));
    assert_eq!(client.watch("n"), "3");
    assert_eq!(client.go("reverseContinue"), stop("step", &[10, 4]));
    assert_eq!(client.list("Globals"), sum);
    // What was set by hand stays when the run is made anew.
    let arguments = json!({ "expression": "sum", "value": "100", "frameId": 1 });
    assert_eq!(client.ask("setExpression", arguments)["value"], "100");
    assert_eq!(client.go("next"), stop("step", &[11, 4]));
    assert_eq!(client.go("next"), stop("step", &[12, 4]));
    assert_eq!(client.watch("sum"), "102");
    client.go("stepBack");
    assert_eq!(client.go("stepBack"), stop("step", &[11, 4]));
    assert_eq!(client.watch("sum"), "100");
    client.ask("setBreakpoints", json!({ "source": { "path": file }, "breakpoints": [] }));
    client.ask("continue", json!({ "threadId": 1 }));
    client.event("terminated");
    // Printed once, though the run was made several times.
    assert_eq!(client.output("stdout"), "sum 105\n");
    client.close();
}

#[test]
fn the_timer_is_the_runs_own() {
    let (_folder, file) = script("DIM t AS TIME\nWait 250ms\nt = TIMER()\nSetOut 1, ON\nPRINT t\n");
    let mut client = Client::start();
    client.launch(json!({ "program": file, "stopOnEntry": true }), json!([{ "line": 4 }]));
    assert_eq!(client.halt().0, "entry");
    assert_eq!(client.watch("TIMER()"), "0ms");
    assert_eq!(client.go("continue"), stop("breakpoint", &[4]));
    // A wait counts whole milliseconds of the machine's clock, from the next one on.
    let timer = client.watch("TIMER()");
    assert!(["250ms", "251ms"].contains(&timer.as_str()), "{timer}");
    assert_eq!(client.watch("TIMER() - t"), "0ms");
    client.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(client.event("exited")["exitCode"], 0);
    client.event("terminated");
    client.close();
}

#[test]
fn faults_halt_and_can_be_looked_at() {
    let (_folder, file) =
        script("DIM n\nn = 1\nGOSUB part\nEND\npart:\nPRINT 10 / (n - 1)\nRETURN\n");
    let mut client = Client::start();
    client.launch(json!({ "program": file, "stopOnEntry": true }), json!([]));
    assert_eq!(client.halt().0, "entry");
    assert_eq!(client.go("continue"), stop("exception", &[6, 3]));
    assert_eq!(client.watch("n - 1"), "0");
    client.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(client.event("exited")["exitCode"], 3);
    client.event("terminated");
    assert!(client.output("stderr").contains("F02"));
    client.close();
}

#[test]
fn an_analog_output_is_shown_with_its_unit() {
    let (folder, file) = script("");
    let mill = include_str!("../../../examples/profiles/mill.toml");
    let profile = folder.path().join("blower.toml");
    let kinds = [("", "10mV", "1 blow=400mV"), ("range = 1000\n", "1", "1 blow=40")];
    for (keys, step, shown) in kinds {
        let text = format!("{mill}\n[[aout]]\nn = 1\nname = \"blow\"\n{keys}");
        std::fs::write(&profile, text).expect("a file");
        std::fs::write(
            &file,
            format!("CONST STEP_UP = {step}\nSetAout blow, 40 * STEP_UP\nWait 1ms\n"),
        )
        .expect("a file");
        let mut client = Client::start();
        let launch = json!({ "program": file, "profile": profile.display().to_string() });
        client.launch(launch, json!([{ "line": 3 }]));
        assert_eq!(client.halt().0, "breakpoint");
        assert_eq!(client.list("Analog outputs"), [shown]);
        client.close();
    }
}

#[test]
fn variables_are_set_and_a_run_is_paused_and_restarted() {
    let (_folder, file) = script(
        "DIM go_on AS LENGTH AT 3000 MAX 9mm\nWHILE go_on = 0mm\n  Wait 1ms\nWEND\nPRINT go_on\n",
    );
    let mut client = Client::start();
    client.launch(json!({ "program": file }), json!([]));
    client.ask("pause", json!({ "threadId": 1 }));
    assert_eq!(client.halt().0, "pause");
    client.ask("restart", json!({}));
    client.ask("pause", json!({ "threadId": 1 }));
    assert_eq!(client.halt().0, "pause");
    let scopes = client.ask("scopes", json!({ "frameId": 1 }));
    let globals = scopes["scopes"][0]["variablesReference"].clone();
    let set =
        |value: &str| json!({ "variablesReference": globals, "name": "go_on", "value": value });
    assert!(client.refused("setVariable", set("2s")).contains("Length"));
    assert!(client.refused("setVariable", set("10mm")).contains("to 9mm, by its MIN and MAX"));
    assert_eq!(client.ask("setVariable", set("2.5mm"))["value"], "2.5mm");
    client.ask("continue", json!({ "threadId": 1 }));
    client.event("terminated");
    assert_eq!(client.output("stdout"), "2500um\n");
    // The file as it is now.
    std::fs::write(&file, "PRINT \"anew\"\n").expect("a file");
    client.ask("restart", json!({}));
    client.event("terminated");
    assert_eq!(client.output("stdout"), "anew\n");
    client.close();
}

#[test]
fn what_is_wrong_is_said_and_does_no_harm() {
    let (_folder, file) = script("DIM n\nn = 3mm + 2s\n");
    let mut client = Client::start();
    assert!(client.refused("launch", json!({})).contains("program"));
    assert!(client.refused("launch", json!({ "program": "nonesuch.bas" })).contains("nonesuch"));
    assert!(client.refused("launch", json!({ "program": file })).contains("K001"));
    assert!(client.refused("attach", json!({ "program": file })).contains("board"));
    for command in ["stackTrace", "continue", "variables", "pause", "stepIn", "no such"] {
        client.refused(command, json!({ "variablesReference": 99 }));
    }
    client.refused("setBreakpoints", json!([5]));
    client.close();
    // What is no message ends the session, not with a crash.
    let mut client = Client::start();
    client.send(b"Content-Length: 3\r\n\r\n{]}");
    assert!(
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            client.event("initialized");
        }))
        .is_err()
    );
}

#[test]
fn one_editor_after_the_other_at_a_port() {
    let mut adapter = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(["dap", "--port", "0"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut said = String::new();
    let mut output = BufReader::new(adapter.stdout.take().expect("an output"));
    output.read_line(&mut said).expect("its address");
    let address = said.trim().strip_prefix("listening on ").expect("its address").to_owned();
    let (_folder, file) = script("PRINT 1\n");
    for _ in 0..2 {
        let mut client = Client::connect(&address);
        client.launch(json!({ "program": file }), json!([]));
        client.event("terminated");
        assert_eq!(client.output("stdout"), "1\n");
        client.close();
    }
    adapter.kill().and_then(|()| adapter.wait()).expect("it ends");
}
