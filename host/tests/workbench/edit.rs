//! Script and simulation.

use std::time::Duration;

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// The editor's text.
const TEXT: &str = "document.querySelector('.ed .text').textContent";

#[test]
fn a_script_is_written_checked_completed_and_saved() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.wait(&format!("{TEXT} === 'Home\\n'"), PATIENCE)?;
    page.end_of_script()?;
    page.type_text("\nMoveAxe X, 5kg")?;
    page.says("#problem-count", "error")?;
    // The mark under the words is painted with the next frame.
    page.wait("CSS.highlights.get('error')?.size >= 1", PATIENCE)?;
    // A click on the problem selects its words; typing over them fixes it.
    page.click("#problems .plain")?;
    page.wait("getSelection().toString() !== ''", PATIENCE)?;
    page.end_of_script()?;
    for _ in 0..3 {
        page.press("Backspace", "Backspace", 8, "", 0)?;
    }
    page.type_text("5mm\nMoveA")?;
    page.wait("!document.querySelector('#completions').hidden", PATIENCE)?;
    page.says("#completions", "MoveAxe")?;
    page.press("Enter", "Enter", 13, "\r", 0)?;
    page.type_text(" y , 3mm")?;
    page.wait(&format!("{TEXT}.includes('MoveAxe y , 3mm')"), PATIENCE)?;
    page.says("#problem-count", "no problems")?;
    page.click("#format")?;
    page.wait(&format!("{TEXT}.includes('MoveAxe Y, 3mm')"), PATIENCE)
        .or_else(|_| page.wait(&format!("{TEXT}.includes('MoveAxe y, 3mm')"), PATIENCE))?;
    // Format is one step of undo.
    page.click(".ed .text")?;
    page.undo()?;
    page.wait(&format!("{TEXT}.includes('MoveAxe y , 3mm')"), PATIENCE)?;
    page.press("s", "KeyS", 83, "", 2)?;
    page.says("#notes", "Saved")?;
    let saved = std::fs::read_to_string(stand.script()).map_err(|error| error.to_string())?;
    assert!(saved.contains("MoveAxe X, 5mm\nMoveAxe y , 3mm"), "{saved}");
    Ok(())
}

#[test]
fn a_file_that_changes_on_disk_is_followed_and_nothing_is_lost() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.wait(&format!("{TEXT} === 'Home\\n'"), PATIENCE)?;
    let write =
        |text: &str| std::fs::write(stand.script(), text).map_err(|error| error.to_string());
    write("Home X\n")?;
    page.wait(&format!("{TEXT} === 'Home X\\n'"), PATIENCE)?;
    page.end_of_script()?;
    page.type_text("\nWait 1s")?;
    page.wait("document.querySelector('#file').textContent.includes('•')", PATIENCE)?;
    std::thread::sleep(Duration::from_millis(600));
    write("Home Y\n")?;
    page.wait("!document.querySelector('#conflict').hidden", PATIENCE)?;
    page.wait(&format!("{TEXT} === 'Home X\\nWait 1s'"), PATIENCE)?;
    page.click("#keep-text")?;
    page.wait("document.querySelector('#conflict').hidden", PATIENCE)?;
    page.click("#save")?;
    page.says("#notes", "Saved")?;
    let saved = std::fs::read_to_string(stand.script()).map_err(|error| error.to_string())?;
    assert!(saved.contains("Wait 1s"), "{saved}");
    // A second page works on the same text.
    let other = stand.page()?;
    other.wait(&format!("{TEXT}.trimEnd() === 'Home X\\nWait 1s'"), PATIENCE)?;
    other.end_of_script()?;
    other.type_text("\nWait 2s")?;
    page.wait(&format!("{TEXT}.includes('Wait 2s')"), PATIENCE)
}

/// Points of a canvas in a colour of the page.
fn colours(page: &Page, canvas: &str, name: &str) -> Outcome<u64> {
    let js = format!(
        "(() => {{ const c = document.querySelector({canvas:?}), t = document.createElement('canvas').getContext('2d', {{ willReadFrequently: true }});
            t.fillStyle = getComputedStyle(c).getPropertyValue({name:?}); t.fillRect(0, 0, 1, 1);
            const want = t.getImageData(0, 0, 1, 1).data, all = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
            let n = 0; for (let i = 0; i < all.length; i += 4) if (all[i] === want[0] && all[i + 1] === want[1] && all[i + 2] === want[2] && all[i + 3] === 255) n++; return n }})()"
    );
    Ok(page.eval(&js)?.as_u64().unwrap_or(0))
}

