//! `pasapas size`: what the firmware uses, by module, against its budget.

use clap::Args;
use serde_json::json;

use super::console::{Console, Options};
use super::part::Choice;
use crate::board::size::{budget, sizes};
use crate::failure::Failure;

/// `pasapas size`
#[derive(Debug, Args)]
pub struct Size {
    #[command(flatten)]
    part: Choice,
}

impl Size {
    /// Prints the table.
    ///
    /// # Errors
    /// The image that this tool was built with is damaged.
    pub fn run(&self, _options: &Options, console: &Console) -> Result<(), Failure> {
        let build = self.part.or_default();
        let sizes = sizes(build.elf).map_err(Failure::Output)?;
        let budget = budget(build).map_err(Failure::Output)?;
        let mut modules: Vec<_> = sizes.modules.iter().collect();
        modules.sort_by_key(|(_, own)| std::cmp::Reverse((own.flash, own.ram)));
        if console.json() {
            for (module, own) in modules {
                console
                    .json_line(&json!({ "module": module, "flash": own.flash, "ram": own.ram }))?;
            }
            return console.json_line(&json!({
                "module": "all", "part": build.part.chip.name,
                "flash": sizes.total.flash, "flash_limit": budget.flash,
                "ram": sizes.total.ram, "ram_limit": budget.ram,
            }));
        }
        let width = modules.iter().map(|(module, _)| module.len()).max().unwrap_or(0).max(12);
        let mut text = format!("{:width$}  {:>6}  {:>5}\n", "module", "flash", "RAM");
        for (module, own) in modules {
            text += &format!("{module:width$}  {:6}  {:5}\n", own.flash, own.ram);
        }
        text += &format!(
            "{:width$}  {:6}  {:5}\n{:width$}  {:6}  {:5}\nbuilt for the {}\n",
            "all",
            sizes.total.flash,
            sizes.total.ram,
            "budget",
            budget.flash,
            budget.ram,
            build.part.chip.name
        );
        console.result(&text)
    }
}
