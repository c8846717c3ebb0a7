//! The page for the person at the machine.

use crate::cdp::Outcome;
use crate::stand::{PATIENCE, Stand};

#[test]
fn a_person_chooses_a_program_sets_a_quantity_and_runs_it() -> Outcome<()> {
    let text = "KEEP wanted ' Pieces, 1..9\nDIM n\nWaitStart\nFOR n = 1 TO wanted\n  PRINT \"piece \"; n\n  Wait 50ms\nNEXT\nPRINT \"ready\"\n";
    let Some(stand) = Stand::start(text, &["--operator"])? else { return Ok(()) };
    let other = stand.folder.path().join("other.bas");
    std::fs::write(&other, "Wait 60s\n").map_err(|error| error.to_string())?;
    let page = stand.page()?;
    page.window(820, 1180, true)?;
    page.wait("document.querySelectorAll('#program option').length === 2", PATIENCE)?;
    page.eval("document.querySelector('#program').dispatchEvent(new Event('change'))")?;
    page.says("#lamp", "Ready")?;
    page.says("#quantities", "Pieces")?;
    page.push("#start")?;
    page.says("#lamp", "Press Start")?;
    for n in 1..=3 {
        page.push(".quantity button:last-of-type")?;
        page.wait(&format!("document.querySelector('.quantity input').value === '{n}'"), PATIENCE)?;
    }
    // Out of the script's own range: refused in words.
    page.eval("(() => { const i = document.querySelector('.quantity input'); i.value = 10; i.dispatchEvent(new Event('change')) })()")?;
    page.says("#notes", "1 to 9")?;
    page.push("#start")?;
    page.says("#message", "ready")?;
    page.says("#lamp", "Ready")?;
    page.eval("(() => { const p = document.querySelector('#program'); p.value = 'other.bas'; p.dispatchEvent(new Event('change')) })()")?;
    page.wait("document.querySelectorAll('.quantity').length === 0", PATIENCE)?;
    page.push("#start")?;
    page.says("#lamp", "Running")?;
    page.click("#stop")?;
    page.says("#lamp", "Ready")?;
    // More than that is not given to this page.
    page.eval("(async () => { const { Link } = await import('/link.js'); const link = new Link(); await new Promise(done => link.addEventListener('welcome', done)); try { await link.ask({ jog: { axis: 'X', um: 1000, speed: 1000 } }); document.title = 'moved' } catch (e) { document.title = e.message } })()")?;
    page.wait("document.title.includes('only starts')", PATIENCE)
}

/// Quantities with AT are set while nothing runs, and the program finds them.
#[test]
fn a_quantity_is_set_before_start_by_its_label_and_within_its_range() -> Outcome<()> {
    let text = "DIM wanted AT 3000 LABEL \"Pieces\" MIN 1 MAX 9\nDIM n\nFOR n = 1 TO wanted\n  PRINT \"piece \"; n\nNEXT\nPRINT \"made \"; wanted\n";
    let Some(stand) = Stand::start(text, &["--operator"])? else { return Ok(()) };
    let page = stand.page()?;
    page.wait("document.querySelectorAll('#program option').length === 1", PATIENCE)?;
    page.eval("document.querySelector('#program').dispatchEvent(new Event('change'))")?;
    page.says("#lamp", "Ready")?;
    page.says("#quantities", "Pieces")?;
    page.fill(".quantity input", "10")?;
    page.says("#notes", "Pieces: 1 to 9")?;
    // By the button, whose number comes back from the board.
    for n in 1..=4 {
        page.push(".quantity button:last-of-type")?;
        page.wait(&format!("document.querySelector('.quantity input').value === '{n}'"), PATIENCE)?;
    }
    // Past the page's own look the tool refuses too.
    page.eval("(async () => { const { Link } = await import('/link.js'); const link = new Link(), program = new Promise(done => link.addEventListener('program', e => done(e.detail))); await new Promise(done => link.addEventListener('welcome', done)); await link.ask({ helm: true }); const told = await program; try { await link.ask({ set: { cell: told.vars[0].cell, value: 10 } }); document.title = 'set' } catch (e) { document.title = e.message } await link.ask({ helm: false }) })()")?;
    page.wait("document.title === 'Pieces: 1 to 9'", PATIENCE)?;
    page.wait("!document.querySelector('#helm').hidden", PATIENCE)?;
    page.push("#helm")?;
    page.wait("document.querySelector('#helm').hidden", PATIENCE)?;
    page.push("#start")?;
    page.says("#message", "made 4")?;
    page.says("#lamp", "Ready")?;
    page.wait("document.querySelector('.quantity input').value === '4'", PATIENCE)
}
