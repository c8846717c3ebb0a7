use super::*;

#[test]
fn the_three_text_shapes_are_recognised_and_agree() {
    let hex = ":04C00000B240805A70\n:02FFFE0000C041\n:00000001FF\n";
    let txt = "@C000\nB2 40 80 5A\n@FFFE\n00 C0\nq\n";
    let a = Image::parse(hex.as_bytes()).expect("hex");
    let b = Image::parse(txt.as_bytes()).expect("ti-txt");
    assert_eq!(a, b);
    assert_eq!(a.byte(0xC003), Some(0x5A));
    assert_eq!(a.byte(0xFFFF), Some(0xC0));
    assert_eq!(a.byte(0xC004), None);
}

#[test]
fn damage_is_named_with_its_line() {
    let bad = |text: &str| Image::parse(text.as_bytes()).expect_err("must be refused");
    assert_eq!(bad(":04C00000B240805A71\n:00000001FF\n").line, 1);
    assert_eq!(bad("@C000\nB2 4x\nq\n").line, 2);
    assert_eq!(bad("@FFFFF\n01 02\nq\n").line, 2);
    assert!(bad("@C000\nB2 40\n").text.contains("cut short"));
    assert!(bad(":04C00000B240805A70\n").text.contains("cut short"));
    assert!(bad("hello").text.contains("expected"));
    assert!(Image::parse(&[0xFF, 0xFE]).is_err());
    assert!(Image::parse(b"\x7fELF\x01\x01").is_err());
}

/// A linked ELF file with one segment that runs at `vaddr` and is stored at `paddr`.
fn elf(vaddr: u32, paddr: u32, data: &[u8]) -> Vec<u8> {
    let mut file = b"\x7fELF\x01\x01\x01".to_vec();
    file.resize(16, 0);
    // ET_EXEC, EM_MSP430, version, entry, program header offset, no sections, flags.
    file.extend([2, 0, 105, 0, 1, 0, 0, 0]);
    file.extend([vaddr, 52, 0, 0].iter().flat_map(|word| word.to_le_bytes()));
    // Header sizes and counts.
    file.extend([52u16, 32, 1, 40, 0, 0].iter().flat_map(|half| half.to_le_bytes()));
    let len = data.len() as u32;
    // PT_LOAD, offset, addresses, sizes, flags, alignment.
    let header = [1, 84, vaddr, paddr, len, len, 5, 2];
    file.extend(header.iter().flat_map(|word| word.to_le_bytes()));
    file.extend(data);
    file
}

#[test]
fn elf_segments_go_to_their_physical_addresses() {
    let image = Image::parse(&elf(0x0200, 0xC000, &[1, 2, 3])).expect("a linked file");
    assert_eq!(image.segments, [Segment { addr: 0xC000, data: vec![1, 2, 3] }]);
    assert!(Image::parse(&elf(0x0200, 0xF_FFFE, &[1, 2, 3])).is_err(), "beyond 20 bits");
    let whole = elf(0xC000, 0xC000, &[1, 2, 3]);
    for len in 4..whole.len() {
        assert!(Image::parse(&whole[..len]).is_err(), "cut to {len} bytes");
    }
}

/// One program above 64 KB in all shapes.
#[test]
fn addresses_of_20_bits_are_loaded() {
    let linear = ":020000040002F8\n:04400000B240805AF0\n:00000001FF\n";
    let segment = ":020000022000DC\n:04400000B240805AF0\n:00000001FF\n";
    let txt = "@24000\nB2 40 80 5A\nq\n";
    let whole = Image::from_bytes(0x2_4000, &[0xB2, 0x40, 0x80, 0x5A]);
    for text in [linear, segment, txt] {
        assert_eq!(Image::parse(text.as_bytes()), whole, "{text}");
    }
    assert_eq!(Image::parse(&elf(0x2_4000, 0x2_4000, &[0xB2, 0x40, 0x80, 0x5A])), whole);
}
