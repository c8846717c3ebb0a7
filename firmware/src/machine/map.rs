//! The registers and bits of the link (`lang::wire`).

use crate::RELEASE;
use crate::analog::ANALOGS as ANALOGS_OF;
use crate::machine::chip::Chip;
use crate::machine::controller::Controller;
use crate::machine::controller::trace;
use crate::machine::flash::Area;
use crate::machine::motor::AXES;
use crate::machine::pool;
use crate::machine::profile::profile_word;
use crate::modbus::Map;
use crate::rules::{Axis, Machine, commands, coords, status};
use crate::store::{NAME, Store};
use crate::verify::{Bytes, MACHINE};
use lang::fault::Fault;
use lang::image::{at, cells};
use lang::isa::FINGERPRINT;
use lang::record::AxisRecord;
#[allow(
    clippy::wildcard_imports,
    reason = "the table of the registers: what this file serves"
)]
use lang::wire::*;

const COMMANDED_END: u16 = COMMANDED + 6;
const COMMAND_END: u16 = COMMAND + 21;
const RAPID_OVERRIDE: u16 = OVERRIDES + 1;
const ACTUAL_SPEEDS_END: u16 = ACTUAL_SPEEDS + 6;
const TARGETS_END: u16 = TARGETS + 6;
const TARGET_SPEEDS_END: u16 = TARGET_SPEEDS + 6;
const UPLOAD_NAME_END: u16 = UPLOAD_NAME + NAME as u16;
const MEASURED_END: u16 = MEASURED + 6;
const KEEPS_END: u16 = KEEPS + 16;
const ANALOGS_USED: u16 = ANALOGS + ANALOGS_OF as u16;

impl<C: Chip> Controller<C> {
    fn axis_value(&mut self, address: u16, first: u16, of: fn(&Controller<C>, u8) -> i32) -> u16 {
        let n = ((address - first) >> 1) as u8;
        if n >= AXES {
            return 0;
        }
        let value = of(self, n);
        self.lines.half(address, value)
    }

    fn work_position(&self, n: u8) -> i32 {
        coords::work_steps(&self.motor, Axis::new(n))
    }

