/* Made by `cargo run -p lower` of firmware/src/rules/ticks.rs: change that. */

    .section .text.ticks,"axR",@progbits
module.rules.ticks:
    .balign 2, 0
    .global ticks_rest
ticks_rest:
    MICRO
    PROFILE B_LAMP
    CALL set_output
    IF_SET TICKS_DONE, .Lticks_1
    IF_NONE TRACING, T_HEARD, .Lticks_3
    GET TRACING
    ADDI -T_QUARTER
    PUT TRACING
    GOTO .Lticks_4
.Lticks_3:
    BITS_OFF TRACING, T_ON|T_FULL
.Lticks_4:
.Lticks_1:
    IF_ANY RUN_FLAGS, R_BOOTED, .Lticks_5
    LIT16 499
    F cmp MILLIS
    IF_CARRY .Lticks_5
    BITS_ON RUN_FLAGS, R_BOOTED
    IF_ANY RUN_FLAGS, R_HOST, .Lticks_5
    PROFILE B_FLAGS
    TESTI BOARD_AUTORUN
    IF_EQUAL .Lticks_5
    IF_IS_NOT CAUSE, 4, .Lticks_5
    IF_IS_NOT RUN, RUN_READY, .Lticks_5
    DO run_start
.Lticks_5:
    IF_ANY MOTION, M_JOG, .Lticks_12
    GET EFFECT
    ADDI -OP_HOME
    CMPI OP_WAIT-OP_HOME+1
    IF_CARRY .Lticks_11
    IF_IS EFFECT, OP_PULSE, .Lticks_13
    IF_IS RUN, RUN_PAUSED, .Lticks_11
.Lticks_13:
.Lticks_12:
    LIT 1
    DO negate
    F add TIME
    IF_NEGATIVE .Lticks_14
    F store TIME
    GOTO .Lticks_15
.Lticks_14:
    IF_NONE MOTION, M_JOG, .Lticks_16
    DO motion_stop
.Lticks_16:
    IF_IS_NOT EFFECT, OP_PULSE, .Lticks_17
    GET N
    CALL output_off
.Lticks_17:
.Lticks_15:
.Lticks_11:
    .if HAS_EVENTS
    END
    br #event_tick
    .endif
    RETURN
    .balign 2, 0
