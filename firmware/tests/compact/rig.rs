//! A whole program on the chip: the test takes the main loop's place, millisecond by millisecond.

use std::sync::LazyLock;

use emulator::Wiring;
use emulator::plant::OutputChange;
use lang::front::source::Source;
use lang::front::{ProfileChoice, compile};
use lang::profile::Profile;
use lang::record::BoardRecord;
use lang::wire::{RunState, TraceKind};

use crate::chip::Chip;
use crate::verify::Elf;
use micro::decode::Code;

/// The first slot of the program area, and where its image lies.
pub const SLOT: u16 = crate::area::AREA;
pub const IMAGE: u16 = SLOT + 4;
/// A commit word.
pub const COMMITTED: u16 = 0xA500;
/// Where the board's profile lies: segment C.
pub const PROFILE: u16 = lang::part::G2553.profiles[1];
/// Outputs or latch and enable of the chain: driven by the firmware when they have their levels.
const OUTPUTS: u8 = 1 << 2 | 1 << 5;
/// `T_` flags, as the image has them: trace mode.
pub static T_ON: LazyLock<u8> = LazyLock::new(|| flag("T_ON"));
/// See [`T_ON`]: the host reads on.
pub static T_HEARD: LazyLock<u8> = LazyLock::new(|| flag("T_HEARD"));
/// See [`T_ON`]: an event waits.
pub static T_FULL: LazyLock<u8> = LazyLock::new(|| flag("T_FULL"));

fn flag(name: &str) -> u8 {
    Elf::of("whole").symbol(name).expect("a constant of the image") as u8
}

/// One trace event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// See [`TraceKind`].
    pub kind: u8,
    /// Its argument.
    pub argument: u8,
    /// Its value.
    pub value: i32,
}

/// An event of the wanted kind.
pub const fn event(kind: TraceKind, argument: u8, value: i32) -> Event {
    Event { kind: kind as u8, argument, value }
}

/// The image of a script for a profile.
pub fn image_of(profile: &Profile, script: &str) -> Vec<u8> {
    let (source, _) = Source::decode("test", script.as_bytes());
    let choice = ProfileChoice::Given(Box::new(profile.clone()));
    let (program, diags) = compile(&source, choice);
    let program = program.unwrap_or_else(|| panic!("{script}: {:?}", diags));
    lang::back::compile(&program).expect("it fits").image
}

/// The chip with a program, its milliseconds counted by the test.
pub struct Rig {
    /// The chip.
    pub chip: Chip,
    /// Trace events so far.
    pub events: Vec<Event>,
    /// What was printed.
    pub printed: String,
    /// Whether a host takes what is printed.
    pub takes: bool,
}

impl Rig {
    /// A board with the profile of that name, its program stored.
    pub fn new(profile: &str, script: &str) -> Rig {
        Rig::with(&Profile::built_in(profile).expect("a built-in profile"), script)
    }

    /// A board with this profile, its program stored.
    pub fn with(profile: &Profile, script: &str) -> Rig {
        Rig::with_image(profile, &image_of(profile, script))
    }

    /// A board with this profile and this image stored.
    pub fn with_image(profile: &Profile, image: &[u8]) -> Rig {
        let direct = profile.wiring == lang::profile::Wiring::Direct;
        let mut chip = Chip::wired(if direct { Wiring::Direct } else { Wiring::Chain });
        let mut put = |first: u16, bytes: &[u8]| {
            for (address, &byte) in (first..).zip(bytes) {
                chip.board.poke8(address, byte);
            }
        };
        put(SLOT, &COMMITTED.to_le_bytes());
        put(IMAGE, image);
        put(PROFILE, &BoardRecord::of(profile, 1).to_bytes());
        // As the boot table has it.
        for (register, value) in [("P2DIR", !OUTPUTS), ("P1OUT", 0xFF), ("P1REN", 0xFF)] {
            chip.board.bus_write8(chip.at(register), value);
        }
        chip.set_word("BOARD", PROFILE);
        chip.set_word("OVERRIDE", 0x6464);
        chip.call("io_open", &[]);
        chip.call("store_mount", &[]);
        let rig = Rig { chip, events: Vec::new(), printed: String::new(), takes: true };
        assert_eq!(rig.state(), RunState::Ready, "refusal {}", rig.chip.byte("REFUSAL"));
        rig
    }

