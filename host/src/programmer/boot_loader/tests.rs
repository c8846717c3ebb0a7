//! A boot loader as the documents have it, around the emulated chip: what a round does in RAM is done by the
//! chip.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io;
use std::rc::Rc;
use std::time::Duration;

use emulator::{Board, Config, FlashSpeed, Image, Part, Reset, Rng, Silicon, Stop};
use proptest::prelude::*;

use super::frame::{BLANK, PASSWORD, Report, SUCCESS};
use super::rounds::ENTRY;
use super::{Desk, Hid, Segments, Told, Trouble, write};
use crate::board::F5529;

const WRONG: u8 = 5;
/// End of the writer's code, which nothing guards but that it comes twice.
const CODE_END: u32 = ENTRY + 0x100;

/// The chip with its boot loader, and the wires between.
struct Chip {
    board: Board,
    open: bool,
    /// Answers that wait.
    answers: Vec<Report>,
    /// Reports from the computer that are lost, of a thousand.
    lossy: u32,
    noise: Rng,
    /// The button is held all the while.
    button: bool,
    /// Milliseconds until the device is there.
    away: Option<u64>,
    /// Milliseconds that passed.
    now: u64,
    mass_erases: usize,
    rounds: usize,
    /// Power fails at this flash operation.
    cut: Option<u64>,
    /// Places of this round's blocks that came, and of those that have not yet.
    arrived: BTreeSet<u32>,
    missing: BTreeSet<u32>,
}

#[derive(Clone)]
struct Plug(Rc<RefCell<Chip>>);

struct Open(Rc<RefCell<Chip>>);

impl Chip {
    fn new(silicon: Silicon) -> Chip {
        let config = Config { part: Part::F5529, silicon, ..Config::default() };
        Chip {
            board: Board::with_config(&config, &Image::default()),
            open: false,
            answers: Vec::new(),
            lossy: 0,
            noise: Rng::new(7),
            button: false,
            away: Some(0),
            now: 0,
            mass_erases: 0,
            rounds: 0,
            cut: None,
            arrived: BTreeSet::new(),
            missing: BTreeSet::new(),
        }
    }

    fn answer(&mut self, code: u8) {
        let mut report = [0; 64];
        report[..4].copy_from_slice(&[0x3F, 2, 0x3B, code]);
        self.answers.push(report);
    }

