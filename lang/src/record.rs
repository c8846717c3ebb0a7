//! The two records in which a profile reaches the device: the axes' part in every program image,
//! the board's part in the information memory.
//!
//! Both are little endian and laid out as the `repr(C)` structures below, which the device reads in
//! place. The host writes them with `encode` (feature `compiler`).

/// The `S` of full power unless a profile says otherwise; 0 is dark.
pub const FULL_POWER: i32 = 1000;

/// What M4 makes of the output of a PWM's laser: on, and its power follows the speed. Any other state than 0 is on.
pub const FOLLOWS: i32 = 2;

/// Version of both layouts.
pub const RECORD_VERSION: u16 = 2;

/// Image features: what a program uses, so that the device can lay out its RAM.
pub mod feature {
    /// G0 to G3: interpolated motion.
    pub const INTERPOLATE: u16 = 1 << 0;
    /// `START`, `MoveSpeed`: axes on their own.
    pub const START: u16 = 1 << 1;
    /// G2, G3.
    pub const ARC: u16 = 1 << 2;
    /// `ON IN`, `ON EVERY`.
    pub const EVENTS: u16 = 1 << 3;
    /// KEEP variables.
    pub const KEEP: u16 = 1 << 4;
    /// `ON ERROR`: the image holds a statement table (ERL, RESUME NEXT).
    pub const LINES: u16 = 1 << 5;
    /// Addresses of three bytes; only the host runs such images.
    pub const WIDE: u16 = 1 << 6;
    /// `S` on a machine with a laser or a PWM: its power, see [`FULL_POWER`](super::FULL_POWER).
    pub const POWER: u16 = 1 << 7;
    /// The firmware runs streamed pieces ([`wire`](crate::wire), Streaming); no image has it.
    pub const STREAM: u16 = 1 << 8;
    /// The firmware holds several programs ([`wire`](crate::wire), Library); no image's header has it: those with
    /// RUN want it ([`called::runs`](crate::called::runs)).
    pub const LIBRARY: u16 = 1 << 9;
    /// Lines run through their corners by slow points that the host has computed ([`course`](crate::image::course)); no
    /// image's header has it: those with [`MachineRecord::COURSES`](super::MachineRecord::COURSES) want it.
    pub const COURSE: u16 = 1 << 10;
    /// RESUME alone; no image's header has it: those with the instruction want it.
    pub const RETRY: u16 = 1 << 11;
    /// SIN, COS, ATAN2, SCALE; no image's header has it: those with the instructions want it.
    pub const MATHS: u16 = 1 << 12;
    /// Analog inputs; no image's header has it: AIN needs a
    /// profile with analog inputs, and that wants it.
    pub const ANALOG: u16 = 1 << 13;
    /// SYNC: outputs that act on the way of a path; no image's header has it: those with the instruction want it.
    pub const ACTIONS: u16 = 1 << 14;
    /// SetAout; no image's header has it: those with the instruction want it, and a profile with an analog output.
    pub const AOUT: u16 = 1 << 15;
}

/// One axis in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct AxisRecord {
    /// [`AxisRecord::PRESENT`] and others.
    pub flags: u16,
    /// `steps` motor steps move the axis by `um`.
    pub steps: u16,
    /// See `steps`.
    pub um: u16,
    /// Start and stop rate, steps/s.
    pub start_rate: u16,
    /// Homing rate toward the switch, steps/s.
    pub home_fast: u16,
    /// Homing rate off the switch, steps/s.
    pub home_slow: u16,
    /// Rest between the two, ms.
    pub home_pause: u16,
    /// Top rate, steps/s.
    pub top_rate: u32,
    /// Ramp up, steps/s2.
    pub accel: u32,
    /// Ramp down, steps/s2.
    pub decel: u32,
    /// Lowest machine position, um.
    pub min: i32,
    /// Highest machine position, um.
    pub max: i32,
    /// How far to look for the switch, um.
    pub home_stroke: i32,
    /// Machine position where the switch opens, um.
    pub home_position: i32,
    /// Clearance move, um, away from the switch when positive.
    pub home_clearance: i32,
}

impl AxisRecord {
    /// [`AxisRecord::flags`]: the machine has the axis.
    pub const PRESENT: u16 = 1 << 0;
    /// [`AxisRecord::flags`]: DIR is low for the positive direction.
    pub const INVERT: u16 = 1 << 1;
    /// [`AxisRecord::flags`]: the reference switch is at the positive end.
    pub const HOME_POSITIVE: u16 = 1 << 2;
    /// Bytes of a record.
    pub const SIZE: usize = 46;
    /// What holds on a board without a program, where a command's own parameters decide: positions
    /// are steps, nothing bounds the travel.
    pub const FREE: AxisRecord = AxisRecord {
        flags: AxisRecord::PRESENT,
        steps: 1,
        um: 1,
        start_rate: 400,
        home_fast: 1,
        home_slow: 1,
        home_pause: 0,
        top_rate: 100_000,
        accel: 10_000_000,
        decel: 10_000_000,
        min: i32::MIN,
        max: i32::MAX,
        home_stroke: 0,
        home_position: 0,
        home_clearance: 0,
    };
}

