//! Inputs that a person draws on the timeline of the simulation.

use std::process::Command;

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

const SCRIPT: &str =
    "INPUT part = 3\nSetOut 1, ON\nWaitIn part, ON\nWait 500ms\nSetOut 1, OFF\nPRINT \"has it\"\n";

/// A place on the timeline: the row below that of the lines, and the part of its length.
fn place(page: &Page, row: usize, part: f64) -> Outcome<(f64, f64)> {
    page.centre("#rows")?;
    let at = page.eval("(() => { const r = document.querySelector('#rows').getBoundingClientRect(); return [r.x, r.y, r.width] })()")?;
    let at = [0, 1, 2].map(|n| at[n].as_f64().unwrap_or(0.0));
    Ok((at[0] + 90.0 + part * (at[2] - 98.0), at[1] + 4.0 + 18.0 * (row + 1) as f64 + 8.0))
}

#[test]
fn a_pulse_that_is_drawn_goes_on_with_the_run_and_into_the_scripts_world() -> Outcome<()> {
    let Some(stand) = Stand::start(SCRIPT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.wait("document.querySelector('#files').hidden", PATIENCE)?;
    // The dead end of a wait says which input it is, and one click leads on.
    page.says("#sim-fault", "Line 3 waits for an input")?;
    page.says("#sim-fault .pulse", "Input 3 comes")?;
    page.click("#sim-fault .pulse")?;
    page.says("#sums", "runs to its end")?;
    page.says("#prints", "has it")?;
    page.says("#sim-notes", "with 1 drawn pulse; Save writes it to job.rhai")?;
    page.says("#sim-notes", "Input 3 part is on from")?;
    // The world is beside the script, as text.
    page.says("#show-world", "job.rhai")?;
    page.push("#show-world")?;
    page.says("#world", "set_in(3, true)")?;
    page.wait("document.querySelector('#editor').hidden", PATIENCE)?;
    page.push("#show-script")?;
    page.wait(
        "document.querySelector('#world').hidden && document.querySelector('#editor').checkVisibility()",
        PATIENCE,
    )?;
    // A drag on the input's row draws another one: outputs have the first row.
    let (from, to) = (place(&page, 1, 0.8)?, place(&page, 1, 0.9)?);
    page.mouse("mousePressed", from)?;
    page.mouse("mouseMoved", to)?;
    page.mouse("mouseReleased", to)?;
    page.says("#sim-notes", "with 2 drawn pulses")?;
    // On an output's row a click shows that time, as before.
    let at = place(&page, 0, 0.5)?;
    page.mouse("mousePressed", at)?;
    page.mouse("mouseReleased", at)?;
    page.wait("+document.querySelector('#scrub').value > 4000 && +document.querySelector('#scrub').value < 6000", PATIENCE)?;
    // A click on one that was drawn takes it away.
    let at = place(&page, 1, 0.85)?;
    page.mouse("mousePressed", at)?;
    page.mouse("mouseReleased", at)?;
    page.says("#sim-notes", "with 1 drawn pulse;")?;
    // Without a mouse: the fields, and Remove.
    page.eval("(() => { document.querySelector('#pulse-form input').value = 700; document.querySelector('#pulse-add').click() })()")?;
    page.says("#sim-notes", "with 2 drawn pulses")?;
    page.says("#sim-notes", "is on from 700 ms to 900 ms")?;
    // Saved with the script, in the script's world, which other commands take.
    assert!(!stand.folder.path().join("job.rhai").exists());
    page.click("#save")?;
    page.says("#sim-notes", "with the world job.rhai and 2 drawn pulses")?;
    page.wait(
        "!document.querySelector('#sim-notes').textContent.includes('Save writes')",
        PATIENCE,
    )?;
    let world = stand.folder.path().join("job.rhai");
    let text = std::fs::read_to_string(&world).map_err(|error| error.to_string())?;
    assert!(text.contains("at(700, || set_in(3, true)); at(900, || set_in(3, false));"), "{text}");
    let done = Command::new(env!("CARGO_BIN_EXE_pasapas"))
        .arg("sim")
        .arg(stand.script())
        .arg("--world")
        .arg(&world)
        .output()
        .map_err(|error| error.to_string())?;
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let said = String::from_utf8_lossy(&done.stdout);
    assert!(said.starts_with("has it\n") && said.contains("done in line 6"), "{said}");
    // What a person writes into the world stays when a pulse is removed and saved.
    std::fs::write(&world, format!("// mine\n{text}")).map_err(|error| error.to_string())?;
    page.eval("document.querySelector('#sim-notes li button').click()")?;
    page.says("#sim-notes", "and 1 drawn pulse;")?;
    page.click("#save")?;
    page.wait(
        "!document.querySelector('#sim-notes').textContent.includes('Save writes')",
        PATIENCE,
    )?;
    let text = std::fs::read_to_string(&world).map_err(|error| error.to_string())?;
    assert!(
        text.starts_with("// mine\n") && text.matches("set_in(3, true)").count() == 1,
        "{text}"
    );
    Ok(())
}

#[test]
fn a_world_that_was_given_is_not_written() -> Outcome<()> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let world = folder.path().join("given.rhai");
    std::fs::write(&world, "at(100, || set_in(4, true));\n").map_err(|error| error.to_string())?;
    let name = world.display().to_string();
    let Some(stand) = Stand::start(SCRIPT, &["--world", &name])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sim-fault .pulse", "Input 3 comes")?;
    page.click("#sim-fault .pulse")?;
    page.says("#sums", "runs to its end")?;
    page.says("#sim-notes", "not kept in a file")?;
    page.click("#save")?;
    page.says("#notes", "Saved")?;
    let text = std::fs::read_to_string(&world).map_err(|error| error.to_string())?;
    assert_eq!(text, "at(100, || set_in(4, true));\n");
    assert!(!stand.folder.path().join("job.rhai").exists());
    // The script's own pulses are still there.
    page.says("#sim-notes", "1 drawn pulse")
}
