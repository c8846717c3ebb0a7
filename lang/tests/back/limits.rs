//! Programs that want too much are refused at a place in the source.

use lang::back::{self, Excess, Resource};
use lang::front::source::Source;
use lang::front::{self, ProfileChoice};
use lang::image::Image;
use lang::image::limits::Entry;
use lang::vm::{State, Vm};

fn excesses(text: &str) -> Vec<Excess> {
    let source = Source::new("test.bas", text.to_owned());
    let (program, diags) = front::compile(&source, ProfileChoice::built_in());
    let program = program.unwrap_or_else(|| panic!("{}", diags.render(&source)));
    back::compile(&program).map(|compiled| compiled.cells).err().unwrap_or_default()
}

#[test]
fn the_promised_cells_fit_beside_the_promised_depths() {
    let deep = "PRINT 1 + (2 + (n + (3 + (n + (4 + (n + 5))))))\n";
    for machine in ["G0 X1", "START MoveAxe X, 1mm", "MoveAxe X, 1mm"] {
        let text = format!("DIM n, rest(254), last\n{machine}\nlast = n\n{deep}");
        assert_eq!(excesses(&text), [], "{machine}");
        assert_eq!(super::compile(&text).cells, 256);
    }
}

#[test]
fn too_many_cells_are_refused_at_the_variable_that_is_too_much() {
    let text = "DIM small(31)\nDIM large(226)\nlarge(small(1)) = 1\n";
    let found = excesses(text);
    let [Excess { resource: Resource::Cells, used: 257, available, span }] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(*available, 256);
    assert_eq!(&text[span.clone()], "large");
}

#[test]
fn an_array_is_no_longer_than_an_instruction_can_say() {
    assert_eq!(excesses("DIM a(255)\na(a(1)) = 1\n"), []);
    let text = "DIM a(256)\na(a(1)) = 1\n";
    let found = excesses(text);
    let [Excess { resource: Resource::Cells, used: 256, available: 255, span }] = &found[..] else {
        panic!("{found:?}")
    };
    assert_eq!(&text[span.clone()], "a");
}

#[test]
fn locals_of_subs_that_never_run_together_share_cells() {
    let text = "one 1\ntwo 2\nSUB one(a)\n  DIM u(20)\n  u(a) = a\nEND SUB\n\
                SUB two(b)\n  DIM v(20)\n  v(b) = b\nEND SUB\n";
    assert_eq!(super::compile(text).cells, 21);
    let nested = "one 1\nSUB one(a)\n  DIM u(10)\n  u(a) = a\n  two a\nEND SUB\n\
                  SUB two(b)\n  DIM v(10)\n  v(b) = b\nEND SUB\n";
    assert_eq!(super::compile(nested).cells, 22);
}

#[test]
fn a_handlers_locals_lie_apart_from_what_it_interrupts() {
    let text = "ON EVERY 1s GOSUB tick\none 1\nSUB one(a)\n  DIM u(5)\n  u(a) = a\nEND SUB\n\
                SUB tick\n  DIM v(5)\n  v(1) = 1\nEND SUB\n";
    assert_eq!(super::compile(text).cells, 11);
}

#[test]
fn depths_count_across_calls_and_handlers() {
    let text = "DIM a\na = 1 + f(2 + f(3))\nFUNCTION f(n)\n  RETURN n * 2 + g(n)\nEND FUNCTION\n\
                FUNCTION g(n)\n  RETURN n\nEND FUNCTION\n";
    let compiled = super::compile(text);
    // f waits below g with one value, two of the main program wait below f; every routine gets
    // the room of the deepest, three.
    assert_eq!((compiled.stack, compiled.calls), (6, 2));
    let events = "ON EVERY 1s GOSUB tick\nsubs\nEND\ntick:\n  subs2\n  RETURN\n\
                  SUB subs\n  PRINT 1\nEND SUB\nSUB subs2\n  PRINT 2\nEND SUB\n";
    assert_eq!(super::compile(events).calls, 3);
}

