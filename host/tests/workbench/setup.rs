//! A new machine from its first wire to its profile, each step tried on the board.

use lang::profile::{InputRole, Profile};
use pasapas::client::status::Status;

use crate::cdp::{Outcome, Page};
use crate::look::picture;
use crate::stand::{PATIENCE, Stand};

/// What hands do to the machine: output 16 presses the emergency stop, whose contact opens; output 15
/// makes the motor of X lose steps.
const WORLD: &str = "set_in(4, true);\n\
    after_out(16, true, 0, || set_in(4, false));\n\
    after_out(16, false, 0, || set_in(4, true));\n\
    after_out(15, true, 0, || fault_at(0, \"stall\", \"X\", 60));\n";

/// Brings the machine to the board.
fn apply(page: &Page) -> Outcome<()> {
    page.push("#apply")?;
    page.wait("document.querySelector('#apply') === null", PATIENCE)
}

fn is_at(page: &Page, step: &str) -> Outcome<()> {
    page.says("#steps [aria-current=step]", step)
}

#[test]
fn a_machine_is_set_up_step_by_step_left_and_taken_up_again() -> Outcome<()> {
    let Some(mut stand) = Stand::with_world("Home\n", WORLD, &["--setup"])? else { return Ok(()) };
    let page = stand.page()?;
    page.fill("#name", "../bench")?;
    page.eval("document.querySelector('#begin').noValidate = true")?;
    page.push("#begin [type=submit]")?;
    page.says("#notes", "is no name for a machine")?;
    page.fill("#name", "bench")?;
    page.push("#begin [type=submit]")?;
    is_at(&page, "Wiring and pins")?;
    for (width, height, mobile) in [(1440, 900, false), (820, 1180, true), (390, 844, true)] {
        page.window(width, height, mobile)?;
        for dark in [false, true] {
            page.theme(dark)?;
            page.rest()?;
            let wide = page.eval("document.documentElement.scrollWidth")?.as_u64().unwrap_or(0);
            assert!(wide <= u64::from(width), "the set-up is {wide} wide on a screen of {width}");
            picture(&page, &format!("setup-{width}-{}", if dark { "dark" } else { "light" }))?;
        }
    }
    page.window(1440, 900, false)?;
    page.wait("document.querySelectorAll('svg.chip').length === 2", PATIENCE)?;
    // The picture of the chip that is connected is open.
    page.wait(
        "document.querySelector('#step details[open] > summary').textContent === 'MSP430F5529'",
        PATIENCE,
    )?;
    // One may look ahead and come back; nothing is tried by that.
    page.says("#of", "1 of 21")?;
    page.wait("document.querySelector('#previous').disabled", PATIENCE)?;
    page.push("#following")?;
    page.says("#of", "2 of 21")?;
    is_at(&page, "Link")?;
    page.push("#previous")?;
    is_at(&page, "Wiring and pins")?;
    assert_eq!(page.eval("document.querySelectorAll('#steps .done').length")?, 0);
    page.eval("[...document.querySelectorAll('#step button')].find(b => b.textContent === 'It is wired like this').click()")?;
    is_at(&page, "Link")?;
    // What the board does not answer is not done.
    page.push("#link-done")?;
    page.says("#notes", "bring the machine to the board first")?;
    apply(&page)?;
    page.push("#link-done")?;
    is_at(&page, "Switches")?;
    page.push("[aria-label='Press emergency stop']")?;
    stand.board()?.output(16, true)?;
    page.says("#step table", "input 4, on when open")?;
    stand.board()?.output(16, false)?;
    apply(&page)?;
    page.eval("[...document.querySelectorAll('#step button')].find(b => b.textContent === 'All of them answer').click()")?;
    is_at(&page, "Emergency stop")?;
    // Nothing but the board's own word counts.
    page.push("#stop-done")?;
    page.says("#notes", "has told no emergency stop")?;
    let at = page.centre("[aria-label='Jog X plus']")?;
    page.mouse("mousePressed", at)?;
    stand.board()?.until("a jog", |status| status.moving.contains(&'X'))?;
    stand.board()?.output(16, true)?;
    stand.board()?.until("F14", |status| {
        status.fault.as_deref() == Some("F14") && status.moving.is_empty()
    })?;
    page.mouse("mouseReleased", at)?;
    page.says("#now", "F14")?;
    page.push("#stop-done")?;
    is_at(&page, "Outputs")?;
    stand.board()?.output(16, false)?;
    page.push("#acknowledge")?;
    page.wait("!document.querySelector('#now').textContent.includes('F14')", PATIENCE)?;
    page.push("[aria-label='Output 1 on']")?;
    stand.board()?.until("output 1", |status| status.outputs == [1])?;
    page.push("[aria-label='Output 1 off']")?;
    stand.board()?.until("no output", |status| status.outputs.is_empty())?;
    // A name that no script can write is refused with one that it can.
    page.fill("[aria-label='Name of output 1']", "mill motor")?;
    page.push("[aria-label='Keep output 1']")?;
    page.says("#notes", "write \"mill_motor\"")?;
    page.fill("[aria-label='Name of output 1']", "mill_motor")?;
    page.push("[aria-label='Keep output 1']")?;
    page.wait("document.querySelector('#apply') !== null", PATIENCE)?;
    // Left, and taken up again.
    let url = stand.url.clone();
    page.go("about:blank")?;
    page.go(&url)?;
    page.wait("document.querySelector('#port')?.classList.contains('on')", PATIENCE)?;
    page.says("#file", "bench")?;
    page.push("[aria-label='Take output 2 out']")?;
    page.wait("document.querySelector('[aria-label=\"Take output 2 out\"]') === null", PATIENCE)?;
    apply(&page)?;
    page.eval("[...document.querySelectorAll('#step button')].find(b => b.textContent === 'Each was tried').click()")?;
    is_at(&page, "X: Direction")?;
    axis(&page, &mut stand, &X)?;
    // It may be written before its time, and says so.
    finish(&page, "steps were not tried")?;
    let report = report(&stand)?;
    assert!(report.contains("not tried"), "{report}");
    let early = std::fs::read_to_string(stand.folder.path().join("bench.toml"));
    let early = early.map_err(|error| error.to_string())?;
    assert!(
        early.contains("steps were tried on the machine.\n# Not tried: Y: Direction"),
        "{early}"
    );
    to_step(&page, "Y: Direction")?;
    axis(&page, &mut stand, &Y)?;
    axis(&page, &mut stand, &Z)?;
    finish(&page, "Every step was tried.")?;
    let text = std::fs::read_to_string(stand.folder.path().join("bench.toml"));
    let profile = Profile::parse(&text.map_err(|error| error.to_string())?);
    let profile = profile.map_err(|error| error.to_string())?;
    let stop = profile.input_with(InputRole::EmergencyStop).ok_or("no emergency stop")?;
    assert_eq!((stop.n, stop.invert), (4, true));
    let x = profile.x.ok_or("no X")?;
    assert_eq!((x.min_um, x.max_um, x.invert), (0, 250_000, false));
    assert_eq!((x.scale.steps, x.scale.um), (100, 987));
    assert!((2000..=2100).contains(&x.top_rate), "{}", x.top_rate);
    let y = profile.y.ok_or("no Y")?;
    assert_eq!((y.min_um, y.max_um, y.scale.steps * 101), (0, 180_000, y.scale.um * 10));
    let z = profile.z.ok_or("no Z")?;
    assert_eq!((z.min_um, z.max_um, z.invert), (-60_000, 0, false));
    assert_eq!(profile.outputs.len(), 1);
    let report = self::report(&stand)?;
    for words in [
        "the board told F14",
        "asked 10 mm, measured 9.87 mm",
        "asked 10 mm, measured 10.1 mm",
        "Z finds its switch at the positive end",
        "no step lost",
    ] {
        assert!(report.contains(words), "no {words} in {report}");
    }
    assert!(!report.contains("not tried"), "{report}");
    // A script names the machine that stands beside it.
    page.push("#leave")?;
    page.wait("!document.querySelector('#begin').hidden", PATIENCE)?;
    page.click("#back")?;
    page.wait("document.querySelector('#problem-count') !== null", PATIENCE)?;
    page.wait("document.querySelector('#port')?.classList.contains('on')", PATIENCE)?;
    page.select_script("PROFILE \"bench\"\nG0 X200\n")?;
    page.says("#problem-count", "no problems")?;
    page.says("#sums", "runs to its end")?;
    // Two thirds of 3000 steps/s at 101.3 steps per mm.
    page.says("#sums", "19.7 mm/s")
}

