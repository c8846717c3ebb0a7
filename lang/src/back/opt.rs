//! The peephole pass: shorter sequences for what lowering writes plainly.
//!
//! Each rule looks at a few neighbouring items, never across a label, and keeps the order in which
//! faults can come. Marks do not stop the rules that join a branch with the jump after it.

use std::collections::HashMap;

use crate::back::ir::{Cond, InlineOp, Item, Label};
use crate::back::report::MarkKind;
use crate::hir::VarId;
use crate::isa::{self, Op};

/// Applies all rules until none fits.
pub fn peephole(items: &mut Vec<Item>, resumes: bool) {
    loop {
        let before = items.len();
        let mut changed = thread_jumps(items);
        changed |= branch_over_jump(items);
        changed |= jump_to_next(items);
        changed |= unreachable(items, resumes);
        changed |= windows(items);
        if !changed && items.len() == before {
            break;
        }
    }
    whole_millimetres(items);
    repeated_constant(items);
    added_variables(items);
}

/// The sum with a variable is one instruction. Last, because other rules look for an addition.
fn added_variables(items: &mut Vec<Item>) {
    let mut out: Vec<Item> = Vec::with_capacity(items.len());
    for item in items.drain(..) {
        match (out.last(), item) {
            (Some(Item::Load(var)), Item::Plain(Op::Add)) => {
                let sum = Item::Change(Op::AddCell, *var);
                out.pop();
                out.push(sum);
            }
            (_, item) => out.push(item),
        }
    }
    *items = out;
}

/// Slides over the items and replaces what a rule recognises.
fn windows(items: &mut Vec<Item>) -> bool {
    let mut out: Vec<Item> = Vec::with_capacity(items.len());
    let mut changed = false;
    for item in items.drain(..) {
        out.push(item);
        while let Some((taken, replacement)) = rule(&out) {
            out.truncate(out.len() - taken);
            out.extend(replacement);
            changed = true;
        }
    }
    *items = out;
    changed
}

/// How many items at the end of `items` become what.
fn rule(items: &[Item]) -> Option<(usize, Vec<Item>)> {
    if let [.., a, b, c, d] = items
        && let Some(new) = change_variable(a, b, c, d)
    {
        return Some((4, new));
    }
    match items {
        [.., Item::Const(value), Item::Plain(Op::Neg)] if *value != i32::MIN => {
            Some((2, vec![Item::Const(-value)]))
        }
        [.., Item::Const(0), Item::Plain(Op::Add | Op::Sub | Op::Or | Op::Xor)]
        | [.., Item::Const(1), Item::Plain(Op::Mul | Op::Div)] => Some((2, vec![])),
        [.., Item::Const(n @ 1..=4), Item::Plain(Op::In)] => {
            Some((2, vec![Item::Short(Op::InShort, *n as u8 - 1)]))
        }
        [.., Item::Const(0), Item::Flags(Op::SetPos, [axis, ..])] => {
            Some((2, vec![Item::Short(Op::SetPosZero, *axis)]))
        }
        [.., Item::Const(0), Item::Store(var)] => Some((2, vec![Item::Zero(*var)])),
        [.., Item::Const(0), Item::Branch(Cond::Eq, to)] => {
            Some((2, vec![Item::Branch(Cond::Zero, *to)]))
        }
        [.., Item::Const(0), Item::Branch(Cond::Ne, to)] => {
            Some((2, vec![Item::Branch(Cond::Nonzero, *to)]))
        }
        [.., Item::Plain(op), Item::Branch(cond @ (Cond::Zero | Cond::Nonzero), to)] => {
            let fused = Cond::of(*op)?;
            let fused = if *cond == Cond::Nonzero { fused } else { fused.inverse() };
            Some((2, vec![Item::Branch(fused, *to)]))
        }
        _ => None,
    }
}

