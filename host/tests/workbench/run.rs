//! Runs on the board.

use std::process::{Command, Output};
use std::time::{Duration, Instant};

use crate::cdp::Outcome;
use crate::stand::{PATIENCE, Stand};

#[test]
fn a_program_is_uploaded_started_paused_resumed_and_stopped() -> Outcome<()> {
    let text = "DIM n\nFOR n = 1 TO 60\n  PRINT \"to \"; n\n  MoveAxe X, 20mm, 10mm/s\n  MoveAxe X, 0mm, 10mm/s\nNEXT\n";
    let Some(mut stand) = Stand::with_board(text)? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.push("#start")?;
    stand
        .board()?
        .until("a run", |status| status.state == "running" && !status.moving.is_empty())?;
    page.says("#run-state", "running · line")?;
    page.says("#console", "to 1")?;
    page.wait("!document.querySelector('.ed .run').hidden", PATIENCE)?;
    page.push("#pause")?;
    stand.board()?.until("a pause", |status| status.state == "paused")?;
    page.says("#run-state", "paused")?;
    // A variable is seen and set.
    page.wait("document.querySelector('#vars .number').value === '1'", PATIENCE)?;
    page.eval("(() => { const i = document.querySelector('#vars .number'); i.value = 49; i.dispatchEvent(new Event('change')) })()")?;
    page.push("#resume")?;
    page.says("#console", "to 50")?;
    // Twice as fast.
    page.eval("(() => { const s = document.querySelector('#feed'); s.value = 200; s.dispatchEvent(new Event('change')) })()")?;
    page.wait("document.querySelector('#feed-value').textContent === '200 %'", PATIENCE)?;
    page.click("#stop")?;
    let rest = stand.board()?.until("its end", |status| status.state == "ready")?;
    assert_eq!((rest.last_end, rest.runs), (Some("stopped"), 1));
    page.says("#run-state", "last run: stopped")
}

#[test]
fn a_fault_is_told_with_line_cause_and_remedy() -> Outcome<()> {
    let text = "Wait 10ms\nWaitIn 3, ON, 50ms\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.push("#start")?;
    page.says("#fault", "F13")?;
    page.says("#run-state", "fault")?;
    page.wait("document.querySelector('#start').textContent === 'Acknowledge'", PATIENCE)?;
    page.push("#start")?;
    page.says("#run-state", "ready")?;
    // With the input closed by a click the same program runs to its end.
    page.tab("machine")?;
    page.eval("document.querySelector('#inputs details').open = true")?;
    page.click("[aria-label^='Input 3']")?;
    page.wait(
        "document.querySelector('[aria-label^=\"Input 3\"]').ariaPressed === 'true'",
        PATIENCE,
    )?;
    page.tab("run")?;
    page.push("#start")?;
    page.says("#run-state", "last run: done")
}

#[test]
fn a_breakpoint_halts_and_steps_follow() -> Outcome<()> {
    let text = "MoveAxe X, 1mm\nPRINT \"here\"\nMoveAxe Y, 1mm\nMoveAxe X, 2mm\n";
    let Some(mut stand) = Stand::with_board(text)? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.click(".ed .gutter [data-line='1']")?;
    page.push("#debug")?;
    page.says("#run-state", "halted before line 2")?;
    // Longer than a board waits for a reader that is gone.
    std::thread::sleep(Duration::from_millis(2_600));
    assert_eq!(
        page.eval("document.querySelector('#console').textContent.includes('here')")?,
        false
    );
    let halted = stand.board()?.status()?;
    assert_eq!((halted.pos.x, halted.pos.y), (Some(100), Some(0)));
    page.push("#step")?;
    page.says("#run-state", "halted before line 3")?;
    page.says("#console", "here")?;
    page.push("#go")?;
    let rest = stand.board()?.until("its end", |status| status.state == "ready")?;
    assert_eq!((rest.last_end, rest.pos.x, rest.pos.y), (Some("done"), Some(200), Some(100)));
    page.says("#run-state", "ready")
}

