//! The readable and writable values of each board, for other tools: a row for every value.
//!
//! The rows are made from the register map, the machine's profile and the script on the board.

use lang::axis::Axis;
use lang::profile::Profile;
use lang::wire::{self, BLOCKS, Block, NAMES, Table, WRITABLE};
use serde::Serialize;

use super::known::Variable;

/// A value of a board.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Board.
    pub board: String,
    /// Unit by which the gateway's clients ask for it.
    pub unit: u8,
    /// `coil`, `discrete input`, `holding register`, `input register`.
    pub table: &'static str,
    /// Address as requests have it, from 0.
    pub address: u16,
    /// `bit`, `uint16`, or `int32` in two registers, low word first.
    pub kind: &'static str,
    /// Name.
    pub name: String,
    /// What one unit of the value is.
    pub of: &'static str,
    /// The value times this is in `of`.
    pub scale: f64,
    /// Whether it may be written, by the board.
    pub writable: bool,
    /// What it is.
    pub meaning: String,
}

/// The columns, in the order of [`Row::csv`].
pub const COLUMNS: &str = "board,unit,table,address,kind,name,of,scale,writable,meaning";

impl Row {
    /// A line of a CSV file (RFC 4180) without its end.
    pub fn csv(&self) -> String {
        let quote = |text: &str| {
            if text.contains([',', '"', '\n']) {
                format!("\"{}\"", text.replace('"', "\"\""))
            } else {
                text.to_owned()
            }
        };
        let Row { board, unit, table, address, kind, name, of, scale, writable, meaning } = self;
        let (name, meaning) = (quote(name), quote(meaning));
        format!("{board},{unit},{table},{address},{kind},{name},{of},{scale},{writable},{meaning}")
    }
}

/// What all rows of a board have alike.
struct Maker<'a> {
    board: &'a str,
    unit: u8,
    profile: &'a Profile,
    rows: Vec<Row>,
}

/// Every value of a board with this machine, and the variables of its program.
pub fn rows(board: &str, unit: u8, profile: &Profile, variables: &[Variable]) -> Vec<Row> {
    let mut maker = Maker { board, unit, profile, rows: Vec::new() };
    maker.ports();
    for (name, address, meaning) in NAMES {
        maker.register(name, *address, meaning.trim());
    }
    maker.variables(variables);
    maker.rows
}

/// The block of registers that an address lies in; that of holding registers where both kinds show it.
fn block(address: u16) -> Option<&'static Block> {
    let holds = |table: Table| {
        BLOCKS.iter().find(|block| {
            block.table == table as u8
                && (block.first..block.first + block.count).contains(&address)
        })
    };
    holds(Table::Holding).or_else(|| holds(Table::InputRegisters))
}

