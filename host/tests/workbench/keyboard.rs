//! Users without a mouse, and users of a screen reader: every main job by keys alone, what the
//! board did of it, and the names that a screen reader gets.

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// Presses of Tab that lead once through everything, and more.
const MOST_TABS: usize = 400;

/// Everything that Tab should come to, and what is not right where it came.
const REACHABLE: &str = "(() => {
    const all = 'a[href], button, input, select, textarea, summary, [tabindex], [contenteditable]';
    window.wanted = [...document.querySelectorAll(all)].filter(e => e.tabIndex >= 0 && !e.matches(':disabled')
        && e.checkVisibility({ visibilityProperty: true }) && e.getClientRects().length);
    window.visited = new Set(); window.wrong = [];
    return window.wanted.length;
})()";
const VISIT: &str = "(() => {
    const e = document.activeElement;
    if (e === document.body || !e) return false;
    const before = visited.has(e), style = getComputedStyle(e.closest('.ed') ?? e), box = e.getBoundingClientRect();
    visited.add(e);
    const name = e.id || e.ariaLabel || e.textContent.trim().slice(0, 40) || e.outerHTML.slice(0, 80);
    if (style.outlineStyle === 'none' && style.boxShadow === 'none') wrong.push(`no mark at ${name}`);
    if (box.bottom < 0 || box.top > innerHeight || box.right < 0 || box.left > innerWidth) wrong.push(`${name} is out of sight`);
    return before;
})()";
const MISSED: &str = "wanted.filter(e => e.isConnected && !visited.has(e) && !e.matches(':disabled')).map(e => e.outerHTML.slice(0, 120))";

/// The keys of a hand that has no mouse.
trait Keys {
    /// The next thing; out of the script, too, which keeps Tab for itself until Escape.
    fn on(&self) -> Outcome<()>;
    /// Goes on until that has the focus.
    fn to(&self, selector: &str) -> Outcome<()>;
    /// Shows a part of the page by the arrows of its tabs.
    fn part(&self, name: &str) -> Outcome<()>;
    fn enter(&self) -> Outcome<()>;
    fn space(&self) -> Outcome<()>;
    fn arrow(&self, name: &str, vk: u32) -> Outcome<()>;
}

impl Keys for Page {
    fn on(&self) -> Outcome<()> {
        self.press("Escape", "Escape", 27, "", 0)?;
        self.press("Tab", "Tab", 9, "", 0)
    }

    fn to(&self, selector: &str) -> Outcome<()> {
        self.wait(
            &format!("document.querySelector({selector:?})?.matches(':disabled') === false"),
            PATIENCE,
        )
        .map_err(|error| format!("{selector}: {error}"))?;
        for _ in 0..MOST_TABS {
            if self.eval(&format!("document.activeElement?.matches({selector:?}) === true"))?
                == true
            {
                return Ok(());
            }
            self.on()?;
        }
        let at = self.eval("document.activeElement?.outerHTML.slice(0, 200)")?;
        Err(format!("no Tab leads to {selector}; the focus is at {at}"))
    }

    fn part(&self, name: &str) -> Outcome<()> {
        self.to("[role=tab][aria-selected=true]")?;
        for _ in 0..5 {
            if self.eval("document.activeElement.dataset.tab")? == name {
                return Ok(());
            }
            self.arrow("ArrowRight", 39)?;
        }
        Err(format!("no arrow leads to {name}"))
    }

    fn enter(&self) -> Outcome<()> {
        self.press("Enter", "Enter", 13, "\r", 0)
    }

    fn space(&self) -> Outcome<()> {
        self.press(" ", "Space", 32, " ", 0)
    }

    fn arrow(&self, name: &str, vk: u32) -> Outcome<()> {
        self.press(name, name, vk, "", 0)
    }
}