#[test]
fn each_pause_in_typing_shows_the_run_that_will_be() -> Outcome<()> {
    let text = "DIM n\nG0 X10\nFOR n = 1 TO 3\n  PRINT \"pass \"; n\n  Wait 1s\nNEXT\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.says("#prints", "pass 3")?;
    page.wait(
        "document.querySelector('#rows').ariaLabel.includes('3 lines printed; no fault')",
        PATIENCE,
    )?;
    assert!(colours(&page, "#rows", "--accent")? > 20, "nothing marks what is printed");
    // The switches stand at the ends of the travel where the machine has them.
    page.wait("document.querySelector('#path').ariaLabel.includes('X lower end, Y lower end, Z upper end')", PATIENCE)?;
    // Half of the run: the second pass waits.
    page.eval("(() => { const s = document.querySelector('#scrub'); s.value = 5000; s.dispatchEvent(new Event('input')) })()")?;
    page.says("#now", "line 5")?;
    page.says("#sim-vars", "n2")?;
    page.wait("document.querySelector('.ed .run').style.top === '80px'", PATIENCE)?;
    // A fault is told with its line, cause and remedy.
    page.end_of_script()?;
    page.type_text("\nWaitIn 3, ON, 50ms")?;
    page.says("#sim-fault", "Line 7")?;
    page.wait("document.querySelector('#rows').ariaLabel.includes('F13 at 3.')", PATIENCE)?;
    assert!(colours(&page, "#rows", "--bad")? > 40, "nothing marks the fault");
    // A script that never ends does no harm.
    page.select_all()?;
    page.type_text("again: GOTO again\n")?;
    page.says("#sums", "stops in line 1")
}

#[test]
fn names_are_coloured_mended_renamed_and_found() -> Outcome<()> {
    let text = "CONST PITCH = 2mm\nDIM n\nn == 2\ndrill PITCH\nSUB drill(depth)\n  MoveAxe Z, depth\nEND SUB\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#problem-count", "1 error")?;
    // One click fixes it.
    page.wait("document.querySelector('#problems .fix')?.textContent === 'Write `=`'", PATIENCE)?;
    page.click("#problems .fix")?;
    page.wait(&format!("{TEXT}.includes('n = 2')"), PATIENCE)?;
    page.says("#problem-count", "no problems")?;
    // Colours say what names mean: two of the CONST, of the SUB and of its parameter.
    for kind in ["constant", "routine", "parameter"] {
        page.wait(&format!("CSS.highlights.get('{kind}')?.size === 2"), PATIENCE)?;
    }
    // Rename, with the editor's question answered beforehand, changes every mention.
    page.eval("window.prompt = () => 'peck'")?;
    page.eval("(() => { const s = getSelection(), n = document.querySelector('.ed .text').firstChild; document.querySelector('.ed .text').focus(); s.collapse(n, n.data.indexOf('drill PITCH') + 2) })()")?;
    page.press("F2", "F2", 113, "", 0)?;
    page.wait(
        &format!("{TEXT}.includes('peck PITCH') && {TEXT}.includes('SUB peck(depth)')"),
        PATIENCE,
    )?;
    page.press("F12", "F12", 123, "", 0)?;
    page.wait(
        &format!("{TEXT}.slice(0, getSelection().focusOffset).split('\\n').length === 5"),
        PATIENCE,
    )?;
    // A call's form, with the argument that is being written.
    page.end_of_script()?;
    page.type_text("\nMoveAxe X, ")?;
    page.wait("document.querySelector('#signature b')?.textContent === 'target'", PATIENCE)?;
    page.press("Escape", "Escape", 27, "", 0)?;
    page.wait("document.querySelector('#signature').hidden", PATIENCE)
}

