//! What a profile may say: ranges, and each number, name and role once.

use std::collections::HashMap;

use super::{FIRST_THRESHOLD, InputRole, OutputRole, Profile, ProfileError, SafeState, Wiring};
use crate::axis::Axis;
use crate::front::diag::Diags;
use crate::front::lexer::{begins_gcode, lex};
use crate::front::token::Tok;

impl Profile {
    /// Each number, name and role once, but for roles that a machine may have several of.
    /// The inputs that choose a program follow one another, as the board's record has them.
    fn check_selection(&self) -> Result<(), ProfileError> {
        let places = InputRole::SELECT.map(|role| self.input_with(role).map(|input| input.n));
        let count = places.iter().flatten().count();
        let first = places[0].unwrap_or_default();
        let in_order = (first..).zip(places).take(count).all(|(n, place)| place == Some(n));
        if !in_order {
            return Err(ProfileError(
                "the inputs that choose a program have the roles select_1, select_2 and so on, without a gap, at \
                 numbers that follow one another: select_1 at input 4, select_2 at input 5"
                    .to_owned(),
            ));
        }
        if count > 0 && self.input_with(InputRole::NextProgram).is_some() {
            return Err(ProfileError(
                "a machine chooses its program by inputs (select_1 ...) or by a button (next_program), not by both"
                    .to_owned(),
            ));
        }
        Ok(())
    }

    fn check_roles(&self) -> Result<(), ProfileError> {
        fn twice<T: PartialEq>(list: &[Option<T>]) -> Option<(usize, usize)> {
            let known = list.iter().enumerate().filter(|(_, item)| item.is_some());
            known.clone().find_map(|(at, item)| {
                known
                    .clone()
                    .find(|(other, same)| *other > at && *same == item)
                    .map(|(b, _)| (at, b))
            })
        }
        let refuse = |what: &str, section: &str, (a, b): (usize, usize), remedy: &str| {
            let (a, b) = (a + 1, b + 1);
            Err(ProfileError(format!(
                "[[{section}]] number {a} and {b} both have {what}; {remedy}"
            )))
        };
        let inputs: Vec<_> = self.inputs.iter().map(|input| Some(input.n)).collect();
        if let Some(at) = twice(&inputs) {
            let what = format!("n = {}", self.inputs[at.0].n);
            return refuse(&what, "input", at, "write one section with all of its keys");
        }
        let outputs: Vec<_> = self.outputs.iter().map(|output| Some(output.n)).collect();
        if let Some(at) = twice(&outputs) {
            let what = format!("n = {}", self.outputs[at.0].n);
            return refuse(&what, "output", at, "write one section with all of its keys");
        }
        for role in InputRole::ALL {
            let with: Vec<usize> =
                (0..self.inputs.len()).filter(|at| self.inputs[*at].role == Some(role)).collect();
            let (name, most) = (role.name(), role.most());
            if let Some(last) = with.get(most) {
                let remedy = if most == 1 {
                    "a machine has one".to_owned()
                } else {
                    format!("a machine has at most {most}; join contacts of more in series")
                };
                let what = format!("role = \"{name}\"");
                return refuse(&what, "input", (with[0], *last), &remedy);
            }
            let filtered = InputRole::SELECT.contains(&role)
                || matches!(role, InputRole::Start | InputRole::NextProgram);
            if filtered && with.iter().any(|at| self.inputs[*at].n == Wiring::Chain.probe()) {
                return Err(ProfileError(format!(
                    "input 17 has role = \"{name}\", but no filter; take one of the inputs 1 to 16"
                )));
            }
        }
        self.check_selection()?;
        for role in OutputRole::ALL {
            let with: Vec<_> = self
                .outputs
                .iter()
                .map(|output| (output.role == Some(role)).then_some(role))
                .collect();
            if let Some(at) = twice(&with) {
                let what = format!("role = \"{}\"", role.name());
                return refuse(&what, "output", at, "a machine has one");
            }
        }
        let order: Vec<_> = self.home_order.iter().map(|name| Some(Axis::from(*name))).collect();
        if let Some((a, b)) = twice(&order) {
            return Err(ProfileError(format!(
                "home_order names {:?} at place {} and {}; name each axis once",
                self.home_order[a],
                a + 1,
                b + 1
            )));
        }
        Ok(())
    }

