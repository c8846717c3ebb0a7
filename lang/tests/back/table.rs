//! The opcode table against the disassembler, and against what the compiler really uses.

use lang::back::Compiled;
use lang::back::disasm::{self, Insn};
use lang::front::ProfileChoice;
use lang::image::{self, HEADER, Image, at};
use lang::isa::{Op, Operands, ROWS};
use lang::profile::Profile;
use lang::record::MachineRecord;
use std::collections::BTreeSet;

/// An image whose code is these bytes; it need not pass the check.
fn with_code(code: &[u8]) -> Vec<u8> {
    let mut bytes = super::compile("PRINT \"text\"").image;
    let head = HEADER + MachineRecord::SIZE;
    let old = usize::from(bytes[at::CODE_LEN]);
    bytes.splice(head..head + old, code.iter().copied());
    let len = bytes.len() as u16;
    bytes[at::LEN..][..2].copy_from_slice(&len.to_le_bytes());
    bytes[at::CODE_LEN..][..2].copy_from_slice(&(code.len() as u16).to_le_bytes());
    image::seal(&mut bytes);
    bytes
}

#[test]
fn every_code_is_listed_with_its_name_and_its_bytes() {
    for row in ROWS {
        for n in 0..row.count {
            let mut code = vec![row.code + n];
            code.extend((0..row.operands.len(false)).map(|i| i as u8));
            let bytes = with_code(&code);
            let image = Image::new(&bytes).unwrap();
            let insns = disasm::instructions(&image);
            let [Insn { pc: 0, bytes, text }] = &insns[..] else { panic!("{insns:?}") };
            assert_eq!(*bytes, code);
            assert_eq!(text.split_whitespace().next(), Some(row.name));
            let plain = row.operands == Operands::None && row.count == 1;
            assert_eq!(text.contains(' '), !plain, "{text}");
        }
    }
}

#[test]
fn a_cut_or_unknown_instruction_is_listed_as_such() {
    let bytes = with_code(&[Op::Word as u8, 1]);
    let image = Image::new(&bytes).unwrap();
    let texts: Vec<String> =
        disasm::instructions(&image).into_iter().map(|insn| insn.text).collect();
    assert_eq!(texts[0], "?");
    let bytes = with_code(&[0xFF]);
    assert_eq!(disasm::instructions(&Image::new(&bytes).unwrap())[0].text, "?");
}

#[test]
fn the_scripts_of_the_tests_use_every_instruction() {
    let mut used: BTreeSet<Op> = BTreeSet::new();
    let mut see = |compiled: Compiled| {
        let image = Image::new(&compiled.image).unwrap();
        let codes = disasm::instructions(&image).into_iter().map(|insn| insn.bytes[0]);
        used.extend(codes.filter_map(|code| Op::decode(code).map(|(op, _)| op)));
    };
    for file in ["run", "back", "check/ok"].into_iter().flat_map(super::scripts) {
        let text = std::fs::read_to_string(file).unwrap();
        text.split("' ---\n").for_each(|part| see(super::compile(part)));
    }
    // No built-in machine has an analog output.
    let mill = include_str!("../../../examples/profiles/mill.toml").to_owned();
    let whole = Box::new(Profile::parse(&(mill + "[[aout]]\nn = 1\n")).unwrap());
    see(super::compile_for("SetAout 1, 1V\n", ProfileChoice::Given(whole)));
    // Slow points come from the host's computation, not from a script.
    used.insert(Op::Course);
    let unused: Vec<&str> =
        ROWS.iter().filter(|row| !used.contains(&row.op)).map(|row| row.name).collect();
    assert!(unused.is_empty(), "no script shows {unused:?}");
}
