//! The MSP430F5529 as the machine sees it ([`firmware::machine::chip`]). The handle has no size; each method is a function of
//! this image.

use crate::boot;
use crate::chain;
use crate::check;
use crate::chip;
use crate::flash::{self, Key};
use crate::guard;
use crate::link;
use crate::math;
use crate::measure;
use crate::observe;
use crate::ram;
use crate::step;
use crate::vm_core;
use firmware::machine::chip::{Chip, Clock, Core, FREE, Guard, Memory, Observed, Pins, Steps};
use firmware::machine::stream;
use firmware::machine::vm::Vm;
use firmware::motion::{PathSegment, Segment};
use lang::record::{BoardRecord, MachineRecord};
use lang::wire::Seen;

/// This chip.
#[derive(Clone, Copy)]
pub struct F5529;

/// See [`FREE`].
static FREE_AXES: MachineRecord = FREE;

impl Memory for F5529 {
    type Profile = &'static BoardRecord;
    type Axes = &'static MachineRecord;

    #[inline(always)]
    fn byte(&self, address: u16) -> u8 {
        // SAFETY: any address can be read.
        unsafe { (address as *const u8).read_volatile() }
    }
    #[inline(always)]
    fn word(&self, address: u16) -> u16 {
        flash::read(address)
    }
    #[inline(always)]
    fn set_word(&self, address: u16, word: u16) {
        // SAFETY: a word of the pool or of the frame, to which nobody has a reference.
        unsafe { (address as *mut u16).write(word) };
    }
    #[inline(always)]
    fn long(&self, address: u16) -> i32 {
        // SAFETY: any address can be read; they are aligned to words, as i32 is here.
        unsafe { (address as *const i32).read() }
    }
    #[inline(always)]
    fn set_long(&self, address: u16, value: i32) {
        // SAFETY: as of `set_word`.
        unsafe { (address as *mut i32).write(value) };
    }
    #[inline(always)]
    fn copy(&self, from: u16, to: u16, words: u16) {
        // SAFETY: the caller's, as of `set_word`.
        unsafe {
            core::ptr::copy_nonoverlapping(from as *const u16, to as *mut u16, words.into());
        }
    }
    #[inline(always)]
    fn with_bytes<R>(&self, address: u16, length: u16, read: impl FnOnce(&[u8]) -> R) -> R {
        // SAFETY: any address can be read; nothing writes there before `read` returns.
        read(unsafe { core::slice::from_raw_parts(address as *const u8, length.into()) })
    }
    #[inline(always)]
    fn pool(&self) -> u16 {
        ram::pool()
    }
    #[inline(always)]
    fn frame(&self) -> u16 {
        ram::frame()
    }
    #[inline(always)]
    fn nothing(&self) -> u16 {
        ram::nothing()
    }
    #[inline(always)]
    fn write(&self, address: u16, word: u16) {
        flash::write(Key::new(), address, word);
    }
    #[inline(always)]
    fn erase(&self, address: u16) {
        flash::erase(Key::new(), address);
    }
    #[inline(always)]
    fn profile_at(&self, address: u16) -> &'static BoardRecord {
        // SAFETY: a whole record at an even address of flash; it is only erased when it is not in use. What lies behind
        // it is integers.
        unsafe { &*(address as *const BoardRecord) }
    }
    #[inline(always)]
    fn default_profile(&self) -> &'static BoardRecord {
        &BoardRecord::UNKNOWN
    }
    #[inline(always)]
    fn address_of(profile: &&'static BoardRecord) -> u16 {
        core::ptr::from_ref(*profile) as u16
    }
    #[inline(always)]
    fn axes_at(&self, address: u16) -> &'static MachineRecord {
        // SAFETY: a record at an even address, in front of the code of a verified image; the store tells the VM when it
        // gives that image up. All its fields are integers.
        unsafe { &*(address as *const MachineRecord) }
    }
    #[inline(always)]
    fn free_axes(&self) -> &'static MachineRecord {
        &FREE_AXES
    }
}

const _: () = assert!(check::SCRATCH <= stream::SCRATCH);

impl Core for F5529 {
    #[inline(always)]
    fn mul_div(a: u32, b: u32, c: u32) -> u32 {
        math::mul_div(a, b, c)
    }
    #[inline(always)]
    fn crc(crc: u16, byte: u8) -> u16 {
        // 3 KB take 20 ms, and the check of the code follows.
        boot::kick();
        math::crc16(crc, byte)
    }
    #[inline(always)]
    fn run(&self, vm: &mut Vm<F5529>) -> u16 {
        vm_core::run(vm)
    }
    #[inline(always)]
    fn check(&self, image: u16, features: u8, scratch: u16) -> u8 {
        // SAFETY: memory of the caller that is large enough, and that nobody has a reference to.
        let scratch = unsafe { &mut *(scratch as *mut [u8; check::SCRATCH]) };
        check::verify(image, features, scratch).err().unwrap_or(0)
    }
}

impl Steps for F5529 {
    const DIR: [u8; 3] = chip::ports::DIR;

