//! The firmware's routines as micro-code sees them.
//!
//! A row is `name takes gives "flags"` of the accumulator and then what is out of the ordinary: a routine that says
//! nothing keeps both pointers and, when it is instructions, every temporary byte. [`crate::verify`] holds those that
//! are micro-code to their rows, a test those that are instructions.

use super::Gives::{self, Kept, Long, Lost, Low, Only};
use super::Operand::{Number, Pairs};
use super::Takes::{self, Nothing};
use super::{Routine, Scratch};

const LOW: Takes = Takes::Low;
const LONG: Takes = Takes::Long;

const fn row(name: &'static str, takes: Takes, gives: Gives, flags: &'static str) -> Routine {
    Routine::new(name, takes, gives, flags)
}

/// What a motion that begins takes for its planner.
const PLANNER: Scratch = Scratch::ALL;

/// Those with a number, in the order of the numbers. A pad byte that execution comes over is number 0.
pub const ROUTINES: &[Routine] = &[
    row("micro_nothing", Nothing, Kept, "").means("nothing"),
    row("micro_event", LONG, Low, "")
        .with(&[Number])
        .means("event of this kind, argument N, value acc: r12 = DONE"),
    row("micro_event_ok", LONG, Low, "").with(&[Number]).means("the same with TRACE_OK"),
    row("scaled_most", Nothing, Long, "").means("above every scaled number"),
    row("zero", Nothing, Long, "").at("scaled_zero").means("0"),
    row("new", LONG, Long, "").at("pasapas_scaled_new").means("an integer as a scaled number"),
    row("root", LONG, Long, "").at("pasapas_scaled_root").means("scaled root"),
    row("floor", LONG, Long, "").at("pasapas_scaled_floor").means("a scaled number as an integer"),
    row("abs", LONG, Long, "").at("pasapas_abs").means("without its sign"),
    row("negate", LONG, Long, "N").at("pasapas_neg").means("with the other sign"),
    row("axis_n", Nothing, Low, "").sets("ar").means("the axis N"),
    row("axis_select", LOW, Kept, "").sets("ar").means("the axis r12"),
    row("axis_at", Nothing, Kept, "").needs("a").sets("r").means("the record of axis r8"),
    row("axis_bit", Nothing, Low, "").needs("a").means("bit of axis r8"),
    row("axis_there", Nothing, Kept, "Z").needs("ar").means("Z when the machine lacks the axis"),
    row("here", Nothing, Long, "N").needs("a").means("where the axis stands, steps"),
    row("to_steps", LONG, Long, "C").needs("r").means("um as steps; C when they do not fit"),
    row("to_um", LONG, Long, "C").needs("r").means("steps as um; C when they do not fit"),
    row("aim", LONG, Only, "")
        .needs("ar")
        .reads(Scratch::FRAME_OF)
        .loses("r")
        .means("a target is looked at: r12 = 0 or a fault"),
    row("command", Nothing, Long, "Z")
        .needs("a")
        .means("the target is commanded; Z when the axis stands there"),
    row("settle_here", Nothing, Long, "")
        .needs("ar")
        .means("the commanded place is where the axis stands"),
    row("offset_steps", Nothing, Long, "").needs("ar").means("work offset in steps"),
    row("pop_value", Nothing, Long, "").means("the top of the stack, taken"),
    row("pop_level", Nothing, Long, "")
        .leaves(Scratch::UNIT)
        .means("UNIT = whether the top, taken, is not 0"),
    row("pop_number", Nothing, Long, "")
        .with(&[Number, Number])
        .ends_caller()
        .means("the top, taken; F20 unless within"),
    row("time_up", Nothing, Kept, "").ends_caller().means("NOT_YET while time is left"),
    row("pop_time", Nothing, Long, "")
        .ends_caller()
        .means("TIME = the top, taken; F20 when it is negative"),
    row("wait_begin", Nothing, Lost, "")
        .ends_caller()
        .means("flags of a wait into BITS, its timeout into TIME"),
    row("fx_output", LOW, Only, "")
        .reads(Scratch::UNIT)
        .means("output r12 takes the level in UNIT: DONE or F20"),
    row("operand_byte", Nothing, Low, "").means("the statement's next operand byte"),
    row("rate", LOW, Long, "Z").needs("r").means("a rate from the stack, as bits of r12 say"),
    row("speed_least", LONG, Long, "Z")
        .reads(Scratch::SPEED)
        .leaves(Scratch::SPEED)
        .means("bounds the pace's speed"),
    row("begin_axis", Nothing, Only, "")
        .needs("a")
        .loses("ar")
        .reads(Scratch::TEMP)
        .means("the axis sets off at the pace in TEMP: NOT_YET"),
    row("line_rapid", LOW, Lost, "")
        .loses("ar")
        .writes(PLANNER)
        .finds(Scratch::TEMP.and(Scratch::SPARE))
        .means("a rapid line of these axes begins"),
    row("poke", Nothing, Kept, "").with(&[Pairs]).means("writes bytes to peripherals"),
    row("output", LOW, Only, "Z").means("level of output r12"),
    row("fail", LOW, Lost, "").means("a fault that ends the run"),
    row("blocking", Nothing, Only, "Z")
        .means("the input that keeps the machine from working, 0 for none"),
    row("unfiltered", LOW, Only, "Z").means("level of input r12 before the filter"),
    row("run_start", Nothing, Lost, "")
        .loses("ar")
        .writes(Scratch::ALL)
        .means("as the Start button"),
    row("output_states", LOW, Lost, "").means("outputs take the states of an occasion"),
    row("output_unit", LOW, Lost, "Z")
        .reads(Scratch::UNIT)
        .means("output r12 takes the level in UNIT; Z when it does not exist"),
    row("motion_rests", Nothing, Kept, "Z").means("Z when no step comes any more"),
    row("motion_stop", Nothing, Kept, "").means("ramps down and forgets the rest"),
    row("motion_halt", Nothing, Lost, "").loses("ar").writes(PLANNER).means("steps cease at once"),
    row("ticks_a_second", Nothing, Long, "").means("16 MHz, scaled"),
    row("short_flags", LOW, Low, "").means("flags of a short form"),
    row("axis_flags", LOW, Long, "")
        .sets("ar")
        .leaves(Scratch::FLAGS.and(Scratch::TEMP))
        .means("FLAGS, the axis that they name, and its pace in TEMP"),
    row("speed_flags", Nothing, Long, "Z")
        .needs("r")
        .reads(Scratch::FLAGS.and(Scratch::SPEED))
        .leaves(Scratch::SPEED)
        .means("a speed for the pace, as FLAGS say"),
    row("rate_of", LONG, Long, "Z")
        .needs("r")
        .reads(Scratch::UNIT)
        .means("a rate in the unit of UNIT as scaled steps"),
    row("axis_pace", Nothing, Long, "")
        .needs("r")
        .leaves(Scratch::TEMP)
        .means("TEMP = the axis's own pace"),
    row("not_negative", LONG, Long, "").means("0 for what is negative"),
    row("home_closed", Nothing, Only, "Z").means("Z clear when the switch is closed"),
    row("home_by_profile", LOW, Low, "").means("plans the reference run of the axis r12"),
    row("motion_hit", LONG, Lost, "")
        .needs("a")
        .loses("ar")
        .writes(PLANNER)
        .planner(Scratch::SPARE_TOO)
        .means("the axis that was at acc stops"),
    row("probe_input", LOW, Lost, "")
        .reads(Scratch::UNIT.and(Scratch::FLAGS))
        .means("waits for input r12"),
    row("probe_xor", LONG, Kept, "").means("inputs that must be off"),
    row("probe_and", LONG, Lost, "").reads(Scratch::FLAGS).means("inputs that count"),
    row("probe_begin", Nothing, Lost, "Z")
        .needs("a")
        .loses("ar")
        .writes(PLANNER)
        .reads(Scratch::TEMP.and(Scratch::FLAGS))
        .means("the probe sets off; Z clear when the inputs answer already"),
    row("probe_answers", Nothing, Lost, "Z").means("Z clear when the inputs answer"),
    row("home_missed", Nothing, Only, "").needs("a").sets("r").means("a reference run that failed"),
    row("input", LOW, Only, "Z").means("level of input r12"),
    row("segment_scale", LONG, Long, "").means("scaled acc * 2^r7 as an integer"),
    row("segment_sign", LONG, Long, "Z").means("keeps the sign; Z for 0"),
    row("command_target", LONG, Only, "")
        .needs("ar")
        .leaves(Scratch::TEMP)
        .loses("r")
        .means("the pace and the place behind it: r12 = 0, or not"),
    row("command_pace", Nothing, Long, "Z")
        .needs("ar")
        .leaves(Scratch::TEMP)
        .means("TEMP = the pace at r5; Z when one is not above 0"),
    row("command_axes", Nothing, Lost, "")
        .reads(Scratch::FLAGS)
        .loses("a")
        .leaves(Scratch::RAMPS)
        .means("the targets of FLAGS are commanded"),
    row("command_float", Nothing, Long, "").means("the next argument, a float: thousandths of it"),
    row("command_long", Nothing, Long, "").means("the next argument"),
    row("rounded", LONG, Long, "").means("the integer next to acc over 2^13"),
    row("motion_nominal", Nothing, Lost, "").loses("ar").means("NOMINAL2 from feed and override"),
    row("idle", Nothing, Kept, "Z").means("Z when no run is active and nothing moves"),
    row("map_homes", Nothing, Long, "C").means("C unless an axis homes"),
    row("emergency_now", Nothing, Only, "Z").means("the emergency stop that is on, 0 for none"),
    row("reference_at", Nothing, Low, "")
        .needs("a")
        .means("input of the reference switch of axis r8"),
    row("motion_poll", Nothing, Lost, "")
        .loses("ar")
        .writes(PLANNER)
        .leaves(Scratch::SPARE_TOO)
        .means("fills a slot, ends the motion"),
    row("line_begin", LOW, Lost, "")
        .loses("ar")
        .writes(PLANNER)
        .finds(Scratch::TEMP.and(Scratch::SPARE))
        .means("a line of these axes begins"),
    row("control", LOW, Lost, "").loses("ar").writes(Scratch::ALL).means("obeys a Control code"),
    row("abandon", Nothing, Lost, "")
        .loses("ar")
        .means("a reference run or probe by command is given up"),
];