    fn own(&mut self, address: u16) -> u16 {
        match address {
            VERSION => WIRE_VERSION,
            FIRMWARE_VERSION => RELEASE,
            ISA_FINGERPRINT => FINGERPRINT,
            PROFILE_HASH if self.lock.closed => 0,
            PROFILE_HASH => self.record.crc,
            FEATURES => C::PART.features,
            AREA_BYTES => Store::area::<Area<C>>(),
            FREE_BYTES => self.store.free(&self.area()),
            PROGRAM_LENGTH => self.store.length(&self.area()),
            PROGRAM_CRC => self.header(at::CRC),
            PROGRAM_PROFILE => self.header(at::PROFILE),
            PROGRAM_CELLS => cells(self.header(at::CELLS) as u8),
            RESET_CAUSE => u16::from(self.reset.cause | self.chip.clock_fault()),
            STACK_FREE => self.chip.stack_free(),
            MISSED_DEADLINES => self.clock.missed,
            LATE_EVENTS => self.chip.late(),
            CHIP_REVISION => self.chip.revision(),
            POOL_WORDS_REGISTER => const { pool::words(&C::PART) as u16 },
            RUN_STATE => u16::from(self.session.shown()),
            FAULT => u16::from(self.session.fault),
            FAULT_PC => status::fault_pc(self),
            FAULT_LINE => self.vm.line(self.vm.fault_pc),
            FAULT_INPUT => u16::from(self.program.fault_input),
            PROGRAM_COUNTER => status::program_counter(self),
            LAST_END => u16::from(self.session.last),
            RUN_COUNT => self.session.runs,
            HOMED => u16::from(self.motor.homed),
            BLOCKING_INPUT => status::blocking(self),
            MACHINE_POSITIONS..COMMANDED => {
                self.axis_value(address, MACHINE_POSITIONS, |controller, n| {
                    controller.motor.position(n)
                })
            }
            COMMANDED..COMMANDED_END => self.axis_value(address, COMMANDED, |controller, n| {
                controller.motor.steps[usize::from(n)]
            }),
            STREAM_CALL | STREAM_ACCEPTED..=STREAM_RESULT | STREAM_SLOTS..=STREAM_REQUEST => {
                self.stream.read(address)
            }
            TRACE_MODE => status::trace_mode(self),
            TRACE_ROOM => trace::ROOM.into(),
            TRACE_TAKEN => self.trace.number,
            JOG_HOLD => self.command.hold,
            HELM => self.lines.helm(),
            UPLOAD_LENGTH => self.incoming.length,
            UPLOAD_RESULT => u16::from(self.incoming.refusal),
            TRACE_EVEN..PRINT_COUNT => self.slot(address),
            PRINT_COUNT => self.talk.print.count(),
            PRINT_TAIL => self.talk.print.tail(),
            PRINT_TEXT..CHAR_OUT => {
                let at = (address - PRINT_TEXT) * 2;
                u16::from_be_bytes([self.talk.print.byte(at), self.talk.print.byte(at + 1)])
            }
            CHAR_OUT => self.talk.char_out,
            CHAR_IN => u16::from(self.talk.char_in),
            PROGRAM_NUMBER => u16::from(self.store.current()),
            SELECTED => u16::from(self.library.selected),
            UPLOAD_NUMBER => u16::from(self.incoming.number),
            UPLOAD_NAME..UPLOAD_NAME_END => {
                self.incoming.name[usize::from(address - UPLOAD_NAME) & (NAME - 1)]
            }
            MEASURE => self.chip.measures(),
            MEASURED..MEASURED_END => self.chip.measured(address - MEASURED),
            WAITS => u16::from(self.waits()),
            EFFECT_PLACE => self.pc_of_effect(),
            OPEN_CALLS.. => self.vm.open_call(address - OPEN_CALLS),
            _ => 0,
        }
    }

    fn header(&self, offset: usize) -> u16 {
        self.image().map_or(0, |image| self.image_at(image).word(offset as u16))
    }

    /// Of the axes' part of the profile in the stored program, 0 without one and while a lock hides it.
    fn machine_word(&self, index: u16) -> u16 {
        let image = self.image().filter(|_| !self.lock.closed);
        image.map_or(0, |image| self.image_at(image).word(MACHINE + 2 * index))
    }

    fn slot(&mut self, address: u16) -> u16 {
        let odd = address >= TRACE_ODD;
        self.received(odd);
        if (self.trace.number & 1 != 0) != odd {
            return 0;
        }
        let told = self.trace.newest;
        match address & 7 ^ TRACE_EVEN & 7 {
            0 => self.trace.number,
            1 => u16::from_le_bytes([told.kind, told.argument]),
            2 => told.pc,
            3 => told.value as u16,
            4 => {
                let high = (told.value >> 16) as u16;
                // Nothing follows an end, by which its reception could be told.
                if told.kind == TraceKind::End as u8 {
                    self.trace.full = false;
                }
                high
            }
            _ => 0,
        }
    }

    /// Whether nothing runs.
    ///
    /// # Errors
    /// Busy.
    pub fn idle(&self) -> Result<(), Exception> {
        if self.session.is_active() || self.motor.moving() != 0 {
            return Err(Exception::Busy);
        }
        Ok(())
    }