    #[inline(always)]
    fn is_running(&self) -> bool {
        step::is_running()
    }
    #[inline(always)]
    fn axis_is_running(&self, axis: usize) -> bool {
        step::axis_is_running(axis)
    }
    #[inline(always)]
    fn clear(&self) {
        step::clear();
    }
    #[inline(always)]
    fn set_invert(&self, invert: u8) {
        step::set_invert(invert);
    }
    #[inline(always)]
    fn path_has_room(&self) -> bool {
        step::path_has_room()
    }
    #[inline(always)]
    fn ahead(&self) -> u16 {
        step::ahead()
    }
    #[inline(always)]
    fn put_path(&self, segment: &PathSegment, power: u16) {
        step::put_path(segment, power);
    }
    #[inline(always)]
    fn power(&self) -> u16 {
        step::power()
    }
    #[inline(always)]
    fn shine_at_pwm(&self) {
        step::shine();
    }
    #[inline(always)]
    fn axis_has_room(&self, axis: usize) -> bool {
        step::axis_has_room(axis)
    }
    #[inline(always)]
    fn put_axis(&self, axis: usize, segment: &Segment, negative: bool) {
        step::put_axis(axis, segment, negative);
    }
    #[inline(always)]
    fn halt(&self) {
        step::halt();
    }
    #[inline(always)]
    fn halt_axis(&self, axis: usize) {
        step::halt_axis(axis);
    }
    #[inline(always)]
    fn fold(&self, axis: usize, position: &mut i32) {
        step::fold(axis, position);
    }
    #[inline(always)]
    fn set_count(&self, axis: usize, position: i32) {
        step::set_count(axis, position);
    }
    #[inline(always)]
    fn watch(&self, pins: u8, idle: u8, halt: bool) {
        step::watch(pins, idle, halt);
    }
    #[inline(always)]
    fn hit(&self) -> u8 {
        step::hit()
    }
    #[inline(always)]
    fn caught(&self, axis: usize, position: i32) -> i32 {
        step::caught(axis, position)
    }
    #[inline(always)]
    fn late(&self) -> u16 {
        step::late()
    }
    #[inline(always)]
    fn measure(&self, mode: u16) -> bool {
        measure::set(mode)
    }
    #[inline(always)]
    fn measures(&self) -> u16 {
        measure::mode()
    }
    #[inline(always)]
    fn measured(&self, n: u16) -> u16 {
        measure::found(n)
    }
    #[inline(always)]
    fn revision(&self) -> u16 {
        u16::from(chip::capture::revision())
    }
}

impl Guard for F5529 {
    #[inline(always)]
    fn guard(&self, pins: u8, inputs: u16) {
        guard::watch(pins, inputs);
    }
    #[inline(always)]
    fn tripped(&self) -> u8 {
        guard::tripped()
    }
    #[inline(always)]
    fn answered(&self) -> u16 {
        guard::answered()
    }
}

impl Pins for F5529 {
    const PROBE: u8 = chip::ports::PROBE;

    #[inline(always)]
    fn exchange(&self, outputs: u16) -> u16 {
        chain::exchange(outputs)
    }
    #[inline(always)]
    fn pins(&self, outputs: u16) -> u16 {
        chain::pins(outputs)
    }
    #[inline(always)]
    fn probe(&self) -> bool {
        chain::probe()
    }
    #[inline(always)]
    fn buttons(&self) -> u16 {
        chain::buttons()
    }
    #[inline(always)]
    fn analog(&self, n: u8) -> u16 {
        chip::adc::sum(n)
    }
    #[inline(always)]
    fn convert_analog(&self) {
        chip::adc::convert();
    }
    #[inline(always)]
    fn open_analog(&self, inputs: u8) {
        chip::adc::open(inputs);
    }
    #[inline(always)]
    fn remember_stop(&self, outputs: u16) {
        chip::flash::remember_stop(outputs);
    }
    #[inline(always)]
    fn open_pwm(&self, hz: u16) -> (u16, u16) {
        chip::pwm::open(hz)
    }
    #[inline(always)]
    fn set_pwm(&self, compare: u16) {
        chip::pwm::set(compare);
    }
    #[inline(always)]
    fn gate_pwm(&self, on: bool) {
        chip::pwm::gate(on);
    }
    #[inline(always)]
    fn open_aout(&self, hz: u16) -> u16 {
        chip::aout::open(hz)
    }
    #[inline(always)]
    fn set_aout(&self, compare: u16) {
        chip::aout::set(compare);
    }
    #[inline(always)]
    fn darken_aout(&self) {
        chip::aout::darken();
    }
}

impl Clock for F5529 {
    const PER_MS: u16 = chip::timer::PER_MS;
    const RATE: u32 = chip::clock::RATE;

    #[inline(always)]
    fn millis(&self) -> u16 {
        link::millis()
    }
    #[inline(always)]
    fn look_after_clock(&self) {
        chip::clock::recover();
    }
    #[inline(always)]
    fn now(&self) -> u16 {
        chip::timer::now()
    }
    #[inline(always)]
    fn clock_fault(&self) -> u8 {
        chip::clock::fault()
    }
    #[inline(always)]
    fn mark(&self, runs: bool) {
        boot::mark(runs);
    }
    #[inline(always)]
    fn is_marked(&self) -> bool {
        boot::is_marked()
    }
    #[inline(always)]
    fn stack_free(&self) -> u16 {
        boot::stack_free()
    }
}

impl Observed for F5529 {
    #[inline(always)]
    fn event(&self, kind: u8, argument: u8, value: i32, commanded: &[i32; 3], pc: u16) {
        observe::event(kind, argument, value, commanded, pc);
    }
    #[inline(always)]
    fn beside(&self, what: Seen, byte: u8, pc: u16) {
        observe::beside(what, byte, pc);
    }
}

impl Chip for F5529 {
    const PART: lang::part::Part = chip::PART;
    const AREA: u16 = chip::AREA;
    const LOG: u16 = chip::LOG;
}
