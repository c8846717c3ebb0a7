//! Tests of the peephole rules, one for each, and of the instruction forms.

use crate::back::emit::constant;
use crate::back::ir::{Cond, InlineOp, Item, Label, SourceMark};
use crate::back::opt::{peephole, written_first};
use crate::back::report::MarkKind;
use crate::hir::VarId;
use crate::isa::{self, Op, ROWS, flags};

const V: VarId = VarId(0);
const W: VarId = VarId(1);
const A: Label = Label(0);
const B: Label = Label(1);

fn mark(kind: MarkKind) -> Item {
    Item::Mark(SourceMark { line: 1, span: 0..0, kind, resume: None })
}

fn becomes(before: &[Item], after: &[Item]) {
    let mut items = before.to_vec();
    peephole(&mut items, false);
    assert_eq!(items, after);
}

#[test]
fn adding_one_to_a_variable_is_an_increment() {
    let one = [Item::Load(V), Item::Const(1), Item::Plain(Op::Add), Item::Store(V)];
    becomes(&one, &[Item::Change(Op::Inc, V)]);
    let swapped = [Item::Const(1), Item::Load(V), Item::Plain(Op::Add), Item::Store(V)];
    becomes(&swapped, &[Item::Change(Op::Inc, V)]);
}

#[test]
fn a_variable_is_added_without_a_load() {
    let sum = [Item::Load(V), Item::Load(W), Item::Plain(Op::Add)];
    becomes(&sum, &[Item::Load(V), Item::Change(Op::AddCell, W)]);
}

#[test]
fn subtracting_the_least_number_stays_as_it_is() {
    let items = [Item::Load(V), Item::Const(i32::MIN), Item::Plain(Op::Sub), Item::Store(V)];
    becomes(&items, &items);
}

#[test]
fn subtracting_a_variable_from_another_stays_as_it_is() {
    let items = [Item::Load(W), Item::Load(V), Item::Plain(Op::Sub), Item::Store(V)];
    becomes(&items, &items);
}

#[test]
fn a_negated_constant_is_a_constant() {
    becomes(&[Item::Const(500), Item::Plain(Op::Neg)], &[Item::Const(-500)]);
    let least = [Item::Const(i32::MIN), Item::Plain(Op::Neg)];
    becomes(&least, &least);
}

#[test]
fn neutral_operands_vanish() {
    becomes(&[Item::Load(V), Item::Const(0), Item::Plain(Op::Add)], &[Item::Load(V)]);
    becomes(&[Item::Load(V), Item::Const(1), Item::Plain(Op::Mul)], &[Item::Load(V)]);
    becomes(&[Item::Load(V), Item::Const(1), Item::Plain(Op::Div)], &[Item::Load(V)]);
}

#[test]
fn a_variable_set_to_0_is_one_instruction() {
    becomes(&[Item::Const(0), Item::Store(V)], &[Item::Zero(V)]);
}

#[test]
fn a_comparison_with_0_needs_no_0() {
    let equal = [Item::Load(V), Item::Const(0), Item::Branch(Cond::Eq, A)];
    becomes(&equal, &[Item::Load(V), Item::Branch(Cond::Zero, A)]);
    let unequal = [Item::Load(V), Item::Const(0), Item::Branch(Cond::Ne, A)];
    becomes(&unequal, &[Item::Load(V), Item::Branch(Cond::Nonzero, A)]);
}

#[test]
fn a_branch_takes_the_comparison_in() {
    let items = [Item::Plain(Op::Lt), Item::Branch(Cond::Zero, A)];
    becomes(&items, &[Item::Branch(Cond::Ge, A)]);
    let items = [Item::Plain(Op::Lt), Item::Branch(Cond::Nonzero, A)];
    becomes(&items, &[Item::Branch(Cond::Lt, A)]);
}

#[test]
fn a_branch_takes_a_logical_not_in() {
    let not = [Item::Load(V), Item::Const(0), Item::Plain(Op::Eq)];
    let items = [&not[..], &[Item::Branch(Cond::Zero, A)]].concat();
    becomes(&items, &[Item::Load(V), Item::Branch(Cond::Nonzero, A)]);
}

