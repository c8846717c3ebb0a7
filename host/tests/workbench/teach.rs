//! Points by jogging become a table of the script, and are tried one by one.

use std::time::Duration;

use crate::cdp::Outcome;
use crate::stand::{PATIENCE, Stand};

/// The editor's text.
const TEXT: &str = "document.querySelector('.ed .text').textContent";

#[test]
fn points_are_recorded_named_corrected_ordered_and_tried() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("' A job.\nPROFILE \"mill\"\nHome\n")? else {
        return Ok(());
    };
    let page = stand.page()?;
    page.tab("machine")?;
    page.fill("#speed", "100")?;
    page.push("#home")?;
    stand.board()?.until("homed", |status| status.homed.len() == 3 && status.moving.is_empty())?;
    page.says("#teach", "No points yet")?;
    // Two places, reached by jogging: the first with a name.
    page.click("#steps button:nth-child(5)")?;
    page.push(".jog.Xp")?;
    stand
        .board()?
        .until("X 10", |status| status.pos.x == Some(1000) && status.moving.is_empty())?;
    page.says("#axes .axis:nth-child(1) .place", "10.000")?;
    page.eval("document.querySelector('#point-name').value = 'left clamp'")?;
    page.wait("!document.querySelector('.lamp.on[title=moves]')", PATIENCE)?;
    page.push("#record")?;
    let first = "TABLE points(3) = 10mm, 0mm, 0mm ' left clamp";
    page.has(first)?;
    page.wait("document.querySelectorAll('#teach li').length === 1", PATIENCE)?;
    page.push(".jog.Yp")?;
    stand
        .board()?
        .until("Y 10", |status| status.pos.y == Some(1000) && status.moving.is_empty())?;
    page.push(".jog.Zm")?;
    stand.board()?.until("Z", |status| status.pos.z == Some(-1000) && status.moving.is_empty())?;
    page.says("#axes .axis:nth-child(3) .place", "-10.000")?;
    page.wait("!document.querySelector('.lamp.on[title=moves]')", PATIENCE)?;
    page.push("#record")?;
    let both = "TABLE points(3) = _\n  10mm, 0mm, 0mm; _ ' left clamp\n  10mm, 10mm, -10mm\n";
    page.has(both)?;
    page.wait("document.querySelectorAll('#teach li').length === 2", PATIENCE)?;
    // It stands behind the declarations, and the script goes on compiling: nothing uses it yet.
    page.wait(&format!("{TEXT}.startsWith('\\' A job.\\nPROFILE \"mill\"\\nTABLE')"), PATIENCE)?;
    page.says("#problem-count", "1 warning")?;
    // A name, a number and the order are corrected.
    page.fill("[aria-label='Name of point 2']", "pin")?;
    page.wait(&format!("{TEXT}.includes('10mm, 10mm, -10mm \\' pin')"), PATIENCE)?;
    page.fill("[aria-label='X of pin, mm']", "12.5")?;
    page.wait(&format!("{TEXT}.includes('12.5mm, 10mm, -10mm \\' pin')"), PATIENCE)?;
    page.push("[aria-label='pin up']")?;
    let turned =
        "TABLE points(3) = _\n  12.5mm, 10mm, -10mm; _ ' pin\n  10mm, 0mm, 0mm ' left clamp\n";
    page.has(turned)?;
    // Tried: Z comes up first, and each axis rests at its place while the button is held.
    page.wait(
        "document.querySelector('#teach li:nth-child(2) .name')?.value === 'left clamp'",
        PATIENCE,
    )?;
    let at = page.centre("[aria-label='Go to left clamp while held']")?;
    page.mouse("mousePressed", at)?;
    stand.board()?.until("the place", |status| {
        status.pos.values() == [Some(1000), Some(0), Some(0)] && status.moving.is_empty()
    })?;
    page.mouse("mouseReleased", at)?;
    page.wait(
        "document.querySelector('#teach li:nth-child(2)').classList.contains('here')",
        PATIENCE,
    )?;
    // Who lets go on the way stops it, with the keyboard too.
    page.fill("#speed", "40")?;
    page.fill("[aria-label='X of pin, mm']", "250")?;
    page.has("250mm, 10mm, -10mm")?;
    page.wait("document.querySelector('[aria-label=\"X of pin, mm\"]').value === '250'", PATIENCE)?;
    std::thread::sleep(Duration::from_millis(400));
    page.eval("document.querySelector('[aria-label=\"Go to pin while held\"]').focus()")?;
    page.key("keyDown", " ", "Space", 32, " ", 0)?;
    stand.board()?.until("X moves", |status| status.moving.contains(&'X'))?;
    std::thread::sleep(Duration::from_millis(300));
    page.key("keyUp", " ", "Space", 32, "", 0)?;
    let rest = stand.board()?.until("rest", |status| status.moving.is_empty())?;
    std::thread::sleep(Duration::from_millis(700));
    let later = stand.board()?.status()?;
    assert_eq!(rest.pos, later.pos, "it goes on by itself");
    assert!(later.pos.x.is_some_and(|x| (1000..20_000).contains(&x)), "{later:?}");
    // The present place becomes the point; another goes out; undo brings it back.
    page.wait("!document.querySelector('.lamp.on[title=moves]')", PATIENCE)?;
    page.push("[aria-label='pin is here']")?;
    page.wait(&format!("!{TEXT}.includes('250mm')"), PATIENCE)?;
    page.push("[aria-label='pin out']")?;
    page.has(first)?;
    page.click(".ed .text")?;
    page.undo()?;
    page.wait(&format!("{TEXT}.includes('\\' pin')"), PATIENCE)?;
    page.wait("document.querySelectorAll('#teach li').length === 2", PATIENCE)
}

