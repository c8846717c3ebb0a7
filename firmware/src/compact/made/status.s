/* Made by `cargo run -p lower` of firmware/src/rules/status.rs: change that. */

    .section .text.micro,"axR",@progbits
module.link.status:
    /* blocking */
map_blocking:
    DO blocking
    RETURN
    /* program_counter */
map_program_counter:
    F word EFFECT_PC
.Lstatus_1:
    F sub VM_CODE
    RETURN
    /* fault_pc */
map_fault_pc:
    F word VM_FAULT_PC
    GOTO .Lstatus_1
    /* trace_mode */
map_trace_mode:
    .if T_ON != 1
    .error "a leaf's bit"
    .endif
    GET TRACING
    ANDI T_ON
    RETURN
    /* probe_input */
map_probe_input:
    LIT 17
    DO input
    RETURN
    /* command_room */
map_command_room:
    DO idle
    IF_NOT_EQUAL .Lstatus_2
    LIT COMMAND_WORDS
.Lstatus_2:
    RETURN
    /* plc_status */
map_plc_status:
    IF_NONE RUN, RUN_ACTIVE, .Lstatus_3
    LIT16 1024
.Lstatus_3:
    RETURN
    /* homes */
    ROUTINE_ODD map_homes, module.link.status
    GET EFFECT
    ADDI -OP_HOME
    CMPI OP_HOME_QUERY+1-OP_HOME
    RETURN
    /* cnc_state */
map_cnc_state:
    .if M_JOG != 32
    .error "a leaf's bit"
    .endif
    GET MOTION
    ANDI M_JOG
    F put TEMP
    IF_IS_NOT RUN, RUN_FAULT, .Lstatus_4
    BITS_ON TEMP, 0x1
.Lstatus_4:
    IF_NONE RUN, RUN_ACTIVE, .Lstatus_5
    BITS_ON TEMP, 0x8
.Lstatus_5:
    IF_IS_NOT RUN, RUN_PAUSED, .Lstatus_6
    BITS_ON TEMP, 0x10
.Lstatus_6:
    DO map_homes
    IF_CARRY .Lstatus_7
    BITS_ON TEMP, 0x4
.Lstatus_7:
    PROFILE B_DOOR
    DO input
    IF_NOT_EQUAL .Lstatus_9
    PROFILE B_DOOR+1
    DO input
    IF_EQUAL .Lstatus_8
.Lstatus_9:
    BITS_ON TEMP, 0x40
.Lstatus_8:
    CALL emergency_now
    IF_EQUAL .Lstatus_word
    BITS_ON TEMP+1, 0x1
    GOTO .Lstatus_word
    /* limit_switches */
map_limit_switches:
    F clear TEMP
    DO micro_first_axis
.Lstatus_10:
    DO axis_at
    CALL reference_at
    DO input
    IF_EQUAL .Lstatus_11
    FR word A_FLAGS, SHORT
    TESTI AXIS_HOME_POSITIVE
    IF_EQUAL .Lstatus_12
    DO axis_bit
    AXIS_ON TEMP+1
    GOTO .Lstatus_11
.Lstatus_12:
    DO axis_bit
    AXIS_ON TEMP
.Lstatus_11:
    NEXT_AXIS .Lstatus_10
    GOTO .Lstatus_word
    /* probing */
map_probing:
    F clear TEMP
    IF_IS_NOT EFFECT, OP_PROBE, .Lstatus_word
    DO axis_n
    DO axis_bit
    AXIS_ON TEMP+1
    GOTO .Lstatus_word
    /* homing */
map_homing:
    F clear TEMP
    GET HOMING_ERROR
    PUT TEMP+1
    DO map_homes
    IF_CARRY .Lstatus_word
    DO axis_n
    DO axis_bit
    AXIS_ON TEMP
.Lstatus_word:
    F word TEMP
    RETURN
    .balign 2, 0
