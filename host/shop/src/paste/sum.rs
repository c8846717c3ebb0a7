//! Sums of aperture macros: `$1/2-$3`, with `x` or `X` for a product.

use std::collections::BTreeMap;

/// Brackets in brackets.
const DEEPEST: u32 = 50;

/// Works a sum out; a variable that has no value is 0.
pub(super) fn value(text: &str, variables: &BTreeMap<u32, f64>) -> Option<f64> {
    let mut reader = Reader { rest: text.trim().as_bytes(), variables, depth: 0 };
    let value = reader.sum()?;
    (reader.rest.is_empty() && value.is_finite()).then_some(value)
}

struct Reader<'t> {
    rest: &'t [u8],
    variables: &'t BTreeMap<u32, f64>,
    depth: u32,
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<u8> {
        while let Some((b' ' | b'\n' | b'\r' | b'\t', rest)) = self.rest.split_first() {
            self.rest = rest;
        }
        self.rest.first().copied()
    }

    fn next(&mut self) {
        self.rest = self.rest.get(1..).unwrap_or_default();
    }

    fn sum(&mut self) -> Option<f64> {
        let mut left = self.product()?;
        while let Some(sign @ (b'+' | b'-')) = self.peek() {
            self.next();
            let right = self.product()?;
            left = if sign == b'+' { left + right } else { left - right };
        }
        Some(left)
    }

    fn product(&mut self) -> Option<f64> {
        let mut left = self.factor()?;
        while let Some(sign @ (b'x' | b'X' | b'/')) = self.peek() {
            self.next();
            let right = self.factor()?;
            left = if sign == b'/' { left / right } else { left * right };
        }
        Some(left)
    }

    fn factor(&mut self) -> Option<f64> {
        match self.peek()? {
            sign @ (b'+' | b'-' | b'(') => {
                self.next();
                self.depth += 1;
                if self.depth > DEEPEST {
                    return None;
                }
                let value = if sign == b'(' { self.sum()? } else { self.factor()? };
                self.depth -= 1;
                if sign == b'(' {
                    if self.peek()? != b')' {
                        return None;
                    }
                    self.next();
                }
                Some(if sign == b'-' { -value } else { value })
            }
            b'$' => {
                self.next();
                let number = self.digits(|c| c.is_ascii_digit()).parse().ok()?;
                Some(self.variables.get(&number).copied().unwrap_or(0.0))
            }
            _ => self.digits(|c| c.is_ascii_digit() || c == b'.').parse().ok(),
        }
    }

    fn digits(&mut self, test: fn(u8) -> bool) -> &str {
        let end = self.rest.iter().position(|c| !test(*c)).unwrap_or(self.rest.len());
        let (digits, rest) = self.rest.split_at(end);
        self.rest = rest;
        std::str::from_utf8(digits).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn sums_are_worked_out_and_nonsense_is_none() {
        let variables = [(1, 1.2), (3, 0.2)].into();
        let of = |text: &str| value(text, &variables);
        assert_eq!(of("$1/2-$3").map(|v| (v * 1e6).round()), Some(400_000.0));
        assert_eq!(of("0-(1 + 2)x-3"), Some(9.0));
        assert_eq!(of("$9+.5"), Some(0.5));
        for wrong in ["", "1+", "(1", "1/0", "$", "a", "1 2", &"(".repeat(1000), &"-".repeat(1000)]
        {
            assert_eq!(of(wrong), None, "{wrong}");
        }
    }
}
