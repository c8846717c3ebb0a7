//! Answers of the tool that come in another order than usual, and texts that come back to what they were.

use serde_json::json;

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// Nothing is being waited for: what is shown is the run of this very text.
const FRESH: &str =
    "!document.body.classList.contains('stale') && document.querySelector('#sim-words').hidden";

/// A page to which answers come as late as `slow` says, ms, and everything as late as `late` says.
fn slow_page(stand: &Stand) -> Outcome<Page> {
    let page = stand.browser.page("about:blank")?;
    let source = "window.slow = window.late = 0; window.WebSocket = class extends WebSocket { set onmessage(hear) { super.onmessage = e => { if (window.late) setTimeout(hear, window.late, e); else if (window.slow && typeof e.data === 'string' && e.data.startsWith('{\"done\"')) setTimeout(hear, window.slow, e); else hear(e); }; } };";
    page.call("Page.addScriptToEvaluateOnNewDocument", json!({ "source": source }))?;
    page.go(&stand.url)?;
    page.wait("document.querySelector('#port')?.classList.contains('on') === true", PATIENCE)?;
    Ok(page)
}

/// The picture of a text comes before the answer that numbers the text: it is taken when that comes.
#[test]
fn a_picture_before_its_number_is_taken() -> Outcome<()> {
    let Some(stand) = Stand::start("Wait 1s\n", &[])? else { return Ok(()) };
    let page = slow_page(&stand)?;
    page.says("#sums", "1.00 s")?;
    page.wait(FRESH, PATIENCE)?;
    page.eval("window.slow = 1500")?;
    page.select_script("Wait 2500ms\nQuux\n")?;
    page.says("#problem-count", "1 error")?;
    page.wait("document.querySelector('#sim-words').textContent.length > 0 && !document.querySelector('#sim-words').textContent.includes('…')", PATIENCE)?;
    page.select_script("Wait 3500ms")?;
    page.says("#sums", "3.50 s")?;
    page.wait(FRESH, PATIENCE)?;
    page.says("#problem-count", "no problems")
}

/// A key and its undoing before the tool heard of either: what was shown holds again.
#[test]
fn a_text_that_is_what_it_was_is_not_waited_for() -> Outcome<()> {
    let Some(stand) = Stand::start("Wait 1s\nQuux 1s\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    // A digit into the text, and out of it: no word that asks for a completion, which would bring it to the tool.
    let there_and_back = |at: u32| {
        page.eval(&format!("(() => {{ const t = document.querySelector('.ed .text'), before = t.textContent; t.focus(); getSelection().collapse(t.firstChild, {at}); document.execCommand('insertText', false, '5'); const other = t.textContent !== before; document.execCommand('delete'); return other && t.textContent === before && document.body.classList.contains('stale') }})()"))
    };
    page.says("#problem-count", "1 error")?;
    let marked = "CSS.highlights.get('error').size > 0";
    page.wait(marked, PATIENCE)?;
    // In the middle of what is marked.
    assert_eq!(there_and_back(10)?, true);
    page.wait(marked, PATIENCE)?;
    page.select_script("Wait 2s")?;
    page.says("#sums", "2.00 s")?;
    page.wait(FRESH, PATIENCE)?;
    page.says("#problem-count", "no problems")?;
    assert_eq!(there_and_back(5)?, true);
    page.wait(FRESH, PATIENCE)
}

/// Keys behind Save, before the page hears that it is saved: they are no other person's text.
#[test]
fn keys_behind_a_save_are_no_conflict() -> Outcome<()> {
    let Some(stand) = Stand::start("Wait 1s\n", &[])? else { return Ok(()) };
    let page = slow_page(&stand)?;
    page.wait(FRESH, PATIENCE)?;
    // What is saved is known here a second later; the hand goes on when the tool has it.
    page.eval("window.heard = 0; window.late = 1000; WebSocket.prototype.send = new Proxy(WebSocket.prototype.send, { apply: (send, own, [text]) => { if (text.includes('\"save\"')) setTimeout(() => { window.heard = 1 }, 200); return send.call(own, text) } }); null")?;
    page.end_of_script()?;
    page.type_text("' one ")?;
    page.press("s", "KeyS", 83, "", 2)?;
    page.wait("window.heard === 1", PATIENCE)?;
    page.type_text("two ")?;
    page.says("#notes", "Saved.")?;
    page.wait("document.querySelector('#split').hidden", PATIENCE)?;
    page.says("#file", "•")?;
    page.has("' one two ")?;
    page.press("s", "KeyS", 83, "", 2)?;
    page.wait("!document.querySelector('#file').textContent.includes('•')", PATIENCE)?;
    let file = std::fs::read_to_string(stand.script()).map_err(|error| error.to_string())?;
    assert!(file.contains("' one two"), "{file}");
    Ok(())
}
