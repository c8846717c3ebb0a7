//! From instructions to bytes: shortest forms, addresses, the image.

use std::collections::HashMap;

use crate::back::cells::{self, Cells};
use crate::back::courses::Courses;
use crate::back::data::{self, Data};
use crate::back::graph::Graph;
use crate::back::ir::{Cond, Handler, Item, Label, RoutineCode, Unit};
use crate::back::places::{NO_RESUME, close, parted};
use crate::back::report::{Compiled, Mark, MarkKind, Sidecar, VarPlace};
use crate::hir::{Limits, Program, RoutineId, Storage, VarId};
use crate::image::statements::{self, Place};
use crate::image::{self, HEADER, Header, MAX_CELLS, NARROW, pool_limit};
use crate::isa::{LOW_CELLS, Op, SHORT_CELLS, SMALL};
use crate::record::{MachineRecord, feature};

/// Where the items of each routine lie in the image, and their bytes.
pub fn places(
    program: &Program,
    unit: &Unit,
    cells: &Cells,
) -> HashMap<RoutineId, Vec<(usize, usize)>> {
    let plain = Emitter::new(program, unit, cells, false);
    let of = |routine: &RoutineCode| {
        let first = plain.entries.get(&routine.id).copied().unwrap_or(0);
        let all = first..first + routine.items.len();
        (routine.id, all.map(|i| (plain.addresses[i], plain.sizes[i])).collect())
    };
    unit.routines.iter().map(of).collect()
}

/// Writes the image of a program that fits.
pub fn emit(
    program: &Program,
    mut unit: Unit,
    graph: &Graph,
    cells: &Cells,
    courses: &Courses,
) -> Compiled {
    courses.insert(program, &mut unit, cells);
    let narrow = Emitter::new(program, &unit, cells, false).finish();
    let fits = |code: &Code| {
        let parts = [
            HEADER,
            MachineRecord::SIZE,
            code.bytes.len(),
            code.data.bytes.len(),
            code.table.len(),
        ];
        parts.iter().sum::<usize>() <= NARROW
    };
    let (code, wide) = if fits(&narrow) {
        (narrow, false)
    } else {
        (Emitter::new(program, &unit, cells, true).finish(), true)
    };
    let profile = MachineRecord::of(&program.profile);
    let profile_hash = profile.hash();
    let limits = if code.limits { MachineRecord::AT_LIMITS } else { 0 };
    let (flag, stack) = match courses.records.is_empty() {
        true => (0, graph.stack()),
        false => (MachineRecord::COURSES, graph.stack() + usize::from(courses.pool / 4)),
    };
    let own = MachineRecord {
        flags: profile.flags | limits | flag,
        keeps: cells::keeps_id(program, cells),
        ..profile
    };
    let machine = own.to_bytes();
    let data_len = code.data.bytes.len() + code.table.len();
    let features = unit.features | if wide { feature::WIDE } else { 0 };
    let header = Header {
        features: features as u8,
        len: HEADER + machine.len() + code.bytes.len() + data_len,
        code_len: code.bytes.len(),
        entry: code.entry,
        cells: cells.count as u16,
        stack: stack as u8,
        frame: graph.frame as u8,
        calls: graph.calls as u8,
        keeps: cells.kept as u8,
        keep_base: cells.keep_base as u8,
        profile_hash,
    };
    let mut image = header.bytes().to_vec();
    image.extend(machine);
    image.extend(&code.bytes);
    image.extend(&code.data.bytes);
    image.extend(&code.table);
    image::seal(&mut image);
    let mut vars: Vec<VarPlace> = cells
        .of
        .iter()
        .map(|(&var, &cell)| VarPlace { var, cell, len: program.var(var).len })
        .collect();
    vars.sort_unstable_by_key(|place| (place.cell, place.var));
    let depths = 4 * graph.stack() + 2 * graph.calls;
    Compiled {
        image,
        sidecar: Sidecar { marks: code.marks },
        vars,
        statements: program.statements,
        code_bytes: code.bytes.len(),
        table_bytes: data_len,
        cells: cells.count,
        cells_available: (pool_limit(features as u8).saturating_sub(depths) / 4).min(MAX_CELLS),
        stack: graph.stack(),
        calls: graph.calls,
        keeps: cells.kept,
    }
}

