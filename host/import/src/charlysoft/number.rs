//! Numbers and units of the source.

use super::{Read, Refused};
use crate::codes::Code;
use lang::front::literal::Decimal;

/// A ratio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Factor {
    pub num: u32,
    pub den: u32,
}

/// `text` times a ratio, rounded half away from zero. Both points and commas would be decimals in
/// French sources, but a comma parts values: only the point is one.
pub(super) fn whole_number(text: &str, factor: Factor) -> Option<i64> {
    Decimal::parse(text.trim())?.scaled(factor.num, factor.den).map(|(value, _)| value)
}

/// `mm`, `cm`, `inch`, each with `/` and how many parts: `inch/10`. The result is um.
pub(super) fn unit(text: &str) -> Read<Factor> {
    let compact: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let (name, parts) = compact.split_once('/').unwrap_or((&compact, "1"));
    let num = match name.to_ascii_lowercase().as_str() {
        "mm" => 1000,
        "cm" => 10_000,
        "inch" | "in" | "zoll" | "pouce" => 25_400,
        _ => {
            return Err(Refused::new(
                Code::Unsupported,
                format!("`{text}` is no unit"),
                "units are mm, cm, inch, and parts of them: inch/10",
            ));
        }
    };
    match parts.parse::<u32>() {
        Ok(den) if (1..=10_000).contains(&den) => Ok(Factor { num, den }),
        _ => Err(Refused::new(
            Code::OutOfRange,
            format!("`{parts}` parts of a unit"),
            "write `inch/10`",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::{Factor, unit, whole_number};

    #[test]
    fn a_broken_unit_of_the_binder_is_a_tenth() {
        let tenth = unit("inch/1 0").ok();
        assert_eq!(tenth, Some(Factor { num: 25_400, den: 10 }));
        assert_eq!(whole_number("2", Factor { num: 2540, den: 10 }), Some(508));
        assert!(unit("furlong").is_err() && unit("mm/0").is_err());
    }
}
