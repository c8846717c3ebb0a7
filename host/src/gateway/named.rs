//! Variables of a board's program by name, read with each poll of the board.

use std::collections::HashMap;

use super::known::{Program, Variable};
use super::line::Board;
use crate::client::ClientError;
use crate::client::status::long;

/// Values that one look reads: two registers each, within a request's most of the smallest board.
const AT_ONCE: u16 = 8;

/// A value of a variable that the link sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// As the script writes it, an array's with its index.
    pub name: String,
    /// What the board has, in the language's own units.
    pub value: i32,
    /// What one unit of [`Named::real`] is, or nothing for a plain number.
    pub unit: &'static str,
    /// The value times this is in the unit.
    pub scale: f64,
    /// It outlives power.
    pub keep: bool,
}

impl Named {
    /// The value in its unit; none for one that is a whole number of it as it stands.
    pub fn real(&self) -> Option<f64> {
        // Divided, not multiplied: 1100 thousandths are 1.1 and not 1.1 and a little.
        (self.scale != 1.0).then(|| f64::from(self.value) / self.scale.recip().round())
    }
}

/// Where values of a program stand: first register and how many values, each as one request reads them.
fn pieces(variables: &[Variable]) -> Vec<(u16, u16)> {
    let mut all: Vec<u16> =
        variables.iter().flat_map(Variable::values).map(|(_, register)| register).collect();
    all.sort_unstable();
    all.dedup();
    let mut pieces: Vec<(u16, u16)> = Vec::new();
    for register in all {
        match pieces.last_mut() {
            Some((first, count)) if *count < AT_ONCE && *first + 2 * *count == register => {
                *count += 1
            }
            _ => pieces.push((register, 1)),
        }
    }
    pieces
}

/// The variables of one board's program.
#[derive(Default)]
pub struct Names {
    program: Option<Program>,
    pieces: Vec<(u16, u16)>,
    /// The piece to be read next.
    next: usize,
    values: HashMap<u16, i32>,
}

impl Names {
    /// Begins a round with the program that the board is known to have.
    pub fn begin(&mut self, program: Option<Program>) {
        if self.program != program {
            let variables = program.as_ref().map_or(&[][..], |program| &program.variables);
            self.pieces = pieces(variables);
            self.program = program;
        }
        self.next = 0;
        self.values.clear();
    }

    /// Whether there is nothing to be read.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    /// The program's line whose code holds an offset.
    pub fn line(&self, pc: u16) -> Option<u16> {
        self.program.as_ref()?.line(pc)
    }

    /// Makes the next exchange of a round; false: there is none left.
    ///
    /// # Errors
    /// See [`ClientError`]. Registers that the board has not are passed over.
    pub fn look(&mut self, board: &mut Board) -> Result<bool, ClientError> {
        let Some((first, count)) = self.pieces.get(self.next).copied() else { return Ok(false) };
        match board.holding(first, 2 * count) {
            Ok(words) => {
                let pairs = words.chunks_exact(2).map(|pair| long(pair[0], pair[1]));
                self.values.extend((0..count).map(|n| first + 2 * n).zip(pairs));
            }
            Err(ClientError::Exception(_)) => {}
            Err(error) => return Err(error),
        }
        self.next += 1;
        Ok(self.next < self.pieces.len())
    }

    /// What the round brought, in the program's order.
    pub fn values(&self) -> Vec<Named> {
        let variables = self.program.iter().flat_map(|program| &program.variables);
        let of = |var: &Variable| {
            let ((unit, scale), keep) = (var.unit(), var.keep);
            let value = move |(name, register): (String, u16)| {
                let value = *self.values.get(&register)?;
                Some(Named { name, value, unit, scale, keep })
            };
            var.values().filter_map(value).collect::<Vec<_>>()
        };
        variables.flat_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{AT_ONCE, Named, pieces};
    use crate::gateway::known::Variable;

    #[test]
    fn what_stands_together_is_read_together() {
        let variable = |register, count| Variable {
            name: "a".to_owned(),
            register,
            count,
            array: count > 1,
            kind: "Length".to_owned(),
            keep: false,
        };
        assert_eq!(pieces(&[]), []);
        let list = [variable(3010, 3), variable(3000, 1), variable(3002, 1), variable(3000, 1)];
        assert_eq!(pieces(&list), [(3000, 2), (3010, 3)]);
        assert_eq!(pieces(&[variable(4000, 20)]), [(4000, 8), (4016, 8), (4032, 4)]);
        assert!(pieces(&[variable(4000, 100)]).iter().all(|(_, count)| *count <= AT_ONCE));
    }

    #[test]
    fn values_are_told_in_their_unit() {
        let named =
            |value, scale| Named { name: "a".to_owned(), value, unit: "mm", scale, keep: false };
        assert_eq!(named(1100, 0.001).real(), Some(1.1));
        assert_eq!(named(-3, 0.001).real(), Some(-0.003));
        assert_eq!(named(7, 1.0).real(), None);
    }
}