/// Pad, place, Home and Record stand beside the points, without scrolling, and the points are on the drawing.
#[test]
fn jogging_and_teaching_are_on_one_screen() -> Outcome<()> {
    let text = "DIM i\nTABLE points(3) = 10mm, 20mm, -1mm; 30mm, 20mm, -1mm\nFOR i = 0 TO 1\n  MoveAxe X, points(i, 0)\nNEXT\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.window(1366, 768, false)?;
    page.says("#sums", "runs to its end")?;
    page.eval("document.querySelector('[data-tab=machine]').click()")?;
    page.wait("document.querySelectorAll('#teach li').length > 0", PATIENCE)?;
    page.rest()?;
    let hidden = page.eval("(() => { const panel = document.querySelector('#machine').getBoundingClientRect(); return ['.jog.Xp', '.jog.Zm', '#axes .axis:last-child .place', '#home', '#steps', '#speed', '#record', '#table', '#teach li', '#teach li button', '[aria-label=\"Go to X\"]', '[aria-label=\"Probe Z\"]'].filter(own => { const r = document.querySelector(own).getBoundingClientRect(); return r.top < panel.top || r.bottom > panel.bottom || r.right > panel.right; }).join() })()")?;
    assert_eq!(hidden, "");
    assert_eq!(page.eval("document.querySelector('#machine').scrollWidth <= document.querySelector('#machine').clientWidth")?, true);
    // What has a name stands first; a fold tells which of the others is on.
    assert_eq!(
        page.eval("document.querySelector('#inputs .port').ariaLabel")?,
        "Input 9 reference X"
    );
    page.click("#inputs summary")?;
    page.click("[aria-label='Input 4']")?;
    page.says("#inputs summary", "on: 4")?;
    // The points are drawn while the machine is in sight, and only then.
    let marks = "(() => { const c = document.querySelector('#path'), t = document.createElement('canvas').getContext('2d'); t.fillStyle = getComputedStyle(c).getPropertyValue('--accent'); t.fillRect(0, 0, 1, 1); const [r, g, b] = t.getImageData(0, 0, 1, 1).data, d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 0; i < d.length; i += 4) n += d[i] === r && d[i + 1] === g && d[i + 2] === b && d[i + 3] === 255; return n })()";
    page.wait(&format!("{marks} > 20"), PATIENCE)?;
    page.eval("document.querySelector('[data-tab=simulate]').click()")?;
    page.wait(&format!("{marks} < 20"), PATIENCE)
}
