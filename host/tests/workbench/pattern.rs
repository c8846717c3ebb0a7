//! The wizard for patterns: what it writes is simulated, and what it cannot write is reported.

use std::time::Instant;

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// The editor's text.
const TEXT: &str = "document.querySelector('.ed .text').textContent";

/// Answers the next question of the page.
fn answer(page: &Page, text: &str) -> Outcome<()> {
    page.eval(&format!("window.prompt = () => {text:?}")).map(drop)
}

#[test]
fn a_pattern_becomes_a_script_that_a_person_would_have_written() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("pattern")?;
    for (field, value) in [("x", "20"), ("y", "30"), ("surface", "-20")] {
        page.fill(&format!("#pattern [name={field}]"), value)?;
    }
    page.push("#show-pattern")?;
    page.says("#made", "FOR column = 0 TO 4")?;
    page.says("#pattern-words", "15 points.")?;
    assert_eq!(page.eval(TEXT)?, "Home\n", "showing changes nothing");
    answer(&page, "grid.bas")?;
    page.push("#new-pattern")?;
    page.says("#file", "grid.bas")?;
    page.has("FOR column = 0 TO 4")?;
    page.says("#sums", "runs to its end")?;
    let file = std::fs::read_to_string(stand.folder.path().join("grid.bas"));
    assert!(file.map_err(|error| error.to_string())?.contains("PROFILE \"mill\"\n"));
    // A piece of the same script, with names of its own.
    page.fill("#shape", "circle")?;
    page.fill("#act", "pulse")?;
    page.end_of_script()?;
    page.push("#insert-pattern")?;
    page.has("TABLE holes(2) = _")?;
    page.has("Pulse 3, 500ms")?;
    page.says("#problem-count", "no problems")?;
    page.says("#sums", "runs to its end")?;
    page.undo()?;
    page.wait(&format!("!{TEXT}.includes('TABLE holes')"), PATIENCE)
}

/// Rings of the accent's colour on the drawing: some points of each.
fn rings(page: &Page) -> Outcome<u64> {
    let js = "(() => { const c = document.querySelector('#path'), t = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
        t.fillStyle = getComputedStyle(c).getPropertyValue('--accent'); t.fillRect(0, 0, 1, 1);
        const want = t.getImageData(0, 0, 1, 1).data, all = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
        let n = 0; for (let i = 0; i < all.length; i += 4) if (Math.abs(all[i] - want[0]) + Math.abs(all[i + 1] - want[1]) + Math.abs(all[i + 2] - want[2]) < 12 && all[i + 3] === 255) n++; return n })()";
    Ok(page.eval(js)?.as_u64().unwrap_or(0))
}

/// Waits until so many of these points are painted.
fn until(page: &Page, what: &str, fits: impl Fn(u64) -> bool) -> Outcome<u64> {
    let end = Instant::now() + PATIENCE;
    loop {
        let n = rings(page)?;
        if fits(n) {
            return Ok(n);
        }
        if Instant::now() > end {
            return Err(format!("never drawn: {what}; {n} points"));
        }
    }
}

#[test]
fn points_are_on_the_drawing_as_one_types() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    let none = rings(&page)?;
    page.tab("pattern")?;
    page.says("#pattern-live", "15 points, ringed")?;
    let grid = until(&page, "15 rings", |n| n > none + 15 * 10)?;
    // One more column: three more rings, and no script was written.
    page.fill("#pattern [name=grid_columns]", "10")?;
    page.says("#pattern-live", "30 points, ringed")?;
    page.wait("document.querySelector('#made').hidden", PATIENCE)?;
    until(&page, "30 rings", |n| n > none + (grid - none) * 3 / 2)?;
    // Outside of the travel is told at once, in red; what is half typed is not.
    page.fill("#pattern [name=x]", "-500")?;
    page.wait("document.querySelector('#pattern-live').className === 'bad'", PATIENCE)?;
    page.says("#pattern-live", "outside")?;
    page.fill("#pattern [name=x]", "-")?;
    page.wait("document.querySelector('#pattern-live').textContent === ''", PATIENCE)?;
    until(&page, "no rings", |n| n <= none + 20)?;
    // They belong to the wizard: another tab shows the path alone.
    page.fill("#pattern [name=x]", "50")?;
    page.says("#pattern-live", "30 points")?;
    page.tab("simulate")?;
    page.wait("document.querySelector('#pattern-live').textContent === ''", PATIENCE)?;
    until(&page, "no rings", |n| n <= none + 20)?;
    assert_eq!(page.eval(TEXT)?, "Home\n");
    Ok(())
}

