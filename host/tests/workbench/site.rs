//! The page that needs no tool, from a server that knows nothing but files: `host/web/build.py` made it
//! into the folder that PASAPAS_SITE names.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use serde_json::json;

use crate::cdp::{Browser, Outcome, Page};
use crate::stand::{PATIENCE, has_chromium, turn};

/// Until the first path is drawn, ms.
const FIRST_PICTURE: f64 = 2000.0;

/// A web server for a folder, ended with its story.
struct Files(Child);

impl Drop for Files {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Serves the page; nothing where it was not built.
fn serve() -> Outcome<Option<(Files, String)>> {
    let Some(folder) = std::env::var_os("PASAPAS_SITE").map(PathBuf::from) else {
        eprintln!("PASAPAS_SITE names no folder: the story of the page without a tool is left out");
        return Ok(None);
    };
    if !has_chromium() {
        return Ok(None);
    }
    let mut child = Command::new("python3")
        .args(["-u", "-m", "http.server", "--bind", "127.0.0.1", "--directory"])
        .arg(folder)
        .arg("0")
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| error.to_string())?;
    let out = child.stdout.take().ok_or("no standard output")?;
    let files = Files(child);
    let mut line = String::new();
    BufReader::new(out).read_line(&mut line).map_err(|error| error.to_string())?;
    let mut words = line.split_whitespace().skip_while(|word| *word != "port").skip(1);
    let port = words.next().ok_or_else(|| format!("the server says {line:?}"))?;
    Ok(Some((files, format!("http://127.0.0.1:{port}/"))))
}

fn picture(page: &Page, name: &str) -> Outcome<()> {
    let Some(folder) = std::env::var_os("WORKBENCH_PICTURES").map(PathBuf::from) else {
        return Ok(());
    };
    page.screenshot(&folder.join(format!("{name}.png")))
}

#[test]
fn a_page_without_a_tool_checks_simulates_and_plays() -> Outcome<()> {
    let Some((_files, url)) = serve()? else { return Ok(()) };
    let _turn = turn();
    let browser = Browser::start()?;
    let page = browser.page(&url)?;
    page.call("Log.enable", json!({}))?;
    page.window(1440, 900, false)?;
    page.says("#sums", "runs to its end")?;
    // Since the address was asked for.
    let took = page.eval("performance.getEntriesByName('path')[0].startTime")?;
    let took = took.as_f64().ok_or("no time")?;
    eprintln!("the first path was drawn after {took:.0} ms");
    assert!(took < FIRST_PICTURE, "the first path took {took} ms");
    picture(&page, "site")?;
    // An example with its world: the drill's plate is met where the world says.
    page.eval("(() => { const list = document.querySelector('#open'); list.value = 'probe_grid.bas'; list.onchange(); })()")?;
    page.wait("document.title === 'probe_grid.bas'", PATIENCE)?;
    page.says("#sums", "runs to its end")?;
    // A program of another system becomes a script.
    page.eval("(() => { const list = document.querySelector('#open'); list.value = 'import/dil14.isel'; list.onchange(); })()")?;
    page.wait("document.title === 'dil14.isel'", PATIENCE)?;
    page.says(".ed .text", "REPEAT 7")?;
    page.says("#sums", "runs to its end")?;
    // An error is shown with its remedy, and simulated again when it is fixed.
    page.end_of_script()?;
    page.type_text("\nMoveAxe X, 5kg")?;
    page.says("#problem-count", "error")?;
    page.wait("!document.querySelector('#sim-words').hidden", PATIENCE)?;
    for _ in 0..3 {
        page.press("Backspace", "Backspace", 8, "", 0)?;
    }
    page.type_text("5mm")?;
    page.wait("!document.querySelector('#problem-count').classList.contains('bad')", PATIENCE)?;
    page.wait("document.querySelector('#sim-words').hidden", PATIENCE)?;
    page.type_text("\nMoveA")?;
    page.says("#completions", "MoveAxe")?;
    // Play goes through the run.
    page.push("#play")?;
    page.wait("+document.querySelector('#scrub').value > 100", PATIENCE)?;
    // What was written outlives the page.
    page.go(&url)?;
    page.says(".ed .text", "MoveAxe X, 5mm")?;
    let problem = page.event("Runtime.exceptionThrown", std::time::Duration::from_millis(1));
    assert!(problem.is_err(), "the page's script failed: {problem:?}");
    let problem = page.event("Log.entryAdded", std::time::Duration::from_millis(1));
    assert!(problem.is_err(), "the browser complains: {problem:?}");
    Ok(())
}
