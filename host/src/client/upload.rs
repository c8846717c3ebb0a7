//! Upload of a program (lang's `wire` module, Upload).

use std::fmt;

use lang::called;
use lang::image::Image;
use lang::part::{G2553, Lack, PARTS, Part, SHORT_PULSE_US};
use lang::record::feature;
use lang::wire::{self, Exception, Refusal, Upload};

use super::library::{Called, name_of, words_of};
use super::{Client, ClientError};
use crate::link::Link;

/// Registers in one request: what every board takes at least (firmware/README.md, Link).
const REGISTERS: usize = 21;

/// Why a program did not get to the board.
#[derive(Debug)]
pub enum UploadError {
    /// The link or the board failed.
    Client(ClientError),
    /// It does not fit beside the stored program, which would be lost.
    NoRoomBeside {
        /// Bytes of the image.
        image: usize,
        /// Bytes that are free.
        free: u16,
    },
    /// It does not fit at all.
    TooLong {
        /// Bytes of the image.
        image: usize,
        /// Bytes of the whole area.
        area: u16,
    },
    /// The firmware has no such feature; the first build that runs the program, if one does.
    Lacks(Lack, Option<&'static Part>),
    /// A program runs or an axis moves.
    Busy,
    /// The board checked the image and refused it.
    Refused(Option<Refusal>),
    /// The board's library has no place for it.
    NoPlace(String),
    /// It was not made for this board.
    Mismatch(String),
}

impl From<ClientError> for UploadError {
    fn from(error: ClientError) -> UploadError {
        UploadError::Client(error)
    }
}

impl fmt::Display for UploadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UploadError::Client(error) => error.fmt(f),
            UploadError::NoRoomBeside { image, free } => write!(
                f,
                "the program has {image} bytes and {free} are free beside what is stored; --replace gives the one \
                 that it replaces up first (a cut cable then leaves the board without it)"
            ),
            UploadError::TooLong { image, area } => {
                write!(f, "the program has {image} bytes; the board holds {area}")
            }
            UploadError::Lacks(lack, build) => {
                write!(f, "the board's firmware lacks what the program wants: {lack}")?;
                match build {
                    // Only the G2553's firmware lacks anything: what suits that board is another build for it.
                    Some(part) if part.chip.family == G2553.chip.family => {
                        write!(f, "; `pasapas flash --part {}` writes one that has it", part.name)
                    }
                    Some(part) => write!(
                        f,
                        "; that of another chip, the {}, has it: `pasapas sim` runs the program without a board",
                        part.chip.name
                    ),
                    None => f.write_str(
                        "; no chip's firmware has it: `pasapas sim` runs the program without a board",
                    ),
                }
            }
            UploadError::Busy => {
                f.write_str("a program runs or an axis moves; `pasapas stop` ends that")
            }
            UploadError::Refused(refusal) => {
                let reason = reason(*refusal);
                write!(f, "the board refused the program: {reason}")
            }
            UploadError::NoPlace(text) | UploadError::Mismatch(text) => f.write_str(text),
        }
    }
}

/// Why a board refused a program or a piece of one, in words.
pub fn reason(refusal: Option<Refusal>) -> &'static str {
    match refusal {
        Some(Refusal::TooLong) => "it does not fit",
        Some(Refusal::NotBegun | Refusal::Incomplete) => "parts of it did not arrive",
        Some(Refusal::Crc) => "it arrived damaged",
        Some(Refusal::Version) => "its format or instruction set is another version's",
        Some(Refusal::Feature) => "it uses what this firmware does not have",
        Some(Refusal::Memory) => "it needs more cells, stack or calls than there are",
        Some(Refusal::Code) => "its code does not pass the board's check",
        Some(Refusal::Flash) => "the flash does not hold what was written",
        Some(Refusal::None) | None => "no reason was given",
    }
}

impl std::error::Error for UploadError {}

impl<L: Link> Client<L> {
    /// Brings `image` to the board and makes it the stored program. `progress` hears how many bytes
    /// have arrived. The old program stays until the last step, unless `replace` gives it up.
    ///
    /// # Errors
    /// See [`UploadError`].
    pub fn upload(
        &mut self,
        image: &[u8],
        replace: bool,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), UploadError> {
        self.upload_as(image, None, replace, progress)
    }