/// A trial of rates ends with its step, with the page and at Halt; no faster one follows it.
#[test]
fn a_trial_does_not_outlive_its_step() -> Outcome<()> {
    let Some(mut stand) = Stand::with_world("Home\n", WORLD, &["--setup"])? else { return Ok(()) };
    let mut page = stand.page()?;
    page.fill("#name", "bench")?;
    page.push("#begin [type=submit]")?;
    is_at(&page, "Wiring and pins")?;
    to_step(&page, "Link")?;
    apply(&page)?;
    for letter in ["X", "Y"] {
        for ends in ["step", "halt", "page"] {
            to_step(&page, &format!("{letter}: Top rate and ramp"))?;
            for (label, value) in [
                ("First rate, steps/s", "2000"),
                ("Fastest rate, steps/s", "8000"),
                ("Way, mm", "50"),
                ("Times", "20"),
            ] {
                page.fill(&format!("[aria-label='{label}']"), value)?;
            }
            page.push("#climb")?;
            page.says("#trying", &format!("{letter} is being tried at 2000 steps/s"))?;
            let at = |status: &Status| if letter == "X" { status.pos.x } else { status.pos.y };
            stand.board()?.until("a run", |status| at(status) > Some(1500))?;
            match ends {
                "step" => to_step(&page, "Emergency stop")?,
                "halt" => page.push("#halt")?,
                _ => {
                    page.close()?;
                    page = stand.page()?;
                }
            }
            page.wait("document.querySelector('#trying').hidden", PATIENCE)?;
            stand.board()?.until("rest", |status| status.moving.is_empty())?;
            let x = stand.board()?.status()?.pos;
            std::thread::sleep(std::time::Duration::from_millis(800));
            let after = stand.board()?.status()?;
            assert_eq!((after.pos, after.moving.len()), (x, 0), "{letter}, {ends}: it goes on");
        }
    }
    Ok(())
}

