/* Made by `cargo run -p lower` of firmware/src/rules/moves.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.moves:
fx_feed:
    PUT UNIT
    DO pop_value
    IF_IS UNIT, OP_SPINDLE, .Lmoves_m0
    DO not_negative
    DO test_long
    IF_NOT_EQUAL .Lmoves_2
    FAULT F_SPEED_RANGE
.Lmoves_2:
    IF_IS UNIT, OP_FEED, .Lmoves_3
    DO negate
.Lmoves_3:
    F store FEED
.Lmoves_m0:
    DONE_
fx_set_pos_zero:
    ADDI -OP_SET_POS_ZERO
    DO axis_select
    LIT 0
    GOTO fx_place_is
fx_set_pos:
    DO operand_byte
    DO axis_select
    DO pop_value
fx_place_is:
    F store SPARE
    F load UM, AXIS
    F sub SPARE
    IF_OVERFLOW .Lmoves_4
    F store OFFSET, AXIS
    DO axis_bit
    AXIS_ON PLACED
    DONE_
.Lmoves_4:
    FAULT F_OVERFLOW
fx_read:
    DO operand_byte
    PUT FLAGS
    ANDI FL_AXIS
    DO axis_select
    GET FLAGS
    DO half
    DO half
    DO micro_switch
    TO .Lmoves_5
    TO .Lmoves_6
    TO .Lmoves_7
    TO .Lmoves_8
    TO .Lmoves_9
    TO .Lmoves_10
    TO .Lmoves_11
    TO .Lmoves_12
    TO .Lmoves_13
    TO .Lmoves_14
    PLACES_END
.Lmoves_14:
    GET CHAR_IN
    LET CHAR_IN, 0
    GOTO .Lmoves_m2
.Lmoves_5:
    DO here
    GOTO .Lmoves_m1
.Lmoves_6:
    DO here
    GOTO .Lmoves_m2
.Lmoves_7:
    F load PROBED, AXIS
.Lmoves_m1:
    DO to_um
    DO zero_if_carry
    F sub OFFSET, AXIS
    GOTO .Lmoves_m2
.Lmoves_8:
    F load PROBED, AXIS
    GOTO .Lmoves_m2
.Lmoves_9:
    IF_NOT_AXIS PROBE_OK, .Lmoves_m5
    GOTO .Lmoves_m3
.Lmoves_10:
    IF_NOT_AXIS MOVING, .Lmoves_m5
    GOTO .Lmoves_m3
.Lmoves_11:
    IF_NOT_AXIS HOMED, .Lmoves_20
.Lmoves_m3:
    LIT 1
    GOTO .Lmoves_m2
.Lmoves_20:
.Lmoves_m5:
    LIT 0
    GOTO .Lmoves_m2
.Lmoves_12:
    LIT 17
    DO input
    F put TEMP+2
    F word INPUT
    F put TEMP
    F load TEMP
    GOTO .Lmoves_m2
.Lmoves_13:
    F load TIMER_MS
.Lmoves_m2:
    CALL push_value
    DONE_
    .balign 2, 0