#[test]
fn two_runs_are_compared() -> Outcome<()> {
    let Some(stand) = Stand::start("MoveAxe X, 10mm, 10mm/s\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.push("#compare")?;
    page.select_script("MoveAxe X, 30mm, 10mm/s\n")?;
    page.says("#sums", "(+2.00 s)")?;
    page.says("#sums", "3,000 (+2,000)")?;
    // Against the run that was kept, not against the one before.
    page.select_script("MoveAxe X, 20mm, 10mm/s\n")?;
    page.says("#sums", "2,000 (+1,000)")?;
    page.says("#sums", "20.0 / 0.0 / 0.0 mm (+10.0 mm)")?;
    page.push("#compare")?;
    page.wait("!document.querySelector('#sums').textContent.includes('(+')", PATIENCE)
}

/// What is shown is the text's own run, or dimmed and said to be another one's; a script that loops for
/// ever is shown by its first turns.
#[test]
fn an_old_run_is_never_shown_as_the_texts_own() -> Outcome<()> {
    let Some(stand) = Stand::start("MoveAxe X, 10mm\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.wait("!document.body.classList.contains('stale')", PATIENCE)?;
    // Dim from the first key on.
    page.end_of_script()?;
    page.type_text("\n")?;
    assert_eq!(page.eval("document.body.classList.contains('stale')")?, true);
    page.wait("!document.body.classList.contains('stale')", PATIENCE)?;
    // Endless: three turns, with a way to see more. It waits, so that all of a simulated day is
    // a hundred turns: at 90 s a turn it takes 16 s of a processor.
    page.select_script("DIM n\nMoveAxe X, 1mm\nDO\nFOR n = 1 TO 5\nMoveAxe X, 40mm\nMoveAxe X, 0mm\nNEXT\nWait 900s\nPRINT \"turn\"\nLOOP\n")?;
    page.says("#sums", "loops on: 3 turns are shown")?;
    page.says("#sim-notes", "goes on after its third turn")?;
    let prints = "document.querySelectorAll('#prints li').length";
    page.wait(&format!("{prints} === 3"), PATIENCE)?;
    page.push("#more")?;
    page.wait(&format!("{prints} > 50"), PATIENCE)?;
    // A heavy script is given up for the next one.
    page.select_script(
        "DIM n\nDIM m\nFOR n = 1 TO 30000\nFOR m = 1 TO 30000\nNEXT\nNEXT\nMoveAxe Y, 1mm\n",
    )?;
    page.says("#sim-words", "simulating")?;
    page.select_script("MoveAxe X, 20mm, 10mm/s\n")?;
    page.says("#sums", "2,000")?;
    page.wait(
        "!document.body.classList.contains('stale') && document.querySelector('#sim-words').hidden",
        PATIENCE,
    )
}

/// A script that waits says where and for what; the world that stands beside it by its name is taken.
#[test]
fn a_wait_for_an_input_is_told_and_a_world_ends_it() -> Outcome<()> {
    let Some(stand) = Stand::start("PRINT \"waits\"\nWaitIn 3, ON\nPRINT \"came\"\n", &[])? else {
        return Ok(());
    };
    let page = stand.page()?;
    page.says("#sums", "waits in line 2")?;
    page.says("#sim-fault", "Line 2 waits for an input")?;
    page.says("#sim-fault", "job.rhai")?;
    let world = stand.folder.path().join("job.rhai");
    std::fs::write(world, "at(500, || set_in(3, true));\n").map_err(|error| error.to_string())?;
    page.end_of_script()?;
    page.type_text("\n")?;
    page.says("#prints", "came")?;
    page.says("#sim-notes", "with the world job.rhai")
}

/// Programs of other systems are opened, listed and dropped; a file that is not there yet is begun.
#[test]
fn files_of_other_systems_and_new_ones_are_opened() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let code = "G21 G90\nG0 X10 Y10\nG1 X20 F600\nM30\n";
    let file = stand.folder.path().join("plate.nc");
    std::fs::write(&file, code).map_err(|error| error.to_string())?;
    let page = stand.page()?;
    page.wait(
        "[...document.querySelector('#open').options].some(own => own.value === 'plate.nc')",
        PATIENCE,
    )?;
    page.eval("(() => { const list = document.querySelector('#open'); list.value = 'plate.nc'; list.onchange(); })()")?;
    page.says("#file", "plate.bas •")?;
    page.has("G1 X20 F600")?;
    page.says("#problem-count", "no problems")?;
    page.press("s", "KeyS", 83, "", 2)?;
    page.says("#notes", "Saved")?;
    // From anywhere else; the name that is taken is left alone.
    let other = tempfile::tempdir().map_err(|error| error.to_string())?;
    let file = other.path().join("plate.tap");
    std::fs::write(&file, code.replace("X20", "X30")).map_err(|error| error.to_string())?;
    page.choose("#own", &file)?;
    page.says("#file", "plate_2.bas •")?;
    page.has("G1 X30 F600")?;
    let kept = std::fs::read_to_string(stand.folder.path().join("plate.bas"));
    assert!(kept.map_err(|error| error.to_string())?.contains("X20"));
    // What was not saved stays beside it when the tool ends.
    page.eval("window.confirm = words => { window.asked = words; return true }")?;
    page.click("#quit")?;
    page.says("#blind", "ended")?;
    assert!(
        page.eval("window.asked")?
            .as_str()
            .is_some_and(|words| words.contains("plate_2.bas is not saved"))
    );
    let kept = std::fs::read_to_string(stand.folder.path().join("plate_2.bas~"));
    assert!(kept.map_err(|error| error.to_string())?.contains("X30"));
    Ok(())
}

/// The caret is never behind the line numbers, and the running line is marked as far as it goes.
#[test]
fn the_caret_of_a_long_line_is_in_sight() -> Outcome<()> {
    let text = format!("PRINT \"{}\"\n", "x".repeat(300));
    let Some(stand) = Stand::start(&text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let caret = |at: u32| {
        page.eval(&format!("(() => {{ const t = document.querySelector('.ed .text'); t.focus(); getSelection().collapse(t.firstChild, {at}) }})()"))
    };
    // At the end of the line the pane scrolls; from there back to its beginning.
    caret(300)?;
    page.type_text("x")?;
    page.wait("document.querySelector('.ed').scrollLeft > 500", PATIENCE)?;
    caret(0)?;
    page.type_text("' ")?;
    let seen = "(() => { const r = document.createRange(); const n = document.querySelector('.ed .text').firstChild; r.setStart(n, 2); r.setEnd(n, 3); return r.getBoundingClientRect().left >= document.querySelector('.ed .gutter').getBoundingClientRect().right })()";
    page.wait(seen, PATIENCE)
}

/// A laser's work is grey by its power, and the scale says so.
#[test]
fn a_lasers_power_is_grey() -> Outcome<()> {
    let text = include_str!("../../../examples/laser.bas");
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    let greys = "(async () => { const { colour, CLASSES } = await import('/strokes.js'); return [0, 8, 15].map(n => colour(CLASSES + n, false)).join() })()";
    assert_eq!(page.eval(greys)?, "hsl(218 12% 88%),hsl(218 12% 48%),hsl(218 12% 13%)");
    // On the drawing, without its scale.
    page.rest()?;
    let hues = "(() => { const c = document.querySelector('#path'), d = c.getContext('2d').getImageData(0, c.height * .3, c.width, c.height * .4).data; let grey = 0, green = 0; for (let n = 0; n < d.length; n += 4) { const [r, g, b] = [d[n], d[n + 1], d[n + 2]]; if (g > r + 60 && g > b + 20) green++; if (r < 100 && Math.abs(r - b) < 30) grey++; } return green < 20 && grey > 200 })()";
    page.wait(hues, PATIENCE)
}

/// Drilled holes are rings, travel is dashed, and path and text lead to one another; as many views as there
/// are, with Z upward also where a machine counts it downward.
#[test]
fn path_and_text_lead_to_one_another() -> Outcome<()> {
    let text = "PROFILE \"charly\"\nHome\nG0 X20 Y20\nMoveRel Z, 3mm, 2mm/s\nMoveRel Z, -3mm\nG0 X80\nMoveRel Z, 3mm, 2mm/s\nMoveRel Z, -3mm\nG1 Y60 F600\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.wait("document.querySelector('#path').ariaLabel.includes('2 places where the tool goes straight down')", PATIENCE)?;
    // A click at the second hole: the slider goes there, and its line is marked in the text.
    let (x, y) = page.centre("#path")?;
    let size = page.eval("(() => { const r = document.querySelector('#path').getBoundingClientRect(); return [r.width, r.height] })()")?;
    let (width, height) = (size[0].as_f64().unwrap_or(0.0), size[1].as_f64().unwrap_or(0.0));
    // The picture's extent is X 0 to 80, Y 0 to 60 with equal scales: the cut is at its right edge.
    let zoom = ((width - 80.0) / 80.0).min((height - 110.0) / 60.0);
    let at = (x + 40.0 * zoom, y + 8.0 - 10.0 * zoom);
    page.mouse("mousePressed", at)?;
    page.mouse("mouseReleased", at)?;
    page.says("#now", "line 9")?;
    page.wait("document.querySelector('.ed .run').style.top === '160px'", PATIENCE)?;
    // The caret's line is thick on the path: more of the paper is covered while it is there.
    let covered = "(() => { const c = document.querySelector('#path'), d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return n })()";
    page.rest()?;
    let thick = page.eval(covered)?.as_u64().unwrap_or(0);
    page.eval("(() => { const t = document.querySelector('.ed .text'); t.focus(); getSelection().collapse(t.firstChild, 0) })()")?;
    page.wait(&format!("{covered} < {thick} - 200"), PATIENCE)?;
    // Every view shows something; in space it turns by keys.
    for view in ["front", "side", "space", "top"] {
        page.click(&format!("[data-view={view}]"))?;
        page.rest()?;
        assert!(page.eval(covered)?.as_u64() > Some(1000), "{view}");
    }
    page.click("[data-view=space]")?;
    page.eval("document.querySelector('#path').focus()")?;
    page.press("ArrowLeft", "ArrowLeft", 37, "", 0)?;
    page.press("ArrowUp", "ArrowUp", 38, "", 0)?;
    page.rest()
}
