//! Inputs and outputs as a file names them: a number, or a name of the profile.

use lang::profile::Profile;
use serde::Deserialize;

/// A number of an input or output, or its name in the profile.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub enum Terminal {
    /// From 1.
    Number(i32),
    /// As the profile calls it.
    Name(String),
}

/// As in a script, upper and lower case are the same.
fn is_named(own: Option<&str>, name: &str) -> bool {
    own.is_some_and(|own| own.eq_ignore_ascii_case(name))
}

/// Number of an output.
///
/// # Errors
/// The machine has none such; in words.
pub fn output(profile: &Profile, terminal: &Terminal) -> Result<i32, String> {
    let n = match terminal {
        Terminal::Number(n) => *n,
        Terminal::Name(name) => {
            let found = profile.outputs.iter().find(|o| is_named(o.name.as_deref(), name));
            found.map(|output| output.n).ok_or_else(|| format!("no output is named `{name}`"))?
        }
    };
    let most = profile.wiring.outputs();
    if (1..=most).contains(&n) { Ok(n) } else { Err(format!("outputs are 1 to {most}")) }
}

/// Number of an input.
///
/// # Errors
/// The machine has none such; in words.
pub fn input(profile: &Profile, terminal: &Terminal) -> Result<i32, String> {
    let n = match terminal {
        Terminal::Number(n) => *n,
        Terminal::Name(name) => {
            let found = profile.inputs.iter().find(|i| is_named(i.name.as_deref(), name));
            found.map(|input| input.n).ok_or_else(|| format!("no input is named `{name}`"))?
        }
    };
    let most = profile.wiring.inputs();
    if (1..=most).contains(&n) { Ok(n) } else { Err(format!("inputs are 1 to {most}")) }
}
