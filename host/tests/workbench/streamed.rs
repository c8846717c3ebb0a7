//! What takes long: jobs of any length fed to the board from the page, simulations, an operator's pieces.

use std::time::Duration;

use crate::cdp::Outcome;
use crate::stand::{PATIENCE, Stand};

/// A job of a thousand lines that goes to and fro, a second each.
fn long() -> String {
    let lines = (1..1_000).map(|n| format!("G1 X{} F1200\n", n % 2 * 20));
    format!("PRINT \"begins\"\n{}", lines.collect::<String>())
}

#[test]
fn a_long_job_is_fed_paused_resumed_and_stopped_from_the_page() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board(&long())? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.push("#stream")?;
    stand.board()?.until("a run", |status| status.state == "running")?;
    page.says("#console", "begins")?;
    page.says("#run-state", "running · line")?;
    // How far it is: of 1 000 statements the first ones.
    page.says("#job", "streamed: line")?;
    page.says("#job", " %")?;
    page.says("#job", " left")?;
    page.wait("!document.querySelector('#upload-bar').hidden && document.querySelector('#upload-bar').value > 0", PATIENCE)?;
    page.wait("!document.querySelector('.ed .run').hidden", PATIENCE)?;
    // The machine's place goes on while the job has the board.
    let line = "(+document.querySelector('#job').textContent.match(/line (\\d+)/)?.[1])";
    let first = page.eval(line)?.as_u64().unwrap_or(0);
    page.wait(&format!("{line} > {}", first + 1), PATIENCE)?;
    page.push("#pause")?;
    stand.board()?.until("a pause", |status| status.state == "paused")?;
    page.says("#run-state", "paused")?;
    // Ramped down by now, in the middle of a line.
    std::thread::sleep(Duration::from_secs(1));
    let rests = stand.board()?.x()?;
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(stand.board()?.x()?, rests);
    page.push("#resume")?;
    stand.board()?.until("to go on", |status| status.state == "running")?;
    page.says("#run-state", "running")?;
    // Nothing is put off until the job is over: then nobody would expect it.
    page.eval("(async () => { const { Link } = await import('/link.js'); const link = new Link(); await new Promise(done => link.addEventListener('welcome', done)); await link.ask({ helm: true }); const said = []; for (const wish of [{ jog: { axis: 'X', um: 1000, speed: 1000 } }, 'upload', { output: [3, true] }, 'stream', { home: ['X'] }, { debug: { breaks: [], step: false } }]) try { await link.ask(wish); said.push('done') } catch (e) { said.push(e.message) } await link.ask({ helm: false }); document.title = said.every(words => words.includes('a job is fed')) ? 'all refused' : said.join(', ') })()")?;
    page.wait("document.title === 'all refused'", PATIENCE)
        .or_else(|error| Err(format!("{error}: {:?}", page.eval("document.title")?)))?;
    page.push("#helm")?;
    page.click("#stop")?;
    let rest = stand.board()?.until("its end", |status| status.state == "empty")?;
    assert!(rest.moving.is_empty() && rest.last_end == Some("stopped"), "{rest:?}");
    page.says("#notes", "pasapas stream job.bas --from-line")?;
    page.wait("document.querySelector('#upload-bar').hidden && document.querySelector('#job').textContent === ''", PATIENCE)?;
    // Nothing was stored.
    page.says("#run-state", "no program")
}