    /// Names that a script can write, each once: upper and lower case are the same there, and so are inputs and
    /// outputs.
    fn check_names(&self) -> Result<(), ProfileError> {
        let inputs = self.inputs.iter().map(|own| ("input", own.n, own.name.as_deref()));
        let outputs = self.outputs.iter().map(|own| ("output", own.n, own.name.as_deref()));
        let mut seen = HashMap::new();
        let analogs = self.analogs.iter().map(|own| ("analog input", own.n, own.name.as_deref()));
        let aouts = self.aouts.iter().map(|own| ("analog output", own.n, own.name.as_deref()));
        for (what, n, name) in inputs.chain(outputs).chain(analogs).chain(aouts) {
            let Some(name) = name else { continue };
            if !is_name(name) {
                let proposal =
                    proposal(name).unwrap_or_else(|| format!("{what}_{n}").replace(' ', "_"));
                return Err(ProfileError(format!(
                    "{what} {n} is named {name:?}, which no script can write: a name is a letter, then letters, digits \
                     and `_`, and no word of the language; write {proposal:?}"
                )));
            }
            if let Some((other, m)) = seen.insert(name.to_lowercase(), (what, n)) {
                return Err(ProfileError(format!(
                    "{other} {m} and {what} {n} both have the name {name:?}; give one of them another (upper and lower \
                     case are the same)"
                )));
            }
        }
        Ok(())
    }

    /// Whether all of it may stand in a profile.
    pub(super) fn check(&self) -> Result<(), ProfileError> {
        fn range(field: &str, value: i64, low: i64, high: i64) -> Result<(), ProfileError> {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(ProfileError(format!("{field} is {value}; it must lie in {low}..{high}")))
        }
        if self.axes().next().is_none() {
            return Err(ProfileError("the profile has no axis; write a section [x]".to_owned()));
        }
        range("pulse_us", self.pulse_us.into(), 2, 30)?;
        for (axis, part) in self.axes() {
            let at = |field: &str| format!("{}.{field}", axis.letter().to_ascii_lowercase());
            range(&at("scale.steps"), part.scale.steps.into(), 1, 65_535)?;
            range(&at("scale.um"), part.scale.um.into(), 1, 65_535)?;
            // Words of the record.
            let slow = i64::from(part.top_rate).min(65_535);
            range(&at("start_rate"), part.start_rate.into(), 1, slow)?;
            range(&at("accel"), part.accel.into(), 100, 10_000_000)?;
            range(&at("decel"), part.decel.unwrap_or(part.accel).into(), 100, 10_000_000)?;
            range(&at("top_rate"), part.top_rate.into(), 1, i64::from(i32::MAX))?;
            let possible = crate::part::top_rate(self.pulse_us);
            if part.top_rate.unsigned_abs() > possible {
                return Err(ProfileError(format!(
                    "{} is {}; with pulses of {} us the controller makes {possible} steps/s",
                    at("top_rate"),
                    part.top_rate,
                    self.pulse_us
                )));
            }
            range(&at("min_um"), part.min_um.into(), -10_000_000, part.max_um.into())?;
            range(&at("max_um"), part.max_um.into(), part.min_um.into(), 10_000_000)?;
            range(&at("home.fast_rate"), part.home.fast_rate.into(), 1, slow)?;
            range(
                &at("home.slow_rate"),
                part.home.slow_rate.into(),
                1,
                part.home.fast_rate.into(),
            )?;
            range(&at("home.stroke_um"), part.home.stroke_um.into(), 1, 20_000_000)?;
            range(&at("home.position_um"), part.home.position_um.into(), -10_000_000, 10_000_000)?;
            range(&at("home.clearance_um"), part.home.clearance_um.into(), -1_000_000, 1_000_000)?;
            // Sums of two places in steps fit into 32 bits.
            let reach = [part.min_um, part.max_um, part.home.stroke_um, part.home.position_um];
            let longest = reach.map(|um| i64::from(um).abs()).into_iter().max().unwrap_or_default();
            let steps = longest * i64::from(part.scale.steps) / i64::from(part.scale.um);
            range(&format!("the longest way of {}, steps,", axis.letter()), steps, 0, 1 << 30)?;
        }
        if let Some(name) = self.home_order.iter().find(|name| self.axis((**name).into()).is_none())
        {
            return Err(ProfileError(format!(
                "home_order names {name:?}, which the machine does not have"
            )));
        }
        range("dir_setup_us", self.dir_setup_us.into(), 1, 30)?;
        range("corner_um", self.corner_um.into(), 0, 10_000)?;
        range("default_feed_um_s", self.default_feed_um_s.unwrap_or(1).into(), 1, 1_000_000)?;
        let lines = [("link", Some(&self.link)), ("rs485", self.rs485.as_ref())];
        for (name, line) in lines {
            let Some(line) = line else { continue };
            range(&format!("{name}.address"), line.address.into(), 1, 247)?;
            if ![9_600, 19_200, 57_600, 115_200].contains(&line.rate) {
                return Err(ProfileError(format!(
                    "{name}.rate is {}; it must be 9600, 19200, 57600 or 115200",
                    line.rate
                )));
            }
        }
        for input in &self.inputs {
            if !self.has_input(input.n) {
                range("input.n", input.n.into(), 1, self.wiring.inputs().into())?;
            }
            if input.n >= FIRST_THRESHOLD && input.invert {
                return Err(ProfileError(format!(
                    "input {}: invert does not go with a threshold; exchange on_mv and off_mv",
                    input.n
                )));
            }
            range("input.filter_ms", input.filter_ms.into(), 1, 50)?;
        }
        self.check_analog()?;
        self.check_pwm(range)?;
        self.check_aout(range)?;
        self.check_roles()?;
        self.check_names()?;
        for output in &self.outputs {
            range("output.n", output.n.into(), 1, self.wiring.outputs().into())?;
            if output.reset == SafeState::Keep {
                return Err(ProfileError(format!("output {}: reset must be on or off", output.n)));
            }
        }
        Ok(())
    }
}