/// What the operator is asked for has the script's words and range on this page, too.
#[test]
fn a_quantity_is_set_by_its_name_and_within_its_range() -> Outcome<()> {
    let text = "DIM wanted AT 3000 LABEL \"Pieces\" MIN 1 MAX 9\nDIM n\nFOR n = 1 TO wanted\n  PRINT \"piece \"; n\nNEXT\nPRINT \"made \"; wanted\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.says("#vars", "wanted")?;
    page.says("#vars", "Pieces, 1 to 9")?;
    page.fill("[aria-label=wanted]", "10")?;
    page.says("#notes", "Pieces: 1 to 9")?;
    // Past the page's own look the tool refuses too; what is no quantity has no such range.
    page.eval("(async () => { const { Link } = await import('/link.js'); const link = new Link(), program = new Promise(done => link.addEventListener('program', e => done(e.detail))); await new Promise(done => link.addEventListener('welcome', done)); await link.ask({ helm: true }); const told = await program; const cell = told.vars.find(own => own.name === 'wanted').cell; try { await link.ask({ set: { cell, value: 10 } }); document.title = 'set' } catch (e) { document.title = e.message } await link.ask({ helm: false }) })()")?;
    page.wait("document.title === 'Pieces: 1 to 9'", PATIENCE)?;
    page.says("#helm", "Take the helm")?;
    page.push("#helm")?;
    page.says("#helm", "You have the helm")?;
    page.fill("[aria-label=wanted]", "4")?;
    page.push("#start")?;
    page.says("#console", "made 4")?;
    page.wait("document.querySelector('[aria-label=wanted]').value === '4'", PATIENCE)
}

/// What a command of the tool does at the board that the workbench has.
fn command(port: &str, args: &[&str]) -> Outcome<String> {
    let begun = Instant::now();
    let done = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .args(args)
        .args(["--port", port])
        .output()
        .map_err(|error| error.to_string())?;
    let Output { status, stdout, stderr } = done;
    let (out, words) = (String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    assert!(status.success(), "{args:?}: {words}");
    assert!(begun.elapsed() < Duration::from_secs(10), "{args:?} took {:?}", begun.elapsed());
    Ok(out.into_owned())
}

/// The line has one owner at a time: who asks has it until the reply is there, workbench and command
/// line in turns, and both show the same board.
#[test]
fn the_command_line_has_its_turns_beside_the_workbench() -> Outcome<()> {
    let text = "DIM n\nFOR n = 1 TO 500\n  PRINT n\n  Wait 20ms\nNEXT\n";
    let Some(mut stand) = Stand::with_line(text)? else { return Ok(()) };
    let page = stand.page()?;
    let port = stand.board()?.port.clone();
    let script = stand.script().display().to_string();
    command(&port, &["upload", &script])?;
    page.tab("run")?;
    page.wait("document.querySelector('#start').matches(':enabled')", PATIENCE)?;
    command(&port, &["start"])?;
    page.says("#run-state", "running")?;
    page.says("#console", "run 1 begins")?;
    command(&port, &["pause"])?;
    page.says("#run-state", "paused")?;
    page.push("#resume")?;
    page.says("#run-state", "running")?;
    assert!(command(&port, &["status", "--format", "json"])?.contains("\"state\":\"running\""));
    command(&port, &["stop"])?;
    page.says("#run-state", "last run: stopped")?;
    // A button that is held goes on while others ask.
    page.tab("machine")?;
    let at = page.centre("[aria-label='Jog X plus']")?;
    page.mouse("mousePressed", at)?;
    page.wait("document.querySelector('.jog.held') !== null", PATIENCE)?;
    for _ in 0..8 {
        command(&port, &["status"])?;
    }
    assert_eq!(page.eval("document.querySelector('.jog.held') !== null")?, true, "the jog ended");
    assert!(command(&port, &["status", "--format", "json"])?.contains("\"moving\":[\"X\"]"));
    // And Stop from another window ends it.
    command(&port, &["stop"])?;
    let rest = stand.board()?.until("rest", |status| status.moving.is_empty())?;
    page.wait("document.querySelector('.jog.held') === null", PATIENCE)?;
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(stand.board()?.status()?.pos, rest.pos, "it went on though it is still held");
    page.mouse("mouseReleased", at)
}

#[test]
fn programs_of_the_board_are_listed_chosen_and_erased() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("PRINT \"here\"\n")? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.says("#library", "Start runs it")?;
    // Another program beside it, as from the command line.
    stand.board()?.bring("SetOut 2, ON\n", "second")?;
    page.says("#library", "second")?;
    let choose = "button[aria-label^='Choose']";
    page.wait(&format!("document.querySelectorAll(\"#library {choose}\").length === 1"), PATIENCE)?;
    page.push(&format!("#library {choose}"))?;
    page.wait(
        &format!("!document.querySelector(\"#library {choose}\").ariaLabel.includes('second')"),
        PATIENCE,
    )?;
    page.push("#start")?;
    page.says("#console", "here")?;
    // While a program runs none is erased.
    page.says("#run-state", "last run: done")?;
    page.eval("window.confirm = () => true")?;
    page.push("#library button[aria-label='Erase second']")?;
    page.wait("!document.querySelector('#library').textContent.includes('second')", PATIENCE)?;
    Ok(())
}

