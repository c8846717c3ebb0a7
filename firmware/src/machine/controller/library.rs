//! The library: uploads into it, and which of its programs Start runs.

use super::Controller;
use crate::machine::chip::Chip;
use crate::machine::flash::{Area, Image};
use crate::machine::reset;
use crate::store::{self, Denied, NAME, Store};
use crate::verify::{Bytes, CODE};
use lang::fault::Fault;
use lang::image::at;
use lang::record::BoardRecord;
use lang::wire::{Exception, LIBRARY_NAME, Refusal, RunState, TraceKind, Upload};

/// Which program of the library is meant.
pub struct Library {
    /// Number of the one that Start runs, 0 for none.
    pub selected: u8,
    /// The button for the next program was down a millisecond ago.
    pressed: bool,
    /// Number that the status lamp blinks, once; 0 for none.
    pub shown: u8,
}

/// What the link says of the next upload, and the words of its image on their way to flash. They lie in the memory of
/// streamed pieces and are written once the reply is on its way, while the next request arrives.
pub struct Incoming {
    /// Number that it or an erase is for, 0 for the selected one or a free one.
    pub number: u8,
    /// Name that it gives.
    pub name: [u16; NAME],
    /// Announced length, bit 15 KEEP.
    pub length: u16,
    /// [`lang::wire::Refusal`]
    pub refusal: u8,
    /// Place of the first word in the image, words.
    first: u16,
    /// How many.
    count: u8,
    /// One was not taken: the upload cannot be sound any more.
    failed: bool,
}

impl Incoming {
    /// Between two requests: what the last one brought goes to flash.
    pub fn write<C: Chip>(&mut self, chip: &C, spare: u16, store: &mut Store) {
        if self.count == 0 {
            return;
        }
        for n in 0..self.count {
            let place = self.first + u16::from(n);
            let word = chip.word(spare + 2 * u16::from(n));
            // The link brings the earlier byte in the low half, as flash has it.
            self.failed |= store.write(&mut Area(chip.clone()), 2 * place, word).is_err();
        }
        self.count = 0;
    }
}

impl<C: Chip> Controller<C> {
    /// Between two requests: what the last one brought goes to flash.
    pub fn write_incoming(&mut self) {
        let spare = self.spare();
        self.incoming.write(&self.chip, spare, &mut self.store);
    }

    /// Whether program and profile may be replaced now.
    ///
    /// # Errors
    /// Device failure while they are locked, busy while anything runs.
    #[inline(never)]
    fn may_replace(&self) -> Result<(), Exception> {
        if self.lock.closed { Err(Exception::DeviceFailure) } else { self.idle() }
    }

    /// The stored program may have changed: it is checked, unless it is attached and so was before, and its
    /// profile holds.
    pub fn stored(&mut self) {
        self.forget_pieces();
        let attached = self.vm.code;
        let image = self.image().filter(|&image| image + CODE == attached || self.check(image));
        self.attach(image.unwrap_or(0));
        if image.is_none() {
            // The last fault's place went with its program.
            self.vm.fault_pc = 0;
        }
        self.session.stored(image.is_some());
    }

    /// Checks the image at an address. The pool stays as it is: AT variables live in it between runs.
    pub fn check(&mut self, image: u16) -> bool {
        self.incoming.refusal = self.chip.check(image, C::PART.features as u8, self.scratch());
        self.incoming.refusal == 0
    }

    /// Word `index` of the image that is uploaded.
    ///
    /// # Errors
    /// Busy or locked; no upload is open, or an earlier word does not hold its value.
    pub fn take_word(&mut self, index: u16, value: u16) -> Result<(), Exception> {
        if self.incoming.count == 0 {
            self.may_replace()?;
            self.forget_pieces();
        }
        let staged = &mut self.incoming;
        if staged.failed || !self.store.takes(2 * index) {
            return Err(Exception::DeviceFailure);
        }
        if staged.count == 0 {
            staged.first = index;
        }
        // One request brings words one behind the other, and no more than these.
        let next = staged.first.wrapping_add(u16::from(staged.count));
        let count = staged.count;
        if index != next || usize::from(count) >= const { Controller::<C>::spare_words() } {
            return Err(Exception::DeviceFailure);
        }
        staged.count += 1;
        self.chip.set_word(self.spare() + 2 * u16::from(count), value);
        Ok(())
    }

