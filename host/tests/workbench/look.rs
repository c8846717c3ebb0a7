//! How it looks on a desk, a tablet and a phone, in the dark and in light.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::json;

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// A program with everything to see.
const TEXT: &str = include_str!("../../../examples/pocket.bas");

/// Writes a picture of a page where they are wanted.
pub fn picture(page: &Page, name: &str) -> Outcome<()> {
    let Some(folder) = std::env::var_os("WORKBENCH_PICTURES").map(PathBuf::from) else {
        return Ok(());
    };
    std::fs::create_dir_all(&folder).map_err(|error| error.to_string())?;
    page.screenshot(&folder.join(format!("{name}.png")))
}

#[test]
fn every_part_fits_every_screen_in_both_themes() -> Outcome<()> {
    let Some(stand) = Stand::start(TEXT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.call("Log.enable", json!({}))?;
    page.says("#sums", "runs to its end")?;
    page.upload()?;
    page.push("#start")?;
    page.says("#run-state", "running")?;
    for (width, height, mobile) in [(1440, 900, false), (820, 1180, true), (390, 844, true)] {
        page.window(width, height, mobile)?;
        for dark in [false, true] {
            page.theme(dark)?;
            for tab in ["script", "simulate", "run", "machine", "pattern"] {
                if tab == "script" && width == 1440 {
                    continue;
                }
                page.eval(&format!("document.querySelector('[data-tab={tab}]').click()"))?;
                page.eval(
                    "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))",
                )?;
                let wide = page.eval("document.documentElement.scrollWidth")?.as_u64().unwrap_or(0);
                assert!(wide <= u64::from(width), "{tab} is {wide} wide on a screen of {width}");
                let stop = page.eval("(() => { const r = document.querySelector('#stop').getBoundingClientRect(); return r.x >= 0 && r.right <= innerWidth && r.bottom <= innerHeight && r.height >= 40 })()")?;
                assert_eq!(stop, true, "Stop is not in sight at {width}");
                // One button of a panel is the main one.
                let main = page.eval("[...document.querySelectorAll('main > section')].map(own => [...own.querySelectorAll('.main')].filter(button => button.checkVisibility()).length).every(count => count <= 1)")?;
                assert_eq!(main, true, "two main buttons in {tab}");
                let theme = if dark { "dark" } else { "light" };
                picture(&page, &format!("{tab}-{width}-{theme}"))?;
            }
        }
    }
    let problem = page.event("Runtime.exceptionThrown", Duration::from_millis(1));
    assert!(problem.is_err(), "the page's script failed: {problem:?}");
    let problem = page.event("Log.entryAdded", Duration::from_millis(1));
    assert!(problem.is_err(), "the browser complains: {problem:?}");
    Ok(())
}

/// What of a part cannot be brought in sight, and whether Stop is.
const LOST: &str = "(() => {
    const lost = [], shown = [...document.querySelectorAll('main > section.shown')];
    for (const own of document.querySelectorAll('main > section.shown :is(button, input, select, summary)')) {
        if (!own.checkVisibility() || own.closest('.gutter') || own.type === 'file') continue;
        own.scrollIntoView({ block: 'center' });
        const r = own.getBoundingClientRect(), there = document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2);
        if (!own.contains(there) && !there?.closest('label')?.contains(own)) lost.push(own.id || own.ariaLabel || own.textContent);
    }
    const stop = document.querySelector('#stop').getBoundingClientRect(), least = Math.min(...shown.map(own => own.getBoundingClientRect().height));
    if (stop.top < 0 || stop.bottom > innerHeight || stop.right > innerWidth) lost.push('Stop');
    if (least < 120) lost.push(`a part of ${least} px`);
    return lost.join(', ');
})()";

/// A phone on its side, and the page at 200 %: every part can be used, and Stop stays in sight.
#[test]
fn each_part_can_be_used_on_a_low_screen() -> Outcome<()> {
    let Some(stand) = Stand::start(TEXT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.says("#sums", "runs to its end")?;
    page.upload()?;
    page.wait("document.querySelector('.note') === null", PATIENCE)?;
    for (width, height) in [(844, 390), (720, 450), (390, 844)] {
        page.window(width, height, true)?;
        for tab in ["script", "simulate", "run", "machine", "pattern"] {
            page.eval(&format!("document.querySelector('[data-tab={tab}]').click()"))?;
            page.rest()?;
            assert_eq!(page.eval(LOST)?, "", "{tab} at {width} x {height}");
        }
    }
    Ok(())
}

/// The picture of the README: `WORKBENCH_PICTURES=FOLDER cargo test -p pasapas --test workbench readme` makes
/// it anew as `readme.webp`, which is `host/workbench.webp`.
#[test]
fn the_readmes_picture_is_small() -> Outcome<()> {
    let Some(stand) = Stand::start(TEXT, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.window(1160, 720, false)?;
    page.theme(false)?;
    page.says("#sums", "runs to its end")?;
    page.fill("#scrub", "6200")?;
    page.rest()?;
    let file = stand.folder.path().join("readme.webp");
    page.screenshot(&file)?;
    let bytes = std::fs::metadata(&file).map_err(|error| error.to_string())?.len();
    assert!((10_000..100_000).contains(&bytes), "the picture has {bytes} bytes");
    match std::env::var_os("WORKBENCH_PICTURES") {
        Some(folder) => page.screenshot(&PathBuf::from(folder).join("readme.webp")),
        None => Ok(()),
    }
}
