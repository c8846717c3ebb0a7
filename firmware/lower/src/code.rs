//! Notation of micro-code from functions.
//!
//! What is known makes it short: r12 is 0 when a register is read, so a rule that says 0 says nothing; all words
//! of a file have one end, which the last of them falls into; a bit of a byte that is the word's own comes over as it is.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use micro::isa::{CALLED, OWN, Operand, ROUTINES};

use crate::front::{Body, Cond, Function, Number, Stmt, Value};
use crate::leaf::{Holds, Leaf, Leaves};
use crate::{Made, Refused};

/// Where a word is made: its bytes are scratch of one routine.
const WORD: [&str; 2] = ["TEMP", "TEMP+1"];

/// What is written so far.
struct Writer<'a> {
    leaves: &'a Leaves,
    /// The file's name, in labels.
    file: &'a str,
    text: String,
    labels: usize,
    bytes: usize,
    /// Ends that there are: an operation and RETURN.
    tails: BTreeMap<String, String>,
}

/// Writes all functions of a file.
///
/// # Errors
/// A condition that no jump can tell, or a leaf of another kind.
pub fn write(functions: &[Function], leaves: &Leaves, file: &str) -> Result<Made, Refused> {
    let text = format!(
        "/* Made by `cargo run -p lower` of firmware/src/rules/{file}.rs: change that. */\n\n    \
         .section .text.micro,\"axR\",@progbits\nmodule.link.{file}:\n"
    );
    let mut writer = Writer { leaves, file, text, labels: 0, bytes: 0, tails: BTreeMap::new() };
    let mut bytes = Vec::new();
    let is_word = |function: &&Function| matches!(function.body, Body::Word(..));
    let last = functions.iter().rfind(is_word).map(|function| &function.name);
    let [words, others] = [true, false]
        .map(|wanted| functions.iter().filter(move |function| is_word(function) == wanted));
    // Words last, so that one of them falls into their end.
    for function in others.chain(words) {
        writer.bytes = 0;
        let falls = Some(&function.name) == last;
        writer.function(function, falls)?;
        bytes.push((function.name.clone(), writer.bytes));
    }
    writer.op("    .balign 2, 0");
    Ok(Made { text: writer.text, bytes })
}

/// Bytes of a line.
fn size(line: &str) -> usize {
    let mut words = line.split_whitespace();
    let (Some(name), operands) = (words.next(), words.collect::<Vec<_>>()) else { return 0 };
    match name {
        "F" | "FR" => 2,
        "DO" => 1,
        "LIT" => 1 + usize::from(operands != ["0"]),
        _ => {
            let row = OWN.iter().find(|row| row.notation == Some(name));
            let bytes = |operand: &Operand| match operand {
                Operand::Word | Operand::Routine => 2,
                _ => 1,
            };
            row.map_or(0, |row| 1 + row.operands.iter().map(bytes).sum::<usize>())
        }
    }
}

fn symbol(name: &str) -> String {
    format!("map_{name}")
}

