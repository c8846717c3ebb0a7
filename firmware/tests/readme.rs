//! Tables of the README are those of the code: registers, codes and commands of `lang::wire`, parts and pins of
//! `lang::part`.
//! `UPDATE_README=1 cargo test` rewrites them.

use lang::fault::Fault;
use lang::part::{F5529, Lack, PARTS, pins};
use lang::wire::command::{self, Argument};
use lang::wire::{
    BLOCKS, Called, Control, Direct, End, Exception, LONG, NAMES, Refusal, RunState, Stream,
    TraceKind, Upload, WRITABLE,
};

fn registers() -> String {
    let mut text = String::from("\n| block | functions | access |\n|---|---|---|\n");
    for block in BLOCKS {
        let last = block.first + (block.count - 1);
        let functions = match block.table {
            1 => "1, 5, 15",
            2 => "2",
            3 => "3, 6, 16",
            _ => "4",
        };
        let access = match (block.flags & WRITABLE != 0, block.flags & LONG != 0) {
            (false, _) => "read",
            (true, false) => "read, write",
            (true, true) => "read, write, 32 bits",
        };
        text += &format!("| {}..{last} | {functions} | {access} |\n", block.first);
    }
    text += "\n| address | name | meaning |\n|---|---|---|\n";
    for (name, address, meaning) in NAMES {
        text += &format!("| {address} | `{name}` | {} |\n", meaning.trim());
    }
    text + "\n"
}

fn parts() -> String {
    let mut text = String::from(
        "\n| firmware | chip | program, bytes | with KEEP | cells and stacks, bytes | lacks |\n\
         |---|---|---|---|---|---|\n",
    );
    for part in PARTS {
        let keeps = match part.room_for(true) {
            room if part.lacks_feature(lang::record::feature::KEEP) || room == 0 => "-".to_owned(),
            room => room.to_string(),
        };
        let [one, several] = part.pool;
        let pool =
            if one == several { one.to_string() } else { format!("{one}, interpolated {several}") };
        let mut lacks: Vec<String> = (0..16)
            .map(|bit| 1 << bit)
            .filter(|bit| F5529.features & bit != 0 && part.lacks_feature(*bit))
            .map(|bit| Lack::Feature(bit).to_string())
            .collect();
        if !part.look_ahead {
            let instead =
                if part.course_pool > 0 { " but by [slow points](#slow-points)" } else { "" };
            lacks.push(format!("look-ahead{instead}"));
        }
        if !part.at_limits {
            lacks.push("refusing what MIN and MAX of an AT variable exclude".to_owned());
        }
        if !part.halts {
            lacks.push("halts of a debugger before any effect, and its open calls".to_owned());
        }
        text += &format!(
            "| {} | {} | {} | {keeps} | {pool} | {} |\n",
            part.name,
            part.chip.name,
            part.room_for(false),
            lacks.join(", ")
        );
    }
    text + "\n"
}

/// The text of a doc comment without its links.
fn plain(text: &str) -> String {
    let mut text = text.trim().to_owned();
    while let Some(at) = text.find("](") {
        let end = at + text[at..].find(')').unwrap();
        text.replace_range(at..=end, "]");
    }
    text.replace("[`", "`").replace("`]", "`")
}

fn codes() -> String {
    let mut text = String::new();
    let tables = [
        Control::TABLE,
        RunState::TABLE,
        End::TABLE,
        Upload::TABLE,
        Refusal::TABLE,
        Stream::TABLE,
        Called::TABLE,
        TraceKind::TABLE,
        Direct::TABLE,
        Exception::TABLE,
    ];
    for (about, codes) in tables {
        text += &format!("\n{}\n\n| code | name | meaning |\n|---|---|---|\n", plain(about));
        for (number, name, meaning) in codes {
            text += &format!("| {number} | {name} | {} |\n", plain(meaning));
        }
    }
    text += "\nWhat `FAULT` shows, and `CNC_ALARM` while the fault is latched.\n\n\
             | code | fault | `CNC_ALARM` |\n|---|---|---|\n";
    for fault in Fault::ALL {
        let number = fault.number();
        text += &format!("| {number} | {} | {} |\n", fault.text(), Fault::alarm_of(number));
    }
    text + "\n"
}

fn commands() -> String {
    let mut text = String::from("\n| 2000 | from 2001 on | does |\n|---|---|---|\n");
    for command in command::ALL {
        let mut arguments = Vec::new();
        let mut address = lang::wire::COMMAND + 1;
        for argument in command.arguments {
            let (length, kind) = match argument {
                Argument::Word(..) => (1, ""),
                Argument::Long(..) => (2, ", 32 bits"),
                Argument::Float(..) => (2, ", float"),
            };
            arguments.push(format!("{address}: {}{kind}", argument.name()));
            address += length;
        }
        let example: Vec<String> = command.example().iter().map(u16::to_string).collect();
        text += &format!(
            "| {} | {}. Example: `{}` | {} |\n",
            command.number,
            arguments.join("; "),
            example.join(" "),
            plain(command.meaning)
        );
    }
    text + "\n"
}

/// The table between two comments that name it.
fn holds(name: &str, table: &str) {
    let (begin, end) = (
        format!("<!-- {name}: made by the test `readme` -->\n"),
        format!("<!-- end of {name} -->\n"),
    );
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    let readme = std::fs::read_to_string(path).unwrap();
    let (before, rest) = readme.split_once(&begin).unwrap();
    let (shown, after) = rest.split_once(&end).unwrap();
    if std::env::var_os("UPDATE_README").is_some() {
        std::fs::write(path, [before, &begin, table, &end, after].concat()).unwrap();
        return;
    }
    assert_eq!(shown, table, "run UPDATE_README=1 cargo test -p firmware --test readme");
}

// One test: both would rewrite the file.
#[test]
fn the_tables_are_those_of_the_code() {
    holds("pins", &format!("\n{}\n", pins::table(pins::ROWS, "pin")));
    holds("reserved", &format!("\n{}\n", pins::table(pins::RESERVED, "reserved pin")));
    holds("registers", &registers());
    holds("parts", &parts());
    holds("codes", &codes());
    holds("commands", &commands());
}