/// What [`limits`](crate::image::limits) holds: of each AT variable with MIN or MAX its cells and these.
fn limits(program: &Program, cells: &Cells) -> Vec<i32> {
    let bound = |var: VarId| {
        let var = program.var(var);
        matches!(var.storage, Storage::At(_)) && var.panel.limits != Limits::default()
    };
    let mut vars: Vec<_> = cells.of.iter().filter(|(var, _)| bound(**var)).collect();
    vars.sort_unstable_by_key(|(_, cell)| **cell);
    let values = vars.into_iter().flat_map(|(&var, &cell)| {
        let var = program.var(var);
        let Limits { least, greatest } = var.panel.limits;
        [cell as i32, var.len as i32, least, greatest]
    });
    values.collect()
}

/// The shortest instruction that pushes `value`.
pub fn constant(value: i32) -> Vec<u8> {
    let with = |op: Op, bytes: &[u8]| [&[op.code()], bytes].concat();
    let quotient = |by: i32| (value % by == 0).then(|| value / by);
    let signed = |by| quotient(by).and_then(|quotient| i8::try_from(quotient).ok());
    if let 0..SMALL = value {
        return vec![Op::Small.code() + value as u8];
    }
    if let Ok(byte) = i8::try_from(value) {
        return with(Op::Byte, &byte.to_le_bytes());
    }
    if let Some(byte) = signed(1000) {
        return with(Op::Thousands, &byte.to_le_bytes());
    }
    if let Some(byte) = signed(100) {
        return with(Op::Hundreds, &byte.to_le_bytes());
    }
    if let Some(byte) = quotient(10).and_then(|quotient| u8::try_from(quotient).ok()) {
        return with(Op::Tens, &[byte]);
    }
    if let Ok(word) = i16::try_from(value) {
        return with(Op::Word, &word.to_le_bytes());
    }
    if let Some(word) = quotient(10).and_then(|quotient| i16::try_from(quotient).ok()) {
        return with(Op::WordTens, &word.to_le_bytes());
    }
    with(Op::Long, &value.to_le_bytes())
}

/// Finished code.
struct Code {
    bytes: Vec<u8>,
    entry: usize,
    data: Data,
    /// AT variables have limits.
    limits: bool,
    /// The statement table.
    table: Vec<u8>,
    marks: Vec<Mark>,
}

struct Emitter<'a> {
    program: &'a Program,
    unit: &'a Unit,
    cells: &'a Cells,
    wide: bool,
    items: Vec<&'a Item>,
    /// Where each routine begins in `items`.
    entries: HashMap<RoutineId, usize>,
    labels: HashMap<Label, usize>,
    /// How long each item is, so far.
    sizes: Vec<usize>,
    addresses: Vec<usize>,
    data: Data,
    /// Where in the data the limits of AT variables stand, if there are any.
    limits: Option<usize>,
}

