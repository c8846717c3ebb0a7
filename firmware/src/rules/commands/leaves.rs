//! What commands need of a chip.

use crate::rules::probe::Probes;
use crate::rules::{Answer, Axis};
use lang::fault::Fault;

/// What commands look at and do.
pub trait Commands: Probes {
    /// The command.
    #[cfg_attr(any(), micro(place = "COMMAND_HEAD"))]
    fn command(&self) -> u16;
    /// Its first argument, most often the axis from 1.
    #[cfg_attr(any(), micro(place = "COMMAND_HEAD+2"))]
    fn argument(&self) -> u16;
    /// The next long; the first one stands behind the axis.
    #[cfg_attr(any(), micro(code = "DO command_long"))]
    fn next(&mut self) -> i32;
    /// The next one, a float, in thousandths.
    #[cfg_attr(any(), micro(code = "DO command_float"))]
    fn next_thousandths(&mut self) -> i32;
    /// An input keeps the level that the second argument says.
    ///
    /// # Errors
    /// Its role stops the machine, or there is no such level.
    #[cfg_attr(any(), micro(code = "CALL force_input"))]
    fn force(&mut self, n: u8) -> Answer;
    /// As a control code says.
    #[cfg_attr(any(), micro(code = "DO control"))]
    fn control(&mut self, code: u8);
    /// A run was begun and has not ended.
    #[cfg_attr(any(), micro(any = "RUN, RUN_ACTIVE"))]
    fn is_active(&self) -> bool;
    /// A program is stored.
    #[cfg_attr(any(), micro(code = "F word VM_CODE", holds = "NOT_EQUAL"))]
    fn has_program(&self) -> bool;
    /// The first input that keeps a move from working, from 1, or 0.
    #[cfg_attr(any(), micro(code = "DO blocking"))]
    fn blocking(&self) -> u8;
    /// What moves for as long as the host speaks does.
    #[cfg_attr(any(), micro(any = "MOTION, M_JOG"))]
    fn is_held(&self) -> bool;
    /// What moves does so for as long as it speaks.
    #[cfg_attr(any(), micro(code = "BITS_ON MOTION, M_JOG"))]
    fn set_held(&mut self);

    /// Code of the effect under way, 0 for none.
    #[cfg_attr(any(), micro(place = "EFFECT"))]
    fn effect(&self) -> u8;
    /// An effect by command begins: its axis is the effect's number.
    #[cfg_attr(any(), micro(place = "EFFECT"))]
    fn set_effect(&mut self, code: u8);
    /// Its first phase: none was under way.
    #[cfg_attr(any(), micro(code = "UP PHASE"))]
    fn first_phase(&mut self);
    /// No effect is under way any more.
    #[cfg_attr(any(), micro(code = "F clear EFFECT"))]
    fn forget(&mut self);
    /// Homing the axis by command failed.
    #[cfg_attr(any(), micro(on = "HOMING_ERROR"))]
    fn set_homing_failed(&mut self, axis: Axis);
    /// It has not.
    #[cfg_attr(any(), micro(off = "HOMING_ERROR"))]
    fn set_homing(&mut self, axis: Axis);
    /// So did probing.
    #[cfg_attr(any(), micro(on = "PROBE_ERROR"))]
    fn set_probe_failed(&mut self, axis: Axis);
    /// It has not.
    #[cfg_attr(any(), micro(off = "PROBE_ERROR"))]
    fn set_probing(&mut self, axis: Axis);