/// Tab comes to everything that may be used, in sight and marked, and leaves it again.
fn walk(page: &Page, what: &str) -> Outcome<()> {
    page.rest()?;
    let wanted = page.eval(REACHABLE)?.as_u64().unwrap_or(0);
    assert!(wanted > 3, "{what}: nothing can be used");
    let mut again = 0;
    for _ in 0..MOST_TABS {
        page.on()?;
        again = if page.eval(VISIT)? == true { again + 1 } else { 0 };
        // Twice round: behind its last thing the page hands the focus to the browser, which hands it back to the first one
        // in its own time. When it has not come by this look at it, the next Tab leads on from there unseen.
        if again > wanted {
            break;
        }
    }
    assert_eq!(page.eval(MISSED)?.to_string(), "[]", "{what}: Tab never comes to these");
    assert_eq!(page.eval("wrong")?.to_string(), "[]", "{what}");
    Ok(())
}

const TEXT: &str = "DIM wanted AT 3000 LABEL \"Pieces\" MIN 1 MAX 9\nINPUT lid = 5\nPRINT wanted\nIF IN(lid) THEN PRINT 2\nMoveAxe X, 5mm\n";

#[test]
fn tab_leads_through_the_whole_page() -> Outcome<()> {
    let Some(stand) = Stand::start(TEXT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.upload()?;
    page.click("header h1")?;
    for part in ["simulate", "run", "machine", "pattern"] {
        page.part(part)?;
        walk(&page, part)?;
    }
    // On a small screen the script is a part like the others.
    page.window(820, 1180, false)?;
    page.part("script")?;
    walk(&page, "script")?;
    // And on a phone, in the dark, each of them.
    page.window(390, 844, false)?;
    page.theme(true)?;
    for part in ["simulate", "run", "machine", "pattern"] {
        page.part(part)?;
        walk(&page, &format!("{part} on a phone"))?;
    }
    page.theme(false)?;
    page.window(1440, 900, false)?;
    // A board that is emulated has its buttons here; Start is held as a finger holds it.
    page.part("machine")?;
    page.to("#press-start")?;
    page.key("keyDown", " ", "Space", 32, " ", 0)?;
    page.wait("document.querySelector('#console').textContent.includes('run 1 begins')", PATIENCE)?;
    page.key("keyUp", " ", "Space", 32, "", 0)?;
    page.part("run")?;
    page.fill("[aria-label=wanted]", "1")?;
    page.close()?;
    let operator = stand.browser.page(&stand.url.replace("/#", "/operator#"))?;
    operator.wait("document.querySelectorAll('#program option').length > 0", PATIENCE)?;
    // The run has ended, the helm is free, and this page has taken it.
    operator.wait("document.querySelector('#start').matches(':enabled')", PATIENCE)?;
    operator.says("#quantities", "Pieces")?;
    walk(&operator, "the operator's page")
}

#[test]
fn every_main_job_is_done_by_keys_alone() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1ms\n")? else { return Ok(()) };
    let page = stand.page()?;
    // Written, with a breakpoint, and saved.
    page.to(".ed .text")?;
    page.select_all()?;
    page.type_text("DIM n\nPRINT \"hello\"\nMoveAxe X, 30mm, 10mm/s\nSetOut 1, ON\n")?;
    page.arrow("ArrowUp", 38)?;
    page.press("F9", "F9", 120, "", 0)?;
    page.wait(
        "document.querySelector('.ed .gutter [aria-pressed=true], .ed .gutter .break') !== null",
        PATIENCE,
    )?;
    page.press("F9", "F9", 120, "", 0)?;
    page.press("s", "KeyS", 83, "", 2)?;
    page.says("#notes", "Saved.")?;
    let saved = std::fs::read_to_string(stand.script()).map_err(|error| error.to_string())?;
    assert!(saved.contains("MoveAxe X, 30mm"), "{saved}");
    // Simulated, and looked at in time.
    page.part("simulate")?;
    page.says("#sums", "runs to its end")?;
    page.to("#scrub")?;
    page.press("End", "End", 35, "", 0)?;
    page.wait("document.querySelector('#scrub').value === '10000'", PATIENCE)?;
    page.press("Home", "Home", 36, "", 0)?;
    page.to("#play")?;
    page.space()?;
    page.wait("+document.querySelector('#scrub').value > 0", PATIENCE)?;
    // Brought to the board, run, paused, gone on with, stopped.
    page.part("run")?;
    page.to("#upload")?;
    page.enter()?;
    page.says("#notes", "The program is on the board.")?;
    page.to("#start")?;
    page.space()?;
    stand.board()?.until("a run", |own| own.state == "running" && !own.moving.is_empty())?;
    page.to("#pause")?;
    page.enter()?;
    stand.board()?.until("a pause", |own| own.state == "paused")?;
    page.to("#resume")?;
    page.enter()?;
    stand.board()?.until("a run", |own| own.state == "running")?;
    page.to("#stop")?;
    page.enter()?;
    let rest = stand.board()?.until("its end", |own| own.state == "ready")?;
    assert_eq!(rest.last_end, Some("stopped"));
    page.to("#feed")?;
    page.arrow("ArrowRight", 39)?;
    page.says("#feed-value", "105 %")?;
    // The machine by hand: held, by steps, to a place, to its switch.
    page.part("machine")?;
    page.to("[aria-label='Jog X plus']")?;
    page.key("keyDown", " ", "Space", 32, " ", 0)?;
    stand.board()?.until("a jog", |own| !own.moving.is_empty())?;
    page.key("keyUp", " ", "Space", 32, "", 0)?;
    stand.board()?.until("rest", |own| own.moving.is_empty())?;
    page.to("#steps button:nth-child(4)")?;
    page.space()?;
    page.says("#step-words", "each press moves 1 mm")?;
    let from = stand.board()?.x()?;
    page.to("[aria-label='Jog X minus']")?;
    page.enter()?;
    stand.board()?.until("1 mm", |own| own.pos.x == Some(from - 100) && own.moving.is_empty())?;
    page.to("[aria-label='Go to X, mm']")?;
    page.type_text("12")?;
    page.enter()?;
    stand.board()?.until("12 mm", |own| own.pos.x == Some(1200) && own.moving.is_empty())?;
    page.to("[aria-label='Zero X']")?;
    page.enter()?;
    page.wait(
        "document.querySelector('[aria-label=\"X position\"]').textContent === '0.000'",
        PATIENCE,
    )?;
    page.to("[aria-label='Home X']")?;
    page.enter()?;
    stand.board()?.until("home", |own| own.homed == ['X'] && own.moving.is_empty())?;
    page.to("#outputs .port:nth-child(2)")?;
    page.space()?;
    stand.board()?.until("output 2", |own| own.outputs == [2])?;
    page.to("#inputs summary")?;
    page.enter()?;
    page.to("[aria-label^='Input 3']")?;
    page.space()?;
    stand.board()?.until("input 3", |own| own.inputs.contains(&3))?;
    // A point is taught, and a pattern inserted.
    page.to("#record")?;
    page.enter()?;
    page.has("TABLE")?;
    page.part("pattern")?;
    page.to("#shape")?;
    page.arrow("ArrowDown", 40)?;
    page.wait("document.querySelector('#shape').value === 'circle'", PATIENCE)?;
    page.to("#insert-pattern")?;
    page.enter()?;
    page.has("FOR ")
}