impl Writer<'_> {
    fn op(&mut self, line: &str) {
        self.bytes += size(line);
        let _ = writeln!(self.text, "{line}");
    }

    /// Operations that stand in a leaf, one behind the other.
    fn ops(&mut self, code: &str) {
        for op in code.split(';') {
            self.op(&format!("    {}", op.trim()));
        }
    }

    fn label(&mut self) -> String {
        self.labels += 1;
        format!(".L{}_{}", self.file, self.labels)
    }

    fn place(&mut self, label: &str) {
        let _ = writeln!(self.text, "{label}:");
    }

    fn end(&self) -> String {
        format!(".L{}_word", self.file)
    }

    fn function(&mut self, function: &Function, falls: bool) -> Result<(), Refused> {
        let name = symbol(&function.name);
        let numbered = ROUTINES.iter().chain(CALLED).any(|row| row.label == name);
        let _ = writeln!(self.text, "    /* {} */", function.name);
        if numbered {
            self.op(&format!("    ROUTINE_ODD {name}, module.link.{}", self.file));
        } else {
            self.place(&name);
        }
        match &function.body {
            Body::Cond(Cond::Within(byte, first, last)) => {
                self.get(byte)?;
                self.op(&format!("    ADDI -{}", first.text));
                self.op(&format!("    CMPI {}+1-{}", last.text, first.text));
                self.op("    RETURN");
            }
            Body::Cond(cond) => {
                return self.refuse(&format!("{}: {cond:?} leaves no flag", function.name));
            }
            Body::Leaf(leaf) => {
                match self.leaves.get(leaf).cloned() {
                    Some(Leaf::Byte(byte)) => self.op(&format!("    GET {byte}")),
                    Some(Leaf::Word(word)) => self.op(&format!("    F word {word}")),
                    Some(Leaf::Number(code)) => self.ops(&code),
                    Some(Leaf::Any(place, Some(1))) => {
                        let Some((byte, mask)) = place.split_once(", ") else {
                            return self.refuse(&format!("{leaf}: a byte and its bits"));
                        };
                        self.same(mask, 1);
                        self.op(&format!("    GET {byte}"));
                        self.op(&format!("    ANDI {mask}"));
                    }
                    _ => return self.refuse(&format!("{leaf} is no number and no bit that is 1")),
                }
                self.op("    RETURN");
            }
            Body::Less(first, second) => {
                let leaves = self.leaves;
                let (Some(Leaf::Word(a)), Some(Leaf::Word(b))) =
                    (leaves.get(first), leaves.get(second))
                else {
                    return self.refuse(&format!("{first}, {second}: words"));
                };
                self.op(&format!("    F word {a}"));
                self.tail(&format!("    F sub {b}"));
            }
            Body::Either(cond, number) => {
                let end = self.label();
                self.unless(cond, &end)?;
                self.number(number);
                self.place(&end);
                self.op("    RETURN");
            }
            Body::Word(value, high, stmts) => {
                let end = self.end();
                let rest = self.begin(value, *high, stmts)?;
                self.stmts(rest, &end)?;
                if falls {
                    self.place(&end);
                    self.op(&format!("    F word {}", WORD[0]));
                    self.op("    RETURN");
                } else if !self.jumps_to(&end) {
                    self.op(&format!("    GOTO {end}"));
                }
            }
        }
        Ok(())
    }

    /// An operation and RETURN: the same of a function before is gone on with.
    fn tail(&mut self, line: &str) {
        if let Some(label) = self.tails.get(line).cloned() {
            self.op(&format!("    GOTO {label}"));
            return;
        }
        let label = self.label();
        self.place(&label);
        self.tails.insert(line.to_owned(), label);
        self.op(line);
        self.op("    RETURN");
    }

    /// The assembler sees to it that a bit is what the leaf says.
    fn same(&mut self, mask: &str, bit: u16) {
        self.op(&format!("    .if {mask} != {bit}"));
        self.op("    .error \"a leaf's bit\"");
        self.op("    .endif");
    }

    /// Whether the last operation goes there anyhow.
    fn jumps_to(&self, label: &str) -> bool {
        self.text.trim_end().ends_with(&format!("GOTO {label}"))
    }

    fn refuse<T>(&self, text: &str) -> Result<T, Refused> {
        Err(Refused { line: 0, text: text.to_owned() })
    }

    fn get(&mut self, leaf: &str) -> Result<(), Refused> {
        let Some(Leaf::Byte(byte)) = self.leaves.get(leaf) else {
            return self.refuse(&format!("{leaf} is no byte"));
        };
        self.op(&format!("    GET {byte}"));
        Ok(())
    }

    /// r12 = a number.
    fn number(&mut self, number: &Number) {
        let op = if number.value.is_some_and(|value| value > 0xFF) { "LIT16" } else { "LIT" };
        self.op(&format!("    {op} {}", number.text));
    }

    /// The word's first value; statements that it has done already are left out.
    fn begin<'s>(
        &mut self,
        value: &Value,
        high: bool,
        stmts: &'s [Stmt],
    ) -> Result<&'s [Stmt], Refused> {
        let clear = format!("    F clear {}", WORD[0]);
        match value {
            Value::Number(zero) if zero.value == Some(0) => {
                if let Some((Stmt::If(Cond::Leaf(leaf), then, other), rest)) = stmts.split_first()
                    && let Some(Leaf::Any(place, Some(bit))) = self.leaves.get(leaf)
                    && let [Stmt::Or(Value::Number(number), false)] = &then[..]
                    && number.value == Some(*bit)
                    && other.is_empty()
                    && let Some((byte, mask)) = place.split_once(", ")
                {
                    let (byte, mask) = (byte.to_owned(), mask.to_owned());
                    self.same(&mask, *bit);
                    self.op(&format!("    GET {byte}"));
                    self.op(&format!("    ANDI {mask}"));
                    self.op(&format!("    F put {}", WORD[0]));
                    return Ok(rest);
                }
                self.op(&clear);
            }
            Value::Byte(leaf) if high => {
                self.op(&clear);
                self.get(leaf)?;
                self.op(&format!("    PUT {}", WORD[1]));
            }
            Value::Byte(leaf) => {
                self.get(leaf)?;
                self.op(&format!("    F put {}", WORD[0]));
            }
            value => return self.refuse(&format!("a word does not begin with {value:?}")),
        }
        Ok(stmts)
    }

    /// Statements, behind which all goes on at `end`.
    fn stmts(&mut self, stmts: &[Stmt], end: &str) -> Result<(), Refused> {
        for (n, stmt) in stmts.iter().enumerate() {
            let last = n + 1 == stmts.len();
            match stmt {
                Stmt::Or(value, high) => self.or(value, *high)?,
                Stmt::If(cond, then, other) => {
                    let behind = if last { end.to_owned() } else { self.label() };
                    if other.is_empty() {
                        self.unless(cond, &behind)?;
                        self.stmts(then, &behind)?;
                    } else {
                        let otherwise = self.label();
                        self.unless(cond, &otherwise)?;
                        self.stmts(then, &behind)?;
                        self.op(&format!("    GOTO {behind}"));
                        self.place(&otherwise);
                        self.stmts(other, &behind)?;
                    }
                    if !last {
                        self.place(&behind);
                    }
                }
                Stmt::Axes(body) => {
                    let [again, next] = [self.label(), self.label()];
                    self.op("    DO micro_first_axis");
                    self.place(&again);
                    self.op("    DO axis_at");
                    self.stmts(body, &next)?;
                    self.place(&next);
                    self.op(&format!("    NEXT_AXIS {again}"));
                }
            }
        }
        Ok(())
    }

    fn or(&mut self, value: &Value, high: bool) -> Result<(), Refused> {
        let place = WORD[usize::from(high)];
        match value {
            Value::Number(number) => {
                let Some(value) = number.value else {
                    return self.refuse(&format!("bits of {} are not known", number.text));
                };
                for (place, byte) in WORD.iter().zip(value.to_le_bytes()) {
                    if byte != 0 {
                        self.op(&format!("    BITS_ON {place}, {byte:#x}"));
                    }
                }
            }
            Value::Bit(axis) => {
                if let Some(leaf) = axis {
                    let Some(Leaf::Axis(code)) = self.leaves.get(leaf) else {
                        return self.refuse(&format!("{leaf} is no axis"));
                    };
                    let code = code.clone();
                    self.ops(&code);
                }
                self.op("    DO axis_bit");
                self.op(&format!("    AXIS_ON {place}"));
            }
            Value::Byte(leaf) => {
                self.get(leaf)?;
                self.op(&format!("    AXIS_ON {place}"));
            }
        }
        Ok(())
    }

    /// Goes to `label` unless a condition holds.
    fn unless(&mut self, cond: &Cond, label: &str) -> Result<(), Refused> {
        match cond {
            Cond::Is(leaf, number) => {
                let Some(Leaf::Byte(byte)) = self.leaves.get(leaf) else {
                    return self.refuse(&format!("{leaf} is no byte"));
                };
                let line = format!("    IF_IS_NOT {byte}, {}, {label}", number.text);
                self.op(&line);
            }
            Cond::Within(byte, first, last) => {
                self.get(byte)?;
                self.op(&format!("    ADDI -{}", first.text));
                self.op(&format!("    CMPI {}+1-{}", last.text, first.text));
                self.jump(Holds::NoCarry, false, label);
            }
            Cond::Call(name) => {
                self.op(&format!("    DO {}", symbol(name)));
                self.jump(Holds::NoCarry, false, label);
            }
            Cond::Leaf(leaf) => match self.leaves.get(leaf).cloned() {
                Some(Leaf::Any(place, _)) => self.op(&format!("    IF_NONE {place}, {label}")),
                Some(Leaf::Is(place)) => self.op(&format!("    IF_IS_NOT {place}, {label}")),
                Some(Leaf::Code(code, other, holds)) => {
                    self.ops(&code);
                    match other {
                        None => self.jump(holds, false, label),
                        Some(other) => {
                            let yes = self.label();
                            self.jump(holds, true, &yes);
                            self.ops(&other);
                            self.jump(holds, false, label);
                            self.place(&yes);
                        }
                    }
                }
                _ => return self.refuse(&format!("{leaf} is not true or false")),
            },
        }
        Ok(())
    }

    /// Jumps when a flag says that something holds, or that it does not.
    fn jump(&mut self, holds: Holds, when: bool, label: &str) {
        let op = match (holds, when) {
            (Holds::Equal, true) | (Holds::NotEqual, false) => "IF_EQUAL",
            (Holds::Equal, false) | (Holds::NotEqual, true) => "IF_NOT_EQUAL",
            // Carry says that it does not; nothing jumps when carry is clear.
            (Holds::NoCarry, _) => "IF_CARRY",
        };
        self.op(&format!("    {op} {label}"));
    }
}
