//! Memory of the desktop's chip: the F5529's 64 KB below its code, profiles decoded from them, and the VM.

use std::rc::Rc;

use firmware::machine::chip::{self, Core, FREE, Memory as _};
use firmware::machine::core;
use firmware::machine::flash::Image;
use firmware::machine::pool::MEMORY_WORDS;
use firmware::machine::stream::FRAME_WORDS;
use firmware::machine::vm::Vm;
use firmware::verify::model::{self, Limits};
use lang::image::at;
use lang::isa::Op;
use lang::part::{F5529, SEGMENT};
use lang::record::{BoardRecord, MachineRecord, MoreRecord};

use super::{Desk, PER_MS, cost};

/// Start of the program area.
pub const AREA: u16 = 0xFE00 - (SEGMENT * F5529.segments as usize) as u16;
/// Segment of the information memory for faults and selections.
pub const LOG: u16 = 0x1800;
/// Bytes of the information memory that are used.
const INFORMATION: usize = 0x180;
/// Where the pool lies in RAM, and after it the frame.
const POOL: u16 = 0x2400;
const FRAME: u16 = POOL + 2 * MEMORY_WORDS as u16;
/// Where an END stands that belongs to no program, and the profile of a board that was never given one.
const NOTHING: u16 = 0x1000;
const DEFAULT: u16 = 0x1100;
/// RAM, which a reset clears.
const RAM: std::ops::Range<usize> = POOL as usize..FRAME as usize + 2 * FRAME_WORDS;

/// All that has an address.
pub struct Memory(Vec<u8>);

impl Memory {
    /// Erased flash, and RAM of zeros.
    pub fn new() -> Memory {
        let mut bytes = vec![0xFF; 0x1_0000];
        bytes[usize::from(NOTHING)] = Op::End as u8;
        let record = BoardRecord::UNKNOWN;
        let start = usize::from(DEFAULT);
        bytes[start..start + BoardRecord::SIZE].copy_from_slice(&record.to_bytes());
        let more = start + BoardRecord::SIZE;
        bytes[more..more + MoreRecord::SIZE].copy_from_slice(&record.more.to_bytes());
        let mut memory = Memory(bytes);
        memory.reset();
        memory
    }

    /// RAM is zeros again.
    pub fn reset(&mut self) {
        self.0[RAM].fill(0);
    }

    fn byte(&self, address: u16) -> u8 {
        self.0.get(usize::from(address)).copied().unwrap_or_default()
    }

    fn word(&self, address: u16) -> u16 {
        u16::from_le_bytes([self.byte(address), self.byte(address.wrapping_add(1))])
    }

    fn set_word(&mut self, address: u16, word: u16) {
        for (offset, byte) in (0..).zip(word.to_le_bytes()) {
            if let Some(place) = self.0.get_mut(usize::from(address.wrapping_add(offset))) {
                *place = byte;
            }
        }
    }

    fn bytes(&self, address: u16, length: usize) -> &[u8] {
        let start = usize::from(address);
        self.0.get(start..(start + length).min(self.0.len())).unwrap_or_default()
    }

    fn array<const N: usize>(&self, address: u16) -> [u8; N] {
        let mut array = [0; N];
        let bytes = self.bytes(address, N);
        array[..bytes.len()].copy_from_slice(bytes);
        array
    }

    /// The program area and the information memory, which outlast a power-off.
    pub fn flash(&self) -> Vec<u8> {
        [self.bytes(LOG, INFORMATION), self.bytes(AREA, usize::from(0xFE00 - AREA))].concat()
    }

    /// Puts what [`Memory::flash`] gave.
    pub fn set_flash(&mut self, bytes: &[u8]) {
        let (information, area) = bytes.split_at(INFORMATION.min(bytes.len()));
        for (start, bytes) in [(LOG, information), (AREA, area)] {
            let start = usize::from(start);
            if let Some(place) = self.0.get_mut(start..start + bytes.len()) {
                place.copy_from_slice(bytes);
            }
        }
    }
}

/// A profile and where it lies.
#[derive(Clone)]
pub struct Profile {
    record: Rc<BoardRecord>,
    address: u16,
}

impl std::ops::Deref for Profile {
    type Target = BoardRecord;
    fn deref(&self) -> &BoardRecord {
        &self.record
    }
}

impl Desk {
    fn change(&self, address: u16, word: u16) {
        self.0.memory.borrow_mut().set_word(address, word);
    }

    /// RAM is zeros again.
    pub(super) fn clear_ram(&self) {
        self.0.memory.borrow_mut().reset();
    }

    /// Puts bytes at an address, whatever memory is there.
    pub(super) fn put(&self, address: u16, bytes: &[u8]) {
        let start = usize::from(address);
        if let Some(place) = self.0.memory.borrow_mut().0.get_mut(start..start + bytes.len()) {
            place.copy_from_slice(bytes);
        }
    }