#[test]
fn a_low_input_stands_in_the_opcode() {
    let items = [Item::Const(3), Item::Plain(Op::In)];
    becomes(&items, &[Item::Short(Op::InShort, 2)]);
    let high = [Item::Const(5), Item::Plain(Op::In)];
    becomes(&high, &high);
}

#[test]
fn a_work_zero_needs_no_0() {
    let items = [Item::Const(0), Item::Flags(Op::SetPos, [1, 0, 0])];
    becomes(&items, &[Item::Short(Op::SetPosZero, 1)]);
}

#[test]
fn a_jump_to_a_jump_goes_where_that_goes() {
    let items = [
        Item::Branch(Cond::Zero, A),
        Item::Plain(Op::Drop),
        Item::Label(A),
        Item::Jump(B),
        Item::Plain(Op::Drop),
        Item::Label(B),
    ];
    let mut shorter = items.to_vec();
    peephole(&mut shorter, false);
    assert_eq!(shorter[0], Item::Branch(Cond::Zero, B));
}

#[test]
fn a_ring_of_jumps_stays_one() {
    let items = [Item::Label(A), Item::Jump(B), Item::Label(B), Item::Jump(A)];
    let mut shorter = items.to_vec();
    peephole(&mut shorter, false);
    assert!(shorter.iter().any(|item| matches!(item, Item::Jump(_))));
}

#[test]
fn a_jump_to_the_end_of_a_sub_is_that_end() {
    let items = [Item::Jump(A), Item::Label(B), Item::Plain(Op::Drop), Item::Label(A)];
    let items = [&items[..], &[Item::Plain(Op::ExitSub)]].concat();
    let mut shorter = items;
    peephole(&mut shorter, false);
    assert_eq!(shorter[0], Item::Plain(Op::ExitSub));
}

#[test]
fn a_branch_over_a_jump_is_the_opposite_branch() {
    let items = [
        Item::Branch(Cond::Lt, A),
        mark(MarkKind::Statement),
        Item::Jump(B),
        Item::Label(A),
        Item::Plain(Op::Drop),
    ];
    let mut shorter = items.to_vec();
    peephole(&mut shorter, false);
    assert_eq!(shorter[0], Item::Branch(Cond::Ge, B));
    assert!(!shorter.contains(&Item::Jump(B)));
}

#[test]
fn a_jump_to_what_follows_vanishes() {
    let items = [Item::Jump(A), mark(MarkKind::Glue), Item::Label(A), Item::Plain(Op::End)];
    becomes(&items, &items[1..]);
}

#[test]
fn code_that_nothing_reaches_vanishes() {
    let items = [Item::Plain(Op::End), Item::Load(V), Item::Plain(Op::Drop), Item::Label(A)];
    becomes(&items, &[Item::Plain(Op::End), Item::Label(A)]);
}

#[test]
fn a_constant_is_pushed_again_by_one_byte() {
    let items = [Item::Const(2540), Item::Const(2540)];
    becomes(&items, &[Item::Const(2540), Item::Plain(Op::Dup)]);
    let small = [Item::Const(3), Item::Const(3)];
    becomes(&small, &small);
}

#[test]
fn whole_millimetres_stand_in_the_effect() {
    let inline = |effect: u8, values: &[i8], flags: &[u8]| {
        let op = InlineOp::of(effect, values.len()).expect("there is such a form");
        Item::Inline(op, values.into(), flags.into())
    };
    let target = [Item::Const(25_000), Item::Short(Op::MoveTo, 1)];
    becomes(&target, &[inline(Op::MoveTo.code() + 1, &[25], &[])]);
    let both = [Item::Const(-3000), Item::Const(7000), Item::Short(Op::Line, 2)];
    becomes(&both, &[inline(Op::Line.code() + 2, &[-3, 7], &[])]);
    let bits = 0b011 | 2 << flags::COMMON_FRAME;
    let relative = [Item::Const(1000), Item::Const(2000), Item::Flags(Op::Linear, [bits, 0, 0])];
    becomes(&relative, &[inline(Op::Linear.code(), &[1, 2], &[bits])]);
}

