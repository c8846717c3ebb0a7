//! What an interface card answers: `0`, or the character of an error.

/// The answers of system version 4.0/5.0. The binder's list of error codes and its text disagree
/// on some letters; where they do, both meanings stand here.
const ANSWERS: [(char, &str); 12] = [
    ('0', "no error"),
    ('1', "a number that cannot be read"),
    ('2', "a limit switch"),
    ('3', "an axis that is not there"),
    ('4', "axes not defined"),
    ('5', "a syntax error"),
    ('6', "memory full"),
    ('7', "a wrong number of values"),
    ('A', "a wrong pulse option"),
    ('B', "a branch before the start, in its list TELL without an end"),
    ('C', "a loop that is not allowed, in its list CR expected"),
    ('D', "a speed out of range"),
];

/// `; the card answers 7 (a wrong number of values)`.
pub(crate) fn answer(error: char) -> String {
    match ANSWERS.iter().find(|(known, _)| *known == error) {
        Some((_, meaning)) => format!("; the card answers {error} ({meaning})"),
        None => format!("; the card answers {error}"),
    }
}