impl<'a> Emitter<'a> {
    fn new(program: &'a Program, unit: &'a Unit, cells: &'a Cells, wide: bool) -> Emitter<'a> {
        let address = 2 + usize::from(wide);
        let mut head = Vec::new();
        if unit.features & feature::EVENTS != 0 {
            head.push(unit.events.len() as u8);
            head.resize(1 + address * unit.events.len(), 0);
        }
        if unit.features & feature::LINES != 0 {
            head.resize(head.len() + address, 0);
        }
        let limits = limits(program, cells);
        if !limits.is_empty() {
            head.resize(head.len() + address, 0);
        }
        let mut data = data::lay_out(program, unit, head);
        let limits = (!limits.is_empty()).then(|| {
            let at = data.bytes.len();
            data.bytes.extend(data::column(&limits));
            at
        });
        let mut emitter = Emitter {
            program,
            unit,
            cells,
            wide,
            items: Vec::new(),
            entries: HashMap::new(),
            labels: HashMap::new(),
            sizes: Vec::new(),
            addresses: Vec::new(),
            data,
            limits,
        };
        emitter.arrange(false);
        emitter.relax();
        if emitter.entry() > usize::from(u16::MAX) {
            emitter.arrange(true);
            emitter.relax();
        }
        emitter
    }

    /// Puts the routines in order: those that are called most come first, where a call takes two
    /// bytes, and the main program behind them, unless that would lie too far.
    fn arrange(&mut self, main_first: bool) {
        let mut calls: HashMap<RoutineId, usize> = HashMap::new();
        for item in self.unit.routines.iter().flat_map(|routine| &routine.items) {
            if let Item::Call(_, id) = item {
                *calls.entry(*id).or_default() += 1;
            }
        }
        let mut order: Vec<_> = self.unit.routines.iter().collect();
        order.sort_by_key(|routine| {
            let main = routine.id.0 == 0;
            let uses = calls.get(&routine.id).copied().unwrap_or(0);
            (main != main_first, core::cmp::Reverse(uses), routine.items.len())
        });
        self.items.clear();
        for routine in order {
            self.entries.insert(routine.id, self.items.len());
            self.items.extend(&routine.items);
        }
        self.labels.clear();
        for (i, item) in self.items.iter().enumerate() {
            if let Item::Label(label) = item {
                self.labels.insert(*label, i);
            }
        }
    }

    fn entry(&self) -> usize {
        self.entries.get(&RoutineId(0)).map_or(0, |&i| self.addresses[i])
    }

    fn address_of(&self, label: Label) -> usize {
        self.labels.get(&label).map_or(0, |&i| self.addresses[i])
    }

    fn address_of_routine(&self, id: RoutineId) -> usize {
        self.entries.get(&id).map_or(0, |&i| self.addresses[i])
    }

    /// Starts from the shortest forms and lengthens what does not reach, until all do.
    fn relax(&mut self) {
        self.sizes = vec![0; self.items.len()];
        self.addresses = vec![0; self.items.len() + 1];
        for i in 0..self.items.len() {
            // All labels still lie at 0, within reach.
            self.sizes[i] = self.bytes(i).len();
        }
        loop {
            let mut address = 0;
            for (i, size) in self.sizes.iter().enumerate() {
                self.addresses[i] = address;
                address += size;
            }
            self.addresses[self.items.len()] = address;
            let mut grown = false;
            for i in 0..self.items.len() {
                let size = self.bytes(i).len();
                grown |= size > self.sizes[i];
                self.sizes[i] = size;
            }
            if !grown {
                break;
            }
        }
    }

    fn address(&self, value: usize) -> Vec<u8> {
        (value as u32).to_le_bytes()[..2 + usize::from(self.wide)].to_vec()
    }

    fn cell(&self, var: VarId) -> u8 {
        self.cells.cell(var) as u8
    }

    /// Short form up to cell 31.
    fn on_cell(short: Op, far: Op, cell: u8) -> Vec<u8> {
        if cell < SHORT_CELLS { vec![short.code() + cell] } else { vec![far.code(), cell] }
    }

    /// An offset into the data in one byte, or in an address.
    fn on_data(&self, short: Op, far: Op, offset: usize) -> Vec<u8> {
        match u8::try_from(offset) {
            Ok(offset) => vec![short.code(), offset],
            Err(_) => [&[far.code()], &self.address(offset)[..]].concat(),
        }
    }

    /// Distance from the end of an instruction of `len` bytes at item `i`, if eight bits hold it.
    /// An item that once took its long form keeps it.
    fn distance(&self, i: usize, len: usize, target: usize) -> Option<u8> {
        if self.sizes[i] > len {
            return None;
        }
        let distance = target as i64 - (self.addresses[i] + len) as i64;
        i8::try_from(distance).ok().map(|distance| distance as u8)
    }

    fn far(&self, op: Op, target: usize) -> Vec<u8> {
        [&[op.code()], &self.address(target)[..]].concat()
    }

    /// The bytes of item `i` at its present address.
    fn bytes(&self, i: usize) -> Vec<u8> {
        match self.items[i] {
            Item::Const(value) => constant(*value),
            Item::Zero(var) => match self.cell(*var) {
                cell @ 0..LOW_CELLS => vec![Op::Zero.code() + cell],
                cell => {
                    let mut bytes = constant(0);
                    bytes.extend(Self::on_cell(Op::Store, Op::StoreFar, cell));
                    bytes
                }
            },
            Item::Inline(op, values, flags) => {
                let mut bytes = vec![op.code()];
                bytes.extend(values.iter().map(|value| *value as u8));
                bytes.extend(flags);
                bytes
            }
            Item::Load(var) => Self::on_cell(Op::Load, Op::LoadFar, self.cell(*var)),
            Item::Store(var) => Self::on_cell(Op::Store, Op::StoreFar, self.cell(*var)),
            Item::StoreAt(var, index) => {
                Self::on_cell(Op::Store, Op::StoreFar, self.cell(*var) + *index as u8)
            }
            Item::Change(op, var) => match (op, self.cell(*var)) {
                (Op::Inc, cell @ 0..LOW_CELLS) => vec![Op::IncShort.code() + cell],
                (op, cell) => vec![op.code(), cell],
            },
            Item::LoadElem(var) => self.on_array(Op::LoadElem, *var),
            Item::StoreElem(var) => self.on_array(Op::StoreElem, *var),
            Item::Plain(op) => vec![op.code()],
            Item::Short(op, n) => vec![op.code() + n],
            Item::Flags(op, flags) => {
                let count = op.row().operands.len(false);
                [&[op.code()], &flags[..count.min(3)]].concat()
            }
            Item::Jump(label) => {
                let target = self.address_of(*label);
                match self.distance(i, 2, target) {
                    Some(distance) => vec![Op::Jump.code(), distance],
                    None => self.far(Op::JumpFar, target),
                }
            }
            Item::Branch(cond, label) => self.branch(i, *cond, self.address_of(*label)),
            Item::OnError(label) => self.far(Op::OnError, self.address_of(*label)),
            Item::Turn(op, var, label) => {
                self.turn(i, vec![op.code(), self.cell(*var)], self.address_of(*label))
            }
            Item::NextLimit(var, limit, label) => {
                let cell = self.cell(*var);
                let [low, high] = limit.to_le_bytes();
                let head = match (cell, limit) {
                    (0..LOW_CELLS, 0..256) => vec![Op::NextShort.code() + cell, low],
                    _ => vec![Op::NextWord.code(), cell, low, high],
                };
                self.turn(i, head, self.address_of(*label))
            }
            Item::Call(op, id) => {
                let target = self.address_of_routine(*id);
                match u8::try_from(target) {
                    Ok(target) if *op == Op::Call && self.sizes[i] <= 2 => vec![op.code(), target],
                    _ if *op == Op::Func => self.far(Op::Func, target),
                    _ => self.far(Op::CallFar, target),
                }
            }
            Item::Gosub(label) => self.far(Op::Gosub, self.address_of(*label)),
            Item::Table(table, column) => {
                self.on_data(Op::Table, Op::TableFar, self.data.column((*table, *column)))
            }
            Item::Text(id) => self.on_data(Op::PrintText, Op::PrintTextFar, self.data.text(*id)),
            Item::Run(id) => self.far(Op::Run, self.data.text(*id)),
            Item::Course(id) => self.far(Op::Course, self.data.text(*id)),
            Item::Label(_) | Item::Mark(_) => Vec::new(),
        }
    }

    fn on_array(&self, op: Op, var: VarId) -> Vec<u8> {
        vec![op.code(), self.cell(var), self.program.var(var).len as u8]
    }

    fn branch(&self, i: usize, cond: Cond, target: usize) -> Vec<u8> {
        if let Some(distance) = self.distance(i, 2, target) {
            return vec![cond.op().code(), distance];
        }
        let jump = self.far(Op::JumpFar, target);
        [&[cond.inverse().op().code(), jump.len() as u8], &jump[..]].concat()
    }

    /// A loop instruction; out of reach it goes through a far jump behind it.
    fn turn(&self, i: usize, head: Vec<u8>, target: usize) -> Vec<u8> {
        if let Some(distance) = self.distance(i, head.len() + 1, target) {
            return [&head[..], &[distance]].concat();
        }
        let jump = self.far(Op::JumpFar, target);
        [&head[..], &[2, Op::Jump.code(), jump.len() as u8], &jump].concat()
    }

    fn finish(mut self) -> Code {
        let mut bytes = Vec::with_capacity(self.addresses[self.items.len()]);
        let mut marks = Vec::new();
        let mut places: Vec<Place> = Vec::new();
        // Where nothing is on the stack, inside statements.
        let (mut depth, mut parts) = (0, Vec::new());
        for i in 0..self.items.len() {
            if let Item::Mark(mark) = self.items[i] {
                let pc = self.addresses[i];
                if let Some(before) = places.last_mut() {
                    close(before, pc);
                }
                let resume = mark.resume.map_or(NO_RESUME, |label| self.address_of(label));
                places.push(Place {
                    line: mark.line as usize,
                    resume,
                    start: pc,
                    entry: pc,
                    end: 0,
                });
                marks.push(Mark { pc, line: mark.line, span: mark.span.clone(), kind: mark.kind });
            }
            bytes.extend(self.bytes(i));
            let (pops, pushes) = self.items[i].effect();
            depth = if self.items[i].ends() { 0 } else { depth + pushes - depth.min(pops) };
            if depth == 0 {
                parts.push(bytes.len());
            }
        }
        let table = self.statement_table(&mut places, &parts, bytes.len());
        self.fill_head();
        if marks.first().is_none_or(|mark| mark.pc != 0) {
            marks.insert(0, Mark { pc: 0, line: 1, span: 0..0, kind: MarkKind::Glue });
        }
        let limits = self.limits.is_some();
        Code { bytes, entry: self.entry(), data: self.data, limits, table, marks }
    }

    /// The statement table of a program with ON ERROR. The last place, the END of the main program
    /// or of a SUB, cannot fail: it needs no entry.
    fn statement_table(&self, places: &mut Vec<Place>, parts: &[usize], end: usize) -> Vec<u8> {
        if self.unit.features & feature::LINES == 0 {
            return Vec::new();
        }
        if let Some(last) = places.last_mut() {
            close(last, end);
        }
        places.retain(|place| place.start != place.end);
        places.pop();
        let places: Vec<Place> = places.iter().flat_map(|place| parted(*place, parts)).collect();
        statements::write(&places, self.wide)
    }

    fn fill_head(&mut self) {
        let mut head = Vec::new();
        if self.unit.features & feature::EVENTS != 0 {
            head.push(self.unit.events.len() as u8);
            for handler in &self.unit.events {
                head.extend(self.address(match handler {
                    Handler::Label(label) => self.address_of(*label),
                    Handler::Routine(id) => self.address_of_routine(*id),
                }));
            }
        }
        if self.unit.features & feature::LINES != 0 {
            head.extend(self.address(self.data.bytes.len()));
        }
        head.extend(self.limits.map(|at| self.address(at)).into_iter().flatten());
        self.data.bytes[..head.len()].copy_from_slice(&head);
    }
}