    /// The same with a host that traces.
    pub fn traced(profile: &str, script: &str) -> Rig {
        let mut rig = Rig::new(profile, script);
        rig.chip.set_byte("TRACING", *T_ON | *T_HEARD);
        rig
    }

    /// The run state, without WaitStart.
    pub fn state(&self) -> RunState {
        RunState::from_number(self.chip.byte("RUN").into()).expect("a run state")
    }

    /// Lets milliseconds pass; in each the program comes round a few times.
    pub fn ms(&mut self, count: u32) {
        for _ in 0..count {
            let now = self.chip.word("MILLIS").wrapping_add(1);
            self.chip.set_word("MILLIS", now);
            // An image check starts the watchdog, which the main loop would kick.
            let [watchdog, off] = ["WATCHDOG", "WATCHDOG_OFF"].map(|name| self.chip.at(name));
            self.chip.board.bus_write16(watchdog, off);
            self.chip.call("ticks", &[]);
            for _ in 0..4 {
                self.chip.call("emergency_input", &[]);
                self.chip.call("run", &[]);
                self.host();
            }
        }
    }

    /// What a host does between two polls: takes the event and the print.
    fn host(&mut self) {
        let mut flags = self.chip.byte("TRACING");
        if flags & *T_ON != 0 {
            flags |= *T_HEARD;
            self.chip.set_byte("TRACING", flags);
        }
        if flags & *T_FULL != 0 {
            let kind = self.chip.byte("TRACE_KIND");
            let argument = self.chip.byte("TRACE_ARGUMENT");
            let value = self.chip.long("TRACE_VALUE", 0).cast_signed();
            // A run begins as if there had been an event 0.
            if self.chip.word("TRACE_NUMBER") != 0 {
                self.events.push(Event { kind, argument, value });
            }
            self.chip.set_byte("TRACING", flags & !*T_FULL);
        }
        if self.takes {
            let ring = self.chip.at("PRINT");
            let tail = self.chip.word("PRINT_TAIL");
            let ready = self.chip.byte("PRINT_READY");
            for k in 0..u16::from(ready) {
                let byte = self.chip.board.peek8(ring + (tail.wrapping_add(k) & 15));
                self.printed.push(byte.into());
            }
            self.chip.set_word("PRINT_TAIL", tail.wrapping_add(ready.into()));
            self.chip.set_byte("PRINT_READY", 0);
            self.chip.set_word("UNHEARD", 0);
        }
    }

    /// Presses Start for as long as the filter wants.
    pub fn start(&mut self) {
        self.chip.board.plant_mut().press_start(true);
        self.ms(20);
        self.chip.board.plant_mut().press_start(false);
        self.ms(20);
    }

    /// Presses Stop for a moment.
    pub fn stop(&mut self) {
        self.chip.board.plant_mut().press_stop(true);
        self.ms(20);
        self.chip.board.plant_mut().press_stop(false);
        self.ms(20);
    }

    /// Sets an input of the plant and lets the filter see it.
    pub fn input(&mut self, n: u8, on: bool) {
        self.chip.board.plant_mut().set_input(n, on);
        self.ms(20);
    }

    /// Whether the plant sees the output on.
    pub fn output(&self, n: u8) -> bool {
        self.chip.board.plant().output(n)
    }

    /// Outputs that changed at the plant: number and state.
    pub fn changes(&mut self) -> Vec<(u8, bool)> {
        let changes = self.chip.board.plant_mut().take_output_changes();
        changes.iter().map(|change: &OutputChange| (change.output, change.on)).collect()
    }
}
