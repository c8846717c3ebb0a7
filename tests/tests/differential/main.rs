//! Differential tests of the engines: generated programs give the same trace, final variables and
//! end on `rhai` and on the device's VM.

use std::collections::BTreeMap;

use lang::back::Compiled;
use lang::front::compile;
use lang::front::source::Source;
use lang::hir::Program;
use lang::image::{Image, seal};
use lang::isa::{Op, ROWS};
use lang::part::F5529;
use pasapas::sim::trace::to_text;
use pasapas::sim::world::World;
use pasapas::sim::{Options, STATEMENT_US};
use pasapas::torture::compare::{Run, difference, hangs_on_an_instant, on_rhai, on_vm};
use pasapas::torture::generate::{Case, generate};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestError, TestRng, TestRunner};

/// Generated programs of one test: four of them make 20 000 and some.
const PROGRAMS: u32 = 5_600;

/// Ends runaway programs; the engines count statements alike.
const OPTIONS: Options = Options {
    limit_us: 60_000_000,
    times: false,
    record: false,
    statements: 4_000,
    statement_us: STATEMENT_US,
    part: F5529,
    judged: true,
    interrupted: || false,
};

fn front(case: &Case) -> Result<Program, String> {
    let source = Source::new("g.bas", case.script.clone());
    let (program, diags) = compile(&source, case.machine());
    program.ok_or_else(|| format!("{diags:?}"))
}

/// Counts by outcome, and codes of the opcode table that the images hold.
#[derive(Default)]
struct Tally {
    run: u32,
    refused: u32,
    /// Differences that hung on one instant.
    instants: u32,
    ends: BTreeMap<String, u32>,
    codes: BTreeMap<u8, u32>,
}

impl Tally {
    fn count(&mut self, compiled: &Compiled, run: &Run) {
        self.run += 1;
        let end = &run.outcome.summary;
        let name = end.fault.clone().unwrap_or_else(|| format!("{:?}", end.status));
        *self.ends.entry(name).or_default() += 1;
        let image = Image::new(&compiled.image).expect("an image of our own");
        let mut pc = 0;
        while let Some((op, _)) = image.code.get(pc).and_then(|code| Op::decode(*code)) {
            *self.codes.entry(op.code()).or_default() += 1;
            pc += 1 + op.row().operands.len(image.header.wide());
        }
    }
}

/// Both runs of a case; `None` when the compiler refuses it.
fn runs(
    case: &Case,
    statement_us: u64,
    spoil: &dyn Fn(&mut Compiled),
) -> Option<(Compiled, Run, Run)> {
    let program = front(case).ok()?;
    let mut compiled = lang::back::compile(&program).ok()?;
    let world = World::parse("g.rhai", &case.world).expect("a world of our own");
    let options = Options { statement_us, ..OPTIONS };
    let rhai = on_rhai(&program, &compiled, &world, &options).expect("rhai");
    spoil(&mut compiled);
    let vm = on_vm(&program, &compiled, &world, &options).expect("vm");
    Some((compiled, rhai, vm))
}

/// Runs one case on both engines; `spoil` may change the VM's image.
fn check(
    case: &Case,
    tally: &mut Tally,
    spoil: &dyn Fn(&mut Compiled),
) -> Result<(), TestCaseError> {
    let Some((compiled, rhai, vm)) = runs(case, STATEMENT_US, spoil) else {
        tally.refused += 1;
        return Ok(());
    };
    tally.count(&compiled, &rhai);
    let Some(text) = difference(case, &rhai, &vm) else { return Ok(()) };
    let both = |case: &Case, us| runs(case, us, spoil).map(|(_, rhai, vm)| (rhai, vm));
    if hangs_on_an_instant(case, &rhai, both) {
        tally.instants += 1;
        return Ok(());
    }
    Err(TestCaseError::fail(format!(
        "{text}\n{}\n// {}\nrhai:\n{}vm:\n{}",
        case.script,
        case.world,
        to_text(&rhai.trace),
        to_text(&vm.trace)
    )))
}

