//! What a file of rules and the signatures of its functions say.

use std::collections::BTreeMap;

use syn::{File, Item};

use super::no;
use crate::Refused;
use crate::leaf::{Holds, Type, micro, signature};

/// A rule as its callers see it.
#[derive(Clone, Debug)]
pub struct Rule {
    /// Its label.
    pub label: String,
    /// It changes the machine.
    pub changes: bool,
    /// Its parameters.
    pub takes: Vec<(String, Type)>,
    /// Its result.
    pub gives: Type,
    /// The flag of its result.
    pub holds: Option<Holds>,
    /// r12 is 0 behind it.
    pub zero: bool,
    pub(super) said: BTreeMap<String, String>,
}

/// Rules by their names, with that of the file in front: `coords::aim`.
pub type Rules = BTreeMap<String, Rule>;

/// What a file says of itself: its mark, and what its functions' labels begin with.
#[derive(Clone, Debug, Default)]
pub struct About {
    /// The module's mark.
    pub module: String,
    /// See above.
    pub prefix: String,
    /// The section that it is in.
    pub section: String,
    /// The symbol of the parts that have it.
    pub when: Option<String>,
}

/// What a file says of itself.
///
/// # Errors
/// It says nothing.
pub fn about(file: &File) -> Result<About, Refused> {
    let mut said = micro(&file.attrs)?.unwrap_or_default();
    let mut take = |key: &str| said.remove(key);
    let (module, prefix) = (take("module"), take("prefix").unwrap_or_default());
    let section = take("section").unwrap_or_else(|| String::from("micro"));
    let when = take("when");
    match module {
        Some(module) => Ok(About { module, prefix, section, when }),
        None => {
            Err(Refused { line: 1, text: "the file says no module, `micro(module = ..)`".into() })
        }
    }
}

/// The signatures of a file's functions.
///
/// # Errors
/// One is not of the subset.
pub fn rules(file: &File, module: &str, about: &About, rules: &mut Rules) -> Result<(), Refused> {
    for item in &file.items {
        let Item::Fn(function) = item else { continue };
        let name = function.sig.ident.to_string();
        let Some((changes, takes, gives)) = signature(&function.sig) else {
            return no(
                &function.sig,
                "`m: &impl Trait` or `m: &mut impl Trait`, then Axis, bool, u8, i32; bool, u8, u16, i32, Axis, \
                 Result<(), Fault>, Progress",
            );
        };
        let said = micro(&function.attrs)?.unwrap_or_default();
        let zero = said.get("leaves").is_some_and(|value| value == "0");
        let label = said.get("label").or_else(|| said.get("entry")).cloned();
        let label = label.unwrap_or_else(|| format!("{}{name}", about.prefix));
        let holds = match said.get("holds").map(String::as_str) {
            Some("EQUAL") => Some(Holds::Equal),
            Some("CARRY") => Some(Holds::Carry),
            Some("NO_CARRY") => Some(Holds::NoCarry),
            _ if gives == Type::Bool => Some(Holds::NotEqual),
            _ => None,
        };
        rules.insert(
            format!("{module}::{name}"),
            Rule { label, changes, takes, gives, holds, zero, said },
        );
    }
    Ok(())
}