impl Maker<'_> {
    fn add(
        &mut self,
        (table, address): (&'static str, u16),
        kind: &'static str,
        name: String,
        (of, scale): (&'static str, f64),
        writable: bool,
        meaning: String,
    ) {
        let (board, unit) = (self.board.to_owned(), self.unit);
        self.rows.push(Row {
            board,
            unit,
            table,
            address,
            kind,
            name,
            of,
            scale,
            writable,
            meaning,
        });
    }

    /// Outputs and inputs by their names in the profile.
    fn ports(&mut self) {
        let named = |list: &[(i32, Option<String>)], n: u16| {
            let own = list.iter().find(|(own, _)| *own == i32::from(n));
            own.and_then(|(_, name)| name.clone())
        };
        let outputs: Vec<_> =
            self.profile.outputs.iter().map(|one| (one.n, one.name.clone())).collect();
        let inputs: Vec<_> =
            self.profile.inputs.iter().map(|one| (one.n, one.name.clone())).collect();
        for n in 1..=16 {
            let name = named(&outputs, n).unwrap_or_else(|| format!("OUTPUT_{n}"));
            let at = ("coil", wire::COILS + n - 1);
            self.add(at, "bit", name, ("", 1.0), true, format!("Output {n}."));
        }
        for n in 1..=17 {
            let name = named(&inputs, n).unwrap_or_else(|| format!("INPUT_{n}"));
            let at = ("discrete input", wire::INPUT_BITS + n - 1);
            self.add(at, "bit", name, ("", 1.0), false, format!("Input {n}."));
        }
    }

    fn register(&mut self, name: &str, address: u16, meaning: &str) {
        // The map says so of what not every part has. A master reads neighbours in one request, which
        // such a register would have refused as a whole; the part is not known here.
        if meaning.contains("Exception 2 on") {
            return;
        }
        let Some(block) = block(address) else { return };
        let table =
            if block.table == Table::Holding as u8 { "holding register" } else { "input register" };
        let writable = block.flags & WRITABLE != 0 && meaning.to_lowercase().contains("write");
        // The map says so of what it has for each axis.
        if !meaning.contains("32 bits for each axis") {
            let meaning = meaning.replace(['[', ']', '`'], "");
            return self.add(
                (table, address),
                "uint16",
                name.to_owned(),
                ("", 1.0),
                writable,
                meaning,
            );
        }
        let speed = meaning.contains("steps/s");
        for axis in Axis::ALL {
            let Some(machine) = self.profile.axis(axis) else { continue };
            let mm = f64::from(machine.scale.um) / f64::from(machine.scale.steps) / 1000.0;
            let at = (table, address + 2 * axis.index() as u16);
            let name = format!("{name}_{}", axis.letter());
            let of = if speed { "mm/s" } else { "mm" };
            self.add(at, "int32", name, (of, mm), false, meaning.to_owned());
        }
    }

    /// Variables that the script shows to the link.
    fn variables(&mut self, variables: &[Variable]) {
        for var in variables {
            let meaning = if var.keep { "KEEP" } else { "AT" };
            for (name, register) in var.values() {
                let at = ("holding register", register);
                let meaning = format!("{meaning} variable of the script.");
                self.add(at, "int32", name, var.unit(), true, meaning);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::rows;
    use crate::gateway::known::variables;
    use lang::front::source::Source;
    use lang::front::{ProfileChoice, compile};
    use lang::profile::Profile;
    use lang::wire;

    #[test]
    fn names_of_profile_script_and_map_stand_at_their_addresses() {
        let text = "DIM wanted AT 3000\nDIM list(3) AT 3010\nKEEP made\nmade = wanted + list(1)\n";
        let source = Source::new("t", text.to_owned());
        let (program, diags) = compile(&source, ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{diags:?}"));
        let mill = Profile::built_in("mill").expect("built in");
        let rows = rows("drill", 3, &mill, &variables(&program));
        let of = |name: &str| {
            let row = rows.iter().find(|row| row.name == name);
            row.unwrap_or_else(|| panic!("no {name}"))
        };
        assert_eq!((of("wanted").address, of("wanted").kind), (3000, "int32"));
        assert_eq!(of("list[2]").address, 3014);
        assert_eq!(of("made").address, wire::KEEPS);
        // The G2553 refuses it, and with it the whole request of a master that reads its neighbours.
        assert!(rows.iter().all(|row| !row.name.starts_with("TARGET_SPEEDS")));
        assert_eq!(of("ACTUAL_SPEEDS_X").address, wire::ACTUAL_SPEEDS);
        let y = of("MACHINE_POSITIONS_Y");
        assert_eq!((y.address, y.of, y.scale), (wire::MACHINE_POSITIONS + 2, "mm", 0.01));
        assert!(of("RUN_CONTROL").writable && !of("RUN_STATE").writable);
        assert_eq!(of("INPUTS").table, "input register");
        assert_eq!(of("OUTPUT_3").address, 2);
        assert!(rows.iter().all(|row| row.unit == 3 && !row.name.is_empty()));
        let line = of("RUN_CONTROL").csv();
        assert!(
            line.starts_with("drill,3,holding register,5050,uint16,RUN_CONTROL,,1,true,"),
            "{line}"
        );
    }
}
