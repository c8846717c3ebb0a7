//! Unplanned actions of users: hasty keys, things dropped, tabs closed and boards changed in mid-run.

use crate::cdp::{Outcome, Page};
use crate::stand::{Board, PATIENCE, Stand};

/// A job of a thousand lines, a second each.
fn long() -> String {
    let lines = (1..1_000).map(|n| format!("G1 X{} F1200\n", n % 2 * 20));
    format!("PRINT \"begins\"\n{}", lines.collect::<String>())
}

/// A hand drops a file on the page.
fn drop_file(page: &Page, name: &str, text: &str) -> Outcome<()> {
    page.eval(&format!("(() => {{ const d = new DataTransfer(); d.items.add(new File([{text:?}], {name:?})); document.body.dispatchEvent(new DragEvent('drop', {{ dataTransfer: d, bubbles: true, cancelable: true }})) }})()")).map(drop)
}

const MARKED: &str = "!document.querySelector('.ed .run').hidden";

/// Another script while the first one is fed: its lines are not those that run, and its errors do not stop the other.
#[test]
fn a_script_that_is_dropped_on_a_job_is_not_taken_for_it() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board(&long())? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.push("#stream")?;
    page.says("#console", "begins")?;
    page.wait(MARKED, PATIENCE)?;
    drop_file(&page, "second.bas", "Wait 1s\nWait 2s\n")?;
    page.has("Wait 2s")?;
    page.says("#job", "of another text")?;
    page.wait(&format!("!({MARKED})"), PATIENCE)?;
    assert_eq!(stand.board()?.status()?.state, "running");
    page.click("#stop")?;
    stand.board()?.until("its end", |status| status.state == "empty")?;
    page.says("#notes", "stopped in line")
}

/// A tab that is closed while a job is fed leaves the job to the tool; the next page sees it, and stops it.
#[test]
fn a_job_outlives_its_tab_and_obeys_the_next_one() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board(&long())? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("run")?;
    page.push("#stream")?;
    page.says("#console", "begins")?;
    page.close()?;
    let page = stand.page()?;
    page.tab("run")?;
    page.says("#job", "streamed: line")?;
    page.wait(MARKED, PATIENCE)?;
    page.push("#pause")?;
    stand.board()?.until("a pause", |status| status.state == "paused")?;
    page.push("#resume")?;
    stand.board()?.until("to go on", |status| status.state == "running")?;
    page.click("#stop")?;
    stand.board()?.until("its end", |status| status.state == "empty")?;
    page.wait("document.querySelector('#job').textContent === ''", PATIENCE)
}

/// Another board at the same place in mid-run: nothing of the old one's program is told of it.
#[test]
fn a_board_that_is_replaced_is_another_one() -> Outcome<()> {
    let text = "DIM n\nFOR n = 1 TO 1000\n  Wait 1s\nNEXT\n";
    let Some(mut stand) = Stand::with_board(text)? else { return Ok(()) };
    let page = stand.page()?;
    page.upload()?;
    page.says("#vars", "n")?;
    page.push("#start")?;
    page.says("#run-state", "running")?;
    page.wait(MARKED, PATIENCE)?;
    let port = stand.board()?.port.clone();
    let number = port.rsplit(':').next().ok_or("a port")?.to_owned();
    stand.board = None;
    page.wait("!document.querySelector('#port').classList.contains('on')", PATIENCE)?;
    page.wait("document.querySelector('#start').disabled", PATIENCE)?;
    stand.board = Some(Board::start(&["--tcp", &number])?);
    page.wait("document.querySelector('#port').classList.contains('on')", PATIENCE)?;
    page.says("#badge", "The board holds no program.")?;
    page.says("#run-state", "no program")?;
    page.wait(&format!("!({MARKED})"), PATIENCE)?;
    page.wait("document.querySelector('#vars-box').hidden", PATIENCE)?;
    // And it takes the text at once.
    page.push("#start")?;
    page.says("#run-state", "running")?;
    page.says("#badge", "as it stands here")
}

/// Keys without a pause, and Save behind the last of them: the file has all of them.
#[test]
fn hasty_keys_are_all_saved() -> Outcome<()> {
    let Some(stand) = Stand::start("Wait 1s\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.end_of_script()?;
    page.type_text("\n")?;
    let mut typed = String::from("Wait 1s\n");
    for n in 0..40 {
        let line = format!("Wait {n}ms\n");
        page.type_text(&line)?;
        typed.push_str(&line);
        if n % 10 == 9 {
            page.press("s", "KeyS", 83, "", 2)?;
        }
    }
    page.says("#notes", "Saved.")?;
    let end = std::time::Instant::now() + PATIENCE;
    loop {
        let file = std::fs::read_to_string(stand.script()).map_err(|error| error.to_string())?;
        if file.trim_end() == typed.trim_end() {
            break;
        }
        if std::time::Instant::now() > end {
            return Err(format!("the file has {file:?}"));
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    page.wait("!document.querySelector('#file').textContent.includes('•')", PATIENCE)
}

/// A text of 25 000 lines is written over and comes back; its run is shown each time.
#[test]
fn a_text_of_25_000_lines_is_written_over_and_comes_back() -> Outcome<()> {
    let text: String = (0..25_000).map(|n| format!("G1 X{} F6000\n", n % 2 * 5)).collect();
    let Some(stand) = Stand::start(&text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    const LONG: &str = "document.querySelector('.ed .text').textContent.length";
    page.wait(&format!("{LONG} >= {}", text.len()), PATIENCE)?;
    page.says("#sums", "runs to its end")?;
    // By key: the middle of such a text is far out of sight.
    page.eval("document.querySelector('.ed .text').focus()")?;
    page.select_all()?;
    page.type_text("Wait 2500ms")?;
    page.says("#sums", "2.50 s")?;
    page.wait(&format!("{LONG} < 100"), PATIENCE)?;
    for _ in 0..20 {
        if page.eval(&format!("{LONG} > 100"))? == true {
            break;
        }
        page.undo()?;
    }
    page.wait(&format!("{LONG} >= {}", text.len() - 1), PATIENCE)?;
    page.wait("!document.querySelector('#sums').textContent.includes('2.50 s') && !document.body.classList.contains('stale')", PATIENCE)
}
