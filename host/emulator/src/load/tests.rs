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
    assert_eq!(bad("@FFFF\n01 02\nq\n").line, 2);
    assert!(bad("@C000\nB2 40\n").text.contains("cut short"));
    assert!(bad(":04C00000B240805A70\n").text.contains("cut short"));
    assert!(bad("hello").text.contains("expected"));
    assert!(Image::parse(&[0xFF, 0xFE]).is_err());
    assert!(Image::parse(b"\x7fELF\x01\x01").is_err());
}