/// Whether a script reads it as one name.
fn is_name(text: &str) -> bool {
    const BEFORE: &str = "PRINT ";
    let mut diags = Diags::new();
    let tokens = lex(&format!("{BEFORE}{text}"), &mut diags);
    let [_, name, end] = &tokens[..] else { return false };
    let whole = name.span.end as usize == BEFORE.len() + text.len();
    end.tok == Tok::LineEnd
        && whole
        && !diags.has_errors()
        && match name.tok {
            Tok::Name => {
                text.parse().ok().and_then(Axis::from_letter).is_none() && !begins_gcode(text)
            }
            Tok::Kw(kw) => kw.is_soft(),
            _ => false,
        }
}

/// A name that is near to a text which is none.
fn proposal(text: &str) -> Option<String> {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = text.trim().chars().map(plain).collect();
    Some(name).filter(|name| is_name(name))
}

#[cfg(test)]
mod tests {
    use super::super::{BUILT_IN, Profile};

    #[test]
    fn doubled_numbers_names_and_roles_are_refused_with_their_places() {
        let input = |n: u8, role: &str| format!("\n[[input]]\nn = {n}\nrole = \"{role}\"\n");
        let mill = BUILT_IN[0].1;
        let error = |text: String| Profile::parse(&(mill.to_owned() + &text)).expect_err(&text).0;
        let base = mill.matches("[[input]]").count();
        let many = |role: &str, count: u8| (1..=count).map(|n| input(n, role)).collect::<String>();
        for (role, most) in [("emergency_stop", 4), ("hold", 2), ("door", 2), ("stop", 2)] {
            let text = mill.to_owned() + &many(role, most);
            assert!(Profile::parse(&text).is_ok(), "{most} of {role}");
            let told = error(many(role, most + 1));
            let (first, last) = (base + 1, base + 1 + usize::from(most));
            let start = format!("[[input]] number {first} and {last} both have role = \"{role}\"");
            assert!(told.starts_with(&start), "{told}");
        }
        for role in ["start", "probe", "reference_x", "reference_y", "reference_z"] {
            assert!(error(many(role, 2)).ends_with("a machine has one"), "{role}");
        }
        assert!(error(input(5, "hold") + &input(5, "emergency_stop")).contains("n = 5"));
        let select = |first: u8, count: u8| {
            (0..count).map(|n| input(first + n, &format!("select_{}", n + 1))).collect::<String>()
        };
        for count in 1..=6 {
            assert!(Profile::parse(&(mill.to_owned() + &select(1, count))).is_ok(), "{count}");
        }
        let apart = input(1, "select_1") + &input(3, "select_2");
        for wrong in [input(1, "select_2"), apart, input(1, "select_1") + &input(2, "select_3")] {
            assert!(error(wrong).contains("without a gap"));
        }
        assert!(error(select(1, 2) + &input(5, "next_program")).contains("not by both"));
        assert!(error(input(17, "next_program")).contains("no filter"));
        assert!(error(input(17, "start")).contains("no filter"));
        let output = |n: u8, rest: &str| format!("\n[[output]]\nn = {n}\n{rest}\n");
        assert!(error(output(9, "") + &output(9, "")).contains("both have n = 9"));
        for role in ["coolant", "lamp", "enable", "laser"] {
            let text = output(9, &format!("role = \"{role}\""))
                + &output(10, &format!("role = \"{role}\""));
            assert!(error(text).contains(role), "{role}");
        }
        let named = |n: u8| format!("\n[[input]]\nn = {n}\nname = \"same\"\n");
        assert!(error(named(5) + &named(6)).contains("\"same\""));
        let line = mill.lines().find(|line| line.starts_with("home_order")).expect("a home order");
        let text = mill.replace(line, "home_order = [\"X\", \"Y\", \"X\"]");
        let told = Profile::parse(&text).expect_err("X twice").0;
        assert!(told.contains("place 1 and 3"), "{told}");
    }

