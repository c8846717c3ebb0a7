//! Modal state between lines of G-code, so that each batch begins where the one before ended.

/// The words that hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Modes {
    /// G20 or G21.
    unit: u16,
    /// G90 or G91.
    distance: u16,
    /// G17 to G19.
    plane: u16,
    /// G61 or G64.
    path: u16,
    /// G0 to G3, once one was there.
    motion: Option<u16>,
    /// F and S as they stand.
    feed: Option<String>,
    power: Option<String>,
    /// The spindle or coolant is on.
    pub busy: bool,
    /// The program has ended: M2, M30.
    pub over: bool,
}

/// Why a line is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unfit;

/// Letters and numbers of a line, remarks left out.
fn words(line: &str) -> Vec<(char, &str)> {
    let mut list = Vec::new();
    let mut rest = line.split(';').next().unwrap_or_default();
    while let Some(letter) = rest.chars().next() {
        rest = &rest[letter.len_utf8()..];
        if letter == '(' {
            rest = rest.split_once(')').map_or("", |(_, behind)| behind);
            continue;
        }
        if letter.is_ascii_alphabetic() {
            let number = rest.trim_start();
            let end = number.find(|c: char| !(c.is_ascii_digit() || "+-. \t".contains(c)));
            let (own, behind) = number.split_at(end.unwrap_or(number.len()));
            list.push((letter.to_ascii_uppercase(), own.trim()));
            rest = behind;
        }
    }
    list
}

impl Default for Modes {
    /// Those of a board that was just switched on: millimetres, absolute, XY.
    fn default() -> Modes {
        Modes {
            unit: 21,
            distance: 90,
            plane: 17,
            path: 64,
            motion: None,
            feed: None,
            power: None,
            busy: false,
            over: false,
        }
    }
}

impl Modes {
    /// Takes a line: as it is, or with the motion word that holds.
    ///
    /// # Errors
    /// A canned cycle: what it repeats would be lost between two batches.
    pub fn take(&mut self, line: &str) -> Result<String, Unfit> {
        let (mut moves, mut named) = (false, false);
        for (letter, number) in words(line) {
            let code = number.parse::<f64>().unwrap_or(-1.0);
            match letter {
                // A tenth as in G38.2 is a motion of its own and holds for its line.
                'G' if code.fract() != 0.0 => named = true,
                'G' => match code as u16 {
                    motion @ 0..=3 => (self.motion, named) = (Some(motion), true),
                    unit @ 20..=21 => self.unit = unit,
                    plane @ 17..=19 => self.plane = plane,
                    distance @ 90..=91 => self.distance = distance,
                    path @ (61 | 64) => self.path = path,
                    80 => self.motion = None,
                    81..=89 => return Err(Unfit),
                    // These take axis words for themselves.
                    4 | 10 | 28 | 30 | 92 => named = true,
                    _ => {}
                },
                'M' => match code as u16 {
                    3 | 4 | 7 | 8 => self.busy = true,
                    5 | 9 => self.busy = false,
                    2 | 30 => (self.over, self.busy) = (true, false),
                    _ => {}
                },
                'F' => self.feed = Some(number.to_owned()),
                'S' => self.power = Some(number.to_owned()),
                'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R' => moves = true,
                _ => {}
            }
        }
        Ok(match self.motion {
            Some(motion) if moves && !named => format!("G{motion} {line}"),
            _ => line.to_owned(),
        })
    }

    /// Lines that bring about what holds; nothing moves by them.
    pub fn head(&self) -> String {
        let Modes { unit, distance, plane, path, .. } = self;
        let mut text = format!("G{unit} G{distance} G{plane} G{path}\n");
        for (letter, value) in [('F', &self.feed), ('S', &self.power)] {
            if let Some(value) = value {
                text += &format!("{letter}{value}\n");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::{Modes, Unfit};

    #[test]
    fn a_line_without_a_motion_word_gets_the_one_that_holds() {
        let mut modes = Modes::default();
        assert_eq!(modes.take("X5").as_deref(), Ok("X5"), "none holds yet");
        for (line, taken) in [
            ("g1x5 f600", "g1x5 f600"),
            ("X10.5 (G0) Y-1", "G1 X10.5 (G0) Y-1"),
            ("G91 Y2 ; X1", "G1 G91 Y2 ; X1"),
            ("G 02 X1 Y1 I1 J0", "G 02 X1 Y1 I1 J0"),
            ("X1 Y1 I1 J0", "G2 X1 Y1 I1 J0"),
            ("G92 X0", "G92 X0"),
            ("G38.2 Z-5", "G38.2 Z-5"),
            ("M3 S500", "M3 S500"),
            ("G4 P1", "G4 P1"),
        ] {
            assert_eq!(modes.take(line).as_deref(), Ok(taken));
        }
        assert_eq!(modes.head(), "G21 G91 G17 G64\nF600\nS500\n");
        assert!(modes.busy && !modes.over);
        assert_eq!(modes.take("G81 X1 Z-1 R1"), Err(Unfit));
        modes.take("M30").expect("good");
        assert!(modes.over && !modes.busy);
    }
}
