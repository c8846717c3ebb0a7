//! Micro-code from the rules in `firmware/src/rules`: plain Rust functions that rustc compiles for the host and the
//! larger chip, and this crate for the 16 KB one. README.md has the subset on one page; what is outside of it is
//! refused by name and line.
//!
//! [`leaf`] reads what each chip does its own way, [`front`] the functions, [`code`] writes the notation of
//! `firmware/src/compact/micro`. The result stands in `firmware/src/compact/made`: the program `lower` writes it, a test
//! compares it.

pub mod code;
pub mod front;
pub mod leaf;

use std::fmt;

/// Why a source is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Line of the source, from 1.
    pub line: usize,
    /// What is wrong and what may stand there instead.
    pub text: String,
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.text)
    }
}

impl std::error::Error for Refused {}

impl Refused {
    fn at(place: &impl syn::spanned::Spanned, text: impl Into<String>) -> Refused {
        Refused { line: place.span().start().line, text: text.into() }
    }
}

impl From<syn::Error> for Refused {
    fn from(error: syn::Error) -> Refused {
        Refused { line: error.span().start().line, text: error.to_string() }
    }
}

/// What is made of a file of rules.
#[derive(Clone, Debug)]
pub struct Made {
    /// The assembler's text.
    pub text: String,
    /// Bytes of each function, but for what it shares with the next ones.
    pub bytes: Vec<(String, usize)>,
}

/// Makes micro-code of the rules in `rules`, whose leaves are those of `machine`; `name` is the file's.
///
/// # Errors
/// Something is not of the subset.
pub fn lower(machine: &str, rules: &str, name: &str) -> Result<Made, Refused> {
    let leaves = leaf::read(&syn::parse_file(machine)?)?;
    let functions = front::read(&syn::parse_file(rules)?, &leaves)?;
    code::write(&functions, &leaves, name)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MACHINE: &str = r#"pub trait Machine {
        #[cfg_attr(any(), micro(any = "RUN, RUN_ACTIVE"))]
        fn is_active(&self) -> bool;
        #[cfg_attr(any(), micro(byte = "EFFECT"))]
        fn effect(&self) -> u8;
        #[cfg_attr(any(), micro(code = "DO first", or = "DO second", holds = "NOT_EQUAL"))]
        fn either(&self) -> bool;
        #[cfg_attr(any(), micro(axis = "DO axis_n"))]
        fn axis(&self) -> Axis;
        #[cfg_attr(any(), micro(word = "EFFECT_PC"))]
        fn pc(&self) -> u16;
        #[cfg_attr(any(), micro(word = "VM_CODE"))]
        fn code(&self) -> u16;
        #[cfg_attr(any(), micro(any = "TRACING, T_ON", bit = 1))]
        fn traces(&self) -> bool;
    }"#;

    fn made(rules: &str) -> String {
        let made = lower(MACHINE, rules, "test").unwrap_or_else(|refused| panic!("{refused}"));
        let ops = made.text.lines().skip(4).map(str::trim);
        ops.filter(|line| !line.starts_with("/*")).collect::<Vec<_>>().join("; ")
    }

    #[test]
    fn a_number_or_nothing_is_a_jump_over_it() {
        let rule = "fn a(m: &impl Machine) -> u16 { if m.is_active() { 1 << 10 } else { 0 } }";
        let code = "map_a:; IF_NONE RUN, RUN_ACTIVE, .Ltest_1; LIT16 1024; .Ltest_1:; RETURN; .balign 2, 0";
        assert_eq!(made(rule), code);
    }

    #[test]
    fn words_share_their_end() {
        let rule = "fn a(m: &impl Machine) -> u16 { let mut w = 0; if m.either() { w |= 3 << 7; } w }
            fn b(m: &impl Machine) -> u16 { let mut w = u16::from(m.effect()) << 8; w |= u16::from(m.axis().bit()); w }";
        let a = "map_a:; F clear TEMP; DO first; IF_NOT_EQUAL .Ltest_1; DO second; IF_EQUAL .Ltest_word; .Ltest_1:; \
            BITS_ON TEMP, 0x80; BITS_ON TEMP+1, 0x1; GOTO .Ltest_word";
        let b = "map_b:; F clear TEMP; GET EFFECT; PUT TEMP+1; DO axis_n; DO axis_bit; AXIS_ON TEMP; .Ltest_word:; \
            F word TEMP; RETURN; .balign 2, 0";
        assert_eq!(made(rule), format!("{a}; {b}"));
    }

    #[test]
    fn a_leaf_is_a_result_and_differences_share_their_end() {
        let rule = "fn a(m: &impl Machine) -> u16 { m.pc().wrapping_sub(m.code()) }
            fn b(m: &impl Machine) -> u16 { m.code().wrapping_sub(m.code()) }
            fn c(m: &impl Machine) -> u16 { u16::from(m.traces()) }";
        let code = "map_a:; F word EFFECT_PC; .Ltest_1:; F sub VM_CODE; RETURN; map_b:; F word VM_CODE; GOTO .Ltest_1; \
            map_c:; .if T_ON != 1; .error \"a leaf's bit\"; .endif; GET TRACING; ANDI T_ON; RETURN; .balign 2, 0";
        assert_eq!(made(rule), code);
        let rule = "fn a(m: &impl Machine) -> u16 { u16::from(m.is_active()) }";
        let refused = lower(MACHINE, rule, "test").expect_err("a bit whose value is not told");
        assert!(refused.text.contains("no bit that is 1"), "{refused}");
    }

    #[test]
    fn what_the_subset_lacks_is_refused_with_its_line() {
        let cases = [
            ("fn a(m: &impl Machine) -> u16 { 3 }", "a word, a word less another"),
            ("fn a(m: &impl Machine) -> u16 { m.pc(); m.code() }", "let mut word"),
            ("fn a(m: &impl Machine) -> u32 { 3 }", "bool, u16"),
            ("fn a(n: u8) -> bool { true }", "one argument"),
            ("fn a(m: &impl Machine) -> bool { m.effect() < 3 }", "a leaf, a function"),
            ("fn a(m: &impl Machine) -> bool { m.nothing() }", "a leaf that is true or not"),
            ("fn a(m: &impl Machine) -> bool { m.is_active() }", "leaves no flag"),
            ("fn a(m: &impl Machine) -> u16 { let mut w = 0; while m.is_active() {} w }", "an if"),
            (
                "fn a(m: &impl Machine) -> u16 { let mut w = 0; w |= u16::from(axis.bit()); w }",
                "the loop's axis",
            ),
            ("const A: u8 = 3;", "a constant says its name"),
            ("struct A;", "functions, constants, use"),
        ];
        for (rule, text) in cases {
            let refused = lower(MACHINE, &format!("\n{rule}"), "test").expect_err(rule);
            assert!(refused.text.contains(text), "{rule}: {refused}");
        }
        let refused = lower(MACHINE, "\n\nstruct A;", "test").expect_err("a struct");
        assert_eq!(
            refused.to_string(),
            "line 3: `struct A ;` is not of the subset: functions, constants, use"
        );
    }

    #[test]
    fn a_leaf_that_says_nothing_is_refused() {
        let refused = lower("pub trait Machine { fn a(&self) -> bool; }", "", "test")
            .expect_err("no attribute");
        assert_eq!(refused.text, "a says nothing of micro-code");
        let refused = lower(
            "pub trait Machine { #[cfg_attr(any(), micro(code = \"DO a\"))] fn a(&self) -> bool; }",
            "",
            "test",
        );
        assert!(refused.expect_err("no flag").text.contains("holds"));
    }
}
