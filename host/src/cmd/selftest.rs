//! `pasapas selftest`: checks on a board what the emulator promises.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;

use super::console::{Console, Options};
use super::port::Port;
use crate::failure::Failure;
use crate::output;
use crate::selftest::{Ask, Plan, Report, Row, Trouble, Verdict, run};

/// `pasapas selftest`
#[derive(Debug, Args)]
pub struct Selftest {
    #[command(flatten)]
    port: Port,
    /// Motors, and what the outputs switch, are unplugged: outputs are switched, STEP pulses are made
    #[arg(long)]
    unplugged: bool,
    /// Each output has a wire to the input of its number (chain: 1 to 16; direct: 1 and 2)
    #[arg(long, requires = "unplugged")]
    jumpers: bool,
    /// Somebody wires pins to P2.2, P2.3 and P2.4 when the test asks for it (MSP430F5529)
    #[arg(long, requires = "unplugged")]
    captures: bool,
    /// Somebody is there to press Start, Stop and RST when the test asks for it
    #[arg(long)]
    hands: bool,
    /// Give up the program that the board holds
    #[arg(long)]
    replace: bool,
    /// How long the board's milliseconds are held against the computer's clock
    #[arg(long, value_name = "S", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    listen: u64,
    /// Write the report to this file too, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
}

impl Selftest {
    /// Measures, and prints a line for each check.
    ///
    /// # Errors
    /// The board does not answer, or holds a program; a check found something else than expected.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        let inputs = [options.profile.as_deref().map(Path::new)];
        output::keep_inputs(&[("--report", self.report.as_ref())], &inputs)?;
        let mut board = self.port.connect(options, console)?;
        let plan = Plan {
            unplugged: self.unplugged,
            jumpers: self.jumpers,
            captures: self.captures,
            hands: self.hands,
            replace: self.replace,
            rates: self.port.has_rate(),
            listen: Duration::from_secs(self.listen),
        };
        let mut written = Ok(());
        let mut tell = |row: &Row| {
            if written.is_ok() {
                written = match console.json() {
                    true => console.json_line(row),
                    false => console.result(&line(row)),
                };
            }
        };
        let report = run(&mut board, plan, &mut tell, &mut |ask| match ask {
            Ask::Press(what) => console.complain(what),
            Ask::Wire(wires) => {
                console.complain(&format!(
                    "take the wires at P2.2 to P2.4 off and wire {wires}; then press Enter"
                ));
                // At its end there is nobody to wait for.
                let _ = std::io::stdin().read_line(&mut String::new());
            }
        });
        written?;
        let report = report.map_err(|trouble| match trouble {
            Trouble::Board(error) => error.into(),
            Trouble::Words(text) => Failure::Board(text),
        })?;
        self.finish(&report, console)
    }

    fn finish(&self, report: &Report, console: &Console) -> Result<(), Failure> {
        let (bad, left) = (report.bad, report.left);
        if !console.json() {
            let done = report.rows.len() - left;
            console.result(&format!("{done} checks, {bad} not as expected, {left} left out\n"))?;
        }
        if let Some(path) = &self.report {
            let text = serde_json::to_string_pretty(report)
                .map_err(|error| Failure::Output(format!("no JSON can be made of it: {error}")))?;
            output::write(path, text + "\n")?;
        }
        if bad > 0 { Err(Failure::Run) } else { Ok(()) }
    }
}

/// `ok    step rate                       2000.1 steps/s (2000 steps/s, 20 more or less)`
fn line(row: &Row) -> String {
    let (word, rest) = match &row.verdict {
        Verdict::Good => ("ok", format!("{} ({})", row.found, row.expected)),
        Verdict::Bad => ("BAD", format!("{}, not {}", row.found, row.expected)),
        Verdict::Left(why) => ("-", format!("left out: {why}")),
    };
    format!("{word:4}  {:<34} {rest}\n", row.check)
}
