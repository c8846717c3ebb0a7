//! `pasapas build`: compiles, and reports how much of the device's limits a script uses.

use clap::Args;
use lang::back::Compiled;
use lang::back::MAX_DEPTH;
use lang::hir::{self, Storage};
use lang::image::Image;
use serde::Serialize;

use super::check::each;
use super::console::{Console, Options};
use super::part::Choice;
use super::script::{self, Script};
use crate::board::Build as Firmware;
use crate::failure::Failure;
use crate::output;

/// `pasapas build`
#[derive(Debug, Args)]
pub struct Build {
    /// Scripts
    #[arg(required = true, value_name = "FILE")]
    files: Vec<String>,
    /// Write the program's image
    #[arg(short, value_name = "IMG")]
    output: Option<String>,
    #[command(flatten)]
    part: Choice,
}

/// What `build` says of one file.
#[derive(Clone, Debug, Serialize)]
struct Figures {
    file: String,
    /// The smallest part on which it runs, or the one asked for.
    part: &'static str,
    statements: u32,
    image_bytes: usize,
    image_limit: usize,
    code_bytes: usize,
    table_bytes: usize,
    bytes_per_statement: f64,
    cells: usize,
    cells_limit: usize,
    stack: usize,
    stack_limit: usize,
    calls: usize,
    calls_limit: usize,
    keeps: usize,
    cell_map: Vec<CellUse>,
    registers: Vec<RegisterUse>,
}

/// Cells of one variable.
#[derive(Clone, Debug, Serialize)]
struct CellUse {
    name: String,
    cell: u32,
    count: u32,
}

/// Registers that an HMI sees a variable at.
#[derive(Clone, Debug, Serialize)]
struct RegisterUse {
    name: String,
    register: u16,
    /// What a panel calls it.
    label: Option<String>,
    /// The least that an operator may give it.
    min: i32,
    /// The greatest.
    max: i32,
}

impl Build {
    /// Compiles the files and prints the table.
    ///
    /// # Errors
    /// A script is wrong or too large for the device, or the image cannot be written.
    pub fn run(&self, options: &Options, console: &Console) -> Result<(), Failure> {
        if self.output.is_some() && self.files.len() > 1 {
            return Err(Failure::Usage("-o takes the image of one script".to_owned()));
        }
        let mut all = Vec::new();
        let result = each(&self.files, |file| {
            let mut script = script::load(file, options, console)?;
            script.keep_inputs(file, options, None, &[("-o", self.output.as_ref())])?;
            let compiled = script::compile_for_device(&script, console)?;
            let (compiled, build) = self.part.fit(&mut script, compiled, console)?;
            if let Some(path) = &self.output {
                output::write(path, &compiled.image)?;
            }
            let figures = figures(file, &script, &compiled, build);
            if console.json() {
                console.json_line(&figures)?;
            }
            all.push(figures);
            Ok(())
        });
        if !console.json() && !all.is_empty() {
            console.result(&table(&all))?;
        }
        result
    }
}

fn figures(file: &str, script: &Script, compiled: &Compiled, build: &Firmware) -> Figures {
    let program = &script.program;
    let image = Image::new(&compiled.image).ok();
    let cells = image.map(|image| build.part.cells_for(&image.header, image.events()));
    let mut cell_map: Vec<CellUse> = compiled
        .vars
        .iter()
        .map(|place| CellUse {
            name: program.var(place.var).name.clone(),
            cell: place.cell,
            count: place.len,
        })
        .collect();
    cell_map.sort_by_key(|own| own.cell);
    let mut registers = Vec::new();
    for var in &program.vars {
        let register = match var.storage {
            Storage::At(register) => register,
            Storage::Keep(n) => lang::wire::KEEPS + 2 * u16::from(n),
            Storage::Global | Storage::Local(_) => continue,
        };
        let hir::Panel { label, limits } = var.panel.clone();
        registers.push(RegisterUse {
            name: var.name.clone(),
            register,
            label,
            min: limits.least,
            max: limits.greatest,
        });
    }
    Figures {
        file: file.to_owned(),
        part: build.part.name,
        statements: compiled.statements,
        image_bytes: compiled.image.len(),
        image_limit: build.part.room_for(compiled.keeps > 0),
        code_bytes: compiled.code_bytes,
        table_bytes: compiled.table_bytes,
        bytes_per_statement: per_statement(compiled.code_bytes, compiled.statements),
        cells: compiled.cells,
        cells_limit: cells.unwrap_or(compiled.cells_available),
        stack: compiled.stack,
        stack_limit: MAX_DEPTH,
        calls: compiled.calls,
        calls_limit: MAX_DEPTH,
        keeps: compiled.keeps,
        cell_map,
        registers,
    }
}

/// Rounded to two digits, as it is compared.
fn per_statement(bytes: usize, statements: u32) -> f64 {
    (bytes as f64 / f64::from(statements.max(1)) * 100.0).round() / 100.0
}

fn table(all: &[Figures]) -> String {
    let width = all.iter().map(|own| own.file.chars().count()).max().unwrap_or(0).max(6);
    let mut text = format!(
        "{:width$}  statements   code  bytes/st  tables        image     cells  stack  calls  keep  part\n",
        "script"
    );
    for own in all {
        text += &format!(
            "{:width$}  {:10} {:6} {:9.2} {:7} {:>12} {:>9} {:>6} {:>6} {:5}  {}\n",
            own.file,
            own.statements,
            own.code_bytes,
            own.bytes_per_statement,
            own.table_bytes,
            format!("{}/{}", own.image_bytes, own.image_limit),
            format!("{}/{}", own.cells, own.cells_limit),
            format!("{}/{}", own.stack, own.stack_limit),
            format!("{}/{}", own.calls, own.calls_limit),
            own.keeps,
            own.part,
        );
    }
    match all {
        [one] => text += &details(one),
        _ => {
            let statements: u32 = all.iter().map(|own| own.statements).sum();
            let code: usize = all.iter().map(|own| own.code_bytes).sum();
            text += &format!(
                "{:width$}  {statements:10} {code:6} {:9.2}\n",
                "all",
                per_statement(code, statements)
            );
        }
    }
    text
}

/// Cells and registers of a single script.
fn details(own: &Figures) -> String {
    let mut text = String::new();
    if !own.cell_map.is_empty() {
        let cells = own.cell_map.iter().map(|cell| match cell.count {
            1 => format!("{} {}", cell.cell, cell.name),
            count => format!("{}..{} {}", cell.cell, cell.cell + count - 1, cell.name),
        });
        text += &format!("cells: {}\n", cells.collect::<Vec<_>>().join(", "));
    }
    for own in &own.registers {
        text += &format!("registers {}, {}: {}\n", own.register, own.register + 1, own.name);
    }
    text
}