/// Those that are called by their address.
pub const CALLED: &[Routine] = &[
    row("aim_place", LONG, Only, "")
        .needs("ar")
        .reads(Scratch::FRAME_OF)
        .loses("r")
        .means("aim, of a machine position"),
    row("axis_begin", LOW, Lost, "")
        .loses("ar")
        .reads(Scratch::TEMP)
        .writes(PLANNER)
        .finds(Scratch::SPARE)
        .means("the axis of this bit sets off"),
    row("boot_log", Nothing, Lost, "").means("the last fault of the log"),
    row("clear_run", Nothing, Only, "").means("clears what a run begins with; r12 = POOL_END"),
    row("command_aim", LONG, Only, "")
        .needs("ar")
        .reads(Scratch::SPARE)
        .loses("r")
        .means("the place acc + SPARE: r12 = 0, or not"),
    row("command_scaled", LONG, Long, "").means("a float without its sign as a scaled number"),
    row("course_line", LONG, Lost, "").means("EXIT2 of the line, acc where its entry falls"),
    row("event_pulse_over", Nothing, Lost, "").means("what a handler has interrupted is over"),
    row("fault_log", Nothing, Lost, "").means("appends the last fault to the log"),
    row("force_input", LOW, Only, "").means("input r12 keeps a level: 0 or an exception"),
    row("handler_open", Nothing, Lost, "Z")
        .means("an entry of the call stack for an error handler; Z when there is none"),
    row("home_record", Nothing, Kept, "").sets("r").means("r9 = what command 106 brought"),
    row("io_exchange", Nothing, Lost, "").means("outputs to the pins, inputs from them"),
    row("io_open", Nothing, Lost, "").means("the pins of the wiring"),
    row("keep_load", Nothing, Lost, "")
        .loses("ar")
        .writes(Scratch::ALL)
        .means("KEEP values from flash"),
    row("keep_save", Nothing, Lost, "")
        .loses("ar")
        .writes(Scratch::ALL)
        .means("KEEP values to flash"),
    row("line_change", LONG, Long, "").needs("a").means("how acc differs from INC"),
    row("line_direction", LONG, Kept, "").needs("a").means("the axis goes the way of acc"),
    row("line_fraction", LONG, Long, "").reads(Scratch::SPARE_TOO).means("acc * 2^32 over LEFT"),
    row("line_of", LOW, Only, "").means("r12 = the line of an address"),
    row("line_origin", Nothing, Lost, "")
        .needs("ar")
        .means("accumulator, count and DIR pin of the axis"),
    row("linear_frame", Nothing, Low, "").means("FRAME_OF of the next axis"),
    row("linear_mixed", LOW, Low, "").means("steps and frames of all axes"),
    row("motion_caught", Nothing, Long, "")
        .needs("a")
        .means("where the axis was when the input answered"),
    row("motion_speed", LOW, Long, "")
        .sets("ar")
        .planner(Scratch::LOCALS)
        .means("speed of axis r12"),
    row("output_off", LOW, Lost, "").means("output r12 is off, in a pause and behind it"),
    row("probe_pins", Nothing, Low, "").means("the pins of inputs that count"),
    row("profile_newest", Nothing, Lost, "").means("BOARD = the profile in use"),
    row("program_attach", Nothing, Lost, "")
        .loses("ar")
        .writes(Scratch::ALL)
        .means("checks the stored program"),
    row("program_length", Nothing, Low, "")
        .loses("r")
        .means("length of the stored program, 0 for none"),
    row("push_small", LOW, Long, "").means("puts r12 on the stack"),
    row("push_value", LONG, Kept, "").means("puts acc on the stack"),
    row("reference", LOW, Low, "").means("input of the reference switch of axis r12"),
    row("run_finish", LOW, Lost, "").means("ends the run"),
    row("segment_by_speed", LONG, Lost, "").means("a segment's events at most, by speed"),
    row("segment_by_time", LONG, Lost, "").means("a segment's events by time"),
    row("segment_change", LONG, Long, "")
        .loses("r")
        .means("change of the interval from an event to the next"),
    row("segment_cruises", LONG, Lost, "C").means("C when the brake is far away"),
    row("segment_divide", LONG, Lost, "")
        .sets("a")
        .means("sub-events; r8 is the slot from here on"),
    row("segment_half", LONG, Long, "").means("half a change before the first event"),
    row("segment_take", Nothing, Long, "N")
        .leaves(Scratch::SPARE_TOO)
        .means("events of a segment, scaled, and the sign that was kept"),
    row("set_output", LONG, Lost, "Z")
        .means("output r12 on or off by r13; Z when it does not exist"),
    row("settle", LONG, Long, "").needs("ar").means("the commanded place is that of acc"),
    row("settle_all", Nothing, Lost, "")
        .loses("a")
        .sets("r")
        .means("the commanded places are where the axes stand"),
    row("stack_end", Nothing, Only, "").means("end of what the program's stack has"),
    row("step_init", Nothing, Lost, "").means("the step engine's timer"),
    row("store_mount", Nothing, Lost, "")
        .loses("ar")
        .writes(Scratch::ALL)
        .means("the stored program"),
    row("target_steps", LOW, Long, "").sets("ar").means("where the axis is to stand, work steps"),
    row("to_other", LONG, Long, "C")
        .needs("r")
        .reads(Scratch::FRAME_OF)
        .means("into the unit that FRAME_OF does not say"),
    row("uart_open", LOW, Lost, "").means("the serial line"),
    row("upload_control", LOW, Low, "")
        .loses("ar")
        .writes(Scratch::ALL)
        .means("obeys an Upload code: 0 or an exception"),
    row("work_position_is", LONG, Only, "")
        .needs("ar")
        .means("the work position becomes acc steps: 0 or an exception"),
    row("work_steps", LOW, Long, "").sets("ar").means("where the axis stands, work steps"),
];
