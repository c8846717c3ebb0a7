//! The registers and bits of the link (`lang::wire`).

use crate::core::Core;
use crate::flash::{self, Area, Key};
use crate::motor::AXES;
use crate::vm::{POOL_WORDS, vm};
use firmware::modbus::Map;
use firmware::print::RING;
use firmware::store::{Denied, Store};
use firmware::verify::Bytes;
use lang::isa::FINGERPRINT;
use lang::record::BoardRecord;
use lang::wire::*;

/// Firmware version, major in the high byte.
const RELEASE: u16 = 0x0001;

const COMMANDED_END: u16 = COMMANDED + 6;

/// The two copies of the board's profile.
pub const PROFILES: [u16; 2] = [0x1080, 0x1040];

impl Core {
    /// One half of a 32-bit value: both are of one instant when they are read in one request.
    fn half(&mut self, address: u16, value: i32) -> u16 {
        if address & 1 == 0 {
            self.latch = (value >> 16) as u16;
            self.latched = address + 1;
            return value as u16;
        }
        if self.latched == address { self.latch } else { (value >> 16) as u16 }
    }

    fn axis_value(&mut self, address: u16, first: u16, of: fn(&Core, u8) -> i32) -> u16 {
        let n = ((address - first) >> 1) as u8;
        if n >= AXES {
            return 0;
        }
        let value = of(self, n);
        self.half(address, value)
    }

    fn work_position(&self, n: u8) -> i32 {
        let offset = crate::vm::convert(n, self.motor.offset[usize::from(n)], true).unwrap_or(0);
        self.motor.position(n).wrapping_sub(offset)
    }

    fn own(&mut self, address: u16) -> u16 {
        match address {
            VERSION => WIRE_VERSION,
            FIRMWARE_VERSION => RELEASE,
            ISA_FINGERPRINT => FINGERPRINT,
            PROFILE_HASH => self.record.crc,
            FEATURES => crate::core::FEATURES,
            AREA_BYTES => Store::area(),
            FREE_BYTES => self.store.free(),
            PROGRAM_LENGTH => self.store.length(),
            PROGRAM_CRC => self.header(4),
            PROGRAM_PROFILE => self.header(18),
            PROGRAM_CELLS => self.header(14) & 0xFF,
            RESET_CAUSE => u16::from(self.cause),
            STACK_FREE => crate::boot::stack_free(),
            MISSED_DEADLINES => self.missed,
            POOL_WORDS_REGISTER => POOL_WORDS as u16,
            RUN_STATE => self.session.state() as u16,
            FAULT => u16::from(self.session.fault()),
            FAULT_PC => vm().fault_pc.wrapping_sub(vm().code),
            FAULT_LINE => vm().line(vm().fault_pc),
            FAULT_INPUT => u16::from(self.fault_input),
            PROGRAM_COUNTER => self.effect_pc.wrapping_sub(vm().code),
            LAST_END => self.session.last() as u16,
            RUN_COUNT => self.session.runs(),
            HOMED => u16::from(self.motor.homed),
            BLOCKING_INPUT => u16::from(self.blocking()),
            MACHINE_POSITIONS..COMMANDED => {
                self.axis_value(address, MACHINE_POSITIONS, |core, n| core.motor.position(n))
            }
            COMMANDED..COMMANDED_END => {
                self.axis_value(address, COMMANDED, |core, n| core.motor.steps[usize::from(n)])
            }
            TRACE_MODE => u16::from(self.trace.on),
            UPLOAD_LENGTH => self.upload_length,
            UPLOAD_RESULT => u16::from(self.refusal),
            TRACE_EVEN..PRINT_COUNT => self.slot(address),
            PRINT_COUNT => u16::from(self.print.count()),
            PRINT_TAIL => self.print.tail(),
            PRINT_TEXT..CHAR_OUT => {
                let at = ((address - PRINT_TEXT) * 2) as u8;
                if usize::from(at) >= RING {
                    return 0;
                }
                u16::from_be_bytes([self.print.byte(at), self.print.byte(at + 1)])
            }
            CHAR_OUT => self.char_out,
            CHAR_IN => u16::from(self.char_in),
            _ => 0,
        }
    }

