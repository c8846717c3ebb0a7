//! A line of G-code, parsed and checked against Grbl's rules of which words exclude each other. Nothing is executed yet.

use super::Error;
use super::modal::{Motion, Spindle};
use super::words::{Word, words};

/// What a line does once beside its motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Once {
    /// G4
    Dwell,
    /// G10 L2, G10 L20
    SetOffset,
    /// G28 or G30: which.
    Go(Stored),
    /// G28.1 or G30.1: which.
    Store(Stored),
    /// G92
    Shift,
    /// G92.1
    Unshift,
}

/// One of the two stored places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stored {
    /// G28
    First,
    /// G30
    Second,
}

/// How a line ends or halts the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// M0, M1
    Halt,
    /// M2, M30
    End,
}

/// Words that Grbl does not have and OpenPnP sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// M82, M84, M204: nothing.
    Nothing,
    /// M114: the place, when all has come to rest.
    Place,
    /// M115: what this is.
    Firmware,
    /// M400: waits for rest.
    Rest,
    /// M42 Pn Sx, M62 to M65 Pn: an output. For M42 the state is S.
    Output(Option<bool>),
    /// M66 Pn: an input is read.
    Input,
}

/// A line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Block {
    /// The motion word, if it is there.
    pub motion: Option<Motion>,
    /// What it does once.
    pub once: Option<Once>,
    /// G53
    pub machine: bool,
    /// 17 to 19.
    pub plane: Option<u8>,
    /// G20 is true.
    pub inches: Option<bool>,
    /// G91 is true.
    pub relative: Option<bool>,
    /// G93 is true.
    pub inverse_time: Option<bool>,
    /// 0 for G54.
    pub wcs: Option<usize>,
    /// G43.1 is true, G49 false.
    pub tool_length: Option<bool>,
    /// M3, M4, M5.
    pub spindle: Option<Spindle>,
    /// M7.
    pub mist: bool,
    /// M8.
    pub flood: bool,
    /// M9.
    pub coolant_off: bool,
    /// M0, M1, M2, M30.
    pub flow: Option<Flow>,
    /// OpenPnP's.
    pub extra: Option<Extra>,
    values: [Option<f64>; 26],
}

/// The letters that have values.
const VALUES: &str = "FIJKLNPRSTXYZ";
/// Of these, the ones that are never below 0.
const POSITIVE: &str = "FNPST";
/// Largest line number.
const MOST_LINES: f64 = 10_000_000.0;
/// Largest tool number.
const MOST_TOOL: f64 = 99_999.0;

/// Groups of words of which a line has one.
#[derive(Clone, Copy)]
enum Group {
    Once,
    Motion,
    Plane,
    Distance,
    ArcDistance,
    FeedMode,
    Units,
    Cutter,
    ToolLength,
    Wcs,
    Path,
    Flow,
    Spindle,
    Extra,
}

impl Block {
    /// Reads a cleaned line.
    ///
    /// # Errors
    /// As Grbl numbers them.
    pub fn read(text: &str) -> Result<Block, Error> {
        let mut block = Block::default();
        let mut groups = 0u32;
        for (letter, value) in words(text)? {
            let group = match letter {
                'G' => Some(block.g(value)?),
                'M' => block.m(value)?,
                _ => {
                    block.value_word((letter, value))?;
                    None
                }
            };
            if let Some(group) = group {
                let bit = 1 << group as u32;
                if groups & bit != 0 {
                    return Err(Error::GROUP);
                }
                groups |= bit;
            }
        }
        block.check()?;
        Ok(block)
    }

    fn g(&mut self, value: f64) -> Result<Group, Error> {
        let tenths = (value * 10.0).round();
        if (value * 10.0 - tenths).abs() > 0.001 || !(0.0..1000.0).contains(&tenths) {
            return Err(Error::UNSUPPORTED);
        }
        let probe = |quiet, away| Some(Motion::Probe { quiet, away });
        let group = match tenths as u32 {
            motion @ (0 | 10 | 20 | 30 | 380..=389 | 800) => {
                self.motion = match motion {
                    0 => Some(Motion::Rapid),
                    10 => Some(Motion::Line),
                    20 => Some(Motion::Clockwise),
                    30 => Some(Motion::CounterClockwise),
                    382 => probe(false, false),
                    383 => probe(true, false),
                    384 => probe(false, true),
                    385 => probe(true, true),
                    800 => Some(Motion::Off),
                    _ => return Err(Error::UNSUPPORTED),
                };
                Group::Motion
            }
            once @ (40 | 100 | 280 | 281 | 300 | 301 | 920 | 921) => {
                self.once = Some(match once {
                    40 => Once::Dwell,
                    100 => Once::SetOffset,
                    280 => Once::Go(Stored::First),
                    281 => Once::Store(Stored::First),
                    300 => Once::Go(Stored::Second),
                    301 => Once::Store(Stored::Second),
                    920 => Once::Shift,
                    _ => Once::Unshift,
                });
                Group::Once
            }
            530 => {
                self.machine = true;
                Group::Once
            }
            plane @ (170 | 180 | 190) => {
                self.plane = Some((plane / 10) as u8);
                Group::Plane
            }
            unit @ (200 | 210) => {
                self.inches = Some(unit == 200);
                Group::Units
            }
            distance @ (900 | 910) => {
                self.relative = Some(distance == 910);
                Group::Distance
            }
            911 => Group::ArcDistance,
            mode @ (930 | 940) => {
                self.inverse_time = Some(mode == 930);
                Group::FeedMode
            }
            400 => Group::Cutter,
            431 | 490 => {
                self.tool_length = Some(tenths == 431.0);
                Group::ToolLength
            }
            wcs @ (540 | 550 | 560 | 570 | 580 | 590) => {
                self.wcs = Some((wcs / 10 - 54) as usize);
                Group::Wcs
            }
            591..=593 => return Err(Error::NO_WCS),
            610 | 640 => Group::Path,
            _ => return Err(Error::UNSUPPORTED),
        };
        Ok(group)
    }