/// Every variable is read, plotted and set, not only the first ones.
#[test]
fn the_tenth_variable_is_seen_and_set() -> Outcome<()> {
    let names = ["a", "b", "c", "d", "e", "f", "g", "h", "list(4)", "n"];
    let dims: String = names.iter().map(|name| format!("DIM {name}\n")).collect();
    let text = format!(
        "{dims}FOR n = 1 TO 90\n  h = n * 2\n  list(3) = n\n  PRINT \"n is \"; n\n  Wait 50ms\nNEXT\n"
    );
    let Some(stand) = Stand::start(&text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.push("#start")?;
    page.says("#console", "n is 5")?;
    page.push("#pause")?;
    page.says("#run-state", "paused")?;
    let value = |name: &str| format!("+document.querySelector('[aria-label=\"{name}\"]').value");
    page.wait(
        &format!(
            "{n} >= 5 && {h} === 2 * {n} && {list} === {n}",
            n = value("n"),
            h = value("h"),
            list = value("list(3)")
        ),
        PATIENCE,
    )?;
    // What is no number is not written, and what is there stands in the field again.
    for wrong in ["", "-", "1.5", "1,5", "x", "99999999999"] {
        page.fill("[aria-label=n]", wrong)?;
        page.wait(&format!("{} >= 5", value("n")), PATIENCE)?;
    }
    page.fill("[aria-label=n]", "85")?;
    page.push("#resume")?;
    page.says("#console", "n is 86")
}

/// A program of the board that is not the text is named as such, never marked in it, and started by its
/// own button alone.
#[test]
fn the_old_program_is_never_taken_for_the_text() -> Outcome<()> {
    let text = "PRINT \"old\"\nMoveAxe X, 30mm, 10mm/s\n";
    let Some(mut stand) = Stand::with_board(text)? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.says("#badge", "holds no program")?;
    page.says("#start", "Upload and start")?;
    page.push("#start")?;
    page.says("#console", "old")?;
    page.says("#badge", "as it stands here")?;
    page.wait("!document.querySelector('.ed .run').hidden", PATIENCE)?;
    page.click("#stop")?;
    page.says("#run-state", "last run: stopped")?;
    page.wait("document.querySelector('#start').textContent === 'Start'", PATIENCE)?;
    // A text with an error cannot be meant by any button.
    page.end_of_script()?;
    page.type_text("\nG1 Q")?;
    page.says("#problem-count", "error")?;
    page.says("#badge", "older than this text")?;
    page.wait("document.querySelector('#start').disabled", PATIENCE)?;
    page.push("#start-stored")?;
    stand.board()?.until("a run", |status| status.moving.contains(&'X'))?;
    page.says("#run-state", "running")?;
    assert_eq!(
        page.eval("document.querySelector('.ed .run').hidden")?,
        true,
        "a line of another text"
    );
    page.click("#stop")?;
    page.says("#run-state", "last run: stopped")?;
    // With another good text the main button brings it before it starts.
    page.select_script("PRINT \"new\"\nWait 10ms\n")?;
    page.wait("document.querySelector('#start').textContent === 'Upload and start'", PATIENCE)?;
    page.push("#start")?;
    page.says("#console", "new")?;
    // Back to the old text: what the board holds is the other one.
    page.select_script(text)?;
    page.says("#badge", "older than this text")
}

/// A mark goes to the line where the board can halt, and says so.
#[test]
fn breakpoints_are_where_the_board_halts() -> Outcome<()> {
    let text = "DIM n\n' a comment\nn = 1\nIF n = 1 THEN\n  PRINT n\nEND IF\nn = 2\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let marks = "[...document.querySelectorAll('.ed .gutter [aria-pressed=true]')].map(own => own.textContent).join()";
    page.click(".ed .gutter [data-line='1']")?;
    page.says("#notes", "the mark is in line 5")?;
    page.wait(&format!("{marks} === '5'"), PATIENCE)?;
    page.click(".ed .gutter [data-line='6']")?;
    page.says("#notes", "none follows here")?;
    page.wait(&format!("{marks} === '5'"), PATIENCE)
}