/// The axes' part of a profile, in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct MachineRecord {
    /// [`MachineRecord::REQUIRE_HOMING`] and others.
    pub flags: u8,
    /// Tells the program's KEEP declarations from other programs': 0 without any and in a profile, never
    /// 255.
    pub keeps: u8,
    /// Junction deviation, um.
    pub corner: u16,
    /// Feed of a G1 that no F reaches, um/s; 0 for none.
    pub default_feed: u32,
    /// X, Y, Z.
    pub axes: [AxisRecord; 3],
}

impl MachineRecord {
    /// [`MachineRecord::flags`]: an absolute move of an unhomed axis is F07.
    pub const REQUIRE_HOMING: u8 = 1 << 0;
    /// [`MachineRecord::flags`]: G0 lifts Z first and lowers it last.
    pub const RAPID_Z_APART: u8 = 1 << 1;
    /// [`MachineRecord::flags`], of a program and of no profile: its image has limits of AT variables
    /// ([`crate::image::limits`]).
    pub const AT_LIMITS: u8 = 1 << 2;
    /// [`MachineRecord::flags`], of a program and of no profile: it has courses, whose memory is the end of its pool
    /// ([`crate::image::course`]).
    pub const COURSES: u8 = 1 << 3;
    /// Bytes of the record.
    pub const SIZE: usize = 8 + 3 * AxisRecord::SIZE;

    /// Highest rate, steps/s, at which an axis may turn round by a record's bytes: its start rate, or what the corner
    /// allows with its ramps.
    pub fn turning_rate(bytes: &[u8]) -> u32 {
        let word = |at: usize| {
            let two = bytes.get(at..).and_then(|rest| rest.first_chunk::<2>());
            two.map_or(0, |two| u16::from_le_bytes(*two))
        };
        let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 2)) << 16;
        let corner = u64::from(word(2));
        let rate = |axis: usize| {
            // Seven words, then top rate and ramps, as [`AxisRecord`] has them.
            let at = 8 + axis * AxisRecord::SIZE;
            if word(at) & AxisRecord::PRESENT == 0 {
                return 0;
            }
            let (steps, um) = (word(at + 2), word(at + 4).max(1));
            let ramp = long(at + 18).max(long(at + 22));
            // Junction deviation: v^2 is at most twice ramp times corner, in steps.
            let round = (2 * ramp * corner * u64::from(steps) / u64::from(um)).isqrt();
            u64::from(word(at + 6)).max(round).min(long(at + 14)) as u32
        };
        (0..3).map(rate).max().unwrap_or(0)
    }
}

/// Output masks for one occasion, bit n-1 for output n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct OutputStates {
    /// These keep their state; the others take that of `on`.
    pub keep: u16,
    /// These go on.
    pub on: u16,
}

/// The board's part of a profile: 64 bytes of information memory, 32 registers of the link, and on some parts more.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct BoardRecord {
    /// One more at each change, modulo 65536: of two valid copies the later one holds.
    pub sequence: u16,
    /// [`RECORD_VERSION`]
    pub version: u16,
    /// [`BoardRecord::CHAIN`] and others.
    pub flags: u16,
    /// Modbus address, 1..=247.
    pub address: u8,
    /// Rate in the low nibble (0: 9600, 1: 19200, 2: 57600, 3: 115200), parity in the high one (0
    /// none, 1 even, 2 odd).
    pub rate: u8,
    /// STEP pulse width, us.
    pub pulse: u8,
    /// DIR set-up time, us.
    pub setup: u8,
    /// Filter time of inputs, ms: the longest that the profile names.
    pub filter: u8,
    /// Input number of the probe.
    pub probe: u8,
    /// Inputs that are on when open: bit n-1 for input n.
    pub input_invert: u16,
    /// Bit 0 for input 17.
    pub input_invert_high: u16,
    /// Input numbers of the reference switches X, Y, Z.
    pub reference: [u8; 3],
    /// Input numbers of Stop buttons, 0 for none. This and what follows up to `end_of_stops` keeps the
    /// machine from working while it is on.
    pub stop: [u8; 2],
    /// Input numbers of feed hold.
    pub hold: [u8; 2],
    /// Input numbers of doors.
    pub door: [u8; 2],
    /// Input numbers of emergency stops.
    pub emergency: [u8; 4],
    /// [`BoardRecord::END_OF_STOPS`]
    pub end_of_stops: u8,
    /// Input number of a second Start, 0 for none.
    pub start: u8,
    /// Inputs that choose the program: the first in bits 0..4, how many in the upper three, 1 to 6; 0 for none.
    /// [`BoardRecord::NEXT`]: the one input is a button for the next program.
    pub select: u8,
    /// Outputs that are on after reset.
    pub reset_on: u16,
    /// Outputs whose on is a low level.
    pub output_invert: u16,
    /// In a pause.
    pub pause: OutputStates,
    /// At a fault that ends the run.
    pub fault: OutputStates,
    /// At any other end.
    pub end: OutputStates,
    /// Output number with role laser, 0 for none.
    pub laser: u8,
    /// Output number with role lamp, 0 for none.
    pub lamp: u8,
    /// Output number with role enable, 0 for none.
    pub enable: u8,
    /// Output number with role spindle, 0 for none.
    pub spindle: u8,
    /// Spin-up time after a pause, ms.
    pub spin_up: u16,
    /// Lock code of program and profile ([`wire`](crate::wire), Lock), low word first; a low word of 0
    /// is none.
    pub lock: [u16; 2],
    /// Pins of port 1 that carry emergency stops, as a mask.
    pub emergency_pin: u8,
    /// Those of them where the stop is pressed when the pin goes low.
    pub emergency_falls: u8,
    /// CRC of `more`, 0 where that is nothing.
    pub more_crc: u16,
    /// CRC of the 62 bytes before.
    pub crc: u16,
    /// What boards with room for it hold behind the record; see [`BoardRecord::more`].
    pub more: MoreRecord,
}

