/* Made by `cargo run -p lower` of firmware/src/rules/effects.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.effects:
fx_out_short:
    ADDI -(OP_OUT_SHORT-2)
    PUT UNIT
    DO half
    GOTO fx_output
fx_set_out:
    DO pop_level
    POP_NUMBER 1, 16
    .global fx_output
    ROUTINE_ODD fx_output, module.rules.effects
    PUT N
    PROFILE B_ENABLE
    COMPARE N
    IF_EQUAL .Leffects_2
    PROFILE B_LAMP
    COMPARE N
    IF_EQUAL .Leffects_2
    GET N
    DO output_unit
    IF_NOT_EQUAL .Leffects_1
.Leffects_2:
    FAULT F_VALUE_RANGE
.Leffects_1:
    GET UNIT
    ANDI 1
    EVENT TRACE_OUT
    RETURN
fx_pulse:
    IF_NOT_EQUAL .Leffects_3
    DO pop_time
    POP_NUMBER 1, 16
    LET UNIT, 1
    DO fx_output
    DO or_return
    NOT_YET_
.Leffects_3:
    DO time_up
    LET UNIT, 0
    GET N
    GOTO fx_output
fx_set_port:
    IF_NOT_EQUAL .Leffects_5
    DO pop_value
    PUT BITS
.Leffects_5:
.Leffects_6:
    UP N
    GET BITS
    PUT UNIT
    DO half
    PUT BITS
    GET N
    CMPI 9
    IF_NOT_NEGATIVE .Leffects_m0
    DO fx_output
    IF_NONE TRACING, T_FULL, .Leffects_6
    NOT_YET_
fx_wait:
    IF_NOT_EQUAL .Leffects_9
    DO pop_time
    EVENT TRACE_WAIT
.Leffects_9:
    DO time_up
.Leffects_m0:
    DONE_
fx_wait_in:
    IF_NOT_EQUAL .Leffects_10
    DO wait_begin
    IF_NONE BITS, FLAG_LEVEL, .Leffects_11
    DO pop_level
    BITS_OFF BITS, 3
    GET UNIT
    AXIS_ON BITS
.Leffects_11:
    GET BITS
    DO half
    DO half
    DO half
    DO half
    DO half
    DO half
    ADDI 1
    IF_NONE BITS, FLAG_INPUT_ON_STACK, .Leffects_12
    POP_NUMBER 1, 17
.Leffects_12:
    PUT N
.Leffects_10:
    GET N
    DO input
    PUT UNIT
    GET BITS
    ANDI 1
    COMPARE UNIT
    IF_NOT_EQUAL .Leffects_13
    IF_ANY BITS, 2, .Leffects_15
    EVENT_OK TRACE_WAIT_IN
fx_met:
    IF_NONE BITS, FLAG_WAIT_QUERY, .Leffects_18
    BITS_OFF RUN_FLAGS, R_TIMED_OUT
.Leffects_18:
    DONE_
.Leffects_13:
    BITS_OFF BITS, 2
.Leffects_15:
    DO time_up
    EVENT TRACE_WAIT_IN
    GOTO fx_missed
fx_wait_char:
    IF_NOT_EQUAL .Leffects_16
    DO wait_begin
    POP_NUMBER 33, 125
    PUT N
.Leffects_16:
    GET N
    COMPARE CHAR_IN
    IF_NOT_EQUAL .Leffects_17
    LET CHAR_IN, 0
    EVENT_OK TRACE_WAIT_CHAR
    GOTO fx_met
.Leffects_17:
    DO time_up
    EVENT TRACE_WAIT_CHAR
fx_missed:
    IF_ANY BITS, FLAG_WAIT_QUERY, .Leffects_19
    FAULT F_TIMED_OUT
.Leffects_19:
    BITS_ON RUN_FLAGS, R_TIMED_OUT
    DONE_
fx_send:
    POP_NUMBER 33, 125
    PUT CHAR_OUT
    UP CHAR_OUT+1
    EVENT TRACE_SEND
    RETURN
fx_wait_start:
    IF_NOT_EQUAL .Leffects_20
    BITS_ON RUN_FLAGS, R_WAITING
.Leffects_20:
    IF_NONE RUN_FLAGS, R_WAITING, .Leffects_21
    NOT_YET_
.Leffects_21:
    LIT 0
    EVENT_OK TRACE_WAIT_START
    RETURN
fx_in_short:
    ADDI -(OP_IN_SHORT-1)
    GOTO .Leffects_m1
fx_input:
    POP_NUMBER 1, 17
.Leffects_m1:
    DO input
    GOTO .Leffects_m3
fx_out_state:
    POP_NUMBER 1, 16
    DO output
    GOTO .Leffects_m3
fx_timed_out:
    LIT 0
    IF_NONE RUN_FLAGS, R_TIMED_OUT, .Leffects_22
    LIT 1
.Leffects_22:
.Leffects_m3:
    CALL push_small
    DONE_
    .balign 2, 0
