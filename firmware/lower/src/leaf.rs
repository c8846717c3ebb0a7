//! Leaves: what the traits of the rules say of the small chip in their attributes `micro(..)`.

use std::collections::BTreeMap;

use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::{
    Attribute, Expr, ExprLit, File, FnArg, Item, Lit, Meta, Pat, ReturnType, Token, TraitItem,
};

use crate::Refused;

/// A flag and how it has to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Z is set.
    Equal,
    /// Z is clear.
    NotEqual,
    /// C is set.
    Carry,
    /// C is clear.
    NoCarry,
    /// N is set.
    Negative,
    /// V is set.
    Overflow,
}

impl Holds {
    fn named(name: &str) -> Option<Holds> {
        Some(match name {
            "EQUAL" => Holds::Equal,
            "NOT_EQUAL" => Holds::NotEqual,
            "CARRY" => Holds::Carry,
            "NO_CARRY" => Holds::NoCarry,
            "NEGATIVE" => Holds::Negative,
            "OVERFLOW" => Holds::Overflow,
            _ => return None,
        })
    }
}

/// What a function takes or gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// `()`.
    Nothing,
    /// `bool`.
    Bool,
    /// `u8`.
    Byte,
    /// `u16`.
    Word,
    /// `i32`, `Scaled`.
    Long,
    /// `Axis`.
    Axis,
    /// `Option<i32>`.
    Maybe,
    /// `Result<(), Fault>`, `Answer`.
    Fault,
    /// `Result<u8, Fault>`.
    ByteOrFault,
    /// `Result<i32, Fault>`.
    LongOrFault,
    /// `Progress`.
    Progress,
    /// An item of an enum that is a number in the code: `TraceKind`.
    Number,
}

/// Parameters, each with its name.
pub type Named = Vec<(String, Type)>;

/// The type that is written.
pub fn type_of(text: &str) -> Option<Type> {
    Some(match text.replace(' ', "").as_str() {
        "" => Type::Nothing,
        "bool" => Type::Bool,
        "u8" => Type::Byte,
        "u16" => Type::Word,
        "i32" | "Scaled" => Type::Long,
        "Axis" => Type::Axis,
        "Option<i32>" => Type::Maybe,
        "Result<(),Fault>" | "Answer" => Type::Fault,
        "Result<u8,Fault>" => Type::ByteOrFault,
        "Result<i32,Fault>" => Type::LongOrFault,
        "Progress" => Type::Progress,
        "TraceKind" => Type::Number,
        _ => return None,
    })
}

/// What stands for a leaf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A byte, word or long of RAM, read or written as the function's type says; code that loads it.
    Place(String, Option<String>),
    /// A field of the record at r9; whether 16 bits of it.
    Record(String, bool),
    /// Whether one of these bits of a byte is set; the bit's value when it is told.
    Any(String, String, Option<u16>),
    /// Whether a byte has a value.
    Is(String, String),
    /// The axis's bit in a byte: whether it is set; set it; clear it.
    Bit(String, Option<bool>),
    /// What never is so on the small chip.
    Never,
    /// Code; a second one, of which a flag tells as well or which is that of other parts.
    Code(String, Option<String>),
}

/// A leaf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// What stands for it.
    pub kind: Kind,
    /// It changes the machine.
    pub changes: bool,
    /// Its parameters and their names.
    pub takes: Vec<(String, Type)>,
    /// Its result.
    pub gives: Type,
    /// The flag that says that it is so, or that there is nothing.
    pub holds: Option<Holds>,
    /// r12 is 0 behind it.
    pub zero: bool,
    /// It never fails.
    pub sure: bool,
    /// What r9 is when its code reads a record: nothing is the axis's own; the same after its code.
    pub record: Option<String>,
    /// See `record`.
    pub sets_record: Option<String>,
    /// The symbol of the parts that have it: elsewhere it is nothing, and never so.
    pub when: Option<String>,
    /// Instructions that go on in the function's place behind its code.
    pub ends: Option<String>,
}

/// Leaves by their names.
pub type Leaves = BTreeMap<String, Leaf>;

/// What attributes `cfg_attr(any(), micro(..))` say, by key: no build sees them.
///
/// # Errors
/// It is no list of `key = "text"` or numbers.
pub fn micro(attributes: &[Attribute]) -> Result<Option<BTreeMap<String, String>>, Refused> {
    for row in attributes.iter().filter(|row| row.path().is_ident("cfg_attr")) {
        let list = row.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated)?;
        for meta in list {
            if let Meta::List(list) = meta
                && list.path.is_ident("micro")
            {
                return Ok(Some(said(&list)?));
            }
        }
    }
    Ok(None)
}