/// What a profile says of PWM, RS-485 line, analog inputs and analog output, which only some parts have: 38 bytes behind the
/// record, 19 registers of the link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct MoreRecord {
    /// Frequency of the PWM, Hz, 0 for none.
    pub pwm_hz: u16,
    /// S of its full power, at most 32767.
    pub pwm_range: u16,
    /// On at the least S above 0, thousandths of the period.
    pub pwm_minimum: u16,
    /// A servo's pulse at S0, us.
    pub servo_low: u16,
    /// A servo's pulse at full S, us.
    pub servo_high: u16,
    /// Number of the output that switches it.
    pub pwm_output: u8,
    /// [`MoreRecord::LASER`] and others.
    pub pwm_kind: u8,
    /// Modbus address on the RS-485 line, 0 without one.
    pub rs485_address: u8,
    /// Its rate and parity, as [`BoardRecord::rate`].
    pub rs485_rate: u8,
    /// Inputs that analog ones make, from 18 on; and what is known of the analog inputs.
    pub thresholds: [ThresholdRecord; 4],
    /// Frequency of the analog output, Hz; that of the PWM where there is one.
    pub aout_hz: u16,
    /// Bits 0..14: value at which its pin is high all the time, mV or steps of a share, 0 where there is no output. Bit 15:
    /// [`MoreRecord::SHARE`].
    pub aout_full: u16,
    /// Bits 0..14: its value after a reset, at a fault and at the end of a run. Bit 15: [`MoreRecord::PAUSES`].
    pub aout_safe: u16,
    /// CRC of the 36 bytes before.
    pub crc: u16,
}

/// Two levels of an analog input, and beside them what is known of the analog input of this number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct ThresholdRecord {
    /// Bits 0..11: the input goes on at this voltage, mV. Bits 12..14: number of the analog input, 0 where there is no
    /// threshold. Bit 15 says nothing.
    pub on: u16,
    /// Bits 0..11: it goes off at this voltage, mV. Bit 15: the analog input of this place is used; bits 12..14 its filter:
    /// 2 to this power in ms.
    pub off: u16,
}

impl ThresholdRecord {
    /// Of a word: the voltage.
    pub const LEVEL: u16 = 0xFFF;
    /// Shift of what stands above the voltage.
    pub const ABOVE: u16 = 12;
    /// The three bits above the voltage.
    pub const SMALL: u16 = 7;
    /// [`ThresholdRecord::off`]: the analog input is used.
    pub const USED: u16 = 1 << 15;
    /// [`ThresholdRecord::on`]: set where the record's CRC would else be 0.
    #[cfg(feature = "compiler")]
    pub const SPARE: u16 = 1 << 15;

    /// Number of the analog input that the threshold looks at, from 1; 0 where there is no threshold.
    pub const fn analog(self) -> u16 {
        self.on >> ThresholdRecord::ABOVE & ThresholdRecord::SMALL
    }

    /// Filter of the analog input of this place: 2 to this power in ms.
    pub const fn filter(self) -> u16 {
        self.off >> ThresholdRecord::ABOVE & ThresholdRecord::SMALL
    }
}

