//! The shipped image: above 64 KB there is no word that would leave it the short way.

use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};
use std::collections::{BTreeMap, BTreeSet};

const IMAGE: &[u8] = include_bytes!("../../image/pasapas-f5529.elf");

/// Words of an instruction of compiled code, far ones among them.
fn length(word: u16) -> usize {
    let extends = |register: u16, mode: u16| match mode {
        1 => register != 3,
        3 => register == 0,
        _ => false,
    };
    match word {
        0x0110 => 1,
        0x0080 | 0x0180 | 0x0280 | 0x13B0..=0x13B2 => 2,
        0x1000..0x1300 => 1 + usize::from(extends(word & 15, word >> 4 & 3)),
        0x2000..0x4000 => 1,
        0x4000.. => {
            let source = extends(word >> 8 & 15, word >> 4 & 3);
            1 + usize::from(source) + usize::from(word & 0x80 != 0)
        }
        _ => panic!("{word:#06x}"),
    }
}

#[test]
fn every_way_out_of_a_far_function_is_a_far_one() {
    let file = object::File::parse(IMAGE).expect("an ELF file");
    let banks = [".high", ".more"].map(|name| file.section_by_name(name));
    let banks: Vec<_> = banks.into_iter().flatten().filter(|bank| bank.size() > 0).collect();
    assert!(!banks.is_empty(), "code above 64 KB");
    let words: BTreeMap<u64, u16> = banks
        .iter()
        .flat_map(|bank| {
            let words = bank.data().expect("its bytes").chunks_exact(2);
            let places = (bank.address()..).step_by(2);
            places.zip(words.map(|pair| u16::from_le_bytes([pair[0], pair[1]])))
        })
        .collect();
    let size: u64 = banks.iter().map(|bank| bank.size()).sum();
    let code =
        |symbol: &object::Symbol<'_, '_>| symbol.kind() == SymbolKind::Text && symbol.size() > 0;
    let functions: Vec<_> = file.symbols().filter(code).collect();
    // Several functions of the arithmetic share a section, with labels of their own.
    let starts: BTreeSet<u64> = file.symbols().map(|own| own.address()).collect();
    let gates: BTreeSet<u64> = file
        .symbols()
        .filter(|own| own.name().is_ok_and(|name| name.starts_with("gate.")))
        .map(|own| own.address())
        .collect();
    let (mut calls, mut returns, mut covered) = (0, 0, 0);
    for function in functions.iter().filter(|own| own.address() >= 0x1_0000) {
        let name = function.name().expect("a name");
        let end = function.address() + function.size();
        covered += function.size();
        let mut at = function.address();
        while at < end {
            let word = words[&at];
            let place = at;
            let next = words.get(&(at + 2)).copied().unwrap_or(0);
            match word {
                0x13B0..=0x13B2 => {
                    let target = u64::from(word & 3) << 16 | u64::from(next);
                    assert!(
                        starts.contains(&target) || gates.contains(&target),
                        "{name} calls {target:#x} at {place:#x}"
                    );
                    calls += 1;
                }
                0x0110 => returns += 1,
                0x0180 | 0x0280 => {
                    let target = u64::from(word >> 8) << 16 | u64::from(next);
                    let own = function.address()..function.address() + function.size();
                    assert!(own.contains(&target), "{name} leaves itself at {place:#x}");
                }
                0x12B0 | 0x4130 | 0x4030 => panic!("{name} at {place:#x}: {word:#06x}"),
                _ => {}
            }
            // Erratum CPU40: a word behind a jump must not be 0x?40 or 0x?50.
            let jumps = (0x2000..0x4000).contains(&word);
            assert!(!jumps || !matches!(next & 0xF0FF, 0x0040 | 0x0050), "{name} at {place:#x}");
            at += 2 * length(word) as u64;
        }
        assert_eq!(at, end, "{name}");
    }
    assert!(calls > 500 && returns > 100, "{calls} calls, {returns} returns");
    // Between the functions there is nothing but what aligns them.
    assert!(size - covered < 8 * banks.len() as u64, "{covered} of {size}");
}