    fn status(&mut self, address: u16) -> u16 {
        match address {
            INPUTS => self.io.inputs.levels(),
            INPUTS_HIGH => status::probe_input(self) | u16::from(self.io.analog.on) << 1,
            MOVING => {
                let direction = !self.motor.negative & 0b111;
                u16::from_le_bytes([self.motor.moving(), direction])
            }
            HOMING => status::homing(self),
            MISC_STATUS => u16::from(self.motor.percents != [100; 2]) << 13,
            PROBING => status::probing(self),
            PROBE_ERROR => u16::from(self.command.probe_error),
            PLC_STATUS => status::plc_status(self),
            LIMITS => status::limit_switches(self),
            WORK_POSITIONS..ACTUAL_SPEEDS => {
                self.axis_value(address, WORK_POSITIONS, Controller::work_position)
            }
            PRINT_LENGTH => self.talk.print.count(),
            ACTUAL_SPEEDS..ACTUAL_SPEEDS_END => {
                self.axis_value(address, ACTUAL_SPEEDS, |controller, n| {
                    controller.motor.velocity(n)
                })
            }
            TARGETS..TARGETS_END => self.axis_value(address, TARGETS, |controller, n| {
                coords::target_steps(&controller.motor, Axis::new(n))
            }),
            TARGET_SPEEDS..TARGET_SPEEDS_END => {
                self.axis_value(address, TARGET_SPEEDS, |controller, n| {
                    controller.motor.wanted_velocity(n)
                })
            }
            ANALOGS..ANALOGS_USED => self.millivolts((address - ANALOGS) as u8),
            COMMAND_ROOM => status::command_room(self),
            CNC_STATE => status::cnc_state(self),
            CNC_ALARM if self.session.is(RunState::Fault) => {
                u16::from(Fault::alarm_of(self.session.fault))
            }
            PROBE_RESULT_TEXT..PROBE_RESULT => {
                self.axis_value(address, PROBE_RESULT_TEXT, |controller, n| {
                    controller.motor.probed[usize::from(n)]
                })
            }
            PROBE_RESULT..CNC_STATUS => self.axis_value(address, PROBE_RESULT, |controller, n| {
                controller.motor.probed[usize::from(n)]
            }),
            _ => 0,
        }
    }
}

impl<C: Chip> Machine for Controller<C> {
    fn is_active(&self) -> bool {
        self.session.is_active()
    }
    fn effect_pc(&self) -> u16 {
        self.place()
    }
    fn fault_pc(&self) -> u16 {
        self.vm.fault_pc
    }
    fn code(&self) -> u16 {
        self.vm.code
    }
    fn traces(&self) -> bool {
        self.trace.on
    }
    fn blocking(&self) -> u8 {
        Controller::blocking(self)
    }
    fn input_17(&self) -> u8 {
        u8::from(self.input(17))
    }
    fn is_fault(&self) -> bool {
        self.session.is(RunState::Fault)
    }
    fn is_paused(&self) -> bool {
        self.session.is(RunState::Paused)
    }
    fn jogs(&self) -> bool {
        self.command.jogs && self.motor.moving() != 0
    }
    fn is_idle(&self) -> bool {
        self.idle().is_ok()
    }
    fn door(&self) -> bool {
        self.first_on(&self.record.door) != 0
    }
    fn emergency(&self) -> bool {
        self.first_on(&self.record.emergency) != 0
    }
    fn effect(&self) -> u8 {
        self.program.effect.code
    }
    fn axis(&self) -> Axis {
        Axis::new(self.program.effect.n)
    }
    fn homing_failed(&self) -> u8 {
        self.command.homing_error
    }
    fn reference_closed(&self, axis: Axis) -> bool {
        self.input(self.record.reference[usize::from(axis.n())])
    }
    fn home_positive(&self, axis: Axis) -> bool {
        self.motor.axis(axis.n()).flags & AxisRecord::HOME_POSITIVE != 0
    }
}

impl<C: Chip> Map for Controller<C> {
    fn begin(&mut self) {
        self.lines.begin();
    }

    fn may_steer(&mut self, address: u16, value: Option<u16>) -> Result<(), Exception> {
        self.lines.take_helm(address, value)
    }