    fn take(&mut self, report: &Report) {
        assert_eq!(report[0], 0x3F);
        let content = &report[2..2 + usize::from(report[1])];
        let address = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], 0]);
        let lost = self.noise.bits() % 1000 < u64::from(self.lossy);
        // Sums guard the rest.
        if let (true, 0x1B, at @ ..CODE_END) = (self.open, content[0], address(&content[1..])) {
            if lost && !self.arrived.contains(&at) {
                self.missing.insert(at);
            } else {
                self.missing.remove(&at);
                self.arrived.insert(at);
            }
        }
        if lost {
            return;
        }
        match content[0] {
            0x11 => {
                assert_eq!(content.len(), 1 + PASSWORD);
                let same =
                    (0xFFE0_u32..).zip(&content[1..]).all(|(at, b)| self.board.peek8(at) == *b);
                self.open = same;
                if !same {
                    self.mass_erases += 1;
                    Part::F5529.flash.for_each(|at| self.board.poke8(at, 0xFF));
                }
                self.answer(if same { SUCCESS } else { WRONG });
            }
            0x1B if self.open => {
                let at = address(&content[1..]);
                let data = &content[4..];
                assert!(at >= 0x2500 && at as usize + data.len() <= 0x3200, "{at:x}");
                (at..).zip(data).for_each(|(at, byte)| self.board.poke8(at, *byte));
            }
            0x17 if self.open => self.start(address(&content[1..])),
            0x1B | 0x17 => {}
            code => panic!("this boot loader has no command {code:x}"),
        }
    }

    /// Lets the chip run from its RAM to its reset.
    fn start(&mut self, at: u32) {
        self.open = false;
        self.rounds += 1;
        self.board.reset_pin();
        self.board.bus_write16(0x015C_u32, 0x5A80);
        self.board.set_reg(1, 0x4300_u32);
        self.board.set_reg(0, at);
        if let Some(operation) = self.cut.take() {
            self.board.cut_at_flash_operation(operation, 3);
        }
        self.board.clear_warnings();
        let begun = self.board.cycles();
        // What takes longer than a minute of a slow clock never ends.
        for _ in 0..3_000_000 {
            // A chip behind its reset must not go on as one that runs.
            let stop = self.board.run_us(20);
            if stop == Stop::NoPower {
                self.board.power_up();
                break;
            }
            if self.board.last_reset() == Reset::SoftwareBrownOut {
                break;
            }
        }
        let warnings: Vec<_> = self.board.warnings().iter().filter(|w| w.pc < 0x4400).collect();
        // The code is whole unless a piece of it was lost both times.
        assert!(warnings.is_empty() || !self.missing.is_empty(), "{warnings:?}");
        self.missing.clear();
        self.arrived.clear();
        // RAM is cleared, and enumeration takes its time.
        (0x2400..0x4400_u32).for_each(|at| self.board.poke8(at, 0));
        let blank = self.board.peek16(0xFFFE_u32) == 0xFFFF;
        // The boot loader's clock is eight times that of a reset.
        let ms = (self.board.cycles() - begun) / (self.board.ticks_per_second() / 1000) / 8;
        self.away = (blank || self.button).then_some(900 + ms);
    }
}

impl Desk for Plug {
    fn open(&mut self) -> Result<Option<Box<dyn Hid>>, String> {
        let there = self.0.borrow().away == Some(0);
        Ok(there.then(|| Box::new(Open(self.0.clone())) as Box<dyn Hid>))
    }

    fn pause(&mut self, time: Duration) {
        let mut chip = self.0.borrow_mut();
        let ms = time.as_millis() as u64;
        chip.now += ms;
        chip.away = chip.away.map(|left| left.saturating_sub(ms));
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.0.borrow().now)
    }
}

impl Hid for Open {
    fn send(&mut self, report: &Report) -> io::Result<()> {
        let mut chip = self.0.borrow_mut();
        if chip.away != Some(0) {
            return Err(io::ErrorKind::NotConnected.into());
        }
        chip.take(report);
        Ok(())
    }

    fn receive(&mut self, patience: Duration) -> io::Result<Option<Report>> {
        let mut chip = self.0.borrow_mut();
        if chip.answers.is_empty() {
            chip.now += patience.as_millis() as u64;
            return Ok(None);
        }
        Ok(Some(chip.answers.remove(0)))
    }
}

fn firmware() -> Segments {
    Segments::of_image(F5529.elf).expect("the firmware")
}

fn plug(change: impl FnOnce(&mut Chip)) -> Plug {
    let mut chip = Chip::new(Silicon::default());
    change(&mut chip);
    Plug(Rc::new(RefCell::new(chip)))
}

fn flash(plug: &Plug) -> (Result<(), Trouble>, Vec<Told>) {
    let mut told = Vec::new();
    let done = write(&mut plug.clone(), &firmware(), &mut |what| told.push(what));
    (done, told)
}

/// Every byte of the image is at its place.
fn is_written(plug: &Plug) -> bool {
    let chip = plug.0.borrow();
    let pieces = crate::board::image_file::pieces(F5529.elf).expect("the firmware");
    pieces
        .iter()
        .all(|(start, bytes)| (*start..).zip(bytes).all(|(at, b)| chip.board.peek8(at) == *b))
}

/// The firmware's own segments; what is beside them is the machine's.
const PROGRAM: u32 = 0xF400;
const PROFILE: u32 = 0x1880;

