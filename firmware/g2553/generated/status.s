/* Made by `cargo run -p lower` of firmware/src/rules/status.rs: change that. */

    .section .text.micro,"axR",@progbits
module.link.status:
    .global map_homes
    ROUTINE_ODD map_homes, module.link.status
    GET EFFECT
    ADDI -OP_HOME
    CMPI OP_HOME_QUERY+1-OP_HOME
.Lstatus_m2:
.Lstatus_m3:
    RETURN
map_blocking:
    DO blocking
    RETURN
map_program_counter:
    F word EFFECT_PC
    GOTO .Lstatus_m0
map_fault_pc:
    F word VM_FAULT_PC
.Lstatus_m0:
    F sub VM_CODE
    RETURN
map_trace_mode:
    .if T_ON != 1
    .error "a leaf's bit"
    .endif
    GET TRACING
    ANDI T_ON
    RETURN
map_probe_input:
    LIT 17
    DO input
    RETURN
map_command_room:
    DO idle
    IF_NOT_EQUAL .Lstatus_m2
    LIT COMMAND_WORDS
    RETURN
map_plc_status:
    IF_NONE RUN, RUN_ACTIVE, .Lstatus_m3
    LIT16 1024
    RETURN
map_cnc_state:
    .if M_JOG != 32
    .error "a leaf's bit"
    .endif
    GET MOTION
    ANDI M_JOG
    F put TEMP
    IF_IS_NOT RUN, RUN_FAULT, .Lstatus_5
    BITS_ON TEMP, 0x1
.Lstatus_5:
    IF_NONE RUN, RUN_ACTIVE, .Lstatus_6
    BITS_ON TEMP, 0x8
.Lstatus_6:
    IF_IS_NOT RUN, RUN_PAUSED, .Lstatus_7
    BITS_ON TEMP, 0x10
.Lstatus_7:
    DO map_homes
    IF_CARRY .Lstatus_8
    BITS_ON TEMP, 0x4
.Lstatus_8:
    PROFILE B_DOOR
    DO input
    IF_NOT_EQUAL .Lstatus_10
    PROFILE B_DOOR+1
    DO input
    IF_EQUAL .Lstatus_9
.Lstatus_10:
    BITS_ON TEMP, 0x40
.Lstatus_9:
    DO emergency_now
    IF_EQUAL .Lstatus_m1
    BITS_ON TEMP+1, 0x1
    GOTO .Lstatus_m1
map_limit_switches:
    F clear TEMP
    DO micro_first_axis
.Lstatus_12:
    DO reference_at
    DO input
    IF_EQUAL .Lstatus_14
    DO axis_at
    FR word A_FLAGS, SHORT
    TESTI AXIS_HOME_POSITIVE
    IF_EQUAL .Lstatus_15
    DO axis_bit
    AXIS_ON TEMP+1
    GOTO .Lstatus_16
.Lstatus_15:
    DO axis_bit
    AXIS_ON TEMP
.Lstatus_16:
.Lstatus_14:
    NEXT_AXIS .Lstatus_12
    GOTO .Lstatus_m1
map_probing:
    F clear TEMP
    IF_IS_NOT EFFECT, OP_PROBE, .Lstatus_m1
    DO axis_n
    DO axis_bit
    AXIS_ON TEMP+1
    GOTO .Lstatus_m1
map_homing:
    F clear TEMP
    GET HOMING_ERROR
    PUT TEMP+1
    DO map_homes
    IF_CARRY .Lstatus_18
    DO axis_n
    DO axis_bit
    AXIS_ON TEMP
.Lstatus_18:
.Lstatus_m1:
    F word TEMP
    RETURN
    .balign 2, 0