    /// Whether flash has such an address.
    fn is_flash(address: u16) -> bool {
        (AREA..0xFE00).contains(&address) || (LOG..LOG + INFORMATION as u16).contains(&address)
    }
}

impl chip::Memory for Desk {
    type Profile = Profile;
    type Axes = Rc<MachineRecord>;

    fn byte(&self, address: u16) -> u8 {
        self.0.memory.borrow().byte(address)
    }
    fn word(&self, address: u16) -> u16 {
        self.0.memory.borrow().word(address)
    }
    fn set_word(&self, address: u16, word: u16) {
        self.change(address, word);
    }
    fn long(&self, address: u16) -> i32 {
        let memory = self.0.memory.borrow();
        let halves = [memory.word(address), memory.word(address.wrapping_add(2))];
        (u32::from(halves[0]) | u32::from(halves[1]) << 16).cast_signed()
    }
    fn set_long(&self, address: u16, value: i32) {
        self.change(address, value as u16);
        self.change(address.wrapping_add(2), (value >> 16) as u16);
    }
    fn copy(&self, from: u16, to: u16, words: u16) {
        for offset in (0..words).map(|n| 2 * n) {
            let word = self.word(from.wrapping_add(offset));
            self.change(to.wrapping_add(offset), word);
        }
    }
    fn with_bytes<R>(&self, address: u16, length: u16, read: impl FnOnce(&[u8]) -> R) -> R {
        read(self.0.memory.borrow().bytes(address, length.into()))
    }
    fn pool(&self) -> u16 {
        POOL
    }
    fn frame(&self) -> u16 {
        FRAME
    }
    fn nothing(&self) -> u16 {
        NOTHING
    }
    fn write(&self, address: u16, word: u16) {
        let mut done = self.operate();
        if Desk::is_flash(address) {
            self.change(address, self.word(address) & (word | !done.bits()));
        }
        self.spend(cost::WRITE);
    }
    fn erase(&self, address: u16) {
        // Segments of the information memory are shorter.
        let size = if address < AREA { 0x80 } else { SEGMENT as u16 };
        let start = address & !(size - 1);
        let mut done = self.operate();
        if Desk::is_flash(start) {
            (0..size / 2).for_each(|n| {
                let address = start + 2 * n;
                self.change(address, self.word(address) | done.bits());
            });
        }
        // Interrupts are served meanwhile.
        (0..cost::ERASE / PER_MS).for_each(|_| self.spend(PER_MS));
    }
    fn profile_at(&self, address: u16) -> Profile {
        let memory = self.0.memory.borrow();
        let mut record = BoardRecord::from_bytes(&memory.array(address));
        record.more = MoreRecord::from_bytes(&memory.array(address + BoardRecord::SIZE as u16));
        Profile { record: Rc::new(record), address }
    }
    fn default_profile(&self) -> Profile {
        self.profile_at(DEFAULT)
    }
    fn address_of(profile: &Profile) -> u16 {
        profile.address
    }
    fn axes_at(&self, address: u16) -> Rc<MachineRecord> {
        Rc::new(MachineRecord::from_bytes(&self.0.memory.borrow().array(address)))
    }
    fn free_axes(&self) -> Rc<MachineRecord> {
        Rc::new(FREE)
    }
}

impl Core for Desk {
    fn mul_div(a: u32, b: u32, c: u32) -> u32 {
        firmware::motion::math::mul_div(a, b, c)
    }
    fn crc(crc: u16, byte: u8) -> u16 {
        lang::wire::crc16(crc, byte)
    }
    fn run(&self, vm: &mut Vm<Desk>) -> u16 {
        if let Some(exit) = self.run_driven(vm) {
            self.spend(cost::of_effect(exit));
            return exit;
        }
        // The slice ends with the millisecond in which it begins, as the interrupt ends it on the board.
        let now = self.ticks();
        let end = (now / PER_MS + 1) * PER_MS;
        let mut spent = 0;
        let exit = core::run(vm, |_| {
            spent += cost::INSTRUCTION;
            now + spent >= end
        });
        self.spend(spent + cost::of_effect(exit));
        exit
    }
    fn check(&self, image: u16, features: u8, _: u16) -> u8 {
        let length = self.word(image + at::LEN as u16);
        self.spend(u64::from(length) * cost::CHECK);
        let more = F5529.features & !0xFF;
        let limits = Limits { features: more | u16::from(features), ..Limits::of(&F5529) };
        let verdict = model::verify(&Image(self.clone(), image), &limits);
        verdict.err().map_or(0, |refusal| refusal as u8)
    }
}
