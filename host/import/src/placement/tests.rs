use super::{List, Side, Unit, is_placement, read, read_bom};

const KICAD: &str = "### Footprint positions - created on 2026-01-01T10:00:00 ###
### Printed by KiCad version 8.0.4
## Unit = mm, Angle = deg.
## Side : All
# Ref     Val           Package          PosX       PosY       Rot  Side
C1        100n          C_0402        25.4000    12.7000  180.0000  top
R1        10k 1%        R_0603        10.0000   -20.0000  -90.0000  top
FID1      FID           Fiducial_1mm   3.0000     3.0000    0.0000  top
D1        LED,_red      LED_0603      15.0000    10.0000  -90.0000  bottom
## End
";

fn good(name: &str, text: &str) -> List {
    read(name, text.as_bytes(), None).unwrap_or_else(|diags| panic!("{name}: {diags:?}"))
}

/// The parts of [`KICAD`], but for the order.
fn same(list: &List, what: &str) {
    let wanted = good("a.pos", KICAD);
    for part in &list.parts {
        let other = wanted.parts.iter().find(|other| other.name == part.name).expect("known");
        assert_eq!(
            (part.at, part.turned, part.side),
            (other.at, other.turned, other.side),
            "{what}"
        );
        assert_eq!(part.package, other.package, "{what}");
    }
    assert_eq!(list.parts.len(), 4, "{what}");
}

#[test]
fn kicads_columns_keep_value_package_and_rotation() {
    let list = good("a.pos", KICAD);
    let r1 = &list.parts[1];
    assert_eq!(
        (r1.name.as_str(), r1.value.as_str(), r1.package.as_str()),
        ("R1", "10k 1%", "R_0603")
    );
    assert_eq!(
        (r1.at, r1.turned, r1.side, r1.line),
        ([10_000, -20_000], Some(270_000), Side::Top, 7)
    );
    assert!(list.parts[2].is_fiducial() && !r1.is_fiducial());
    assert_eq!(list.parts[3].side, Side::Bottom);
    assert!(list.notes.is_empty(), "{:?}", list.notes);
    assert!(is_placement("a.pos", KICAD));
    // KiCad 4 and inches.
    let old =
        KICAD.replace("Footprint", "Module").replace(" top", " F.Cu").replace("bottom", "B.Cu");
    same(&good("a.pos", &old), "KiCad 4");
    let inch = "## Unit = inches, Angle = deg.\n# Ref Val Package PosX PosY Rot Side\n\
                R1 1k R_0603 1.5 -0.1 90 top\n## End\n";
    assert_eq!(good("a.pos", inch).parts[0].at, [38_100, -2540]);
}

#[test]
fn tables_of_every_system_say_the_same() {
    let csv = "Ref,Val,Package,PosX,PosY,Rot,Side\n\"C1\",\"100n\",\"C_0402\",25.4,12.7,180.0,top\n\
               \"R1\",\"10k\",\"R_0603\",10.0,-20.0,-90.0,top\n\"FID1\",\"FID\",\"Fiducial_1mm\",3,3,0,top\n\
               \"D1\",\"LED, red\",\"LED_0603\",15.0,10.0,-90,bottom\n";
    let list = good("a.csv", csv);
    same(&list, "KiCad's CSV");
    assert_eq!(list.notes.len(), 1, "its unit is not told");
    assert!(list.notes[0].text.contains("X goes to 25.4: mm is taken"));
    let altium = "Altium Designer Pick and Place Locations\nC:\\board.csv\n\n=====\nUnits used: mm\n\n\
        \"Designator\",\"Comment\",\"Layer\",\"Footprint\",\"Center-X(mm)\",\"Center-Y(mm)\",\"Rotation\",\"Description\"\n\
        \"C1\",\"100n\",\"TopLayer\",\"C_0402\",\"25.4000\",\"12.7000\",\"180\",\"\"\n\
        \"R1\",\"10k\",\"TopLayer\",\"R_0603\",\"10\",\"-20\",\"270\",\"\"\n\
        \"FID1\",\"FID\",\"TopLayer\",\"Fiducial_1mm\",\"3\",\"3\",\"0\",\"\"\n\
        \"D1\",\"LED, red\",\"BottomLayer\",\"LED_0603\",\"15\",\"10\",\"270\",\"\"\n";
    let list = good("a.csv", altium);
    same(&list, "Altium");
    assert_eq!((list.what, list.left_out), ("Altium's list", vec!["Description".to_owned()]));
    let old = "\"Designator\",\"Footprint\",\"Mid X\",\"Mid Y\",\"Ref X\",\"Ref Y\",\"TB\",\"Rotation\",\"Comment\"\n\
        \"C1\",\"C_0402\",\"1000mil\",\"500mil\",\"0mil\",\"0mil\",\"T\",\"180.00\",\"100n\"\n";
    assert_eq!(good("a.csv", old).parts[0].at, [25_400, 12_700], "the middle, not the first pad");
    let jlc = "Designator,Val,Package,Mid X,Mid Y,Rotation,Layer\n\"C1\",\"100n\",\"C_0402\",25.4mm,12.7mm,180,Top\n\
        R1,10k,R_0603,10mm,-20mm,270,Top\nFID1,FID,Fiducial_1mm,3mm,3mm,0,Top\nD1,\"LED, red\",LED_0603,15mm,10mm,270,Bottom\n";
    let list = good("a.csv", jlc);
    same(&list, "JLC");
    assert!(list.notes.is_empty(), "each length has its unit");
    let proteus = "\"LABCENTER PROTEUS PICK AND PLACE FILE\"\n\nUnits: thou\n\nPart ID, Value, Package, Layer, Rotation, X, Y\n\
        \"C1\",\"100n\",\"C_0402\",TOP,180,1000,500\n";
    assert_eq!(good("a.pkp", proteus).parts[0].at, [25_400, 12_700]);
    let semicolons = "Designator;X;Y;Rotation;Side\nR1;10,5;-20,25;90,5;top\n";
    let list = good("a.csv", semicolons);
    assert_eq!((list.parts[0].at, list.parts[0].turned), ([10_500, -20_250], Some(90_500)));
    let wide = "Designator\tMid X\tMid Y\tRotation\tLayer\r\nR1\t12.7mm\t5mm\t0\tT\r\n";
    for (mark, order) in [
        ("\u{FEFF}", u16::to_le_bytes as fn(u16) -> [u8; 2]),
        ("", u16::to_le_bytes),
        ("\u{FEFF}", u16::to_be_bytes),
        ("", u16::to_be_bytes),
    ] {
        let wide = format!("{mark}{wide}");
        let wide: Vec<u8> = wide.encode_utf16().flat_map(order).collect();
        let list = read("a.csv", &wide, None).expect("UTF-16");
        assert_eq!(list.parts[0].at, [12_700, 5000]);
    }
    let list = good("a.mnb", "D1 15.00 10.00 270 LED,_red LED_0603\nR2 1.00 2.00 0 R_0603\n");
    assert_eq!((list.parts[0].side, list.parts[1].package.as_str()), (Side::Bottom, "R_0603"));
}