    /// The same for the program of that number in the board's library, which gets that name.
    ///
    /// # Errors
    /// See [`UploadError`].
    pub fn upload_as(
        &mut self,
        image: &[u8],
        place: Option<(u8, &str)>,
        replace: bool,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), UploadError> {
        let identity = self.identity()?;
        identity.check().map_err(UploadError::Mismatch)?;
        if identity.features & feature::LIBRARY != 0 {
            self.write(wire::UPLOAD_NUMBER, place.map_or(0, |(number, _)| number.into()))?;
            if let Some((_, name)) = place {
                self.write_all(wire::UPLOAD_NAME, &words_of(name))?;
            }
        }
        if let Ok(image) = Image::new(image) {
            let runs = called::runs(&image).next().map_or(0, |_| feature::LIBRARY);
            let wanted = u16::from(image.header.features)
                | runs
                | image.extra().fold(0, |all, (_, feature)| all | feature);
            let missing = wanted & !identity.features;
            if missing != 0 {
                let lack = Lack::Feature(1 << missing.trailing_zeros());
                let runs = |part: &&Part| part.lacks(&image, SHORT_PULSE_US).is_none();
                return Err(UploadError::Lacks(lack, PARTS.iter().find(runs)));
            }
        }
        let area = identity.area_bytes;
        let length = match u16::try_from(image.len()) {
            Ok(length) if length <= area => length,
            _ => return Err(UploadError::TooLong { image: image.len(), area }),
        };
        let begin = if identity.program_bytes == 0 || length <= identity.free_bytes {
            Upload::Begin
        } else if replace {
            Upload::Replace
        } else {
            let free = identity.free_bytes;
            return Err(UploadError::NoRoomBeside { image: image.len(), free });
        };
        // An image with KEEP leaves the segments of its values alone.
        let keep = image.get(1).is_some_and(|features| u16::from(*features) & feature::KEEP != 0);
        self.write(wire::UPLOAD_LENGTH, length | u16::from(keep) << 15)?;
        match self.step(begin) {
            Err(UploadError::Refused(Some(Refusal::TooLong)))
                if begin == Upload::Begin && identity.program_bytes != 0 =>
            {
                if !replace {
                    let free = identity.free_bytes;
                    return Err(UploadError::NoRoomBeside { image: image.len(), free });
                }
                self.step(Upload::Replace)?;
            }
            other => other?,
        }
        let window = wire::upload_window(image.len());
        // Boards that take streamed jobs take longer requests.
        let mut most = match identity.features & feature::STREAM {
            0 => REGISTERS,
            _ => usize::from(self.holding(wire::STREAM_REQUEST, 1)?[0]).max(REGISTERS),
        };
        let mut sent = 0;
        while sent < image.len() {
            let chunk = &image[sent..image.len().min(sent + 2 * most)];
            let values: Vec<u16> = chunk
                .chunks(2)
                .map(|pair| u16::from_le_bytes([pair[0], *pair.get(1).unwrap_or(&0xFF)]))
                .collect();
            match self.write_all(window + (sent / 2) as u16, &values) {
                // An adapter that pauses between its packets, here or beyond a gateway, tears long requests apart: short
                // ones fit into a packet.
                Err(error) if error.may_be_done() && values.len() > REGISTERS => {
                    most = REGISTERS;
                    continue;
                }
                other => other?,
            }
            sent += chunk.len();
            progress(sent);
        }
        let committed = self.while_it_checks(image.len(), |client| client.step(Upload::Commit));
        match committed {
            // A board of one program knows no upload any more when the commit is repeated because its reply was lost.
            Err(UploadError::Refused(Some(Refusal::NotBegun)))
                if identity.features & feature::LIBRARY == 0 && self.identity()?.holds(image) =>
            {
                Ok(())
            }
            other => other,
        }
    }

    /// Brings the program of a file to the board, in whose library it takes the place of the one that is `called` so, or
    /// else so as the file, and is what Start runs. Number and name of that place, if there is a library.
    ///
    /// # Errors
    /// See [`UploadError`].
    pub fn bring(
        &mut self,
        image: &[u8],
        (called, file): (Option<&Called>, &str),
        replace: bool,
        progress: &mut dyn FnMut(usize),
    ) -> Result<Option<(u8, String)>, UploadError> {
        let Some(library) = self.library()? else {
            return match called {
                None | Some(Called::Number(1)) => {
                    self.upload(image, replace, progress).map(|()| None)
                }
                Some(called) => Err(UploadError::NoPlace(format!(
                    "this board holds one program, not a library: {called} cannot be chosen; leave --as away"
                ))),
            };
        };
        let by_file = Called::Name(name_of(file));
        let (number, name) =
            library.place(called.unwrap_or(&by_file), file).map_err(UploadError::NoPlace)?;
        self.upload_as(image, Some((number, &name)), replace, progress)?;
        self.select(number)?;
        Ok(Some((number, name)))
    }

    /// Erases the stored program.
    ///
    /// # Errors
    /// See [`UploadError`].
    pub fn erase(&mut self) -> Result<(), UploadError> {
        self.step(Upload::Erase)
    }

    fn step(&mut self, step: Upload) -> Result<(), UploadError> {
        match self.write(wire::UPLOAD_CONTROL, step as u16) {
            Err(error) if error.is_exception(Exception::Busy) => Err(UploadError::Busy),
            Err(error) if error.is_exception(Exception::DeviceFailure) => {
                if self.is_locked()? {
                    return Err(ClientError::Locked.into());
                }
                let result = self.holding(wire::UPLOAD_RESULT, 1)?[0];
                Err(UploadError::Refused(Refusal::from_number(result)))
            }
            other => Ok(other?),
        }
    }
}
