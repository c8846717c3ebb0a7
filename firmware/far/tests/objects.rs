//! Object files as a compiler makes them, and what becomes of them.

use far::{Near, rewrite};
use object::elf::R_MSP430_16_BYTE;
use object::write::{Object, Relocation, SectionId, Symbol, SymbolId, SymbolSection};
use object::{
    Architecture, BinaryFormat, Endianness, Object as _, ObjectSection, ObjectSymbol,
    RelocationFlags, RelocationTarget, SectionKind, SymbolFlags, SymbolKind, SymbolScope,
};

const CALL: u16 = 0x12B0;
const RET: u16 = 0x4130;
const RETA: u16 = 0x0110;

struct File(Object<'static>);

impl File {
    fn new() -> File {
        File(Object::new(BinaryFormat::Elf, Architecture::Msp430, Endianness::Little))
    }

    /// A section with a symbol at its begin.
    fn section(
        &mut self,
        section: &str,
        name: &str,
        kind: SymbolKind,
        code: &[u16],
    ) -> (SectionId, SymbolId) {
        let text = if section.starts_with(".rodata") {
            SectionKind::ReadOnlyData
        } else {
            SectionKind::Text
        };
        let id = self.0.add_section(Vec::new(), section.as_bytes().to_vec(), text);
        let bytes: Vec<u8> = code.iter().flat_map(|word| word.to_le_bytes()).collect();
        self.0.append_section_data(id, &bytes, 2);
        let symbol = self.symbol(id, name, kind, bytes.len() as u64);
        (id, symbol)
    }

    fn symbol(&mut self, section: SectionId, name: &str, kind: SymbolKind, size: u64) -> SymbolId {
        self.0.add_symbol(Symbol {
            name: name.as_bytes().to_vec(),
            value: 0,
            size,
            kind,
            scope: SymbolScope::Linkage,
            weak: false,
            section: SymbolSection::Section(section),
            flags: SymbolFlags::None,
        })
    }

    /// A compiled function.
    fn function(&mut self, name: &str, code: &[u16]) -> (SectionId, SymbolId) {
        self.section(&format!(".text.{name}"), name, SymbolKind::Text, code)
    }

    /// A routine in assembly.
    fn routine(&mut self, name: &str) -> SymbolId {
        // A label in assembly has no type, as that of a section's address.
        self.section(&format!(".text.{name}"), name, SymbolKind::Label, &[RET]).1
    }

    fn refers(&mut self, (section, _): (SectionId, SymbolId), offset: u64, symbol: SymbolId) {
        let flags = RelocationFlags::Elf { r_type: R_MSP430_16_BYTE };
        self.0
            .add_relocation(section, Relocation { offset, symbol, addend: 0, flags })
            .expect("a place");
    }

    fn made(&self, near: &str) -> Result<Made, String> {
        let bytes = self.0.write().expect("an object file");
        rewrite(&bytes, &Near::parse(near)).map(Made)
    }
}

struct Made(Vec<u8>);

impl Made {
    fn words(&self, section: &str) -> Vec<u16> {
        let file = object::File::parse(&*self.0).expect("an object file");
        let found = file.section_by_name(section);
        let data =
            found.unwrap_or_else(|| panic!("no {section}")).data().expect("its bytes").to_vec();
        data.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
    }

    /// Symbol and addend of the relocations of a section.
    fn relocations(&self, section: &str) -> Vec<(String, i64)> {
        let file = object::File::parse(&*self.0).expect("an object file");
        let found = file.section_by_name(section).expect("a section");
        let named = |target| match target {
            RelocationTarget::Symbol(index) => {
                file.symbol_by_index(index).expect("a symbol").name().expect("its name").to_owned()
            }
            other => panic!("{other:?}"),
        };
        found.relocations().map(|(_, own)| (named(own.target()), own.addend())).collect()
    }
}

/// `caller` calls `callee`, which has an argument on the stack, and the routine `helper`.
fn caller_and_callee(gate: bool) -> File {
    let mut file = File::new();
    // PUSH R10; MOV 4(SP), R12; MOV 0(SP), R13; POP R10; RET.
    let callee = file.function("callee", &[0x120A, 0x411C, 4, 0x411D, 0, 0x413A, RET]);
    let helper = file.routine("helper");
    if gate {
        file.routine("gate.helper");
    }
    let caller = file.function("caller", &[CALL, 0, CALL, 0, RET]);
    file.refers(caller, 2, callee.1);
    file.refers(caller, 6, helper);
    file
}

#[test]
fn functions_go_up_and_find_each_other_and_assembly() {
    let made = caller_and_callee(true).made("").expect("far");
    assert_eq!(made.words(".high.caller"), [0x13B1, 0, 0x13B0, 0, RETA]);
    let wanted = [("callee".to_owned(), -0x1_0000), ("gate.helper".to_owned(), 0)];
    assert_eq!(made.relocations(".high.caller"), wanted);
    // What it pushed is where it was, the argument lies behind a longer return address.
    assert_eq!(made.words(".high.callee"), [0x120A, 0x411C, 6, 0x411D, 0, 0x413A, RETA]);
    assert_eq!(made.words(".text.helper"), [RET]);
}

/// The first 64 KB above are for those that come first; what does not fit goes on at 20000.
#[test]
fn functions_beyond_the_first_bank_go_to_the_second() {
    let mut file = File::new();
    // 40 KB of NOP each.
    let long = [vec![0x4303; 20_000], vec![RET]].concat();
    let first = file.function("first", &long);
    let second = file.function("second", &long);
    let caller = file.function("caller", &[CALL, 0, CALL, 0, RET]);
    file.refers(caller, 2, first.1);
    file.refers(caller, 6, second.1);
    let made = file.made("").expect("far");
    assert_eq!(made.words(".high.first").len(), 20_001);
    assert_eq!(made.words(".more.caller"), [0x13B1, 0, 0x13B2, 0, RETA]);
    let wanted = [("first".to_owned(), -0x1_0000), ("second".to_owned(), -0x2_0000)];
    assert_eq!(made.relocations(".more.caller"), wanted);
}

#[test]
fn near_functions_stay_and_are_called_by_everybody_in_the_same_way() {
    let made = caller_and_callee(false).made("# why\n\ncaller\n");
    // Mangled names have lengths.
    assert!(made.is_err_and(|error| error.contains("no gate.helper, wanted at .text.caller+0x6")));
    let mut file = File::new();
    let callee = file.function("_RNv4ramp3Run7segment", &[RET]);
    let helper = file.routine("helper");
    let caller = file.function("_RNv4ramp6caller", &[CALL, 0, RET]);
    let near = file.function("_RNv4path4near", &[CALL, 0, CALL, 0, RET]);
    file.refers(caller, 2, callee.1);
    file.refers(near, 2, caller.1);
    file.refers(near, 6, helper);
    let made = file.made("Run::segment\npath::near").expect("far");
    assert_eq!(made.words(".text._RNv4ramp3Run7segment"), [RETA]);
    assert_eq!(made.words(".high._RNv4ramp6caller"), [0x13B0, 0, RETA]);
    assert_eq!(made.words(".text._RNv4path4near"), [0x13B1, 0, CALL, 0, RETA]);
    let wanted = [("_RNv4ramp6caller".to_owned(), -0x1_0000), ("helper".to_owned(), 0)];
    assert_eq!(made.relocations(".text._RNv4path4near"), wanted);
}

#[test]
fn assembly_calls_and_goes_to_functions_and_long_jumps_stay_in_theirs() {
    let mut file = File::new();
    // BR #here, of a function to itself.
    let main = file.function("main", &[0x4030, 0]);
    file.refers(main, 2, main.1);
    let reset = file.section(".Reset", "Reset", SymbolKind::Label, &[CALL, 0, 0x4030, 0]);
    file.refers(reset, 2, main.1);
    file.refers(reset, 6, main.1);
    let made = file.made("").expect("far");
    assert_eq!(made.words(".high.main"), [0x0180, 0]);
    assert_eq!(made.words(".Reset"), [0x13B1, 0, 0x0180, 0]);
    assert!(made.relocations(".Reset").iter().all(|(_, addend)| *addend == -0x1_0000));
}

#[test]
fn a_handler_of_the_hardware_stays_as_it_is() {
    let mut file = File::new();
    file.function("handler", &[0x120F, 0x413F, 0x1300]);
    assert_eq!(file.made("").expect("far").words(".text.handler"), [0x120F, 0x413F, 0x1300]);
}

fn refused(name: &str, code: &[u16]) -> String {
    let mut file = File::new();
    file.function(name, code);
    file.made("").err().expect("a refusal")
}

#[test]
fn what_cannot_be_far_is_refused_by_name() {
    // BR table(R12), CALL R12.
    for code in [&[0x4C10, 0][..], &[0x128C, RET]] {
        assert!(refused("chooses", code).starts_with("chooses: goes where a value says at 0x0"));
    }
    // SUB R12, SP in the middle.
    assert_eq!(refused("grows", &[0x430C, 0x8C01, RET]), "grows: the stack moves at 0x2");
    // MOV SP, R12; ADD #2, R12 by the constant generator.
    let text = refused("points", &[0x410C, 0x532C, RET]);
    assert_eq!(text, "points: an argument's address is made by a short constant at 0x2");
    assert!(
        refused("far", &[0x018A, 0x2345]).contains("no instruction of the MSP430 at 0x0: 0x018a")
    );
    assert!(refused("cut", &[0x4030]).contains("cut off"));

    let mut file = File::new();
    let taken = file.function("taken", &[RET]);
    let table = file.section(".rodata.table", "table", SymbolKind::Data, &[0]);
    file.refers(table, 0, taken.1);
    assert_eq!(
        file.made("").err(),
        Some("the address of taken is taken at .rodata.table+0x0".to_owned())
    );

    let mut file = File::new();
    let (section, _) = file.function("one", &[RET, RET]);
    file.symbol(section, "two", SymbolKind::Text, 2);
    assert_eq!(file.made("").err(), Some("two has no section of its own".to_owned()));
    assert!(
        rewrite(b"no object", &Near::default()).is_err_and(|error| error.starts_with("damaged"))
    );
}

#[test]
fn an_argument_whose_address_is_taken_moves_too() {
    let mut file = File::new();
    // SUB #4, SP; MOV SP, R12; ADD #6, R12; MOV SP, R13; ADD #2, R13; ADD #4, SP; RET.
    let code = [0x8221, 0x410C, 0x503C, 6, 0x410D, 0x532D, 0x5221, RET];
    file.function("f", &code);
    let made = file.made("").expect("far");
    assert_eq!(made.words(".high.f"), [0x8221, 0x410C, 0x503C, 8, 0x410D, 0x532D, 0x5221, RETA]);
}