#[test]
fn points_of_a_file_lie_where_two_of_them_were_taught() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let file = |name: &str, text: &str| -> Outcome<std::path::PathBuf> {
        let path = stand.folder.path().join(name);
        std::fs::write(&path, text).map_err(|error| error.to_string())?;
        Ok(path)
    };
    let page = stand.page()?;
    page.tab("pattern")?;
    page.fill("#shape", "points")?;
    // A hostile file first: told in words, and nothing else happens.
    let hostile = "name,x,y\n\"<img src=x onerror=alert(1)>,1,2\n=cmd|' /C calc'!A0,1e999,NaN\n";
    page.choose("#points-file", &file("bad.csv", hostile)?)?;
    page.wait("document.querySelector('#pattern-words').className === 'bad'", PATIENCE)?;
    assert_eq!(page.eval("document.querySelectorAll('#pattern img').length")?, 0);
    page.push("#show-pattern")?;
    page.says("#pattern-words", "1 to 10000 points")?;
    let good = "name;x;y;side\nA;0;0;top\nB;100;0;top\nC;100;50;bottom\n";
    page.choose("#points-file", &file("parts.csv", good)?)?;
    page.says("#pattern-words", "parts.csv: a list, 3 points.")?;
    page.click("#pattern [value=bottom]")?;
    for (n, (name, x, y)) in [("A", "50", "20"), ("B", "50", "120")].into_iter().enumerate() {
        let n = n + 1;
        page.push("#add-pair")?;
        page.fill(&format!("[aria-label='Name of taught point {n}']"), name)?;
        page.fill(&format!("[aria-label='Taught X of point {n}']"), x)?;
        page.fill(&format!("[aria-label='Taught Y of point {n}']"), y)?;
    }
    page.fill("#pattern [name=surface]", "-10")?;
    page.push("#show-pattern")?;
    page.says("#made", "50mm, 20mm; _ ' A")?;
    page.says("#made", "50mm, 120mm ' B")?;
    page.says("#pattern-words", "turned by 90.000 degrees")?;
    page.fill("[aria-label='Taught Y of point 2']", "125")?;
    page.push("#show-pattern")?;
    page.says("#pattern-words", "(+5.00 %)")?;
    assert_eq!(page.eval(TEXT)?, "Home\n", "nothing was written");
    Ok(())
}

/// Untouched, the wizard writes what the machine can do; where Z counts downward, too.
#[test]
fn a_pattern_begins_within_the_machines_travel() -> Outcome<()> {
    for machine in ["mill", "charly"] {
        let Some(stand) = Stand::start("Home\n", &["--profile", machine])? else { return Ok(()) };
        let page = stand.page()?;
        page.says("#sums", "runs to its end")?;
        page.tab("pattern")?;
        for shape in ["grid", "circle", "line", "sockets"] {
            page.fill("#shape", shape)?;
            page.push("#show-pattern")?;
            page.says("#pattern-words", " points.")?;
            let words = page.eval("document.querySelector('#pattern-words').textContent")?;
            assert!(!words.to_string().contains("outside"), "{machine} {shape}: {words}");
            answer(&page, &format!("{machine}_{shape}.bas"))?;
            page.push("#new-pattern")?;
            page.says("#file", &format!("{machine}_{shape}.bas"))?;
            page.wait("!document.body.classList.contains('stale')", PATIENCE)?;
            page.says("#sums", "runs to its end")?;
        }
        // Glue needs no spindle.
        page.click("#spindle")?;
        page.push("#show-pattern")?;
        page.wait("!document.querySelector('#made').textContent.includes('M3')", PATIENCE)?;
        // What lies outside is told in red.
        page.fill("#pattern [name=x]", "5000")?;
        page.push("#show-pattern")?;
        page.says("#pattern-words", "outside")?;
        page.wait("document.querySelector('#pattern-words').className === 'bad'", PATIENCE)?;
    }
    Ok(())
}