    fn read(&mut self, table: Table, address: u16) -> u16 {
        self.lines.reads(address);
        match address {
            OWN..PROFILE_WINDOW => self.own(address),
            PROFILE_WINDOW..LIBRARY if self.lock.closed => 0,
            PROFILE_WINDOW..LIBRARY => {
                let record = C::address_of(&self.record);
                self.chip.word(record + 2 * profile_word(address))
            }
            _ if table as u8 == Table::InputRegisters as u8 => self.status(address),
            OUTPUTS => self.io.outputs,
            AOUTS => self.io.aout.value,
            COMMAND..COMMAND_END => self.command.word(usize::from(address - COMMAND)),
            OVERRIDES | RAPID_OVERRIDE => {
                u16::from(self.motor.percents[usize::from(address - OVERRIDES)])
            }
            SPEEDS..OVERRIDES => {
                self.axis_value(address, SPEEDS, |controller, n| controller.motor.velocity(n))
            }
            KEEPS.. if address < KEEPS_END => {
                let value = self.kept((address - KEEPS) >> 1);
                self.lines.half(address, value)
            }
            POSITIONS..SPEEDS => self.axis_value(address, POSITIONS, Controller::work_position),
            LIBRARY..TRACE_QUEUE => self.listed(address - LIBRARY),
            TRACE_QUEUE..UPLOAD_WINDOW => self.trace.queue(&self.chip, address - TRACE_QUEUE),
            STREAM_MACHINE..STREAM_PIECE => self.machine_word(address - STREAM_MACHINE),
            CELLS..KEEPS => {
                let value = self.open_cell((address - CELLS) >> 1);
                self.lines.half(address, value)
            }
            _ => 0,
        }
    }

    fn between(&mut self) {
        // An axis on its own holds no more than two segments, 4 to 8 ms each.
        self.motor.poll(self.trace.full);
    }

    fn read_bit(&mut self, table: Table, address: u16) -> bool {
        let word = match table {
            Table::Coils => self.io.outputs,
            _ if address < STATUS_BITS => self.status(INPUTS + (address >> 4)),
            _ => self.status(MOVING + ((address - STATUS_BITS) >> 4)),
        };
        word >> (address & 15) & 1 != 0
    }

    fn may_write(&self, address: u16, value: u16) -> Result<(), Exception> {
        let good = match address {
            AOUTS => self.takes_aout(1, value.into()),
            OUTPUTS => value & !self.all_outputs() == 0,
            OVERRIDES => (10..=200).contains(&value),
            RAPID_OVERRIDE => (10..=100).contains(&value),
            CHAR_IN => (33..=125).contains(&value),
            UPLOAD_NUMBER => value <= C::PART.programs.into(),
            RUN_CONTROL => Control::from_number(value).is_some(),
            TRACE_MODE | TRACE_TAKEN | JOG_HOLD | MEASURE | SELECTED | UPLOAD_CONTROL
            | UPLOAD_LENGTH | STREAM_CONTROL | PRINT_TAIL => true,
            COMMAND..COMMAND_END | UPLOAD_NAME..UPLOAD_NAME_END | PROFILE_WINDOW.. => true,
            _ => return Err(Exception::IllegalAddress),
        };
        if good { Ok(()) } else { Err(Exception::IllegalValue) }
    }

