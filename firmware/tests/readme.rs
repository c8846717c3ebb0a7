//! Tables of the README are those of the code: registers of `lang::wire`, parts of `lang::part`.
//! `UPDATE_README=1 cargo test` rewrites them.

use lang::part::{Lack, PARTS, VIRTUAL};
use lang::wire::{BLOCKS, LONG, NAMES, WRITABLE};

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
            .filter(|bit| VIRTUAL.features & bit != 0 && part.lacks_feature(*bit))
            .map(|bit| Lack::Feature(bit).to_string())
            .collect();
        if !part.look_ahead {
            lacks.push("look-ahead".to_owned());
        }
        text += &format!(
            "| {} | {} | {} | {keeps} | {pool} | {} |\n",
            part.name,
            part.chip,
            part.room_for(false),
            lacks.join(", ")
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
    holds("registers", &registers());
    holds("parts", &parts());
}
