//! Help of the editor while a user writes: Return, statements from a list, remedies by a click.

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// The editor's text.
const TEXT: &str = "document.querySelector('.ed .text').textContent";

fn is(page: &Page, text: &str) -> Outcome<()> {
    page.wait(&format!("{TEXT}.trimEnd() === {:?}", text.trim_end()), PATIENCE)
        .map_err(|error| format!("{error}; it is {:?}", page.eval(TEXT)))
}

#[test]
fn return_indents_and_closes_blocks() -> Outcome<()> {
    let Some(stand) = Stand::start("DIM i\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.end_of_script()?;
    page.type_text("\nFOR i = 1 TO 3\nPRINT i")?;
    is(&page, "DIM i\nFOR i = 1 TO 3\n  PRINT i\nNEXT")?;
    // One step of undo for the line and the block's end.
    page.end_of_script()?;
    page.type_text("\nif IN(3) THEN\n")?;
    is(&page, "DIM i\nFOR i = 1 TO 3\n  PRINT i\nNEXT\nif IN(3) THEN\n  \nend if")?;
    page.undo()?;
    is(&page, "DIM i\nFOR i = 1 TO 3\n  PRINT i\nNEXT\nif IN(3) THEN")?;
    // Who writes the end takes the one that is there; a nested one closes its own block.
    page.select_script("DIM i\nDO\nFOR i = 1 TO 3\nIF IN(3) THEN\nWait 1s\nELSE\nWait 2s\nEND IF\nNEXT i\nWait 3s\nLOOP UNTIL IN(4)\nHome\n")?;
    is(
        &page,
        "DIM i\nDO\n  FOR i = 1 TO 3\n    IF IN(3) THEN\n      Wait 1s\n    ELSE\n      Wait 2s\n    END IF\n  NEXT i\n  Wait 3s\nLOOP UNTIL IN(4)\nHome",
    )?;
    page.says("#problem-count", "no problems")?;
    // A block that is closed gets no second end, and one of a line none at all.
    page.press("Home", "Home", 36, "", 2)?;
    page.press("ArrowDown", "ArrowDown", 40, "", 0)?;
    page.press("End", "End", 35, "", 0)?;
    page.type_text("\n")?;
    page.has("DO\n  \n  FOR i")?;
    page.select_script("IF IN(3) THEN Wait 1s\nREPEAT 2 : Wait 1s : END REPEAT\nHome")?;
    is(&page, "IF IN(3) THEN Wait 1s\nREPEAT 2 : Wait 1s : END REPEAT\nHome")
}

#[test]
fn a_statement_comes_from_the_list_with_its_example() -> Outcome<()> {
    let Some(stand) = Stand::start("Home\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.end_of_script()?;
    page.push("#insert-statement")?;
    page.wait("document.activeElement === document.querySelector('#insert input')", PATIENCE)?;
    page.says("#insert", "Waits for an input")?;
    page.type_text("counts")?;
    page.wait("document.querySelectorAll('#insert .examples button').length === 1", PATIENCE)?;
    page.click("#insert .examples button")?;
    is(&page, "Home\nDIM i\nFOR i = 1 TO 5\n  MoveRel X, 2mm\nNEXT")?;
    page.says("#problem-count", "no problems")?;
    page.says("#sums", "runs to its end")?;
    // What is declared is not declared again, and Escape leaves the text as it is.
    page.push("#insert-statement")?;
    page.type_text("writes a line")?;
    page.click("#insert .examples button")?;
    is(&page, "Home\nDIM i\nFOR i = 1 TO 5\n  MoveRel X, 2mm\nNEXT\nPRINT \"piece \"; i")?;
    page.push("#insert-statement")?;
    page.press("Escape", "Escape", 27, "", 0)?;
    page.wait("!document.querySelector('#insert').open", PATIENCE)?;
    page.undo()?;
    is(&page, "Home\nDIM i\nFOR i = 1 TO 5\n  MoveRel X, 2mm\nNEXT")
}

#[test]
fn the_commonest_slips_are_mended_by_a_click() -> Outcome<()> {
    let Some(stand) = Stand::start("MoveAxe X 10\nREPEAT 2\n  Wait 500\n", &[])? else {
        return Ok(());
    };
    let page = stand.page()?;
    for title in ["Insert `,`", "Write `10mm`", "Insert `END REPEAT`", "Write `500ms`"] {
        let found = format!(
            "[...document.querySelectorAll('#problems .fix')].find(own => own.textContent === {title:?})"
        );
        page.wait(&format!("{found} !== undefined"), PATIENCE).map_err(|error| {
            format!("{error}; {:?}", page.eval("document.querySelector('#problems').textContent"))
        })?;
        page.eval(&format!("{found}.click()"))?;
        page.wait(&format!("{found} === undefined"), PATIENCE)?;
    }
    is(&page, "MoveAxe X, 10mm\nREPEAT 2\n  Wait 500ms\nEND REPEAT")?;
    page.says("#problem-count", "no problems")
}

/// A long text is laid out in blocks, which nobody notices: one writes and takes away across their borders.
#[test]
fn a_long_text_is_written_across_its_blocks() -> Outcome<()> {
    let text: String =
        (1..=1_000).map(|n| format!("G1 X{} Y{} F600 ' {n}\n", n % 100, n % 90)).collect();
    let Some(stand) = Stand::start(&text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.wait("document.querySelectorAll('.ed .text > div').length === 5", PATIENCE)?;
    let shows = |want: &str| {
        let all = "[...document.querySelectorAll('.ed .text > div')].map(own => own.textContent.endsWith('\\n') ? own.textContent : own.textContent + '\\n').join('')";
        let want = serde_json::to_string(want).map_err(|error| error.to_string())?;
        page.wait(&format!("{all} === {want}"), PATIENCE)
    };
    // Line 201 begins a block; the caret at its first letter.
    let border = text.lines().take(200).map(|line| line.len() + 1).sum::<usize>();
    let caret = || {
        page.eval("(() => { const t = document.querySelector('.ed .text'); t.focus(); getSelection().collapse(t.children[1].firstChild, 0) })()")
    };
    caret()?;
    page.press("Backspace", "Backspace", 8, "", 0)?;
    shows(&format!("{}{}", &text[..border - 1], &text[border..]))?;
    page.undo()?;
    shows(&text)?;
    caret()?;
    page.press("Delete", "Delete", 46, "", 0)?;
    shows(&format!("{}{}", &text[..border], &text[border + 1..]))?;
    page.undo()?;
    shows(&text)
}

/// What a key changes is read alone in a long text; it is what reading all of it gives, whatever is written, taken out
/// and undone: text, line starts and nodes.
#[test]
fn a_text_is_read_as_it_stands() -> Outcome<()> {
    let Some(stand) = Stand::start("Wait 1s\n", &[])? else { return Ok(()) };
    let page = stand.page()?;
    let write = r#"(async () => {
        const { Editor } = await import('/editor.js');
        const box = document.createElement('div'); box.style.height = '300px'; document.body.append(box);
        const e = new Editor(box, () => [], () => {}, () => {});
        const fresh = () => { let text = ''; const walk = document.createTreeWalker(e.text, NodeFilter.SHOW_TEXT | NodeFilter.SHOW_ELEMENT); for (let node; (node = walk.nextNode());) { if (node.nodeType === 3) text += node.data; else if (node.tagName === 'BR' ? node.nextSibling : text && !text.endsWith('\n')) text += '\n'; } return text; };
        let seed = 7; const rnd = n => { seed = (seed * 1103515245 + 12345) % 2147483648; return seed % n; };
        let fast = 0; const bad = [];
        for (const long of [20, 9000]) { e.set(Array.from({ length: long }, (_, n) => 'G1 X' + n + '\n').join(''));
          for (let k = 0; k < 300; k++) { const n = e.value.length, at = rnd(n + 1), op = rnd(9);
            const before = e.nodes;
            if (op < 3) { e.select(at, at); document.execCommand('insertText', false, 'x' + k); }
            else if (op === 3) { e.select(at, Math.min(n, at + rnd(30))); document.execCommand('delete'); }
            else if (op === 4) { e.select(at, at); document.execCommand('insertLineBreak'); }
            else if (op === 5) { e.select(at, Math.min(n, at + rnd(3000))); e.put('a\nb\nc'); }
            else if (op === 6) document.execCommand('undo');
            else if (op === 7) { if (e.place(at)[0].nodeType === 3 && at < n) e.poke(at, Math.min(n, at + 1), '7'); }
            else { await new Promise(d => setTimeout(d)); e.select(at, at); document.execCommand('insertText', false, 'y'); }
            if (e.nodes === before) fast++;
            const t = fresh(), lines = [0]; for (let i = t.indexOf('\n'); i >= 0; i = t.indexOf('\n', i + 1)) lines.push(i + 1);
            if (e.value !== t || lines.join() !== e.lines.join()) { bad.push([long, k, op, e.value.length, t.length, e.lines.length, lines.length]); e.read(); if (bad.length > 5) break; }
            for (const [start, node, l] of e.nodes) if (e.starts.get(node) !== start || node.length !== l || e.value.slice(start, start + l) !== node.data) { bad.push(['node', long, k, op]); break; }
          } }
        box.remove(); return bad.length ? JSON.stringify(bad) : fast > 200 ? 'the same' : `read again as a whole but ${fast} times`;
})()"#;
    assert_eq!(page.eval(write)?, "the same");
    Ok(())
}