    fn m(&mut self, value: f64) -> Result<Option<Group>, Error> {
        if value.fract() != 0.0 || !(0.0..1000.0).contains(&value) {
            return Err(Error::INTEGER);
        }
        let group = match value as u32 {
            flow @ (0 | 1 | 2 | 30) => {
                self.flow = Some(if flow < 2 { Flow::Halt } else { Flow::End });
                Group::Flow
            }
            spindle @ 3..=5 => {
                self.spindle = Some(match spindle {
                    3 => Spindle::Clockwise,
                    4 => Spindle::CounterClockwise,
                    _ => Spindle::Off,
                });
                Group::Spindle
            }
            // M7 and M8 may stand together.
            7 => {
                self.mist = true;
                return Ok(None);
            }
            8 => {
                self.flood = true;
                return Ok(None);
            }
            9 => {
                self.coolant_off = true;
                return Ok(None);
            }
            // A tool change that the operator made: Grbl has no word for it, its clients send it.
            6 => return Ok(None),
            extra @ (42 | 62..=66 | 82 | 84 | 114 | 115 | 204 | 400) => {
                self.extra = Some(match extra {
                    42 => Extra::Output(None),
                    62 | 64 => Extra::Output(Some(true)),
                    63 | 65 => Extra::Output(Some(false)),
                    66 => Extra::Input,
                    114 => Extra::Place,
                    115 => Extra::Firmware,
                    400 => Extra::Rest,
                    _ => Extra::Nothing,
                });
                Group::Extra
            }
            _ => return Err(Error::UNSUPPORTED),
        };
        Ok(Some(group))
    }

    fn value_word(&mut self, (letter, value): Word) -> Result<(), Error> {
        if !VALUES.contains(letter) {
            return Err(Error::UNSUPPORTED);
        }
        if POSITIVE.contains(letter) && value < 0.0 {
            return Err(Error::NEGATIVE);
        }
        match letter {
            'N' if value > MOST_LINES => return Err(Error::LINE_NUMBER),
            'T' if value > MOST_TOOL => return Err(Error::TOOL),
            _ => {}
        }
        let held = &mut self.values[usize::from(letter as u8 - b'A')];
        if held.replace(value).is_some() {
            return Err(Error::REPEATED);
        }
        Ok(())
    }

    /// The rules that hold for the whole line.
    fn check(&self) -> Result<(), Error> {
        let takes_axes = |once: Once| !matches!(once, Once::Dwell | Once::Unshift | Once::Store(_));
        let once = self.once.is_some_and(takes_axes);
        let moves = self.motion.is_some_and(|motion| motion != Motion::Off);
        let tool = self.tool_length == Some(true);
        if [once, moves, tool].into_iter().filter(|takes| *takes).count() > 1 {
            return Err(Error::AXIS_CONFLICT);
        }
        if let Some(Extra::Output(_) | Extra::Input) = self.extra {
            self.value('P').ok_or(Error::MISSING)?;
        }
        Ok(())
    }

    /// The number of a letter.
    pub fn value(&self, letter: char) -> Option<f64> {
        self.values[usize::from(letter as u8 - b'A')]
    }

    /// The numbers of X, Y and Z.
    pub fn axes(&self) -> [Option<f64>; 3] {
        ['X', 'Y', 'Z'].map(|letter| self.value(letter))
    }

    /// Whether X, Y or Z is there.
    pub fn has_axes(&self) -> bool {
        self.axes().iter().any(Option::is_some)
    }
}

#[cfg(test)]
mod tests {
    use super::{Block, Extra, Once};
    use crate::grbl::Error;
    use crate::grbl::modal::Motion;

    #[test]
    fn what_may_stand_together_is_read() {
        let block = Block::read("G91G1X5Y-2.5F600S300M3M7M8").expect("good");
        assert_eq!(block.axes(), [Some(5.0), Some(-2.5), None]);
        assert_eq!((block.relative, block.motion), (Some(true), Some(Motion::Line)));
        assert!(block.flood && block.mist);
        let block = Block::read("G10L20P1X0").expect("good");
        assert_eq!(block.once, Some(Once::SetOffset));
        assert_eq!(Block::read("M42P3S1").map(|b| b.extra), Ok(Some(Extra::Output(None))));
    }

    #[test]
    fn what_may_not_is_refused_by_number() {
        for (text, number) in [
            ("G1G2X1", 21),
            ("G90G91", 21),
            ("M3M5", 21),
            ("G28G0X1", 24),
            ("G92G1X1", 24),
            ("X1X2", 25),
            ("F-1", 4),
            ("G5", 20),
            ("G1.05", 20),
            ("M3.5", 23),
            ("A5", 20),
            ("N99999999", 27),
            ("G59.1", 29),
            ("M42S1", 28),
            ("G", 2),
            ("5", 1),
        ] {
            assert_eq!(Block::read(text), Err(Error(number)), "{text}");
        }
    }
}
