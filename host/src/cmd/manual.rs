//! `pasapas help language`: the manuals, which are part of the tool.

/// A manual: the word behind `help`, what it is about, its text.
type Manual = (&'static str, &'static str, &'static str);

/// Manuals by the word that asks for them.
pub const MANUALS: [Manual; 13] = [
    ("language", "the language", include_str!("../../../lang/README.md")),
    (
        "firmware",
        "parts, pins, registers and their codes",
        include_str!("../../../firmware/README.md"),
    ),
    ("machines", "machine profiles", include_str!("../../profiles.md")),
    ("worlds", "scenarios for simulations", include_str!("../../worlds.md")),
    ("cells", "cells: things around a machine, tests, proofs", include_str!("../../cell.md")),
    ("placing", "placing a circuit board's parts", include_str!("../../place.md")),
    ("dispensing", "paste and glue in dots", include_str!("../../paste.md")),
    ("pictures", "pictures and drawings for a laser", include_str!("../../engrave.md")),
    ("surfaces", "uneven surfaces: heights correct a job", include_str!("../../level.md")),
    ("senders", "programs that speak to a Grbl controller", include_str!("../../grbl.md")),
    ("editing", "editors and the debugger", include_str!("../../editors.md")),
    ("browser", "the workbench, a page of the browser", include_str!("../../workbench.md")),
    ("servers", "the gateway and fleets", include_str!("../../gateway.md")),
];

/// The manual that a command line asks for: `help WORD`, where WORD is no command.
pub fn asked(arguments: &[String]) -> Option<&'static str> {
    match arguments {
        [help, word] if help == "help" => MANUALS
            .iter()
            .find(|(known, ..)| known.eq_ignore_ascii_case(word))
            .map(|(.., text)| *text),
        _ => None,
    }
}

/// The list of manuals, for the end of `--help`.
pub fn list() -> String {
    let lines = MANUALS.map(|(word, about, _)| format!("  pasapas help {word:<10} {about}"));
    format!("Manuals:\n{}", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::{MANUALS, asked, list};

    #[test]
    fn each_manual_is_found_by_its_word_and_no_command_is_hidden() {
        let words = |word: &str| ["help".to_owned(), word.to_owned()];
        for (word, _, text) in MANUALS {
            assert_eq!(asked(&words(word)), Some(text));
            assert!(text.starts_with("# "), "{word}");
            assert!(list().contains(&format!("help {word}")), "{word}");
            let commands = crate::cmd::command_line();
            assert!(commands.find_subcommand(word).is_none(), "`help {word}` is about a command");
        }
        assert!(asked(&words("sim")).is_none() && asked(&[]).is_none());
    }
}