    /// The machine has the axis.
    #[cfg_attr(any(), micro(code = "DO axis_there", holds = "NOT_EQUAL"))]
    fn is_there(&self, axis: Axis) -> bool;
    /// It has homed.
    #[cfg_attr(any(), micro(has = "HOMED"))]
    fn is_homed(&self, axis: Axis) -> bool;
    /// It moves.
    #[cfg_attr(any(), micro(has = "MOVING"))]
    fn is_moving(&self, axis: Axis) -> bool;
    /// Axes that move.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn moving(&self) -> u8;
    /// Those that keep the command from beginning: all, or fewer where an axis may be sent elsewhere.
    #[cfg_attr(any(), micro(place = "MOVING"))]
    fn in_the_way(&self) -> u8;
    /// Axes that the command stops, bit per axis.
    #[cfg_attr(any(), micro(place = "TEMP"))]
    fn set_axes(&mut self, axes: u8);
    /// The axis is one of them.
    #[cfg_attr(any(), micro(has = "TEMP"))]
    fn is_meant(&self, axis: Axis) -> bool;
    /// The axis brakes.
    #[cfg_attr(any(), micro(code = "DO motion_stop"))]
    fn brake(&mut self, axis: Axis);
    /// So does everything.
    #[cfg_attr(any(), micro(code = "DO motion_stop"))]
    fn brake_all(&mut self);
    /// The work offset of the axis, um.
    #[cfg_attr(any(), micro(place = "OFFSET"))]
    fn set_offset(&mut self, axis: Axis, um: i32);

    /// Where a distance begins, steps.
    #[cfg_attr(any(), micro(place = "SPARE"))]
    fn start(&self) -> i32;
    /// See [`Commands::start`].
    #[cfg_attr(any(), micro(place = "SPARE"))]
    fn set_start(&mut self, steps: i32);
    /// The new place of the axis.
    ///
    /// # Errors
    /// See [`aim_place`](crate::rules::coords::aim_place).
    #[cfg_attr(any(), micro(code = "LET FRAME_OF, F_STEPS|F_RELATIVE; CALL aim_place"))]
    fn aim_steps(&mut self, axis: Axis, steps: i32) -> Result<(), Fault>;
    /// It is commanded: the axis sets off to it at the pace.
    #[cfg_attr(any(), micro(code = "DO command; DO begin_axis"))]
    fn go(&mut self, axis: Axis);
    /// So are those of the axes of the flags, in a line.
    #[cfg_attr(any(), micro(code = "DO command_axes; GET RAMPS; DO line_begin"))]
    fn go_in_line(&mut self);

    /// Command 1111: its first argument.
    #[cfg_attr(any(), micro(place = "FLAGS"))]
    fn set_flags(&mut self, flags: u8);
    /// It names the axis.
    #[cfg_attr(any(), micro(has = "FLAGS"))]
    fn is_named(&self, axis: Axis) -> bool;
    /// Places count from where the axes are.
    #[cfg_attr(any(), micro(any = "FLAGS, JOG_RELATIVE"))]
    fn counts_from_here(&self) -> bool;
    /// Its speed, um/s.
    #[cfg_attr(any(), micro(place = "FEED"))]
    fn set_feed(&mut self, feed: i32);

    /// Command 102: its ramp.
    #[cfg_attr(any(), micro(place = "COMMAND+4"))]
    fn ramp(&self) -> i32;
    /// It is the one down, too.
    #[cfg_attr(any(), micro(place = "COMMAND+12"))]
    fn set_ramp_down(&mut self, ramp: i32);
    /// Its speed with a sign.
    #[cfg_attr(any(), micro(place = "COMMAND+8"))]
    fn speed(&self) -> i32;
    /// See [`Commands::speed`].
    #[cfg_attr(any(), micro(place = "COMMAND+8"))]
    fn set_speed(&mut self, speed: i32);
    /// Steps that take hours.
    #[cfg_attr(any(), micro(code = "LIT16 0x2000; F put SPARE_TOO+2"))]
    fn set_far(&mut self);
    /// The same in the other direction.
    #[cfg_attr(any(), micro(place = "SPARE_TOO"))]
    fn set_far_to(&mut self, steps: i32);
    /// These steps.
    #[cfg_attr(any(), micro(place = "SPARE_TOO"))]
    fn far(&self) -> i32;
    /// Where the axis's travel begins, um.
    #[cfg_attr(any(), micro(record = "A_MIN"))]
    fn travel_begin(&self, axis: Axis) -> i32;
    /// Where it ends.
    #[cfg_attr(any(), micro(record = "A_MAX"))]
    fn travel_end(&self, axis: Axis) -> i32;
    /// A place of it in steps.
    #[cfg_attr(any(), micro(code = "DO to_steps"))]
    fn travel_steps(&self, axis: Axis, um: i32) -> i32;
    /// How far the axis is to run, steps.
    #[cfg_attr(any(), micro(place = "STEPS"))]
    fn set_target(&mut self, axis: Axis, steps: i32);
    /// It sets off.
    #[cfg_attr(any(), micro(code = "DO begin_axis"))]
    fn run(&mut self, axis: Axis);