    fn header(&self, offset: u16) -> u16 {
        self.image().map_or(0, |image| flash::Image(image).word(offset))
    }

    fn slot(&mut self, address: u16) -> u16 {
        let odd = address >= TRACE_ODD;
        self.received(odd);
        if (self.trace.number & 1 != 0) != odd {
            return 0;
        }
        match address & 7 ^ TRACE_EVEN & 7 {
            0 => self.trace.number,
            1 => u16::from_le_bytes([self.trace.kind, self.trace.argument]),
            2 => self.trace.pc,
            3 => self.trace.value as u16,
            4 => (self.trace.value >> 16) as u16,
            _ => 0,
        }
    }

    fn idle(&self) -> Result<(), Exception> {
        if self.session.is_active() || self.motor.moving() != 0 {
            return Err(Exception::Busy);
        }
        Ok(())
    }

    fn upload(&mut self, value: u16) -> Result<(), Exception> {
        self.idle()?;
        let code = Upload::from_number(value).ok_or(Exception::IllegalValue)?;
        let length = self.upload_length & 0x7FFF;
        let keep = self.upload_length & 0x8000 != 0;
        let result = match code {
            Upload::Begin => self.store.begin(&mut Area, length, keep, false),
            Upload::Replace => self.store.begin(&mut Area, length, keep, true),
            Upload::Erase => {
                self.store.discard(&mut Area);
                Ok(())
            }
            Upload::Commit => {
                if let Some(open) = self.store.open_image()
                    && !self.check(flash::AREA + open)
                {
                    self.session.stored(self.store.image().is_some());
                    return Err(Exception::DeviceFailure);
                }
                self.store.commit(&mut Area)
            }
        };
        self.session.stored(self.store.image().is_some());
        self.refusal = match result {
            Ok(()) => Refusal::None,
            Err(Denied::NotBegun) => Refusal::NotBegun,
            Err(Denied::TooLong) => Refusal::TooLong,
            Err(Denied::Flash) => Refusal::Flash,
            Err(Denied::Image) => Refusal::Crc,
        } as u8;
        if self.refusal == 0 { Ok(()) } else { Err(Exception::DeviceFailure) }
    }

    /// A word of the copy of the profile that is not in use; the last one makes it valid.
    fn write_profile(&mut self, index: u16, value: u16) -> Result<(), Exception> {
        self.idle()?;
        let current = core::ptr::from_ref(self.record) as u16;
        let copy = if current == PROFILES[0] { PROFILES[1] } else { PROFILES[0] };
        if index == 0 {
            flash::erase(Key::new(), copy);
        }
        let address = copy + 2 * index;
        flash::write(Key::new(), address, value);
        if flash::read(address) != value {
            return Err(Exception::DeviceFailure);
        }
        if index == BoardRecord::SIZE as u16 / 2 - 1 && crate::boot::profile(copy).is_none() {
            return Err(Exception::DeviceFailure);
        }
        Ok(())
    }

    fn mask(&self, of: fn(&Core, u8) -> bool) -> u16 {
        let mut mask = 0;
        let mut n = AXES;
        while n != 0 {
            n -= 1;
            mask = mask << 1 | u16::from(of(self, n));
        }
        mask
    }