#[test]
fn a_job_ends_by_itself_and_a_fault_is_told() -> Outcome<()> {
    let Some(stand) = Stand::start("G1 X2 F3000\nPRINT \"end\"\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.push("#stream")?;
    page.says("#notes", "The job is done")?;
    page.says("#console", "end")?;
    page.end_of_script()?;
    page.type_text("\nWaitIn 3, ON, 50ms\n")?;
    page.push("#stream")?;
    page.says("#notes", "F13 in line")?;
    page.says("#notes", "--from-line")
}

/// A job goes on at a line: the way there is shown first, and the board goes that one or none.
#[test]
fn a_job_goes_on_in_its_middle_on_the_way_that_was_shown() -> Outcome<()> {
    let text = "PRINT \"begins\"\nG0 X5 Y3 F3000\nG1 X10 F3000\nPRINT \"goes on\"\nG1 X15\nWaitIn 3, ON, 50ms\n";
    let Some(mut stand) = Stand::with_board(text)? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.eval("document.querySelector('#middle').open = true")?;
    page.fill("#from-line", "x")?;
    page.push("#show-way")?;
    page.says("#notes", "is not a whole number")?;
    page.fill("#from-line", "4")?;
    page.push("#show-way")?;
    page.says("#way-words", "X to 10 mm, Y to 3 mm")?;
    let before = stand.board()?.status()?;
    assert_eq!((before.runs, before.pos.x), (0, Some(0)), "it moved");
    // Another line: what was shown is not that one's way.
    page.fill("#from-line", "3")?;
    page.wait("document.querySelector('#go-way').hidden", PATIENCE)?;
    let past = "(async () => { const { Link } = await import('/link.js'); const link = new Link(); await new Promise(done => link.addEventListener('welcome', done)); await link.ask({ helm: true }); try { await link.ask({ stream_from: { line: 4, way: 'X to 1 mm' } }); return 'done' } catch (e) { return e.message } finally { await link.ask({ helm: false }) } })()";
    let told = page.eval(past)?;
    assert!(told.as_str().is_some_and(|own| own.contains("another one by now")), "{told}");
    assert_eq!(stand.board()?.status()?.runs, 0, "it moved");
    page.push("#helm")?;
    page.says("#helm", "You have the helm")?;
    page.fill("#from-line", "4")?;
    page.push("#show-way")?;
    page.says("#way-words", "line 4 begins")?;
    page.push("#go-way")?;
    page.says("#console", "goes on")?;
    // It faults, and the field has the line to go on with.
    page.says("#notes", "F13 in line 6")?;
    page.wait("document.querySelector('#from-line').value === '6'", PATIENCE)?;
    let said = page.eval("document.querySelector('#console').textContent.includes('begins')")?;
    assert_eq!(said, false, "it began at its first line");
    // Not over a latched fault.
    page.push("#show-way")?;
    page.says("#notes", "acknowledge it first")
}

#[test]
fn a_board_without_memory_for_it_says_what_to_do() -> Outcome<()> {
    let Some(stand) = Stand::start(&long(), &["--part", "g2553"])? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.push("#stream")?;
    page.says("#notes", "`pasapas stream job.bas` stores it piece by piece")
}

/// How far a long simulation is, and that the next key ends it.
#[test]
fn a_long_simulation_tells_how_far_it_is_until_the_next_key() -> Outcome<()> {
    let text = "DIM n\nFOR n = 1 TO 2000000\n  SetOut 1, ON\nNEXT\nWait 1s\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.wait("!document.querySelector('#sim-bar').hidden", PATIENCE)?;
    page.says("#sim-words", "simulating… line 3 of 5")?;
    page.wait("document.querySelector('#sim-bar').value === 0.6", PATIENCE)?;
    page.select_script("Wait 2500ms\n")?;
    page.says("#sums", "2.50 s")?;
    page.wait(
        "document.querySelector('#sim-bar').hidden && document.querySelector('#sim-words').hidden",
        PATIENCE,
    )
}

/// The operator sees how far the upload is, and how many pieces are made.
#[test]
fn the_operator_sees_how_far_the_program_is() -> Outcome<()> {
    let text = "DIM n\nWaitStart\nFOR n = 1 TO 4\n  PRINT \"Piece \"; n; \" of 4\"\n  Wait 700ms\nNEXT\nPRINT \"All are done\"\n";
    let Some(stand) = Stand::start(text, &["--operator"])? else { return Ok(()) };
    let page = stand.page()?;
    page.push("#load")?;
    page.wait("document.querySelector('#lamp').textContent === 'Ready'", PATIENCE)?;
    assert_eq!(page.eval("document.querySelector('#bar').hidden")?, true);
    page.push("#start")?;
    page.push("#start")?;
    page.says("#message", "Piece 2 of 4")?;
    page.wait(
        "!document.querySelector('#bar').hidden && document.querySelector('#bar').value >= 0.5",
        PATIENCE,
    )?;
    page.says("#message", "All are done")?;
    page.wait("document.querySelector('#bar').hidden", PATIENCE)
}

/// A job that is too long to be changed here is shown, simulated and fed as it is.
#[test]
fn a_very_long_job_is_read_only_and_runs() -> Outcome<()> {
    let remark = "x".repeat(480);
    let lines: String =
        (0..1_200).map(|n| format!("G1 X{} F6000 ' {remark}\n", n % 2 * 5)).collect();
    let Some(stand) = Stand::start(&format!("PRINT \"begins\"\n{lines}"), &[])? else {
        return Ok(());
    };
    let page = stand.page()?;
    page.says("#long", "1,201 lines: too long to be changed here")?;
    page.says("#sums", "runs to its end")?;
    page.wait("document.querySelector('#path').ariaLabel.includes('It takes 5.0 by')", PATIENCE)?;
    // A key writes nothing, and neither does a list.
    page.click(".ed .text")?;
    page.type_text("x")?;
    page.wait("document.querySelector('#insert-statement').disabled", PATIENCE)?;
    assert_eq!(
        page.eval(
            "document.querySelector('.ed .text').textContent.startsWith('PRINT \"begins\"')"
        )?,
        true
    );
    page.says("#file", "job.bas")?;
    page.tab("run")?;
    page.push("#stream")?;
    page.says("#console", "begins")?;
    page.says("#job", "streamed: line")?;
    page.click("#stop")?;
    page.says("#notes", "pasapas stream job.bas --from-line")
}