fn said(list: &syn::MetaList) -> Result<BTreeMap<String, String>, Refused> {
    if let Ok(name) = syn::parse2::<syn::LitStr>(list.tokens.clone()) {
        return Ok(BTreeMap::from([(String::from("name"), name.value())]));
    }
    let rows = list.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated)?;
    let mut said = BTreeMap::new();
    for row in rows {
        let Meta::NameValue(row) = row else { return Err(Refused::at(&row, "key = value")) };
        let value = match &row.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => text.value(),
            Expr::Lit(ExprLit { lit: Lit::Int(number), .. }) => number.to_string(),
            value => return Err(Refused::at(value, "a text or a number")),
        };
        said.insert(row.path.to_token_stream().to_string(), value);
    }
    Ok(said)
}

/// The leaves of all traits of a file.
///
/// # Errors
/// One says nothing, or nothing that is known.
pub fn read(file: &File, leaves: &mut Leaves) -> Result<(), Refused> {
    for item in &file.items {
        let Item::Trait(machine) = item else { continue };
        for item in &machine.items {
            let TraitItem::Fn(function) = item else {
                return Err(Refused::at(item, "a trait of leaves has functions alone"));
            };
            let name = function.sig.ident.to_string();
            let Some(said) = micro(&function.attrs)? else {
                return Err(Refused::at(function, format!("{name} says nothing of micro-code")));
            };
            let leaf = one(function, said).ok_or_else(|| {
                Refused::at(
                    function,
                    format!("{name}: place, record, any, is, has, on, off, or code and holds"),
                )
            })?;
            if leaves.get(&name).is_some_and(|other| *other != leaf) {
                return Err(Refused::at(function, format!("{name} is another leaf elsewhere")));
            }
            leaves.insert(name, leaf);
        }
    }
    Ok(())
}

fn one(function: &syn::TraitItemFn, mut said: BTreeMap<String, String>) -> Option<Leaf> {
    let (changes, takes, gives) = signature(&function.sig)?;
    let pair = |text: &str| {
        let (byte, value) = text.split_once(", ")?;
        Some((byte.to_owned(), value.to_owned()))
    };
    let holds = match said.remove("holds") {
        None => None,
        Some(name) => Some(Holds::named(&name)?),
    };
    let [record, sets_record, when, ends] =
        ["of", "sets", "when", "ends"].map(|key| said.remove(key));
    let zero = said.remove("leaves").is_some_and(|value| value == "0");
    let sure = said.remove("sure").is_some();
    let kind = if let Some(place) = said.remove("place") {
        Kind::Place(place, said.remove("load"))
    } else if let Some(field) = said.remove("record") {
        Kind::Record(field, gives != Type::Long)
    } else if let Some(any) = said.remove("any") {
        let (byte, mask) = pair(&any).unwrap_or((any, String::new()));
        let bit = said.remove("bit").and_then(|bit| bit.parse().ok());
        Kind::Any(byte, mask, bit)
    } else if let Some(is) = said.remove("is") {
        let (byte, value) = pair(&is)?;
        Kind::Is(byte, value)
    } else if let Some(byte) = said.remove("has") {
        Kind::Bit(byte, None)
    } else if let Some(byte) = said.remove("on") {
        Kind::Bit(byte, Some(true))
    } else if let Some(byte) = said.remove("off") {
        Kind::Bit(byte, Some(false))
    } else if said.remove("never").is_some() {
        Kind::Never
    } else {
        let code = said.remove("code")?;
        if matches!(gives, Type::Bool | Type::Maybe) && holds.is_none() {
            return None;
        }
        Kind::Code(code, said.remove("or"))
    };
    let leaf =
        Leaf { kind, changes, takes, gives, holds, zero, sure, record, sets_record, when, ends };
    said.is_empty().then_some(leaf)
}

/// Whether a function changes the machine, its parameters behind that, its result.
#[must_use]
pub fn signature(sig: &syn::Signature) -> Option<(bool, Named, Type)> {
    let mut inputs = sig.inputs.iter();
    let machine = inputs.next()?.to_token_stream().to_string();
    let changes = match machine.as_str() {
        "& self" => false,
        "& mut self" => true,
        text if text.starts_with("m : & impl ") || text.starts_with("_m : & impl ") => false,
        text if text.starts_with("m : & mut impl ") => true,
        _ => return None,
    };
    let mut takes = Vec::new();
    for input in inputs {
        let FnArg::Typed(input) = input else { return None };
        let Pat::Ident(name) = &*input.pat else { return None };
        // `_name` is what rustc wants where a default does without.
        let name = name.ident.to_string().trim_start_matches('_').to_owned();
        takes.push((name, type_of(&input.ty.to_token_stream().to_string())?));
    }
    let gives = match &sig.output {
        ReturnType::Default => Type::Nothing,
        ReturnType::Type(_, result) => type_of(&result.to_token_stream().to_string())?,
    };
    Some((changes, takes, gives))
}