    /// What a script cannot write nobody can use, and a hint with it helps nobody.
    #[test]
    fn a_name_that_no_script_can_write_is_refused_with_one_that_it_can() {
        let told = |section: &str, n: u8, name: &str| {
            let text = format!("{}\n[[{section}]]\nn = {n}\nname = {name:?}\n", BUILT_IN[0].1);
            Profile::parse(&text).map(drop).map_err(|error| error.0)
        };
        for (name, instead) in [
            ("glue valve", "glue_valve"),
            (" lid ", "lid"),
            ("lid-closed", "lid_closed"),
            ("Türe", "T_re"),
            ("2nd", "output_5"),
            ("on", "output_5"),
            ("Wait", "output_5"),
            ("", "output_5"),
            ("x", "output_5"),
            ("g1", "output_5"),
            ("a'b", "a_b"),
            ("a\nb", "a_b"),
        ] {
            let told = told("output", 5, name).expect_err(name);
            let wanted = format!("output 5 is named {name:?}, which no script can write");
            assert!(told.starts_with(&wanted), "{told}");
            assert!(told.ends_with(&format!("write {instead:?}")), "{told}");
        }
        for name in ["glue", "label", "part_present", "Lid2"] {
            assert_eq!(told("input", 5, name), Ok(()), "{name}");
        }
        let text = |a: &str, b: &str| {
            let port = |section, n, name| format!("\n[[{section}]]\nn = {n}\nname = \"{name}\"\n");
            BUILT_IN[0].1.to_owned() + &port("input", 5, a) + &port("output", 6, b)
        };
        let told = Profile::parse(&text("Lid", "lid")).expect_err("one name").0;
        assert!(told.starts_with("input 5 and output 6 both have the name \"lid\""), "{told}");
        assert!(Profile::parse(&text("lid", "lid_2")).is_ok());
    }

    #[test]
    fn a_value_out_of_range_is_named() {
        let text = BUILT_IN[0].1.replace("pulse_us = 3", "pulse_us = 31");
        let error = Profile::parse(&text).unwrap_err();
        assert_eq!(error.0, "pulse_us is 31; it must lie in 2..30");
    }
}
