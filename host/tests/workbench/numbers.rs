//! Numbers that are dragged, and values beside their lines.

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// The editor's text.
const TEXT: &str = "document.querySelector('.ed .text').textContent";
/// What stands beside the lines.
const BESIDE: &str = "[...document.querySelectorAll('.values span')].map(own => own.dataset.line + ': ' + own.textContent).join('; ')";

/// Puts the caret behind a word of the script, and waits for the number's handle.
fn handle(page: &Page, word: &str) -> Outcome<(f64, f64)> {
    caret(page, word)?;
    page.wait("!document.querySelector('#drag').hidden", PATIENCE)?;
    page.centre("#drag")
}

fn caret(page: &Page, word: &str) -> Outcome<()> {
    page.eval(&format!(
        "(() => {{ const t = document.querySelector('.ed .text'); t.focus(); \
         const n = [...t.childNodes].find(own => own.data?.includes({word:?})); \
         getSelection().collapse(n, n.data.indexOf({word:?}) + {}) }})()",
        word.len()
    ))
    .map(drop)
}

fn seek(page: &Page, part: u32) -> Outcome<()> {
    page.eval(&format!("(() => {{ const s = document.querySelector('#scrub'); s.value = {part}; s.dispatchEvent(new Event('input')) }})()")).map(drop)
}

#[test]
fn a_number_is_dragged_and_the_path_follows_meanwhile() -> Outcome<()> {
    let text =
        "CONST LONG = 20mm\nMoveAxe X, LONG, 10mm/s\nMoveAxe Y, 150mm\nPRINT \"7mm\" ' 8mm\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.wait(
        "document.querySelector('#sums').textContent.includes('20.0 / 150.0 / 0.0 mm')",
        PATIENCE,
    )?;
    let (x, y) = handle(&page, "20mm")?;
    page.mouse("mousePressed", (x, y))?;
    page.mouse("mouseMoved", (x + 40.0, y))?;
    // The path follows while the hand holds it.
    page.wait(&format!("{TEXT}.startsWith('CONST LONG = 30mm\\n')"), PATIENCE)?;
    page.wait("document.querySelector('#sums').textContent.includes('30.0 / 150.0 / 0.0 mm') && !document.body.classList.contains('stale')", PATIENCE)?;
    page.mouse("mouseMoved", (x + 80.0, y))?;
    page.wait("document.querySelector('#sums').textContent.includes('40.0 / 150.0 / 0.0 mm') && !document.body.classList.contains('stale')", PATIENCE)?;
    page.mouse("mouseReleased", (x + 80.0, y))?;
    page.has("CONST LONG = 40mm")?;
    // All of it is one step of undo.
    page.undo()?;
    page.wait(&format!("{TEXT} === {text:?}"), PATIENCE)?;
    page.says("#sums", "20.0 / 150.0 / 0.0 mm")?;
    // The travel of its axis is its bound.
    let (x, y) = handle(&page, "150mm")?;
    page.says("#drag", "0 to 200 mm")?;
    page.mouse("mousePressed", (x, y))?;
    page.mouse("mouseMoved", (x + 500.0, y))?;
    page.has("MoveAxe Y, 200mm")?;
    page.mouse("mouseMoved", (x + 20.0, y))?;
    page.has("MoveAxe Y, 155mm")?;
    // Escape leaves it as it was.
    page.press("Escape", "Escape", 27, "", 0)?;
    page.wait(&format!("{TEXT} === {text:?}"), PATIENCE)?;
    page.mouse("mouseReleased", (x, y))?;
    // Numbers of texts and comments are none.
    for word in ["\"7mm", "' 8mm", "PRINT"] {
        caret(&page, word)?;
        page.wait("document.querySelector('#drag').hidden", PATIENCE)?;
    }
    // By keys.
    caret(&page, "LONG, 10mm/s")?;
    page.press("ArrowUp", "ArrowUp", 38, "", 1)?;
    page.has("LONG, 11mm/s")?;
    page.press("ArrowDown", "ArrowDown", 40, "", 9)?;
    page.has("LONG, 10.9mm/s")
}

/// What another page writes meanwhile is not written over.
#[test]
fn a_text_that_changes_under_the_hand_stays() -> Outcome<()> {
    let Some(stand) = Stand::start("MoveAxe X, 20mm\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let (x, y) = handle(&page, "20mm")?;
    page.mouse("mousePressed", (x, y))?;
    std::fs::write(stand.script(), "Wait 1s\nHome X\n").map_err(|error| error.to_string())?;
    page.wait(&format!("{TEXT} === 'Wait 1s\\nHome X\\n'"), PATIENCE)?;
    page.mouse("mouseMoved", (x + 40.0, y))?;
    page.mouse("mouseReleased", (x + 40.0, y))?;
    page.rest()?;
    page.wait(&format!("{TEXT} === 'Wait 1s\\nHome X\\n'"), PATIENCE)
}

#[test]
fn values_stand_beside_their_lines_at_the_sliders_time() -> Outcome<()> {
    let text = "CONST PITCH = 5mm\nDIM n\nDIM way AS LENGTH\nFOR n = 1 TO 3\n  way = n * PITCH\n  MoveAxe X, way, 10mm/s\n  Wait 1s\nNEXT\nshow 7\nSUB show(n)\n  PRINT \"n is \"; n\nEND SUB\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    // At the begin nothing has a value yet.
    assert_eq!(page.eval(BESIDE)?, "");
    seek(&page, 5000)?;
    let beside = |words: &str| {
        page.wait(&format!("({BESIDE}).includes({words:?})"), PATIENCE)
            .map_err(|error| format!("{error}; it is {:?}", page.eval(BESIDE)))
    };
    beside("4: n = 2")?;
    beside("5: way = 10 mm   n = 2")?;
    seek(&page, 10_000)?;
    beside("6: way = 15 mm   → 15.00 0.00 0.00 mm")?;
    // A parameter of the same name has no cell of its own: what was printed is told instead.
    beside("11: “n is 7”")?;
    assert_eq!(page.eval(&format!("/1[12]: n = /.test({BESIDE})"))?, false);
    // From the first key on they are those of another text.
    page.end_of_script()?;
    page.type_text("' ")?;
    assert_eq!(page.eval(BESIDE)?, "");
    // Nor are they shown beside a line that the board runs.
    page.wait("!document.body.classList.contains('stale')", PATIENCE)?;
    beside("4: n = ")?;
    page.upload()?;
    page.push("#start")?;
    page.wait(&format!("!document.querySelector('.ed .run').hidden && ({BESIDE}) === ''"), PATIENCE)
}

/// A run that is longer than what is kept of it does not show its last known values for later ones.
#[test]
fn values_beyond_what_is_kept_are_not_shown() -> Outcome<()> {
    let text = "DIM n\nFOR n = 1 TO 55000\n  SetOut 1, ON\nNEXT\nWait 10s\nn = 5\nWait 10s\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    seek(&page, 9000)?;
    page.says("#sim-vars", "n?")?;
    assert_eq!(page.eval(&format!("/n = \\d/.test({BESIDE})"))?, false);
    Ok(())
}