    fn status(&mut self, address: u16) -> u16 {
        match address {
            INPUTS => self.inputs.levels(),
            INPUTS_HIGH => u16::from(self.input(17)),
            MOVING => u16::from(self.motor.moving()),
            PLC_STATUS => u16::from(self.session.is_active()) << 10,
            LIMITS => {
                let limit = self.mask(|core, n| core.input(core.record.reference[usize::from(n)]));
                limit
            }
            WORK_POSITIONS..ACTUAL_SPEEDS => {
                self.axis_value(address, WORK_POSITIONS, Core::work_position)
            }
            PROBE_RESULT_TEXT..PROBE_RESULT => {
                self.axis_value(address, PROBE_RESULT_TEXT, |core, n| {
                    core.motor.probed[usize::from(n)]
                })
            }
            PROBE_RESULT..CNC_STATUS => {
                self.axis_value(address, PROBE_RESULT, |core, n| core.motor.probed[usize::from(n)])
            }
            _ => 0,
        }
    }
}

impl Map for Core {
    fn begin(&mut self) {
        self.latched = 0;
    }

    fn read(&mut self, table: Table, address: u16) -> u16 {
        match address {
            OWN..PROFILE_WINDOW => self.own(address),
            PROFILE_WINDOW..UPLOAD_WINDOW => {
                let record = core::ptr::from_ref(self.record) as u16;
                flash::read(record + 2 * (address - PROFILE_WINDOW))
            }
            _ if table as u8 == Table::InputRegisters as u8 => self.status(address),
            OUTPUTS => self.outputs,
            POSITIONS..SPEEDS => self.axis_value(address, POSITIONS, Core::work_position),
            CELLS..KEEPS => {
                if !self.session.is_active() {
                    return 0;
                }
                let value = vm().cell((address - CELLS) >> 1);
                self.half(address, value)
            }
            _ => 0,
        }
    }

    fn read_bit(&mut self, table: Table, address: u16) -> bool {
        let word = match table {
            Table::Coils => self.outputs,
            _ if address < STATUS_BITS => self.status(INPUTS + (address >> 4)),
            _ => self.status(MOVING + ((address - STATUS_BITS) >> 4)),
        };
        word >> (address & 15) & 1 != 0
    }

    fn write(&mut self, address: u16, value: u16) -> Result<(), Exception> {
        match address {
            RUN_CONTROL => {
                let control = Control::from_number(value).ok_or(Exception::IllegalValue)?;
                self.control(control);
                Ok(())
            }
            TRACE_MODE => {
                self.trace.on = value != 0;
                self.trace.full = false;
                Ok(())
            }
            UPLOAD_CONTROL => self.upload(value),
            UPLOAD_LENGTH => {
                self.upload_length = value;
                Ok(())
            }
            PRINT_TAIL => {
                if self.print.take(value) {
                    Ok(())
                } else {
                    Err(Exception::IllegalValue)
                }
            }
            CHAR_IN => {
                if !(33..=125).contains(&value) {
                    return Err(Exception::IllegalValue);
                }
                self.char_in = value as u8;
                Ok(())
            }
            OUTPUTS => {
                self.outputs = value;
                Ok(())
            }
            PROFILE_WINDOW..UPLOAD_WINDOW => self.write_profile(address - PROFILE_WINDOW, value),
            UPLOAD_WINDOW.. => {
                self.idle()?;
                // The link brings the earlier byte in the low half, as flash has it.
                self.store
                    .write(&mut Area, 2 * (address - UPLOAD_WINDOW), value)
                    .map_err(|_| Exception::DeviceFailure)
            }
            _ => Err(Exception::IllegalAddress),
        }
    }

    fn write_long(&mut self, address: u16, value: i32) -> Result<(), Exception> {
        match address {
            CELLS..KEEPS => {
                if !self.session.is_active() {
                    return Err(Exception::DeviceFailure);
                }
                if vm().set_cell((address - CELLS) >> 1, value) {
                    Ok(())
                } else {
                    Err(Exception::IllegalValue)
                }
            }
            _ => Err(Exception::IllegalAddress),
        }
    }

    fn write_bit(&mut self, address: u16, on: bool) -> Result<(), Exception> {
        if self.set_output(address + 1, on) { Ok(()) } else { Err(Exception::IllegalAddress) }
    }

    fn written(&mut self, _address: u16) -> Result<(), Exception> {
        Ok(())
    }
}
