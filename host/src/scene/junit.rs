//! Expectations as JUnit XML, as continuous integration reads it.

use std::time::Duration;

use quick_junit::{NonSuccessKind, Report as Xml, TestCase, TestCaseStatus, TestSuite};

use super::Report;

/// A suite for each file, a case for each expectation. A file whose cell expects nothing has one case, its end.
#[must_use]
pub fn write(files: &[(String, &Report)]) -> String {
    let mut xml = Xml::new("pasapas");
    for (file, report) in files {
        let time = Duration::from_micros(report.end.us);
        let mut suite = TestSuite::new(file.as_str());
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
            case.set_classname(file.as_str()).set_time(time);
            suite.add_test_case(case);
        }
        xml.add_test_suite(suite);
    }
    xml.to_string().unwrap_or_default()
}
