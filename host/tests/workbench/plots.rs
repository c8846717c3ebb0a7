//! Variables, places and speeds over one time: held, and taken along as a table.

use crate::cdp::{Outcome, Page};
use crate::stand::{PATIENCE, Stand};

/// What the page exports now.
fn exported(page: &Page) -> Outcome<String> {
    page.eval("window.table = null")?;
    page.push("#export")?;
    page.wait("window.table !== null", PATIENCE)?;
    Ok(page.eval("window.table")?.as_str().unwrap_or_default().to_owned())
}

#[test]
fn places_and_variables_are_plotted_held_and_exported() -> Outcome<()> {
    let text =
        "DIM n\nFOR n = 1 TO 100\n  MoveAxe X, 5mm, 10mm/s\n  MoveAxe X, 0mm, 10mm/s\nNEXT\n";
    let Some(stand) = Stand::start(text, &[])? else { return Ok(()) };
    let page = stand.page()?;
    page.eval("(() => { const make = URL.createObjectURL; URL.createObjectURL = blob => { blob.text().then(own => { window.table = own }); return make.call(URL, blob) } })()")?;
    page.upload()?;
    page.wait("document.querySelector('#plot-tools').hidden", PATIENCE)?;
    for name in ["n", "X mm", "X mm/s"] {
        page.push(&format!("[aria-label='Plot {name}']"))?;
    }
    page.wait("document.querySelector('#chart').checkVisibility()", PATIENCE)?;
    page.push("#start")?;
    page.says("#run-state", "running")?;
    // Until the variable has changed twice: the axis has moved by then.
    page.wait("+document.querySelector('#vars .number')?.value >= 2", PATIENCE)?;
    page.push("#freeze")?;
    let table = exported(&page)?;
    assert!(table.starts_with("seconds,n,X mm,X mm/s\n"), "{table}");
    let rows: Vec<Vec<f64>> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|own| own.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    assert!(rows.len() > 5 && rows.windows(2).all(|two| two[0][0] <= two[1][0]), "{table}");
    assert!(rows.iter().any(|row| row[2] > 1.0) && rows.iter().any(|row| row[3] < -1.0), "{table}");
    // Held: what comes meanwhile is not in it.
    page.wait("+document.querySelector('#vars .number')?.value >= 3", PATIENCE)?;
    assert_eq!(exported(&page)?, table);
    page.push("#freeze")?;
    let more = exported(&page)?;
    assert!(more.starts_with(&table) && more.len() > table.len(), "{more}");
    page.click("#stop")
}
