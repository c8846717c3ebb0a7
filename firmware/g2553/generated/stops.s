/* Made by `cargo run -p lower` of firmware/src/rules/stops.rs: change that. */

    .section .text.line,"axR",@progbits
module.rules.stops:
    .balign 2, 0
    .global motion_over
motion_over:
    MICRO
    IF_ANY MOTION, M_STOP, .Lstops_1
    F load LEFT
    DO test_long
    IF_NOT_EQUAL .Lstops_m3
.Lstops_1:
    LET MOVING, 0
    IF_NONE MOTION, M_STOP|M_SETTLE|M_JOG, .Lstops_m3
    BITS_OFF MOTION, ~M_PAUSE&0xff
.Lstops_m2:
    CALL settle_all
    RETURN
    .global motion_stop
    ROUTINE_ODD motion_stop, module.rules.stops
    .if HAS_COURSES
    BITS_OFF MOTION, M_PAUSE|M_SETTLE|M_JOG
    BITS_ON MOTION, M_STOP
    .else
    LET MOTION, M_STOP
    .endif
    IF_SET MOVING, .Lstops_m0
    LET MOTION, 0
.Lstops_m3:
.Lstops_m0:
    RETURN
    .global motion_hit
    ROUTINE_ODD motion_hit, module.rules.stops
    F sub STEPS, AXIS
    DO abs
    F store TEMP+8
    F load START2
    F sub NOMINAL2
    IF_CARRY motion_halt
    LIT 31
    DO new
    F times NOMINAL2
    F over DECEL2
    SHIFT -5
    F store TEMP
    LIT 9
    DO new
    F times NOMINAL2
    DO root
    SHIFT -7
    F plus TEMP
    DO floor
    F sub TEMP+8
    BITS_ON MOTION, M_SETTLE
    F store TEMP+8
    LIT 1
    F add TEMP+8
    IF_NOT_NEGATIVE .Lstops_m1
    F add LEFT
    IF_NEGATIVE motion_stop
    F store LEFT
.Lstops_m1:
    RETURN
    .global motion_halt
    ROUTINE_ODD motion_halt, module.rules.stops
    LIT 0
    F store V2
    F clear SLOT0+EVENTS
    F clear SLOT1+EVENTS
    IF_ZERO MOVING, .Lstops_m2
    F store LEFT
    LET MOTION, M_STOP
.Lstops_9:
    DO motion_rests
    IF_NOT_EQUAL .Lstops_9
    DO motion_poll
    RETURN
    .balign 2, 0
