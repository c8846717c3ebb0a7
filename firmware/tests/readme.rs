//! The README's register table is that of `lang::wire`. `UPDATE_README=1 cargo test` rewrites it.

use lang::wire::{BLOCKS, LONG, NAMES, WRITABLE};

const BEGIN: &str = "<!-- registers: made from lang::wire by the test `readme` -->\n";
const END: &str = "<!-- end of registers -->\n";

fn table() -> String {
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

#[test]
fn the_register_table_is_that_of_the_code() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/README.md");
    let readme = std::fs::read_to_string(path).unwrap();
    let (before, rest) = readme.split_once(BEGIN).unwrap();
    let (shown, after) = rest.split_once(END).unwrap();
    if std::env::var_os("UPDATE_README").is_some() {
        std::fs::write(path, [before, BEGIN, &table(), END, after].concat()).unwrap();
        return;
    }
    assert_eq!(shown, table(), "run UPDATE_README=1 cargo test -p firmware --test readme");
}