impl MoreRecord {
    /// [`MoreRecord::pwm_kind`]: dark at rest.
    pub const LASER: u8 = 0;
    /// [`MoreRecord::pwm_kind`]: as S says.
    pub const SPINDLE: u8 = 1;
    /// [`MoreRecord::pwm_kind`]: pulses of an RC servo.
    pub const SERVO: u8 = 2;
    /// [`MoreRecord::aout_full`]: values are steps of a share, not mV.
    pub const SHARE: u16 = 1 << 15;
    /// [`MoreRecord::aout_safe`]: in a pause the output has the same value.
    pub const PAUSES: u16 = 1 << 15;
    /// The value in these two.
    pub const VALUE: u16 = 0x7FFF;
    /// Bytes of the record.
    pub const SIZE: usize = 38;
    /// Nothing.
    pub const NONE: MoreRecord = MoreRecord {
        pwm_hz: 0,
        pwm_range: 0,
        pwm_minimum: 0,
        servo_low: 0,
        servo_high: 0,
        pwm_output: 0,
        pwm_kind: 0,
        rs485_address: 0,
        rs485_rate: 0,
        thresholds: [ThresholdRecord { on: 0, off: 0 }; 4],
        aout_hz: 0,
        aout_full: 0,
        aout_safe: 0,
        crc: 0,
    };
}

impl BoardRecord {
    /// [`BoardRecord::select`]: the upper three bits of a button for the next program.
    pub const NEXT: u8 = 7;
    /// [`BoardRecord::flags`]: chain wiring, otherwise direct.
    pub const CHAIN: u16 = 1 << 0;
    /// [`BoardRecord::flags`]: run the stored program at power-up.
    pub const AUTORUN: u16 = 1 << 1;
    /// [`BoardRecord::flags`]: STEP is active when low.
    pub const STEP_LOW: u16 = 1 << 2;
    /// [`BoardRecord::flags`]: nobody has said yet how the board is wired, so it drives no output and reads no input of the
    /// machine. Of [`BoardRecord::UNKNOWN`] and of no profile.
    pub const UNWIRED: u16 = 1 << 3;
    /// [`BoardRecord::end_of_stops`]: no number of an input, bit 7 set.
    pub const END_OF_STOPS: u8 = 0xFF;
    /// Bytes of the record, without `more`.
    pub const SIZE: usize = 64;

    /// What a board that was never given a profile assumes: that of the built-in `mill`.
    pub const DEFAULT: BoardRecord = BoardRecord {
        sequence: 0,
        version: RECORD_VERSION,
        flags: BoardRecord::CHAIN,
        address: 1,
        rate: 3,
        pulse: 3,
        setup: 2,
        filter: 5,
        probe: 17,
        input_invert: 0,
        input_invert_high: 0,
        reference: [9, 10, 11],
        stop: [0; 2],
        hold: [0; 2],
        door: [0; 2],
        emergency: [0; 4],
        end_of_stops: BoardRecord::END_OF_STOPS,
        start: 0,
        select: 0,
        reset_on: 0,
        output_invert: 0,
        pause: OutputStates { keep: 0xFFFF, on: 0 },
        fault: OutputStates { keep: 0, on: 0 },
        end: OutputStates { keep: 0, on: 0 },
        laser: 0,
        lamp: 0,
        enable: 0,
        spindle: 1,
        spin_up: 0,
        lock: [0; 2],
        emergency_pin: 0,
        emergency_falls: 0,
        more_crc: 0,
        crc: 0,
        more: MoreRecord::NONE,
    };

    /// The same where the board also waits to be told its wiring: what is the latch of one wiring is an output of the other.
    pub const UNKNOWN: BoardRecord = BoardRecord {
        flags: BoardRecord::CHAIN | BoardRecord::UNWIRED,
        reference: [0; 3],
        probe: 0,
        ..BoardRecord::DEFAULT
    };

    /// What the board knows besides, as far as the record says that it is there.
    pub fn more(&self) -> &MoreRecord {
        if self.more_crc == 0 { &MoreRecord::NONE } else { &self.more }
    }

    /// The pin of port 1 that carries input `n`, as a mask; 0 for one in the chain and for none.
    pub const fn pin(&self, n: u8) -> u8 {
        match (self.flags & BoardRecord::CHAIN != 0, n) {
            (false, 1..=4) => 1 << (n + 3),
            (true, 17) => 1 << 4,
            _ => 0,
        }
    }

    /// Pins of port 1 whose inputs go on when they go low.
    pub const fn falling(&self) -> u8 {
        if self.flags & BoardRecord::CHAIN == 0 {
            !(self.input_invert << 4) as u8 & 0xF0
        } else {
            (!self.input_invert_high << 4) as u8 & 1 << 4
        }
    }
}

#[cfg(feature = "compiler")]
mod axes;
#[cfg(feature = "compiler")]
mod decode;
#[cfg(feature = "compiler")]
mod encode;