#[test]
fn what_is_wrong_is_told_by_line() {
    let head = "Designator,X,Y,Rotation,Layer\n";
    for (rows, line, words) in [
        ("R1,1mm,2,0,T\n", 2, "names its unit"),
        ("R1,1mm,2mm,0,T\nR2,1mil,2mil,0,T\n", 3, "its unit is not that"),
        ("R1,1,2,up,T\n", 2, "its rotation is `up`"),
        ("R1,1,2,0,left\n", 2, "its side is `left`"),
        ("R1,one,2,0,T\n", 2, "`one` is no length"),
        ("R1,99999999,2,0,T\n", 2, "beyond 10 m"),
        (",1,2,0,T\n", 2, "without a reference"),
        ("R1,1,2,0,T\nR1,2,2,0,T\n", 3, "R1 is in line 2, too"),
    ] {
        let diags = read("a.csv", format!("{head}{rows}").as_bytes(), None).expect_err(rows);
        let found = diags.iter().find(|diag| diag.text.contains(words));
        let found = found.unwrap_or_else(|| panic!("{rows}: {diags:?}"));
        assert_eq!(found.line, line, "{rows}");
    }
    assert!(read("a.csv", b"", None).is_err() && read("a.csv", b"\0\0", None).is_err());
    assert!(read("a.csv", head.as_bytes(), None).is_err(), "no part");
    let list = read("a.csv", b"Designator,X,Y,Layer\nR1,1,2,T\n", Some(Unit::Inch)).expect("good");
    assert_eq!((list.parts[0].at, list.parts[0].turned), ([25_400, 50_800], None));
    assert!(list.notes.iter().any(|note| note.text.contains("no column is the rotation")));
}

#[test]
fn bills_know_lists_ranges_and_what_is_not_fitted() {
    let names = |text: &str| {
        let bom = read_bom(text.as_bytes()).expect("good");
        let shown =
            |e: &super::Entry| format!("{}={}{}", e.name, e.value, if e.out { "!" } else { "" });
        bom.entries.iter().map(shown).collect::<Vec<_>>()
    };
    let jlc = "Comment,Designator,Footprint,JLCPCB Part #\n10k,\"R1,R2\",R_0603,C25804\n\"LED, red\",D1,LED,C1\n";
    assert_eq!(names(jlc), ["R1=10k", "R2=10k", "D1=LED, red"]);
    let kicad = "\"Id\";\"Designator\";\"Footprint\";\"Quantity\";\"Designation\";\n1;\"R1,R2\";\"R_0603\";2;\"10k\";\n";
    assert_eq!(names(kicad), ["R1=10k", "R2=10k"]);
    let ranges = "Reference,Value,Qty,DNP\n\"R1-R3\",10k,3,\nD1,red,1,DNP\n";
    assert_eq!(names(ranges), ["R1=10k", "R2=10k", "R3=10k", "D1=red!"]);
    assert!(read_bom(b"Reference,Value\nR9-R1,1k\n").is_err());
    assert!(read_bom(b"a,b\n1,2\n").is_err());
}