#[test]
fn a_screen_reader_is_told_every_part_and_what_changes() -> Outcome<()> {
    let Some(stand) = Stand::start(TEXT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.upload()?;
    page.says("#vars", "wanted")?;
    let shown: [(&str, &[&str]); 5] = [
        (
            "script",
            &[
                "textbox \"Script\"",
                "combobox \"Open another script\"",
                "button \"Breakpoint in line 1\"",
                "button \"Save\"",
            ],
        ),
        (
            "simulate",
            &["slider \"Time of the simulation\"", "button \"Play\"", "image \"Tool path"],
        ),
        (
            "run",
            &[
                "status \"\"",
                "log \"What the program prints\"",
                "button \"Start\"",
                "group \"Override\"",
                "slider \"Feeds 100 %\"",
                "textbox \"wanted\"",
                "checkbox \"Plot wanted\"",
                "rowheader \"wanted\"",
            ],
        ),
        (
            "machine",
            &[
                "group \"By hand\"",
                "group \"Step in mm\"",
                "tab \"Machine\"",
                "tabpanel \"Machine\"",
                "button \"Jog Z minus\"",
                "button \"Home Z\"",
                "textbox \"Go to Y, mm\"",
                "button \"Input 11 reference Z\"",
                "button \"Output 1 spindle\"",
                "button \"Record this place\"",
                "slider \"Speed",
                "status \"X position\"",
                "image \"X homed: off\"",
                "button \"Input 5 lid\"",
                "button \"Start button\"",
                "link \"Set up a new machine, step by step\"",
            ],
        ),
        (
            "pattern",
            &[
                "combobox \"Pattern\"",
                "textbox \"Columns\"",
                "button \"Insert at the caret\"",
                "group \"At each point\"",
            ],
        ),
    ];
    for (part, wanted) in shown {
        page.tab(part)?;
        page.rest()?;
        let roles = page.roles()?;
        for own in [
            "banner \"\"",
            "main \"\"",
            "tablist \"Parts of the workbench\"",
            "heading \"Pasapas\"",
        ] {
            assert!(roles.contains(own), "{part}: no {own} in\n{roles}");
        }
        for own in wanted {
            assert!(roles.contains(own), "{part}: no {own} in\n{roles}");
        }
        nameless(part, &roles);
    }
    // What is not shown is not read; what is on is told as on.
    let roles = page.roles()?;
    assert!(!roles.contains("button \"Jog"), "a part that is hidden is read:\n{roles}");
    page.tab("machine")?;
    page.click("#inputs .port")?;
    page.wait("document.querySelector('#inputs .port').ariaPressed === 'true'", PATIENCE)?;
    assert!(
        page.states("button")?
            .lines()
            .any(|line| line.starts_with("Input 5") && line.ends_with("pressed=true"))
    );
    // What goes wrong is read out at once.
    page.eval("document.querySelector('#probe-way').value = ''; document.querySelector('[aria-label=\"Go to X\"]').click()")?;
    page.wait("document.querySelector('#notes [role=alert]') !== null", PATIENCE)?;
    assert!(page.roles()?.contains("alert"), "an error is not read out");
    for (address, wanted) in [
        ("/operator#", ["combobox \"Program\"", "button \"Start\"", "textbox \"Pieces\""]),
        ("/setup#", ["navigation \"Steps\"", "textbox \"Name\"", "button \"Begin\""]),
    ] {
        let other = stand.browser.page(&stand.url.replace("/#", address))?;
        other.wait("document.querySelector('#board, #lamp') !== null", PATIENCE)?;
        std::thread::sleep(std::time::Duration::from_millis(500));
        let roles = other.roles()?;
        for own in wanted.iter().filter(|own| !own.starts_with("navigation")) {
            assert!(roles.contains(own), "{address}: no {own} in\n{roles}");
        }
        nameless(address, &roles);
    }
    Ok(())
}

/// Nothing that can be used is without a name.
fn nameless(part: &str, roles: &str) {
    let used = [
        "button",
        "slider",
        "textbox",
        "spinbutton",
        "combobox",
        "checkbox",
        "link",
        "tab",
        "image",
    ];
    let found: Vec<&str> = roles
        .lines()
        .filter(|line| used.iter().any(|role| *line == format!("{role} \"\"")))
        .collect();
    assert!(found.is_empty(), "{part}: {found:?} in\n{roles}");
}
