/* Made by `cargo run -p lower` of firmware/src/rules/axes.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.axes:
fx_move_axe:
    IF_NOT_EQUAL .Laxes_1
    LET RAMPS, 0
    CMPI OP_MOVE
    IF_NOT_NEGATIVE .Laxes_2
    DO short_flags
    GOTO .Laxes_3
.Laxes_2:
    PUT UNIT
    DO operand_byte
    PUT FLAGS
    IF_IS UNIT, OP_MOVE, .Laxes_5
    DO operand_byte
    PUT RAMPS
.Laxes_5:
    GET FLAGS
.Laxes_3:
    DO axis_flags
    GET RAMPS
    ANDI (FL_DECEL|FL_DECEL_STEPS)
    DO rate
    IF_EQUAL .Laxes_m0
    F store SPARE
    GET RAMPS
    ANDI (FL_ACCEL|FL_ACCEL_STEPS)
    DO rate
    IF_EQUAL .Laxes_m1
    F store SPARE_TOO
    F bound TEMP+4
    F load SPARE_TOO
    IF_NONE RAMPS, FL_DECEL, .Laxes_8
    F load SPARE
.Laxes_8:
    F bound TEMP+8
    DO speed_flags
    IF_NOT_EQUAL .Laxes_9
.Laxes_m0:
.Laxes_m1:
    FAULT F_SPEED_RANGE
.Laxes_9:
    GET FLAGS
    ANDI FL_STEPS+FL_RELATIVE
    ADDI FL_RELATIVE
    ANDI F_STEPS+F_RELATIVE
    PUT FRAME_OF
    DO pop_value
    DO aim
    DO or_return
    DO command
    IF_EQUAL .Laxes_m3
    LIT 0
    EVENT TRACE_AXE
    .global begin_axis
    ROUTINE_ODD begin_axis, module.rules.axes
    DO axis_bit
    CALL axis_begin
.Laxes_m2:
    NOT_YET_
.Laxes_1:
    IF_SET MOVING, .Laxes_m2
.Laxes_m3:
    DONE_
fx_stop_axe:
    DO operand_byte
    PUT N
    LIT 0
    EVENT TRACE_STOP
    RETURN
fx_stop_all:
    DONE_
fx_wait_move:
    DO operand_byte
    DONE_
    .balign 2, 0