    fn write(&mut self, address: u16, value: u16) -> Result<(), Exception> {
        match address {
            RUN_CONTROL => {
                let control = Control::from_number(value).ok_or(Exception::IllegalValue)?;
                match control {
                    Control::Restart => self.idle()?,
                    Control::Start if self.image().is_none() && !self.vm.is_piece => {
                        return Err(Exception::DeviceFailure);
                    }
                    _ => {}
                }
                self.control(control);
                Ok(())
            }
            TRACE_MODE => self.set_trace(value),
            TRACE_TAKEN => {
                if self.trace.take(value) {
                    Ok(())
                } else {
                    Err(Exception::IllegalValue)
                }
            }
            JOG_HOLD => {
                // What has been stopped does not go on, and nothing moves that a bound would end.
                if value == JOG_GOES_ON && self.command.hold == 0
                    || value != 0 && self.motor.moving() == 0
                {
                    return Err(Exception::Busy);
                }
                self.command.hold = if value == 0 { 0 } else { JOG_HOLD_MS };
                Ok(())
            }
            MEASURE => {
                self.idle()?;
                if self.chip.measure(value) { Ok(()) } else { Err(Exception::IllegalValue) }
            }
            SELECTED => self.select(value),
            UPLOAD_CONTROL => self.upload(value),
            UPLOAD_NUMBER => {
                self.incoming.number = value as u8;
                Ok(())
            }
            UPLOAD_NAME..UPLOAD_NAME_END => {
                self.incoming.name[usize::from(address - UPLOAD_NAME) & (NAME - 1)] = value;
                Ok(())
            }
            STREAM_CONTROL => {
                self.control_stream(value, self.idle().is_ok())?;
                self.lines.feed();
                Ok(())
            }
            STREAM_MACHINE..STREAM_PIECE => {
                self.idle()?;
                self.write_stream_machine(address - STREAM_MACHINE, value);
                Ok(())
            }
            STREAM_PIECE..UPLOAD_LARGE => {
                self.write_piece(address - STREAM_PIECE, value)?;
                self.lines.feed();
                Ok(())
            }
            UPLOAD_LENGTH => {
                self.incoming.length = value;
                Ok(())
            }
            PRINT_TAIL => {
                if self.talk.print.take(value) {
                    Ok(())
                } else {
                    Err(Exception::IllegalValue)
                }
            }
            CHAR_IN => {
                self.talk.char_in = value as u8;
                Ok(())
            }
            AOUTS => {
                self.set_aout(value);
                Ok(())
            }
            OUTPUTS => {
                self.motor.actions.take_over(0xFFFF);
                self.io.outputs = value;
                Ok(())
            }
            COMMAND..COMMAND_END => {
                if let Some(place) = self.command.words.get_mut(usize::from(address - COMMAND)) {
                    *place = value;
                }
                Ok(())
            }
            OVERRIDES | RAPID_OVERRIDE => {
                let mut percents = self.motor.percents;
                percents[usize::from(address - OVERRIDES)] = value as u8;
                self.motor.set_override(percents);
                Ok(())
            }
            PROFILE_WINDOW..LIBRARY => self.write_profile(profile_word(address), value),
            UPLOAD_LARGE.. => self.take_word(address - UPLOAD_LARGE, value),
            UPLOAD_WINDOW..STREAM_MACHINE => self.take_word(address - UPLOAD_WINDOW, value),
            _ => Err(Exception::IllegalAddress),
        }
    }

    fn may_write_long(&self, address: u16, value: i32) -> Result<(), Exception> {
        let runs = self.session.is_active();
        match address {
            CELLS..KEEPS => self.may_set_cell((address - CELLS) >> 1, value),
            KEEPS.. if !runs && self.motor.moving() != 0 => Err(Exception::Busy),
            KEEPS.. if (address - KEEPS) >> 1 >= self.keep_count() => Err(Exception::IllegalValue),
            POSITIONS..SPEEDS if (address - POSITIONS) >> 1 >= AXES.into() => {
                Err(Exception::IllegalValue)
            }
            POSITIONS..SPEEDS
                if runs || self.motor.moving() >> ((address - POSITIONS) >> 1) & 1 != 0 =>
            {
                Err(Exception::Busy)
            }
            _ => Ok(()),
        }
    }

    fn write_long(&mut self, address: u16, value: i32) -> Result<(), Exception> {
        match address {
            CELLS..KEEPS => {
                self.vm.set_cell((address - CELLS) >> 1, value);
                Ok(())
            }
            KEEPS.. if self.set_kept((address - KEEPS) >> 1, value) => Ok(()),
            KEEPS.. => Err(Exception::IllegalValue),
            _ => commands::position_is(self, Axis::new(((address - POSITIONS) >> 1) as u8), value),
        }
    }

    fn may_write_bit(&self, address: u16) -> Result<(), Exception> {
        let there = self.all_outputs() >> (address & 15) & 1 != 0;
        if there { Ok(()) } else { Err(Exception::IllegalAddress) }
    }

    fn write_bit(&mut self, address: u16, on: bool) {
        self.command_output(address + 1, on);
    }

    fn written(&mut self, address: u16) -> Result<(), Exception> {
        // The command's number starts it; its arguments may have come before.
        if address == COMMAND { self.execute() } else { Ok(()) }
    }
}