    /// Command 105: the work position, steps.
    #[cfg_attr(any(), micro(place = "COMMAND+4"))]
    fn work_position(&self) -> i32;

    /// Command 106: nothing but 0.
    #[cfg_attr(any(), micro(place = "COMMAND+4"))]
    fn nothing(&self) -> u16;
    /// The switch's input from 0.
    #[cfg_attr(any(), micro(place = "COMMAND+6"))]
    fn switch(&self) -> u16;
    /// See [`Commands::switch`].
    #[cfg_attr(any(), micro(code = "ADDI HOME_COMMAND+1; PUT BITS"))]
    fn set_switch(&mut self, input: u16);
    /// Its level when closed.
    #[cfg_attr(any(), micro(place = "COMMAND+8"))]
    fn closed_level(&self) -> u16;
    /// That is 0.
    #[cfg_attr(any(), micro(code = "BITS_ON BITS, HOME_INVERT"))]
    fn set_inverted(&mut self);
    /// 1: it is at the positive end.
    #[cfg_attr(any(), micro(place = "COMMAND+10"))]
    fn home_side(&self) -> u16;
    /// The end at which it is.
    #[cfg_attr(any(), micro(code = "F put HOME_RECORD+A_FLAGS"))]
    fn set_way(&mut self, flags: u8);
    /// One of its four speeds and ramps.
    #[cfg_attr(any(), micro(place = "HOME_SPEED"))]
    fn home_rate(&self, which: Axis) -> i32;
    /// The run's numbers are steps, and the command's.
    #[cfg_attr(
        any(),
        micro(
            code = "LIT 1; F put HOME_RECORD+A_STEPS; F put HOME_RECORD+A_UM; F word HOME_SLOW_SPEED; F put HOME_RECORD+A_HOME_SLOW; F word HOME_WAIT; F put HOME_RECORD+A_HOME_PAUSE"
        )
    )]
    fn take_plan(&mut self, axis: Axis);
    /// How far to look for the switch.
    #[cfg_attr(any(), micro(place = "HOME_STROKE"))]
    fn home_stroke(&self) -> i32;
    /// See [`Commands::home_stroke`].
    #[cfg_attr(any(), micro(place = "HOME_RECORD+A_HOME_STROKE"))]
    fn set_stroke(&mut self, steps: i32);
    /// The clearance with its sign.
    #[cfg_attr(any(), micro(place = "HOME_CLEARANCE"))]
    fn home_clearance(&self) -> i32;
    /// The same away from the switch.
    #[cfg_attr(any(), micro(place = "HOME_CLEARANCE"))]
    fn set_clearance(&mut self, steps: i32);
    /// Plans the reference run of an axis by the profile.
    ///
    /// # Errors
    /// F01; on the small chip none.
    #[cfg_attr(any(), micro(code = "DO home_by_profile", sure = 1))]
    fn plan(&mut self, n: u8) -> Result<(), Fault>;

    /// Command 107: the input from 0.
    #[cfg_attr(any(), micro(place = "COMMAND+4"))]
    fn probe_input(&self) -> u16;
    /// Its level.
    #[cfg_attr(any(), micro(place = "COMMAND+6"))]
    fn probe_level(&self) -> u16;
    /// Command 108: the inputs that count.
    #[cfg_attr(any(), micro(place = "COMMAND+4"))]
    fn and(&self) -> i32;
    /// Those that must be off.
    #[cfg_attr(any(), micro(place = "COMMAND+8"))]
    fn xor(&self) -> i32;
}
