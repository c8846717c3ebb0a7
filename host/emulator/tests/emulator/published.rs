//! Published instruction vectors: one instruction each, registers, flags, code and data before and
//! after. The figures are those of the instruction tests of vivisect (Apache-2.0), which were made
//! independently of this emulator.
//!
//! Where they contradict the user's guide the guide decides, and the case is listed in `WRONG`.

use emulator::{Board, Config, Image, Part};

/// RAM where the vectors have their data, and their code: some write to it.
const PART: Part = Part {
    name: "vectors",
    ram: 0x1000..=0x4FFF,
    info: 0x5000..=0x50FF,
    flash: 0x6000..=0xFFFF,
    ..Part::G2553
};
const CODE: u16 = 0x4400;
const DATA: u16 = 0x1000;

/// Lines of the file (from 1) that expect what the guide excludes, each with what is wrong.
const WRONG: [(usize, &str); 11] = [
    (48, "BIT does not write its destination"),
    (49, "BIT does not write its destination"),
    (50, "BIT does not write its destination"),
    (51, "BIT does not write its destination"),
    (83, "DADD adds the carry"),
    (84, "DADD adds the carry"),
    (87, "DADD adds the carry"),
    (88, "DADD adds the carry"),
    (154, "X of a symbolic address counts from its own word"),
    (170, "X of a symbolic address counts from its own word"),
    (183, "bit 0 of the program counter is 0"),
];

struct State {
    registers: Vec<(usize, u16)>,
    flags: u16,
    code: Vec<u8>,
    data: Vec<u8>,
}

fn bytes(text: &str) -> Vec<u8> {
    if text == "-" {
        return Vec::new();
    }
    (0..text.len() / 2)
        .map(|i| u8::from_str_radix(&text[2 * i..2 * i + 2], 16).expect("hexadecimal"))
        .collect()
}

fn registers(text: &str) -> Vec<(usize, u16)> {
    text.split(',')
        .filter(|pair| *pair != "-")
        .map(|pair| {
            let (n, value) = pair.split_once('=').expect("register=value");
            (n.parse().expect("number"), u16::from_str_radix(value, 16).expect("hexadecimal"))
        })
        .collect()
}

fn state([regs, flags, code, data]: [&str; 4]) -> State {
    State {
        registers: registers(regs),
        flags: crate::vectors::flags(flags),
        code: bytes(code),
        data: bytes(data),
    }
}

fn run(before: &State) -> Board {
    let config = Config { part: PART, ..Config::default() };
    let mut board = Board::with_config(&config, &Image::default());
    board.bus_write16(crate::WDTCTL, crate::WDT_HOLD);
    for (start, content) in [(CODE, &before.code), (DATA, &before.data)] {
        for (at, byte) in (start..).zip(content) {
            board.poke8(at, *byte);
        }
    }
    for n in 1..16 {
        board.set_reg(n, 0);
    }
    for (n, value) in &before.registers {
        board.set_reg(*n, *value);
    }
    board.set_reg(0, CODE);
    board.set_reg(2, before.flags);
    board.step();
    board
}

fn difference(line: &str) -> Option<String> {
    let field: Vec<&str> = line.split_whitespace().collect();
    let &[code, data, regs, flags, regs_after, flags_after, code_after, data_after] =
        field.as_slice()
    else {
        panic!("malformed vector: {line}");
    };
    let board = run(&state([regs, flags, code, data]));
    let want = state([regs_after, flags_after, code_after, data_after]);
    for (n, value) in want.registers {
        if board.reg(n) != value {
            return Some(format!("R{n} is {:04x}, expected {value:04x}", board.reg(n)));
        }
    }
    if board.reg(2) != want.flags {
        return Some(format!("flags are {:04x}, expected {:04x}", board.reg(2), want.flags));
    }
    for (start, want) in [(CODE, want.code), (DATA, want.data)] {
        for (at, byte) in (start..).zip(want) {
            if board.peek8(at) != byte {
                return Some(format!(
                    "{at:04x} holds {:02x}, expected {byte:02x}",
                    board.peek8(at)
                ));
            }
        }
    }
    None
}

#[test]
fn published_vectors_hold_except_for_those_that_contradict_the_guide() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for (i, line) in include_str!("data/published.txt").lines().enumerate() {
        count += 1;
        if let Some(difference) = difference(line) {
            wrong.push((i + 1, format!("{line}: {difference}")));
        }
    }
    assert_eq!(count, 260);
    for (line, text) in &wrong {
        assert!(WRONG.iter().any(|(n, _)| n == line), "line {line}: {text}");
    }
    assert_eq!(wrong.len(), WRONG.len(), "all of them still differ");
}
