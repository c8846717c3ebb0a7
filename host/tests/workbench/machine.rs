//! The machine by hand: what is held moves, what is let go, hidden, hung or dead rests.

use std::process::Command;
use std::time::{Duration, Instant};

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// Behind the last keep-alive the axis goes on for 300 ms at most; the rest is the machine's load.
const REST: Duration = Duration::from_millis(900);

/// Begins a held jog of X and waits until the board moves.
fn hold(page: &Page, stand: &mut Stand) -> Outcome<(f64, f64)> {
    page.tab("machine")?;
    let at = page.centre(".jog.Xp")?;
    page.mouse("mousePressed", at)?;
    stand.board()?.until("a jog", |status| status.moving.contains(&'X'))?;
    Ok(at)
}

/// The board rests within [`REST`], and stays so.
fn rests(stand: &mut Stand) -> Outcome<()> {
    let begun = Instant::now();
    let board = stand.board()?;
    board.until("rest", |status| status.moving.is_empty())?;
    assert!(begun.elapsed() < REST, "it rests after {:?}", begun.elapsed());
    let x = board.x()?;
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(board.x()?, x, "it moves again");
    Ok(())
}

#[test]
fn a_jog_moves_by_steps_and_as_long_as_it_is_held() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("machine")?;
    page.click("#steps button:nth-child(4)")?;
    page.click(".jog.Xp")?;
    stand.board()?.until("1 mm", |status| status.pos.x == Some(100) && status.moving.is_empty())?;
    page.says("#axes .place", "1.000")?;
    page.click(".jog.Xm")?;
    stand.board()?.until("0 mm", |status| status.pos.x == Some(0) && status.moving.is_empty())?;
    page.click("#steps button:nth-child(1)")?;
    let at = hold(&page, &mut stand)?;
    std::thread::sleep(Duration::from_millis(1000));
    let x = stand.board()?.x()?;
    page.mouse("mouseReleased", at)?;
    rests(&mut stand)?;
    assert!(x > 100, "{x} steps in a second at 3 mm/s: the hold did not go on");
    // The same with the keyboard: Space held, and a Tab that takes the focus away.
    page.eval("document.querySelector('.jog.Xm').focus()")?;
    page.key("keyDown", " ", "Space", 32, " ", 0)?;
    stand.board()?.until("a jog", |status| status.moving.contains(&'X'))?;
    page.press("Tab", "Tab", 9, "", 0)?;
    rests(&mut stand)?;
    // And with a finger that slides away and lifts.
    page.window(390, 844, true)?;
    let at = page.centre(".jog.Xp")?;
    page.touch("touchStart", &[at])?;
    stand.board()?.until("a jog", |status| status.moving.contains(&'X'))?;
    page.touch("touchMove", &[(at.0 + 60.0, at.1 + 90.0)])?;
    page.touch("touchEnd", &[])?;
    rests(&mut stand)
}

#[test]
fn a_page_that_dies_hangs_or_hides_in_a_held_jog_ends_it() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    // Hidden behind another page.
    let page = stand.page()?;
    hold(&page, &mut stand)?;
    let other = stand.browser.page("about:blank")?;
    other.front()?;
    rests(&mut stand)?;
    page.front()?;
    page.mouse("mouseReleased", (1.0, 1.0))?;
    // Busy: nothing is said, and when it goes on the old hold does not come back.
    page.wait("document.querySelector('.jog.held') === null", PATIENCE)?;
    hold(&page, &mut stand)?;
    let busy =
        "setTimeout(() => { const end = Date.now() + 1500; while (Date.now() < end); }, 0), true";
    page.eval(busy)?;
    rests(&mut stand)?;
    page.mouse("mouseReleased", (1.0, 1.0))?;
    // The whole browser sleeps, and wakes with its button still held.
    page.wait("document.querySelector('.jog.held') === null", PATIENCE)?;
    hold(&page, &mut stand)?;
    let all = |signal: &str| {
        let group = format!("-{}", stand.browser.pid());
        Command::new("kill")
            .args([signal, "--", &group])
            .status()
            .map_err(|error| error.to_string())
    };
    all("-STOP")?;
    rests(&mut stand)?;
    let group = format!("-{}", stand.browser.pid());
    Command::new("kill")
        .args(["-CONT", "--", &group])
        .status()
        .map_err(|error| error.to_string())?;
    let x = stand.board()?.x()?;
    std::thread::sleep(Duration::from_millis(800));
    assert_eq!(stand.board()?.x()?, x, "a sleeper moved the machine");
    page.mouse("mouseReleased", (1.0, 1.0))?;
    // Killed.
    page.wait("document.querySelector('.jog.held') === null", PATIENCE)?;
    hold(&page, &mut stand)?;
    Command::new("kill")
        .args(["-KILL", &stand.browser.pid().to_string()])
        .status()
        .map_err(|error| error.to_string())?;
    rests(&mut stand)
}

