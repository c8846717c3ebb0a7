//! The timeline, which is the slider: statements, inputs, outputs and what is printed on one scale.

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

const SCRIPT: &str = "DIM n\nSetOut 1, ON\nSetOut 2, ON\nMoveAxe X, 10mm, 10mm/s\nFOR n = 1 TO 2\n  Wait 1s\nNEXT\nPRINT \"there\"\nSetOut 1, OFF\n";

/// The line that `#now` names.
fn at(page: &Page, line: u32) -> Outcome<()> {
    page.says("#now", &format!("· line {line} ·"))
}

#[test]
fn statement_by_statement_by_keys_and_buttons() -> Outcome<()> {
    let Some(stand) = Stand::start(SCRIPT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let step = |key: &str| page.press(key, "", 0, key, 0);
    page.eval("document.querySelector('#path').focus()")?;
    // Statements of the same time are stepped one by one, too.
    for line in [2, 3, 4, 6, 6, 8, 9] {
        at(&page, line)?;
        step(".")?;
    }
    // The run's end is an event of its last line.
    for line in [9, 8] {
        step(",")?;
        at(&page, line)?;
    }
    page.click("#before")?;
    at(&page, 6)?;
    page.says("#sim-vars", "n2")?;
    page.click("#before")?;
    at(&page, 6)?;
    page.says("#sim-vars", "n1")?;
    page.wait("document.querySelector('.ed .run').style.top === '100px'", PATIENCE)?;
    page.click("#behind")?;
    // In the script these keys write.
    page.end_of_script()?;
    step(".")?;
    page.has("SetOut 1, OFF.")
}

/// The slider's knob stands over the cursor of the rows, whose first one has the lines.
#[test]
fn slider_and_rows_have_one_scale() -> Outcome<()> {
    let Some(stand) = Stand::start(SCRIPT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let boxes = page.eval("(() => { const s = document.querySelector('#scrub').getBoundingClientRect(), r = document.querySelector('#rows').getBoundingClientRect(); return [s.left + 8 - r.left, r.right - s.right + 8, r.top - s.bottom] })()")?;
    let boxes = [0, 1, 2].map(|n| boxes[n].as_f64().unwrap_or(-1.0));
    assert!((boxes[0] - 90.0).abs() < 1.0 && (boxes[1] - 8.0).abs() < 1.0, "{boxes:?}");
    assert!((0.0..8.0).contains(&boxes[2]), "{boxes:?}");
    // A click on the knob's track and one on the row of the lines are the same time.
    let place = page.eval("(() => { const r = document.querySelector('#rows').getBoundingClientRect(); return [r.x + 90 + (r.width - 98) / 4, r.y + 12, r.y - 12] })()")?;
    let place = [0, 1, 2].map(|n| place[n].as_f64().unwrap_or(0.0));
    let mut seen = Vec::new();
    for y in [place[1], place[2]] {
        page.eval("(() => { const s = document.querySelector('#scrub'); s.value = 0; s.dispatchEvent(new Event('input')) })()")?;
        page.mouse("mousePressed", (place[0], y))?;
        page.mouse("mouseReleased", (place[0], y))?;
        page.wait("+document.querySelector('#scrub').value > 0", PATIENCE)?;
        seen.push(page.eval("+document.querySelector('#scrub').value")?.as_f64().unwrap_or(0.0));
    }
    assert!((seen[0] - seen[1]).abs() < 60.0 && (seen[0] - 2500.0).abs() < 60.0, "{seen:?}");
    Ok(())
}

/// A part of the run on the whole width, by buttons, keys and wheel; what is shown of the run comes in sight.
#[test]
fn a_part_of_the_run_is_shown_larger() -> Outcome<()> {
    let Some(stand) = Stand::start(SCRIPT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let words = "document.querySelector('#zoom-words').textContent";
    assert_eq!(page.eval(words)?, "");
    page.wait("document.querySelector('#zoom-out').disabled", PATIENCE)?;
    // The slider's middle stays where it is: a knob's way is a shorter time now.
    let to = |value: u32| {
        page.eval(&format!("(() => {{ const s = document.querySelector('#scrub'); s.value = {value}; s.dispatchEvent(new Event('input')); return document.querySelector('#now').textContent }})()"))
    };
    let middle = to(5_000)?;
    page.push("#zoom-in")?;
    page.push("#zoom-in")?;
    page.says("#zoom-words", " to ")?;
    assert_eq!(to(5_000)?, middle);
    let end = to(10_000)?;
    assert!(
        end != middle && page.eval(words)?.as_str().is_some_and(|own| !own.is_empty()),
        "{end}"
    );
    // A statement out of sight comes in sight, by key.
    let before = page.eval(words)?;
    page.eval("document.querySelector('#path').focus()")?;
    for _ in 0..3 {
        page.press(",", "", 0, ",", 0)?;
    }
    at(&page, 2)?;
    page.wait(&format!("{words} !== {before}"), PATIENCE)?;
    page.wait("+document.querySelector('#scrub').value < 10", PATIENCE)?;
    // The same by keys on the slider, and by the wheel where the pointer is.
    page.eval("document.querySelector('#scrub').focus()")?;
    page.press("0", "Digit0", 48, "0", 0)?;
    page.wait(&format!("{words} === ''"), PATIENCE)?;
    page.press("+", "", 0, "+", 0)?;
    page.says("#zoom-words", "0 ms to ")?;
    page.press("-", "", 0, "-", 0)?;
    page.wait(&format!("{words} === ''"), PATIENCE)?;
    page.eval("(() => { const r = document.querySelector('#rows'), b = r.getBoundingClientRect(); r.dispatchEvent(new WheelEvent('wheel', { bubbles: true, cancelable: true, ctrlKey: true, deltaY: -600, clientX: b.right - 9, clientY: b.y + 9 })) })()")?;
    page.wait(&format!("!{words}.startsWith('0 ms') && {words} !== ''"), PATIENCE)?;
    // Another text: the part stays as far as the run has it, and all of it is a button away.
    page.push("#zoom-all")?;
    page.wait(&format!("{words} === ''"), PATIENCE)
}

/// Sixteen times as fast as the machine is not once, and neither is all of it in 20 s.
#[test]
fn it_plays_as_fast_as_is_said() -> Outcome<()> {
    let Some(stand) = Stand::start("Wait 60s\nHome\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    for (pace, least, most) in [("1", 0.5, 2.5), ("16", 10.0, 30.0)] {
        page.fill("#pace", pace)?;
        let took = page.eval("(async () => {
            const s = document.querySelector('#scrub'), button = document.querySelector('#play');
            s.value = 0; s.dispatchEvent(new Event('input'));
            button.click();
            const begun = performance.now();
            await new Promise(done => setTimeout(done, 1000));
            button.click();
            const seconds = +document.querySelector('#now').textContent.match(/^([\\d.]+) (m?s)/)[1] / (document.querySelector('#now').textContent.includes(' ms') ? 1000 : 1);
            return seconds / ((performance.now() - begun) / 1000) })()")?;
        let took = took.as_f64().unwrap_or(0.0);
        assert!((least..most).contains(&took), "{pace}: {took}");
    }
    Ok(())
}

/// Of a run with more events than are sent, the line beyond them is not that of the last one.
#[test]
fn a_line_beyond_what_is_kept_is_not_made_up() -> Outcome<()> {
    let text =
        "DIM n\nFOR n = 1 TO 21000\n  SetOut 1, ON\nNEXT\nWait 10s\nMoveAxe X, 100mm, 10mm/s\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.eval("(() => { const s = document.querySelector('#scrub'); s.value = 9000; s.dispatchEvent(new Event('input')) })()")?;
    at(&page, 6)
}