#[test]
fn at_and_keep_variables_lie_where_they_must() {
    let text =
        "KEEP total, parts\nDIM quantity AT 3002, other\ntotal = 1\nparts = quantity\nother = 2\n";
    let compiled = super::compile(text);
    let image = Image::new(&compiled.image).unwrap();
    assert_eq!(image.header.keeps, 2);
    let cell = |name: usize| compiled.vars.iter().find(|var| var.var.0 as usize == name);
    let at: Vec<u32> = compiled.vars.iter().map(|var| var.cell).collect();
    assert!(cell(0).is_some() && at.contains(&1), "{:?}", compiled.vars);
    let mut state = State::new(&image.header);
    let mut pool = vec![0; image.header.pool_bytes()];
    let mut vm = Vm::new(image, &mut state, &mut pool);
    vm.set_cell(1, 77);
    while vm.run(100) == lang::vm::Exit::Budget {}
    let base = image.header.keep_base;
    assert_eq!((vm.cell(base), vm.cell(base + 1)), (1, 77));
}

#[test]
fn code_of_any_size_compiles_and_runs() {
    use core::fmt::Write as _;
    let mut text = String::from("DIM n\nGOTO onward\nback:\nPRINT n\nEND\nonward:\n");
    for i in 0..9000 {
        let _ = writeln!(text, "n = n + {i} MOD 7\nIF n = -1 THEN GOTO back");
    }
    text.push_str("GOTO back\n");
    let compiled = super::compile(&text);
    assert!(compiled.code_bytes > 0x8000);
    let image = Image::new(&compiled.image).unwrap();
    assert!(image.header.wide());
    let mut state = State::new(&image.header);
    let mut pool = vec![0; image.header.pool_bytes()];
    let mut vm = Vm::new(image, &mut state, &mut pool);
    loop {
        match vm.run(1000) {
            lang::vm::Exit::Effect => vm.complete(0),
            lang::vm::Exit::End => break,
            lang::vm::Exit::Budget => {}
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(vm.cell(0), (0..9000).map(|i| i % 7).sum::<i32>());
}

#[test]
fn texts_beyond_what_an_address_reaches_are_refused() {
    let text: String = (0..2000).map(|i| format!("PRINT \"number {i} of many\"\n")).collect();
    let found = excesses(&text);
    let texts = |excess: &Excess| excess.resource == Resource::Texts;
    assert!(matches!(&found[..], [excess] if texts(excess)), "{found:?}");
}

#[test]
fn limits_of_at_variables_are_in_the_image_and_nothing_else_changes() {
    let with = "DIM n AT 3000 MIN 1 MAX 500, free AT 3002\nDIM row(3) AT 3006 MIN -2mm\n\
                DIM own\nown = n\nPRINT \"n \"; own; row(1)\n";
    let handlers = "ON ERROR GOTO h\nON IN 3 RISE GOSUB e\n";
    let behind = "END\ne: n = 0\nRETURN\nh: PRINT ERR\nRESUME NEXT\n";
    for text in [with.to_owned(), [handlers, with, behind].concat()] {
        let bytes = super::compile(&text).image;
        let image = super::check(&bytes).expect("accepted");
        let entries: Vec<_> = image.limits().expect("limits").entries().collect();
        let entry = |cell, count, least, greatest| Entry { cell, count, least, greatest };
        assert_eq!(entries, [entry(0, 1, 1, 500), entry(3, 3, -2000, i32::MAX)]);
        let plain = text.replace(" MIN 1 MAX 500", "").replace(" MIN -2mm", " AS LENGTH");
        let plain = plain.replace("row(3) AT 3006 AS LENGTH", "row(3) AS LENGTH AT 3006");
        let without = super::compile(&plain).image;
        let other = super::check(&without).expect("accepted");
        assert!(!other.has_limits() && other.limits().is_none());
        assert_eq!(image.header.cells, other.header.cells);
        // An offset, the column's head, two entries of values of four bytes.
        assert_eq!(image.data.len(), other.data.len() + 2 + 5 + 2 * 16);
        assert_eq!(image.machine[1..], other.machine[1..]);
        assert_eq!(image.header.profile_hash, other.header.profile_hash);
    }
}
