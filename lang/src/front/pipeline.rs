//! The whole front end in one call.

use super::ast::Script;
use super::check::{WHICH_PORT, check};
use super::codes::Code;
use super::diag::{Diag, Diags};
use super::facts::Facts;
use super::parser::parse;
use super::source::Source;
use super::span::Span;
use crate::hir::Program;
use crate::profile::{DEFAULT_NAME, Profile, ProfileError};

/// Where the machine comes from.
pub enum ProfileChoice<'p> {
    /// `--profile`: the script's own PROFILE line does not count.
    Given(Box<Profile>),
    /// The script's PROFILE line, looked up by this function, else the built-in `mill`.
    Script(&'p dyn Fn(&str) -> Result<Profile, ProfileError>),
}

impl ProfileChoice<'static> {
    /// The script's PROFILE line among the built-in profiles.
    pub fn built_in() -> ProfileChoice<'static> {
        ProfileChoice::Script(&Profile::built_in)
    }
}

/// What the front end found in a script, for tools that show it while it is being written.
pub struct Analysis {
    /// The tree, as far as it could be read.
    pub script: Script,
    /// What is known of each declared name.
    pub facts: Facts,
    /// The machine that it was checked for.
    pub profile: Option<Profile>,
    /// The checked program, when no diagnostic is an error.
    pub program: Option<Program>,
    /// What is wrong.
    pub diags: Diags,
}

/// Reads and checks a script. The program is there when no diagnostic is an error.
pub fn compile(source: &Source, profile: ProfileChoice<'_>) -> (Option<Program>, Diags) {
    let Analysis { program, diags, .. } = analyse(source, profile);
    (program, diags)
}

/// Reads and checks a script, and keeps what it found out on the way.
pub fn analyse(source: &Source, profile: ProfileChoice<'_>) -> Analysis {
    let mut diags = Diags::new();
    let script = parse(source.text(), &mut diags);
    let profile = match profile {
        ProfileChoice::Given(profile) => Ok((*profile, None)),
        ProfileChoice::Script(find) => {
            let named = script.profile.as_ref();
            let name = named.map_or(DEFAULT_NAME, |text| text.text.as_str());
            find(name).map(|profile| (profile, None)).or_else(|error| {
                let span = named.map_or(Span::default(), |text| text.span);
                // The rest is checked all the same, for the default machine.
                let fallback = Profile::built_in(DEFAULT_NAME)?;
                Ok::<_, ProfileError>((fallback, Some((span, error))))
            })
        }
    };
    let (profile, known) = match profile {
        Ok((profile, None)) => (profile, true),
        Ok((profile, Some((span, error)))) => {
            diags.push(unknown_profile(source, span, &error));
            (profile, false)
        }
        Err(error) => {
            diags.push(Diag::new(Code::UnknownProfile, Span::default(), error.to_string()));
            return Analysis { script, facts: Facts::new(), profile: None, program: None, diags };
        }
    };
    let (program, facts) = check(&script, source.text(), &profile, &mut diags);
    if !known {
        // What the machine lacks says nothing: it is another one, whose names nobody knows.
        diags.retain(|diag| {
            let of_machine = diag.code.id().starts_with('M') && diag.code != Code::UnknownProfile;
            let port = diag.hint.as_ref().is_some_and(|hint| hint.starts_with(WHICH_PORT));
            !of_machine && !port
        });
    }
    Analysis { script, facts, profile: Some(profile), program, diags }
}

/// A PROFILE line that names none.
fn unknown_profile(source: &Source, span: Span, error: &ProfileError) -> Diag {
    let named = span.of(source.text()).trim_matches('"');
    let diag = Diag::new(Code::UnknownProfile, span, error.to_string());
    match named.strip_suffix(".toml") {
        Some(stem) => diag
            .hint(format!("write `PROFILE \"{stem}\"`: the file `{stem}.toml` beside the script")),
        None => diag.hint(format!(
            "a profile of your own is the file `{named}.toml` beside the script, or is given by \
             `--profile FILE.toml`; `pasapas profile show mill` prints one to begin with"
        )),
    }
}