#[test]
fn what_is_not_whole_millimetres_stays_on_the_stack() {
    let half = [Item::Const(2500), Item::Short(Op::MoveTo, 0)];
    becomes(&half, &half);
    let far = [Item::Const(128_000), Item::Short(Op::MoveTo, 0)];
    becomes(&far, &far);
    let zero = [Item::Const(0), Item::Short(Op::MoveTo, 0)];
    becomes(&zero, &zero);
    let bits = 0b001 | flags::COMMON_STEPS;
    let steps = [Item::Const(2000), Item::Flags(Op::Linear, [bits, 0, 0])];
    becomes(&steps, &steps);
}

#[test]
fn only_a_variable_that_is_read_first_needs_its_0() {
    assert!(written_first(&[Item::Const(1), Item::Store(V), Item::Load(V)], V));
    assert!(!written_first(&[Item::Load(V), Item::Store(V)], V));
    assert!(!written_first(&[Item::Change(Op::Inc, V)], V));
    assert!(!written_first(&[Item::Branch(Cond::Zero, A), Item::Const(1), Item::Store(V)], V));
}

#[test]
fn constants_take_their_shortest_form() {
    let lengths = [
        (0, 1),
        (31, 1),
        (32, 2),
        (127, 2),
        (-1, 2),
        (-128, 2),
        (129, 3),
        (2540, 2),
        (12_500, 2),
        (-12_800, 2),
        (25_000, 2),
        (-128_000, 2),
        (12_540, 3),
        (45_720, 3),
        (123_456, 5),
        (i32::MIN, 5),
    ];
    for (value, len) in lengths {
        assert_eq!(constant(value).len(), len, "{value}");
    }
}

#[test]
fn every_branch_has_a_comparison_and_an_inverse() {
    let all =
        [Cond::Zero, Cond::Nonzero, Cond::Eq, Cond::Ne, Cond::Lt, Cond::Le, Cond::Gt, Cond::Ge];
    for cond in all {
        assert_eq!(cond.inverse().inverse(), cond);
        assert_ne!(cond.inverse().op(), cond.op());
    }
    assert!(ROWS.iter().filter(|row| Cond::of(row.op).is_some()).count() == 6);
}

#[test]
fn every_form_with_millimetres_is_found_from_its_effect() {
    for code in isa::EFFECTS..=u8::MAX {
        if let Some(inline) = isa::inline(code) {
            let op = InlineOp::of(inline.code, inline.values.into());
            assert_eq!(op.map(InlineOp::code), Some(code));
        }
    }
}

/// As long and as wide as a file may be: a chain is refused by its length, and neither takes the
/// square of the number of SUBs.
#[test]
fn thousands_of_subs_are_followed_in_a_moment() {
    const SUBS: usize = 20_000;
    let chain: String = (0..SUBS)
        .map(|i| match i + 1 {
            SUBS => format!("SUB sub{i}\nn = n + 1\nEND SUB\n"),
            next => format!("SUB sub{i}\nsub{next}\nEND SUB\n"),
        })
        .collect();
    let backwards: String = (0..SUBS)
        .map(|i| match i {
            0 => "SUB sub0\nn = n + 1\nEND SUB\n".to_owned(),
            _ => format!("SUB sub{i}\nDIM a\na = n\nsub{}\nn = a\nEND SUB\n", i - 1),
        })
        .collect();
    let calls: String = (0..SUBS).map(|i| format!("sub{i}\n")).collect();
    let flat: String = (0..SUBS).map(|i| format!("SUB sub{i}\nn = n + 1\nEND SUB\n")).collect();
    let begun = std::time::Instant::now();
    for (script, refused) in [
        (format!("DIM n\nsub0\n{chain}"), true),
        (format!("DIM n\nsub{}\n{backwards}", SUBS - 1), true),
        (format!("DIM n\n{calls}{flat}"), false),
    ] {
        let source = crate::front::source::Source::new("subs.bas", script);
        let (program, diags) =
            crate::front::compile(&source, crate::front::ProfileChoice::built_in());
        let program = program.unwrap_or_else(|| panic!("{:?}", diags.into_sorted()));
        let excesses = super::compile(&program).err().unwrap_or_default();
        let calls = excesses.iter().find(|excess| excess.resource == super::Resource::Calls);
        assert_eq!(calls.map(|excess| excess.used), refused.then_some(SUBS));
    }
    // Some tenths of a second; the square of their number took minutes.
    assert!(begun.elapsed() < std::time::Duration::from_secs(30), "{:?}", begun.elapsed());
}