    /// The program that an upload or an erase is for.
    fn meant(&self) -> u8 {
        match (self.incoming.number, self.library.selected) {
            (0, 0) => {
                let free = |number: &u8| self.store.image_of::<Area<C>>(*number).is_none();
                (1..=C::PART.programs).find(free).unwrap_or(1)
            }
            (0, number) | (number, _) => number,
        }
    }

    /// A code of the link for the upload.
    ///
    /// # Errors
    /// Busy, locked, or refused, as the register says.
    pub fn upload(&mut self, value: u16) -> Result<(), Exception> {
        self.may_replace()?;
        let code = Upload::from_number(value).ok_or(Exception::IllegalValue)?;
        let number = self.meant();
        let result = match code {
            Upload::Begin | Upload::Replace => {
                self.incoming.failed = false;
                // No fault is told from a piece any more.
                self.close_stream();
                self.carry(number);
                if self.incoming.number == 0 {
                    // Nobody called it anything else.
                    for n in 0..NAME as u16 {
                        let word = self.store.name(&self.area(), number, n);
                        self.incoming.name[usize::from(n) & (NAME - 1)] = word;
                    }
                }
                let length = self.incoming.length & 0x7FFF;
                let keeps = self.incoming.length & 0x8000 != 0;
                let upload = store::Upload { number, length, keeps };
                self.store.begin(&mut self.area(), upload, code as u16 == Upload::Replace as u16)
            }
            Upload::Erase => {
                self.store.discard(&mut self.area(), number);
                self.incoming.number = 0;
                Ok(())
            }
            Upload::Commit if self.incoming.failed => Err(Denied::Flash),
            Upload::Commit => {
                if let Some(open) = self.store.open_image::<Area<C>>()
                    && !self.check(C::AREA + open)
                {
                    let refusal = self.incoming.refusal;
                    self.stored();
                    self.incoming.refusal = refusal;
                    return Err(Exception::DeviceFailure);
                }
                let number = self.store.open_number();
                let opened = self.store.open_image::<Area<C>>();
                let result = self
                    .hand_over()
                    .and_then(|()| self.store.commit(&mut self.area(), &self.incoming.name));
                if result.is_ok() {
                    // Who uploads next says again what he means.
                    self.incoming.number = 0;
                    if self.library.selected == 0 {
                        self.remember(number);
                    }
                    if number == self.library.selected
                        && let Some(opened) = opened
                    {
                        // It was checked just now.
                        self.attach(C::AREA + opened);
                    }
                }
                result
            }
        };
        // The selected one is what Start runs, whatever ran last.
        self.store.choose(self.library.selected);
        if self.image().is_none() {
            self.attach(0);
        }
        self.stored();
        self.incoming.refusal = match result {
            Ok(()) => Refusal::None,
            Err(Denied::NotBegun) => Refusal::NotBegun,
            Err(Denied::TooLong) => Refusal::TooLong,
            Err(Denied::Flash) => Refusal::Flash,
            Err(Denied::Image) => Refusal::Crc,
        } as u8;
        if self.incoming.refusal == 0 { Ok(()) } else { Err(Exception::DeviceFailure) }
    }

    fn remember(&mut self, number: u8) {
        self.library.selected = number;
        if reset::selected(&self.chip) != number {
            reset::select(&self.chip, number);
        }
    }

    /// From now on Start runs this program, over any reset.
    ///
    /// # Errors
    /// There is none of that number, or something runs.
    pub fn select(&mut self, number: u16) -> Result<(), Exception> {
        self.idle()?;
        let number = u8::try_from(number).map_err(|_| Exception::IllegalValue)?;
        if !self.store.choose(number) {
            return Err(Exception::IllegalValue);
        }
        self.remember(number);
        self.stored();
        Ok(())
    }

    /// After a reset: the program that was selected before, or the only one.
    pub fn reselect(&mut self) {
        let before = reset::settle_selected(&self.chip);
        self.library.selected = match self.store.choose(before) {
            true => before,
            false => self.store.current(),
        };
    }

    /// The program of the selection inputs becomes the one that a start runs, where the profile has such; else the
    /// selected one does.
    ///
    /// # Errors
    /// The library has none of that number.
    pub fn choose(&mut self) -> Result<(), Fault> {
        let number = match self.select_inputs() {
            0 => self.library.selected,
            number => number,
        };
        if self.store.choose(number) { Ok(()) } else { Err(Fault::NoProgram) }
    }