/// What the story finds of an axis.
struct Found {
    letter: char,
    /// Measured for 10 mm, and the scale that it makes.
    measured: &'static str,
    scale: &'static str,
    travel: [&'static str; 2],
    next: &'static str,
}

const X: Found = Found {
    letter: 'X',
    measured: "9.87",
    scale: "100 steps for 0.987 mm",
    travel: ["0", "250"],
    next: "Y: Direction",
};
const Y: Found = Found {
    letter: 'Y',
    measured: "10.1",
    scale: "10 steps for 0.101 mm",
    travel: ["0", "180"],
    next: "Z: Direction",
};
const Z: Found = Found {
    letter: 'Z',
    measured: "10",
    scale: "1 steps for 0.010 mm",
    travel: ["-60", "0"],
    next: "Profile and report",
};

/// Shows a step.
fn to_step(page: &Page, title: &str) -> Outcome<()> {
    let found = format!(
        "[...document.querySelectorAll('#steps button')].find(b => b.textContent.startsWith({title:?}))"
    );
    page.eval(&format!("{found}.click()"))?;
    is_at(page, title)
}

/// The last step: what it says, and the files.
fn finish(page: &Page, words: &str) -> Outcome<()> {
    to_step(page, "Profile and report")?;
    page.says("#step", words)?;
    page.push("#write")?;
    page.says("#written", "bench.toml and bench.report.html")
}

fn report(stand: &Stand) -> Outcome<String> {
    let report = std::fs::read_to_string(stand.folder.path().join("bench.report.html"));
    report.map_err(|error| error.to_string())
}

/// The steps of an axis.
fn axis(page: &Page, stand: &mut Stand, found: &Found) -> Outcome<()> {
    let letter = found.letter;
    let is = move |status: &Status, steps: i32| {
        let at = match letter {
            'X' => status.pos.x,
            'Y' => status.pos.y,
            _ => status.pos.z,
        };
        at == Some(steps) && status.moving.is_empty()
    };
    if letter == 'X' {
        // Wrong, turned round, wrong again, right.
        for _ in 0..2 {
            page.push("#wrong")?;
            page.wait("document.querySelector('#apply') !== null", PATIENCE)?;
            page.push("#plus")?;
            page.says("#notes", "bring the machine to the board first")?;
            apply(page)?;
        }
    }
    page.push("#plus")?;
    stand.board()?.until("+1 mm", |status| is(status, 100))?;
    page.push("#right")?;
    is_at(page, &format!("{letter}: Steps per millimetre"))?;
    page.fill("#asked", "10")?;
    page.push("#forward")?;
    stand.board()?.until("10 mm", |status| is(status, 1100))?;
    page.fill("#measured", found.measured)?;
    page.push("#take-scale")?;
    page.says("#step", found.scale)?;
    page.says("#step .found", &format!("asked 10 mm, measured {} mm", found.measured))?;
    page.wait("document.querySelector('#take-scale').matches(':enabled')", PATIENCE)?;
    if page.eval("document.querySelector('#apply') !== null")? == true {
        apply(page)?;
    }
    to_step(page, &format!("{letter}: Reference"))?;
    page.push("#home-done")?;
    page.says("#notes", &format!("{letter} is not homed: let it run"))?;
    page.push("#home")?;
    page.says("#notes", &format!("{letter} is homed."))?;
    page.says("#now", "homed")?;
    page.push("#home-done")?;
    is_at(page, &format!("{letter}: Travel"))?;
    page.fill("#lowest", found.travel[0])?;
    page.fill("#highest", found.travel[1])?;
    page.push("#take-travel")?;
    is_at(page, &format!("{letter}: Top rate and ramp"))?;
    apply(page)?;
    for (label, value) in [
        ("First rate, steps/s", "3000"),
        ("Fastest rate, steps/s", "3000"),
        ("Way, mm", "20"),
        ("Times", "1"),
    ] {
        page.fill(&format!("[aria-label='{label}']"), value)?;
    }
    page.push("#climb")?;
    page.says("#trials", "no step lost")?;
    page.says("#trial-words", "Up to 3000 steps/s no step was lost.")?;
    if letter == 'X' {
        // Steps that are lost on the way are seen at the switch.
        page.push("#climb")?;
        stand.board()?.until("a run", |status| status.pos.x > Some(1000))?;
        stand.board()?.output(15, true)?;
        page.says("#trials", "steps lost")?;
        page.says("#trial-words", "Steps were lost at the first rate")?;
        stand.board()?.output(15, false)?;
        page.push("#climb")?;
        page.says("#trial-words", "Up to 3000")?;
    }
    page.push("#take-rate")?;
    is_at(page, found.next)?;
    apply(page)
}
