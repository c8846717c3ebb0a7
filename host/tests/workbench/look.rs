//! How it looks on a desk, a tablet and a phone, in the dark and in light.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::json;

use crate::cdp::{Outcome, Page};
use crate::stand::Stand;

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
