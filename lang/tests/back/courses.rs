//! Slow points in an image: where they are put, and that jumps still lead where they led.

use lang::back::{self, Courses, disasm};
use lang::front::source::Source;
use lang::front::{self, ProfileChoice};
use lang::image::Image;
use lang::image::course::{Entry, record};
use lang::isa::{Op, ROWS};

const TEXT: &str = "DIM i\nG90\nF600\nG0 X0\nFOR i = 1 TO 3\nG1 X[i * 1mm]\nG1 Y[i * 1mm]\nNEXT\n\
                    REPEAT 2\nG1 X0.5\nEND REPEAT\nGOSUB part\nEND\npart:\nG1 X7 Y7\nRETURN\n";

#[test]
fn slow_points_stand_in_front_of_the_lines_that_begin_their_courses() {
    let source = Source::new("test.bas", TEXT.to_owned());
    let (program, _) = front::compile(&source, ProfileChoice::built_in());
    let program = program.expect("a program");
    let plain = back::compile(&program).expect("it fits");
    let image = Image::new(&plain.image).expect("an image");
    assert!(!image.has_courses());
    let lines: Vec<usize> = disasm::instructions(&image)
        .iter()
        .filter(|insn| insn.text.starts_with("line"))
        .map(|insn| insn.pc)
        .collect();
    assert_eq!(lines.len(), 4, "{:?}", disasm::instructions(&image));
    // One is longer than what a length byte tells.
    let entries: Vec<Vec<Entry>> = (0..4_u16)
        .map(|n| {
            vec![
                Entry { lines: 1 + n as u8, holds: n & 1 != 0, bound: 0x9000 + n, joins: n as u8 };
                1 + 40 * usize::from(n)
            ]
        })
        .collect();
    let records = lines.iter().zip(&entries).map(|(pc, entries)| (*pc, record(entries)));
    let courses = Courses { pool: 24, records: records.collect() };
    let compiled = back::compile_with(&program, &courses).expect("it fits");
    let image = super::check(&compiled.image).expect("a sound image");
    assert!(image.has_courses());
    assert_eq!(usize::from(image.header.stack), plain.stack + 6);
    let insns = disasm::instructions(&image);
    let mut found = Vec::new();
    for two in insns.windows(2) {
        if two[0].bytes[0] == Op::Course as u8 {
            assert!(two[1].text.starts_with("line"), "{two:?}");
            let offset = u16::from_le_bytes([two[0].bytes[1], two[0].bytes[2]]);
            found.push(image.course(offset.into()).collect::<Vec<_>>());
        }
    }
    assert_eq!(found, entries);
    // But for them the instructions are those of the image without any.
    let name = |insn: &disasm::Insn| {
        let code = insn.bytes[0];
        ROWS.iter().find(|row| code.wrapping_sub(row.code) < row.count).map(|row| row.op)
    };
    let before: Vec<_> = disasm::instructions(&Image::new(&plain.image).expect("an image"))
        .iter()
        .map(name)
        .collect();
    let after: Vec<_> = insns.iter().map(name).filter(|op| *op != Some(Op::Course)).collect();
    assert_eq!(before, after);
}
