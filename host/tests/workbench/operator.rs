//! The page for the person at the machine.

use crate::cdp::{Outcome, Page};
use crate::look::picture;
use crate::stand::{PATIENCE, Stand};

const START: &str = "document.querySelector('#start')";
/// What the page names as the program.
const NAMED: &str = "document.querySelector('#program').selectedOptions[0]?.textContent";

/// Loads the program that the page offers.
fn load(page: &Page, name: &str) -> Outcome<()> {
    page.says("#load", &format!("Load {name}"))?;
    page.push("#load")?;
    page.says("#lamp", "Ready")?;
    page.wait(&format!("{NAMED} === {name:?}"), PATIENCE)
}

#[test]
fn a_person_chooses_a_program_sets_a_quantity_and_runs_it() -> Outcome<()> {
    let text = "KEEP wanted ' Pieces, 1..9\nDIM n\nWaitStart\nFOR n = 1 TO wanted\n  PRINT \"piece \"; n\n  Wait 50ms\nNEXT\nPRINT \"ready\"\n";
    let Some(stand) = Stand::start(text, &["--operator"])? else { return Ok(()) };
    let other = stand.folder.path().join("other.bas");
    std::fs::write(&other, "Wait 60s\n").map_err(|error| error.to_string())?;
    let page = stand.page()?;
    page.window(820, 1180, true)?;
    page.wait("document.querySelectorAll('#program option').length >= 2", PATIENCE)?;
    load(&page, "job")?;
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
    page.wait("document.querySelectorAll('#program option').length >= 1", PATIENCE)?;
    load(&page, "job")?;
    page.says("#quantities", "Pieces")?;
    // Out of its range: nothing begins, and the page says which one.
    page.says("#hint", "Pieces: between 1 and 9.")?;
    page.wait(&format!("{START}.disabled"), PATIENCE)?;
    for wrong in ["10", "", "2,5", "-"] {
        page.fill(".quantity input", wrong)?;
        page.says("#notes", "Pieces: ")?;
        page.wait("document.querySelector('.quantity input').value === '0'", PATIENCE)?;
    }
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

/// The work goes slower by a finger in a glove, and not faster than it is written.
#[test]
fn the_operator_makes_the_work_slower() -> Outcome<()> {
    let Some(mut stand) = Stand::with_world("G1 X1 F600\n", "", &["--operator"])? else {
        return Ok(());
    };
    let page = stand.page()?;
    page.window(390, 844, true)?;
    page.says("#speed", "100 %")?;
    for percent in [90, 80] {
        page.push("#speed button")?;
        page.says("#speed", &format!("{percent} %"))?;
    }
    let large = "[...document.querySelectorAll('button, select, input')].filter(own => own.checkVisibility()).map(own => [own.id || own.ariaLabel, own.getBoundingClientRect()]).filter(([, r]) => r.height < 64 || r.width < 64).map(([id]) => id).join()";
    assert_eq!(page.eval(large)?, "", "too small for a glove");
    for percent in [90, 100] {
        page.push("#speed button:last-of-type")?;
        page.says("#speed", &format!("{percent} %"))?;
    }
    page.wait("document.querySelector('#speed button:last-of-type').disabled", PATIENCE)?;
    let past = "(async () => { const { Link } = await import('/link.js'); const link = new Link(); await new Promise(done => link.addEventListener('welcome', done)); await link.ask({ helm: true }); try { await link.ask({ override: [150, 100] }); return 'done' } catch (e) { return e.message } })()";
    let told = page.eval(past)?;
    assert!(told.as_str().is_some_and(|own| own.contains("not faster")), "{told}");
    assert_eq!(stand.board()?.status()?.runs, 0);
    Ok(())
}

/// What is named is what the board holds, whoever brought it, and nothing else starts.
#[test]
fn the_program_that_is_named_is_the_one_that_starts() -> Outcome<()> {
    let text = "DIM made AT 3000 LABEL \"Pieces\" MIN 0 MAX 9\nPRINT \"brackets\"\nWait 300ms\n";
    let Some(mut stand) = Stand::with_world(text, "", &["--operator"])? else { return Ok(()) };
    for (name, text) in [("broken", "G1 Q\n"), ("washers", "PRINT \"washers\"\n")] {
        let file = stand.folder.path().join(format!("{name}.bas"));
        std::fs::write(&file, text).map_err(|error| error.to_string())?;
    }
    // The board comes with a program of its own, whose script is one of the folder.
    stand.board()?.bring("PRINT \"washers\"\n", "washers")?;
    let page = stand.page()?;
    page.wait(&format!("{NAMED} === 'washers'"), PATIENCE)?;
    page.push("#start")?;
    page.says("#message", "washers")?;
    page.says("#lamp", "Ready")?;
    load(&page, "job")?;
    // What cannot be loaded is told, and the list goes back to what is there.
    page.fill("#program", "broken.bas")?;
    page.says("#refused", "broken could not be loaded. The machine still holds job.")?;
    page.wait(&format!("{NAMED} === 'job'"), PATIENCE)?;
    page.push("#start")?;
    page.says("#message", "brackets")?;
    page.says("#lamp", "Ready")?;
    // One that nobody here knows is not started from this page, and not called something else.
    stand.board()?.bring("PRINT \"strange\"\n", "strange")?;
    page.wait(&format!("{NAMED}.startsWith('strange')"), PATIENCE)?;
    page.says("#hint", "whose script is not here")?;
    page.wait(&format!("{START}.disabled"), PATIENCE)?;
    let runs = stand.board()?.status()?.runs;
    // Past the page: the tool starts only what the page has shown, and never just anything.
    let past = "(async () => { const { Link } = await import('/link.js'); const link = new Link(); await new Promise(done => link.addEventListener('welcome', done)); await link.ask({ helm: true }); const told = []; for (const wish of [{ run: { bytes: 1, crc: 1 } }, 'start', { open: 'job.bas' }, 'upload', { input: [5, true] }]) try { await link.ask(wish); told.push('done') } catch (e) { told.push(e.message) } return told.join('; ') })()";
    let told = page.eval(past)?;
    let told = told.as_str().unwrap_or_default();
    assert!(told.starts_with("the board holds another program by now"), "{told}");
    assert!(!told.contains("done") && told.matches("only starts").count() == 4, "{told}");
    assert_eq!(stand.board()?.status()?.runs, runs, "something was started");
    Ok(())
}

/// Stop is in sight on every screen, whatever stands above it.
#[test]
fn stop_is_in_sight_on_a_phone_and_enlarged() -> Outcome<()> {
    let text = "DIM a AT 3000 LABEL \"Pieces\" MIN 1 MAX 500\nDIM b AT 3002 LABEL \"Rows\" MIN 1 MAX 9\nDIM c AT 3004 LABEL \"Depth\" MIN 1 MAX 9\nPRINT \"Insert a part that is as long as two lines of the page, and press Start\"\nWaitStart\n";
    let Some(mut stand) = Stand::with_world(text, "", &["--operator"])? else { return Ok(()) };
    let page = stand.page()?;
    load(&page, "job")?;
    for label in ["Pieces", "Rows", "Depth"] {
        page.push(&format!("[aria-label='{label} more']"))?;
        page.wait(
            &format!("document.querySelector('[aria-label={label}]').value === '1'"),
            PATIENCE,
        )?;
    }
    page.push("#start")?;
    page.says("#lamp", "Press Start")?;
    let sights = |what: &str| -> Outcome<()> {
        for (width, height) in [(390, 844), (844, 390), (720, 450), (320, 568), (1366, 768)] {
            page.window(width, height, true)?;
            page.rest()?;
            let seen = page.eval("[...document.querySelectorAll('#controls button')].every(b => { const r = b.getBoundingClientRect(); return r.top >= 0 && r.left >= 0 && r.bottom <= innerHeight && r.right <= innerWidth && r.height >= 64 && document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2) === b })")?;
            assert_eq!(seen, true, "{what}: a button is out of sight at {width} x {height}");
            let wide = page.eval("document.documentElement.scrollWidth")?.as_u64();
            assert!(wide <= Some(width.into()), "{what}: {wide:?} wide on {width}");
            picture(&page, &format!("operator-{what}-{width}"))?;
        }
        Ok(())
    };
    sights("running")?;
    // The machine is gone, with technical words as long as they come.
    stand.board = None;
    page.wait("document.querySelector('#lamp').dataset.state === 'lost'", PATIENCE)?;
    page.says("#lamp", "does not answer")?;
    page.wait(&format!("{START}.disabled"), PATIENCE)?;
    sights("lost")
}

/// The page's own words are in the browser's language; the script's stay the script's.
#[test]
fn the_page_speaks_the_browsers_language() -> Outcome<()> {
    let text = "DIM wanted AT 3000 LABEL \"Pieces\" MIN 1 MAX 9\nPRINT wanted\n";
    let Some(stand) = Stand::start(text, &["--operator"])? else { return Ok(()) };
    for (language, lamp, load, stop) in [
        ("de-CH,de,en", "Kein Programm", "job laden", "Stopp"),
        ("fr,en", "", "", "Arr\u{ea}t"),
        ("it,pt", "", "", "Stop"),
    ] {
        let page = stand.browser.page("about:blank")?;
        let own = serde_json::json!({ "userAgent": "Chrome", "acceptLanguage": language });
        page.call("Emulation.setUserAgentOverride", own)?;
        page.go(&stand.url)?;
        page.says("#stop", stop)?;
        if language.starts_with("de") {
            page.says("#lamp", lamp)?;
            page.says("#load", load)?;
            page.push("#load")?;
            page.says("#lamp", "Bereit")?;
            page.says("#hint", "Pieces: zwischen 1 und 9.")?;
        }
        page.window(390, 844, true)?;
        page.rest()?;
        let fits = "[...document.querySelectorAll('#controls button')].every(own => own.scrollWidth <= own.clientWidth && own.getBoundingClientRect().right <= innerWidth)";
        assert_eq!(page.eval(fits)?, true, "{language}: a word is cut");
        page.close()?;
    }
    Ok(())
}