fn mark(chip: &mut Chip) {
    chip.board.poke16(PROGRAM, 0x1234);
    chip.board.poke16(PROFILE, 0x5678);
}

#[test]
fn a_chip_with_another_firmware_is_erased_and_written_and_its_profile_stays() {
    for speed in [FlashSpeed::Fast, FlashSpeed::Slow] {
        let mut chip = Chip::new(Silicon { flash: speed, ..Silicon::default() });
        chip.board.poke16(0xFFFE_u32, 0x4400);
        mark(&mut chip);
        let plug = Plug(Rc::new(RefCell::new(chip)));
        let (done, told) = flash(&plug);
        assert_eq!(done, Ok(()));
        assert_eq!(told[0], Told::Erased);
        let all = firmware().rounds().len() + 2;
        assert_eq!(told.last(), Some(&Told::Rounds(all, all)));
        assert!(is_written(&plug));
        let chip = plug.0.borrow();
        assert_eq!((chip.mass_erases, chip.rounds), (1, all));
        assert_eq!(chip.board.peek16(PROGRAM), 0xFFFF);
        assert_eq!(chip.board.peek16(PROFILE), 0x5678);
    }
}

#[test]
fn the_same_firmware_again_leaves_program_and_keep_values() {
    let plug = plug(|chip| {
        chip.board.program(&F5529.image().expect("the firmware"));
        mark(chip);
    });
    // A byte of the firmware is wrong.
    plug.0.borrow_mut().board.poke8(0x1_0100_u32, 0);
    let (done, told) = flash(&plug);
    assert_eq!((done, told[0]), (Ok(()), Told::Kept));
    assert!(is_written(&plug));
    let chip = plug.0.borrow();
    assert_eq!(chip.mass_erases, 0);
    assert_eq!((chip.board.peek16(PROGRAM), chip.board.peek16(PROFILE)), (0x1234, 0x5678));
    // What was right already was not erased: two segments, the vectors and that byte's.
    assert_eq!(chip.board.wear().erases.len(), 2, "{:?}", chip.board.wear().erases);
}

#[test]
fn what_it_has_written_starts_and_answers() {
    let plug = plug(|_| {});
    assert_eq!(flash(&plug).0, Ok(()));
    let mut chip = plug.0.borrow_mut();
    let board = &mut chip.board;
    board.power_cut();
    board.power_up();
    board.run_us(400_000);
    // Register 5000, the version of the register map.
    board.uart_send(&crate::link::adu::rtu(1, &[3, 0x13, 0x88, 0, 1]));
    board.run_us(20_000);
    let heard: Vec<u8> = board.uart_take().into_iter().map(|(_, byte)| byte).collect();
    assert_eq!(heard[..3], [1, 3, 2], "{heard:x?}");
}

#[test]
fn reports_that_are_lost_are_sent_again() {
    let mut passes = 0;
    for seed in 1..4 {
        let plug = plug(|chip| (chip.lossy, chip.noise) = (1, Rng::new(seed)));
        let (done, told) = flash(&plug);
        assert_eq!(done, Ok(()), "{told:?}");
        assert!(is_written(&plug));
        passes += told.iter().filter(|what| **what == Told::Again).count();
    }
    assert!(passes > 0, "none was lost");
    // So many that nothing can come of it: what was not compared is not started.
    for seed in 1..3 {
        let plug = plug(|chip| (chip.lossy, chip.noise) = (30, Rng::new(seed)));
        let (done, _) = flash(&plug);
        assert!(matches!(done, Err(Trouble::Unverified | Trouble::Silent)), "{done:?}");
        assert_eq!(plug.0.borrow().board.peek16(0xFFFE_u32), 0xFFFF);
    }
}

#[test]
fn a_cut_of_power_leads_back_into_the_boot_loader() {
    let plug = plug(|_| {});
    // In the middle of a round's writes: the chip comes up with blank vectors.
    plug.0.borrow_mut().cut = Some(5);
    assert_eq!(flash(&plug).0, Ok(()));
    assert!(is_written(&plug));
}

