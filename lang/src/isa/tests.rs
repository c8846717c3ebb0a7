//! The opcode table against its decoders.

use super::{Op, Operands, ROWS, Shape, arguments, inline, shape};

#[test]
fn one_code_of_an_effect_is_free() {
    let free: Vec<u8> =
        (crate::isa::EFFECTS..0xFF).filter(|code| Op::decode(*code).is_none()).collect();
    assert_eq!(free, [0xFE], "lang/src/plain.rs says which");
}

#[test]
fn codes_ascend_without_overlap_and_decode_to_their_row() {
    let mut free = 0u16;
    for row in ROWS {
        assert!(u16::from(row.code) >= free, "{} overlaps", row.name);
        free = u16::from(row.code) + u16::from(row.count);
        for n in 0..row.count {
            assert_eq!(Op::decode(row.code + n), Some((row.op, n)));
            assert_eq!(shape(row.code + n), Some(Shape::of(row)), "{}", row.name);
        }
    }
    let known = ROWS.iter().map(|row| usize::from(row.count)).sum::<usize>();
    assert_eq!((0..=255).filter(|&code| shape(code).is_some()).count(), known);
    assert_eq!(shape(0xFF), None, "erased flash must not be an instruction");
}

#[test]
fn a_shape_gives_back_what_its_row_says() {
    for (i, operands) in Operands::ALL.into_iter().enumerate() {
        assert_eq!(operands as usize, i);
    }
    for row in ROWS {
        let shape = Shape::of(row);
        assert_eq!(shape.operands(), row.operands);
        assert_eq!((shape.pops(), shape.pushes()), (row.pops, row.pushes));
        assert_eq!(shape.class(), row.class);
    }
}

#[test]
fn inline_millimetres_are_what_the_effect_would_pop() {
    for row in ROWS {
        for n in 0..row.count {
            let Some(inline) = inline(row.code + n) else { continue };
            let effect = shape(inline.code).unwrap();
            let flags = match row.op {
                Op::LinearMm => 0b010,
                Op::LinearMm2 => 0b101,
                Op::LinearMm3 => 0b111,
                Op::MoveMm | Op::ProbeMm => super::flags::SPEED,
                _ => 0,
            };
            let pops = effect.pops() + arguments(inline.code, flags, 0);
            assert_eq!(pops, inline.values, "{}", row.name);
            let behind = row.operands.len(false) - usize::from(inline.values);
            assert_eq!(behind, effect.operands().len(false), "{}", row.name);
        }
    }
}

#[test]
fn mnemonics_are_unique() {
    let mut names: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), ROWS.len());
}
