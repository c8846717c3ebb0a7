//! Leaves: what the trait `Machine` says of the small chip in its attributes `micro(..)`, and constants' names.

use std::collections::BTreeMap;

use syn::punctuated::Punctuated;
use syn::{Attribute, Expr, ExprLit, File, Item, Lit, Meta, Token, TraitItem};

use crate::Refused;

/// What stands for a leaf.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Leaf {
    /// The value of a byte of RAM.
    Byte(String),
    /// The value of a word of RAM.
    Word(String),
    /// Code that leaves a number in r12.
    Number(String),
    /// Whether one of these bits of a byte is set; the bit's value when it is told.
    Any(String, Option<u16>),
    /// Whether a byte has a value.
    Is(String),
    /// Code behind which a flag tells; a second one that may tell as well.
    Code(String, Option<String>, Holds),
    /// Code that makes an axis the one of r8 and r9.
    Axis(String),
}

/// The flag that says that something holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Z is set.
    Equal,
    /// Z is clear.
    NotEqual,
    /// C is clear.
    NoCarry,
}

/// Leaves by their names.
pub type Leaves = BTreeMap<String, Leaf>;

/// What an attribute `cfg_attr(any(), micro(..))` says: no build sees it.
pub fn micro(attributes: &[Attribute]) -> Option<syn::Result<proc_macro2::TokenStream>> {
    let rows = attributes.iter().filter(|row| row.path().is_ident("cfg_attr"));
    for row in rows {
        let list = row.parse_args_with(Punctuated::<Meta, Token![,]>::parse_terminated);
        for meta in list.into_iter().flatten() {
            if let Meta::List(list) = meta
                && list.path.is_ident("micro")
            {
                return Some(Ok(list.tokens));
            }
        }
    }
    None
}

/// The leaves of the trait `Machine`.
///
/// # Errors
/// One says nothing, or nothing that is known.
pub fn read(file: &File) -> Result<Leaves, Refused> {
    let mut leaves = Leaves::new();
    for item in &file.items {
        let Item::Trait(machine) = item else { continue };
        for item in &machine.items {
            let TraitItem::Fn(function) = item else {
                return Err(Refused::at(item, "Machine has functions alone"));
            };
            let name = function.sig.ident.to_string();
            let Some(tokens) = micro(&function.attrs) else {
                return Err(Refused::at(function, format!("{name} says nothing of micro-code")));
            };
            let leaf = one(tokens?).ok_or_else(|| {
                Refused::at(
                    function,
                    format!("{name}: byte, word, number, any, is, axis, or code and holds"),
                )
            })?;
            leaves.insert(name, leaf);
        }
    }
    Ok(leaves)
}

fn one(tokens: proc_macro2::TokenStream) -> Option<Leaf> {
    use syn::parse::Parser;
    let rows = Punctuated::<Meta, Token![,]>::parse_terminated.parse2(tokens).ok()?;
    let mut said = BTreeMap::new();
    let mut bit = None;
    for row in rows {
        let Meta::NameValue(row) = row else { return None };
        match row.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => {
                said.insert(row.path.get_ident()?.to_string(), text.value());
            }
            Expr::Lit(ExprLit { lit: Lit::Int(number), .. }) => bit = number.base10_parse().ok(),
            _ => return None,
        }
    }
    let mut take = |name: &str| said.remove(name);
    let leaf = if let Some(byte) = take("byte") {
        Leaf::Byte(byte)
    } else if let Some(word) = take("word") {
        Leaf::Word(word)
    } else if let Some(number) = take("number") {
        Leaf::Number(number)
    } else if let Some(any) = take("any") {
        Leaf::Any(any, bit)
    } else if let Some(is) = take("is") {
        Leaf::Is(is)
    } else if let Some(axis) = take("axis") {
        Leaf::Axis(axis)
    } else {
        let holds = match take("holds")?.as_str() {
            "EQUAL" => Holds::Equal,
            "NOT_EQUAL" => Holds::NotEqual,
            _ => return None,
        };
        Leaf::Code(take("code")?, take("or"), holds)
    };
    said.is_empty().then_some(leaf)
}
