//! What hangs where: the pin tables of the firmware's manual, as pages and reports show them.

use lang::part::{self, chip::Family};
use lang::profile::Wiring;
use serde_json::{Value, json};

/// The manual, whose tables are the only ones.
const MANUAL: &str = include_str!("../../../../firmware/README.md");

/// The heading above the table of the board that chips of a family sit on.
const fn heading(family: Family) -> &'static str {
    match family {
        Family::Msp430 => "### MSP430G2553",
        Family::Msp430X => "### MSP430F5529",
    }
}

/// For each chip its pins and what they do with a wiring: `[[pins, function], ...]`.
pub fn tables(wiring: Wiring) -> Value {
    chips().map(|(chip, heading)| json!({ "chip": chip, "pins": table(heading, wiring) })).collect()
}

/// Rows of the table below a heading: the pins, and the column of the wiring.
pub fn table(heading: &str, wiring: Wiring) -> Vec<[String; 2]> {
    let lines = MANUAL.lines().skip_while(|line| *line != heading);
    let rows = lines
        .skip_while(|line| !line.starts_with("| pin "))
        .take_while(|line| line.starts_with('|'));
    let rows = rows.skip(2).filter_map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [pins, direct, chain] = cells[..] else { return None };
        let words = match wiring {
            Wiring::Direct => direct,
            Wiring::Chain if chain == "the same" => direct,
            Wiring::Chain => chain,
        };
        (!words.is_empty()).then(|| [pins.to_owned(), words.to_owned()])
    });
    rows.collect()
}

/// The chips' names and the headings of their tables.
pub fn chips() -> impl Iterator<Item = (&'static str, &'static str)> {
    part::chips().map(|chip| (chip.name, heading(chip.family)))
}
