//! Messages when a job ends in a fault, and the way to go on.

use lang::fault::Fault;
use lang::profile::Profile;

use crate::client::orders;
use crate::client::status::Status;
use crate::cmd::console::Console;

/// How a job ended: the words for it and the hint.
pub(super) struct Ended {
    /// Behind `FILE:LINE:1: `.
    pub what: String,
    /// Behind `hint: `.
    pub hint: String,
}

impl Ended {
    /// Of a job that stopped in a line, with a fault or without.
    pub fn new(
        line: u32,
        fault: Option<Fault>,
        status: Option<&Status>,
        profile: &Profile,
    ) -> Ended {
        let hint = format!("--from-line {line} goes on from there");
        let Some(fault) = fault else { return Ended { what: "stopped here".to_owned(), hint } };
        let own = status.filter(|own| own.fault.as_ref() == Some(&fault.to_string()));
        let text = own.and_then(|own| own.text).unwrap_or(fault.text());
        let what = format!("fault {fault}: {text}");
        let input = status.and_then(|status| status.input);
        match (fault, input) {
            (Fault::LimitSwitch, Some(input)) => limit(what, input, line, profile),
            (_, Some(input)) => Ended { what: format!("{what} (input {input})"), hint },
            _ => Ended { what, hint },
        }
    }

    /// Writes it.
    pub fn tell(&self, file: &str, line: u32, console: &Console) {
        console.complain(&format!("{file}:{line}:1: {}", self.what));
        console.complain(&format!("  hint: {}", self.hint));
    }
}

/// An axis met its reference switch: to go on from the line would meet it again.
fn limit(what: String, input: u16, line: u32, profile: &Profile) -> Ended {
    let Some((axis, jog)) = orders::off_switch(profile, input) else {
        let hint = format!("move the axis off the switch; --from-line {line} goes on from there");
        return Ended { what: format!("{what} (input {input})"), hint };
    };
    let letter = axis.letter();
    Ended {
        what: format!("{what} of {letter} (input {input})"),
        hint: format!(
            "the job reaches beyond the switch of {letter}: `pasapas start` acknowledges, `{jog}` leaves the \
             switch; then begin the job further away from it"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::Ended;
    use lang::fault::Fault;
    use lang::profile::Profile;

    #[test]
    fn a_limit_switch_is_named_with_its_axis_and_the_way_off_it() {
        let mill = Profile::built_in("mill").expect("built in");
        let status = |input| {
            let status = crate::client::status::StatusWords::default().status();
            Some(crate::client::status::Status { input, ..status })
        };
        let ended = |fault, input| {
            let status = status(input);
            let Ended { what, hint } = Ended::new(7, fault, status.as_ref(), &mill);
            format!("{what}; {hint}")
        };
        let x = mill.reference_input(lang::axis::Axis::X) as u16;
        let z = mill.reference_input(lang::axis::Axis::Z) as u16;
        let told = ended(Some(Fault::LimitSwitch), Some(x));
        assert!(
            told.contains(&format!("of X (input {x})")) && told.contains("jog X 5mm"),
            "{told}"
        );
        assert!(!told.contains("--from-line"), "{told}");
        let told = ended(Some(Fault::LimitSwitch), Some(z));
        assert!(told.contains("jog Z -5mm"), "{told}");
        let told = ended(Some(Fault::LimitSwitch), Some(3));
        assert!(told.contains("(input 3)") && told.contains("--from-line 7"), "{told}");
        let told = ended(None, None);
        assert_eq!(told, "stopped here; --from-line 7 goes on from there");
    }
}