fn tapes() -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(any::<u16>(), 20..260)
}

fn runner(seed: u8, cases: u32, max_shrink_iters: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, max_shrink_iters, ..Config::default() };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]);
    TestRunner::new_with_rng(config, rng)
}

/// Generates programs and compares; prints what they covered.
fn compare(seed: u8, programs: u32) {
    let tally = std::cell::RefCell::new(Tally::default());
    let mut runner = runner(seed, programs, 400);
    let result =
        runner.run(&tapes(), |tape| check(&generate(&tape), &mut tally.borrow_mut(), &|_| {}));
    if let Err(TestError::Fail(reason, tape)) = &result {
        panic!("{reason}\ntape {tape:?}");
    }
    result.expect("the runner");
    let tally = tally.into_inner();
    println!(
        "{} programs run, {} refused, {} hung on an instant, ends {:?}",
        tally.run, tally.refused, tally.instants, tally.ends
    );
    let missing: Vec<&str> = ROWS
        .iter()
        .filter(|row| !tally.codes.contains_key(&row.code))
        .map(|row| row.name)
        .collect();
    println!("{} of {} instructions, without {missing:?}", tally.codes.len(), ROWS.len());
    assert!(tally.codes.len() * 100 >= ROWS.len() * 97, "too little covered: without {missing:?}");
    assert!(tally.instants * 200 < tally.run, "{} hung on an instant", tally.instants);
    assert!(tally.refused * 4 < tally.run, "{} of {} refused", tally.refused, tally.run);
}

#[test]
fn engines_agree_on_the_first_series() {
    compare(1, PROGRAMS);
}

#[test]
fn engines_agree_on_the_second_series() {
    compare(2, PROGRAMS);
}

#[test]
fn engines_agree_on_the_third_series() {
    compare(3, PROGRAMS);
}

/// A series of one's own choice: `PASAPAS_SEED=77 cargo test -p tests --test differential`. What a
/// check of a change says must not depend on chance, so there is a seed without it too: one that
/// once found a pulse which ended in a pause and stopped the clock.
#[test]
fn engines_agree_on_a_chosen_series() {
    let seed = std::env::var("PASAPAS_SEED").ok().and_then(|seed| seed.parse().ok());
    compare(seed.unwrap_or(5), PROGRAMS);
}

/// The image with every `from` replaced by `to`.
fn replace(compiled: &mut Compiled, from: Op, to: Op) {
    let image = Image::new(&compiled.image).expect("an image of our own");
    let wide = image.header.wide();
    let start = compiled.image.len() - image.code.len() - image.data.len();
    let mut places = Vec::new();
    let mut pc = 0;
    while let Some((op, _)) = image.code.get(pc).and_then(|code| Op::decode(*code)) {
        if op == from {
            places.push(start + pc);
        }
        pc += 1 + op.row().operands.len(wide);
    }
    for place in places {
        compiled.image[place] = to.code();
    }
    seal(&mut compiled.image);
}

#[test]
fn a_broken_opcode_is_caught() {
    let broken = [
        (Op::Add, Op::Sub),
        (Op::Lt, Op::Le),
        (Op::Mod, Op::Div),
        (Op::JumpZero, Op::JumpNonzero),
        (Op::Shr, Op::Shl),
        (Op::Max, Op::Min),
        (Op::Neg, Op::Abs),
        (Op::Err, Op::Erl),
        (Op::Sin, Op::Cos),
    ];
    for (from, to) in broken {
        let tally = std::cell::RefCell::new(Tally::default());
        let mut runner = runner(9, 2_000, 0);
        let caught = runner.run(&tapes(), |tape| {
            let case = generate(&tape);
            check(&case, &mut tally.borrow_mut(), &|compiled| replace(compiled, from, to))
        });
        assert!(caught.is_err(), "{from:?} that does as {to:?} stays unseen");
    }
}