/// Closed or gone to another address with the button still down; the helm is free for the next page.
#[test]
fn a_page_that_is_closed_or_left_in_a_held_jog_ends_it() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    let page = stand.page()?;
    hold(&page, &mut stand)?;
    page.go("about:blank")?;
    rests(&mut stand)?;
    page.close()?;
    let page = stand.page()?;
    page.says("#helm", "You have the helm")?;
    hold(&page, &mut stand)?;
    page.close()?;
    rests(&mut stand)?;
    stand.page()?.says("#helm", "You have the helm")
}

#[test]
fn axes_are_referenced_sent_and_zeroed_and_ports_are_switched() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("machine")?;
    page.eval("(() => { const s = document.querySelector('#speed'); s.value = 100; s.dispatchEvent(new Event('input')) })()")?;
    page.push("#home")?;
    let homed = stand
        .board()?
        .until("all homed", |status| status.homed.len() == 3 && status.moving.is_empty())?;
    assert_eq!(homed.pos.values(), [Some(0); 3]);
    page.wait("document.querySelectorAll('.lamp.on[title=homed]').length === 3", PATIENCE)?;
    page.click("[aria-label='Go to X, mm']")?;
    page.type_text("12.5\n")?;
    stand
        .board()?
        .until("12.5 mm", |status| status.pos.x == Some(1250) && status.moving.is_empty())?;
    page.push("[aria-label='Zero X']")?;
    page.says("#axes .place", "0.000")?;
    assert_eq!(stand.board()?.x()?, 1250, "zeroing moves nothing");
    // Beyond its travel a homed axis does not go, and the page says so.
    page.eval("document.querySelector('[aria-label=\"Go to X, mm\"]').value = -500")?;
    page.push("[aria-label='Go to X']")?;
    page.says("#notes", "would leave its travel")?;
    assert_eq!(stand.board()?.x()?, 1250);
    page.click("#outputs summary")?;
    page.click("#inputs summary")?;
    page.click("[aria-label^='Output 3']")?;
    stand.board()?.until("output 3", |status| status.outputs == [3])?;
    page.wait(
        "document.querySelector('[aria-label^=\"Output 3\"]').ariaPressed === 'true'",
        PATIENCE,
    )?;
    page.click("[aria-label^='Output 3']")?;
    stand.board()?.until("no output", |status| status.outputs.is_empty())?;
    // A real input is forced, and set free again.
    page.click("[aria-label^='Input 5']")?;
    stand.board()?.until("input 5", |status| status.inputs.contains(&5))?;
    page.click("[aria-label^='Input 5']")?;
    page.click("[aria-label^='Input 5']")?;
    stand.board()?.until("no input", |status| status.inputs.is_empty())?;
    Ok(())
}

/// What is no number moves nothing, by button or by key, in any field; a comma is one.
#[test]
fn a_field_without_a_number_moves_nothing() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    let page = stand.page()?;
    page.tab("machine")?;
    page.eval("(() => { const s = document.querySelector('#speed'); s.value = 100; s.dispatchEvent(new Event('input')) })()")?;
    for (axis, n) in [("X", 0), ("Y", 1)] {
        let field = format!("[aria-label='Go to {axis}, mm']");
        let at = |status: &pasapas::client::status::Status| status.pos.values()[n];
        page.click(&field)?;
        page.type_text("20,5\n")?;
        stand
            .board()?
            .until("20.5 mm", |status| at(status) == Some(2050) && status.moving.is_empty())?;
        for wrong in ["", "-", "+", ".", ",", "1,2,3", "20.5.1", "x", "1e3", "0x10", "1 000"] {
            page.eval(&format!("document.querySelector({field:?}).value = {wrong:?}"))?;
            page.eval(&format!("document.querySelector({field:?}).focus()"))?;
            page.press("Enter", "Enter", 13, "\r", 0)?;
            page.click(&format!("[aria-label='Go to {axis}']"))?;
            page.says("#notes", "a number of mm")?;
        }
        page.eval("document.querySelector('#probe-way').value = ''")?;
        page.click(&format!("[aria-label='Probe {axis}']"))?;
        std::thread::sleep(Duration::from_millis(300));
        let status = stand.board()?.status()?;
        assert_eq!((at(&status), status.moving.len()), (Some(2050), 0), "{axis} moved");
    }
    Ok(())
}