/// `v = v + 1` and its like.
fn change_variable(a: &Item, b: &Item, c: &Item, d: &Item) -> Option<Vec<Item>> {
    match (a, b, c, d) {
        (Item::Load(var), Item::Const(1), Item::Plain(Op::Add), Item::Store(same))
        | (Item::Const(1), Item::Load(var), Item::Plain(Op::Add), Item::Store(same))
        | (Item::Load(var), Item::Const(-1), Item::Plain(Op::Sub), Item::Store(same))
            if var == same =>
        {
            Some(vec![Item::Change(Op::Inc, *var)])
        }
        _ => None,
    }
}

fn is_glue(item: &Item) -> bool {
    matches!(item, Item::Label(_))
        || matches!(item, Item::Mark(mark) if mark.kind == MarkKind::Glue)
}

/// How many jumps to jumps are followed: a ring of jumps stays one.
const MAX_HOPS: usize = 8;

/// A jump to a jump goes where that goes; one to the end of a SUB is that end.
fn thread_jumps(items: &mut [Item]) -> bool {
    let mut behind: HashMap<Label, Item> = HashMap::new();
    let mut waiting: Vec<Label> = Vec::new();
    for item in items.iter() {
        match item {
            Item::Label(label) => waiting.push(*label),
            item if is_glue(item) => {}
            item => {
                for label in waiting.drain(..) {
                    behind.insert(label, item.clone());
                }
            }
        }
    }
    let mut changed = false;
    for item in items.iter_mut() {
        if matches!(item, Item::Gosub(_) | Item::OnError(_)) {
            continue;
        }
        let Some(first) = item.target() else { continue };
        let mut label = first;
        for _ in 0..MAX_HOPS {
            match behind.get(&label) {
                Some(Item::Jump(next)) => label = *next,
                _ => break,
            }
        }
        let ends_sub = behind.get(&label) == Some(&Item::Plain(Op::ExitSub));
        if ends_sub && matches!(item, Item::Jump(_)) {
            *item = Item::Plain(Op::ExitSub);
            changed = true;
        } else if let Some(target) = item.target_mut()
            && label != first
            && !matches!(behind.get(&label), Some(Item::Jump(_)))
        {
            *target = label;
            changed = true;
        }
    }
    changed
}

/// Drops the items whose flag is set.
fn drop_marked(items: &mut Vec<Item>, dropped: &[bool]) -> bool {
    let before = items.len();
    let mut index = 0;
    items.retain(|_| {
        index += 1;
        !dropped[index - 1]
    });
    items.len() != before
}

/// A branch over a jump becomes the opposite branch.
fn branch_over_jump(items: &mut Vec<Item>) -> bool {
    let mut dropped = vec![false; items.len()];
    for i in 0..items.len() {
        let Item::Branch(cond, over) = items[i] else { continue };
        let mut rest = items[i + 1..].iter().enumerate();
        let Some((jump, Item::Jump(to))) =
            rest.by_ref().find(|(_, item)| !matches!(item, Item::Mark(_)))
        else {
            continue;
        };
        let mut lands = rest.take_while(|(_, item)| is_glue(item));
        if lands.any(|(_, item)| *item == Item::Label(over)) {
            items[i] = Item::Branch(cond.inverse(), *to);
            dropped[i + 1 + jump] = true;
        }
    }
    drop_marked(items, &dropped)
}

/// A jump to what follows anyway.
fn jump_to_next(items: &mut Vec<Item>) -> bool {
    let mut dropped = vec![false; items.len()];
    for i in 0..items.len() {
        let Item::Jump(to) = items[i] else { continue };
        let mut lands = items[i + 1..].iter().take_while(|item| is_glue(item));
        dropped[i] = lands.any(|item| *item == Item::Label(to));
    }
    drop_marked(items, &dropped)
}

