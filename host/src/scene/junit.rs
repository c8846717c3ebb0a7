//! Expectations as JUnit XML, as continuous integration reads it.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Report as Xml, TestCase, TestCaseStatus, TestSuite};

use super::Report;

/// A run of a script.
pub struct Run<'a> {
    /// The script.
    pub file: &'a str,
    /// What its cell gave.
    pub report: &'a Report,
    /// What else is not as it should be.
    pub differences: &'a [String],
}

/// A suite for each file, a case for each expectation, and one for the run itself.
#[must_use]
pub fn write(runs: &[Run<'_>]) -> String {
    let mut xml = Xml::new("pasapas");
    for Run { file, report, differences } in runs {
        let time = Duration::from_micros(report.end.us);
        let mut suite = TestSuite::new(*file);
        suite.set_time(time);
        for row in &report.rows {
            let message = format!("was {}", row.was);
            let status = if row.holds {
                TestCaseStatus::success()
            } else {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_message(message.clone());
                status.set_description(format!("{message}; wanted {}", row.wanted));
                status
            };
            let mut case = TestCase::new(row.name.as_str(), status);
            case.set_classname(*file).set_time(time);
            suite.add_test_case(case);
        }
        let status = match differences.first() {
            None => TestCaseStatus::success(),
            Some(first) => {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_message(first.clone());
                status.set_description(differences.join("\n"));
                status
            }
        };
        let mut case = TestCase::new("run", status);
        case.set_classname(*file).set_time(time);
        suite.add_test_case(case);
        xml.add_test_suite(suite);
    }
    xml.to_string().unwrap_or_default()
}