    /// RUN at rest, once the line rests, too: the run ends, and another program's begins in its place. The selection
    /// stays.
    ///
    /// # Errors
    /// The library has none of that name. One that fails its check ends the run as it would end a start.
    pub fn run_other(&mut self) -> Result<(), Fault> {
        if self.program.first() {
            let name = self.vm.data + self.vm.operand_word();
            let called = |number: &u8| self.is_called(*number, self.image_at(name));
            let number = (1..=C::PART.programs).find(called);
            // A piece of a streamed job is no program that could end.
            let number = number.filter(|_| !self.vm.is_piece);
            self.program.effect.n = number.ok_or(Fault::NoProgram)?;
        }
        if !self.motor.settled() || !self.lines.rests || !self.leave_kept() {
            return Ok(());
        }
        self.give_way();
        let (before, number) = (self.store.current(), self.program.effect.n);
        let pc = self.pc_of_effect();
        self.store.choose(number);
        if !self.image().is_some_and(|image| self.enter(image)) {
            self.store.choose(before);
            self.fail(Fault::ImageRefused);
            return Ok(());
        }
        self.set_out_anew();
        // Where RUN stood in the other one's code.
        self.program.pc = self.vm.code.wrapping_add(pc);
        self.emit(TraceKind::Run, number, 0);
        Ok(())
    }

    /// A program gives way to another one: outputs are as at its end, at once and not only when the other one has been
    /// checked, which takes a while.
    fn give_way(&mut self) {
        self.io.outputs = self.io.outputs & self.record.end.keep | self.record.end.on;
        self.exchange();
    }

    /// The run goes on with the image at an address, which the caller has checked, as after RUN. Everything rests.
    pub fn go_on_at(&mut self, image: u16) {
        self.give_way();
        self.begin_image(image, 0);
        self.set_out_anew();
    }

    /// Whether there is a program of this number whose name is that text, which begins with its length. Letters of
    /// both cases are the same.
    fn is_called(&self, number: u8, text: Image<C>) -> bool {
        let length = u16::from(text.byte(0));
        let alike = |at: u16| {
            let [even, odd] = self.store.name(&self.area(), number, at >> 1).to_be_bytes();
            let has = if at & 1 == 0 { even } else { odd };
            let wanted = if at < length { text.byte(at + 1) } else { 0 };
            has.eq_ignore_ascii_case(&wanted)
        };
        length != 0 && length <= 2 * NAME as u16 && (0..2 * NAME as u16).all(alike)
    }

    /// The binary number of the selection inputs' levels, the lowest input first; 0 without such.
    fn select_inputs(&self) -> u8 {
        let (first, count) = (self.record.select & 31, self.record.select >> 5);
        if count == BoardRecord::NEXT {
            return 0;
        }
        (0..count).map(|n| u8::from(self.input(first + n)) << n).sum()
    }

    /// Each millisecond: the button for the next program selects it where it is pressed, if nothing runs.
    pub fn next_program(&mut self) {
        let (input, what) = (self.record.select & 31, self.record.select >> 5);
        let pressed = what == BoardRecord::NEXT && self.input(input);
        let was = core::mem::replace(&mut self.library.pressed, pressed);
        if !pressed || was || self.idle().is_err() || self.session.is(RunState::Fault) {
            return;
        }
        let most = C::PART.programs;
        let mut number = self.library.selected;
        for _ in 0..most {
            number = if number >= most { 1 } else { number + 1 };
            if self.select(number.into()).is_ok() {
                self.library.shown = number;
                self.clock.blink = 0;
                return;
            }
        }
    }

    /// Register `index` of the list of programs: 16 for each, from that of program 1 on.
    pub fn listed(&self, index: u16) -> u16 {
        let (number, field) = ((index >> 4) as u8 + 1, index & 15);
        let Some(offset) = self.store.image_of::<Area<C>>(number) else { return 0 };
        let image = self.image_at(C::AREA + offset);
        match field {
            0 => image.word(at::LEN as u16),
            1 => image.word(at::CRC as u16),
            2 => u16::from(image.byte(at::KEEPS as u16)),
            LIBRARY_NAME.. => self.store.name(&self.area(), number, field - LIBRARY_NAME),
            _ => 0,
        }
    }
}