/// Code behind an instruction that never falls through, up to the next label, or with `resumes`
/// up to the next statement: RESUME NEXT may go on there.
fn unreachable(items: &mut Vec<Item>, resumes: bool) -> bool {
    let mut dead = false;
    let before = items.len();
    items.retain(|item| {
        if matches!(item, Item::Label(_)) || resumes && matches!(item, Item::Mark(_)) {
            dead = false;
        }
        let keep = !dead;
        dead |= item.ends();
        keep
    });
    items.len() != before
}

/// Moves whose values are constants and whole millimetres take them into the code.
fn whole_millimetres(items: &mut Vec<Item>) {
    let mut out: Vec<Item> = Vec::with_capacity(items.len());
    for item in items.drain(..) {
        let inlined = match &item {
            Item::Short(op, n) => inlined(&out, op.code() + n, &[]),
            Item::Plain(op) => inlined(&out, op.code(), &[]),
            Item::Flags(op @ (Op::Linear | Op::Move), flags) => {
                inlined(&out, op.code(), &flags[..1])
            }
            Item::Flags(op @ Op::Probe, flags) => inlined(&out, op.code(), &flags[..2]),
            _ => None,
        };
        match inlined {
            Some((taken, item)) => {
                out.truncate(out.len() - taken);
                out.push(item);
            }
            None => out.push(item),
        }
    }
    *items = out;
}

/// The form with millimetres of an effect whose arguments end `before`, and how many those are;
/// `None` when there is none or it would be no shorter.
fn inlined(before: &[Item], effect: u8, flags: &[u8]) -> Option<(usize, Item)> {
    let first = flags.first().copied().unwrap_or(0);
    let in_steps = match Op::decode(effect)?.0 {
        Op::Linear => first & isa::flags::COMMON_STEPS,
        Op::Move | Op::Probe => first & (isa::flags::STEPS | isa::flags::SPEED_STEPS),
        _ => 0,
    };
    if in_steps != 0 {
        return None;
    }
    let second = flags.get(1).copied().unwrap_or(0);
    let count = usize::from(isa::shape(effect)?.pops() + isa::arguments(effect, first, second));
    let op = InlineOp::of(effect, count)?;
    let values = before.get(before.len().checked_sub(count)?..)?;
    let millimetres = |item: &Item| match item {
        Item::Const(um) if um % 1000 == 0 => i8::try_from(um / 1000).ok(),
        _ => None,
    };
    let values: Box<[i8]> = values.iter().map(millimetres).collect::<Option<_>>()?;
    // A 0 alone takes a byte on the stack too.
    if values.iter().all(|&value| value == 0) {
        return None;
    }
    Some((count, Item::Inline(op, values, flags.into())))
}

/// A constant of two bytes or more that was just pushed is pushed again by one byte.
fn repeated_constant(items: &mut [Item]) {
    for i in 1..items.len() {
        let (before, rest) = items.split_at_mut(i);
        let Some(Item::Const(first)) = before.last() else { continue };
        if let Item::Const(second) = rest[0]
            && *first == second
            && !(0..isa::SMALL).contains(&second)
        {
            rest[0] = Item::Plain(Op::Dup);
        }
    }
}

/// Whether a variable is written before it can be read, so that it needs no 0 at a call.
pub fn written_first(items: &[Item], var: VarId) -> bool {
    for item in items {
        match item {
            Item::Store(stored) | Item::Zero(stored) if *stored == var => return true,
            Item::Load(loaded) if *loaded == var => return false,
            Item::Const(_)
            | Item::Zero(_)
            | Item::Inline(..)
            | Item::Load(_)
            | Item::Store(_)
            | Item::StoreAt(..)
            | Item::LoadElem(_)
            | Item::StoreElem(_)
            | Item::Table(..)
            | Item::Text(_)
            | Item::Run(_)
            | Item::Course(_)
            | Item::Mark(_)
            | Item::Flags(..)
            | Item::Short(..) => {}
            Item::Change(_, changed) if *changed != var => {}
            Item::Plain(_) if !item.ends() => {}
            _ => return false,
        }
    }
    false
}