#[test]
fn troubles_are_told_with_what_to_do() {
    let absent = plug(|chip| chip.away = None);
    assert_eq!(flash(&absent).0, Err(Trouble::Absent));
    let pressed = plug(|chip| chip.button = true);
    assert_eq!(flash(&pressed).0, Err(Trouble::Button));
    assert!(is_written(&pressed));
    let deaf = plug(|chip| chip.lossy = 1000);
    assert_eq!(flash(&deaf).0, Err(Trouble::Silent));
    for trouble in [Trouble::Absent, Trouble::Silent, Trouble::Unverified, Trouble::Refused(5)] {
        assert!(trouble.to_string().contains("hold its BSL button"), "{trouble}");
    }
}

#[test]
fn what_is_no_image_is_refused() {
    assert!(Segments::of_image(b"no ELF").is_err());
    assert_ne!(firmware().password(), BLANK);
}

/// The words in the repository are those of the source, and none is what erratum CPU40 takes for the end of a
/// jump (SLAZ314).
#[test]
fn the_writer_is_its_source_assembled() {
    let image = Image::parse(include_bytes!("writer.txt")).expect("TI-TXT");
    let code = &image.segments[0];
    assert_eq!((image.segments.len(), code.addr, image.segments[1].addr), (2, 0x2500, 0x2600));
    assert!(code.data.len() <= 0xEC);
    // The reset, by its place.
    assert_eq!(code.data[0x9E..0xA4], [0xB2, 0x40, 0x04, 0xA5, 0x20, 0x01]);
    let words: Vec<u16> =
        code.data.chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect();
    for pair in words.windows(2) {
        let jump = pair[0] >> 13 == 1;
        assert!(!(jump && matches!(pair[1] & 0xF0FF, 0x0040 | 0x0050)), "{pair:x?}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let object = folder.path().join("writer.o");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src/programmer/boot_loader/writer.s");
    let assembled = std::process::Command::new("llvm-mc-22")
        .args(["-triple=msp430", "-filetype=obj", source, "-o"])
        .arg(&object)
        .status();
    let Ok(status) = assembled else {
        eprintln!("llvm-mc-22 does not run here: the comparison is left out");
        return;
    };
    assert!(status.success());
    use object::{Object as _, ObjectSection as _};
    let bytes = std::fs::read(object).expect("an object");
    let file = object::File::parse(&*bytes).expect("ELF");
    for (name, segment) in [".text", ".late"].iter().zip(&image.segments) {
        let made = file.section_by_name(name).expect("code").data().expect("bytes");
        assert_eq!(made, segment.data, "{name}");
    }
}

proptest! {
    /// Whatever a boot loader says, the tool ends.
    #[test]
    fn any_answer_is_borne(answers in proptest::collection::vec(any::<[u8; 32]>(), 0..20)) {
        struct Liar(Vec<[u8; 32]>, Duration);
        impl Desk for Liar {
            fn open(&mut self) -> Result<Option<Box<dyn Hid>>, String> {
                Ok(self.0.pop().map(|bytes| Box::new(Says(vec![bytes])) as Box<dyn Hid>))
            }
            fn pause(&mut self, time: Duration) { self.1 += time; }
            fn now(&self) -> Duration { self.1 }
        }
        struct Says(Vec<[u8; 32]>);
        impl Hid for Says {
            fn send(&mut self, _: &Report) -> io::Result<()> { Ok(()) }
            fn receive(&mut self, _: Duration) -> io::Result<Option<Report>> {
                let mut report = [0; 64];
                Ok(self.0.pop().map(|bytes| { report[..32].copy_from_slice(&bytes); report }))
            }
        }
        let done = write(&mut Liar(answers, Duration::ZERO), &firmware(), &mut |_| {});
        prop_assert!(done.is_err());
    }
}
