/* Made by `cargo run -p lower` of firmware/src/rules/coords.rs: change that. */

    .section .text.micro,"axR",@progbits
module.rules.coords:
    .global work_steps
    ROUTINE_ODD work_steps, module.rules.coords
    DO axis_select
    DO offset_steps
    F sub ACTUAL, AXIS
    DO negate
    RETURN
    .global target_steps
    ROUTINE_ODD target_steps, module.rules.coords
    DO axis_select
    DO offset_steps
    F sub STEPS, AXIS
    DO negate
    RETURN
    .global offset_steps
    ROUTINE_ODD offset_steps, module.rules.coords
    F load OFFSET, AXIS
    DO to_steps
    DO zero_if_carry
    RETURN
    .global aim
    ROUTINE_ODD aim, module.rules.coords
    DO axis_there
    IF_NOT_EQUAL .Lcoords_1
    FAULT F_VALUE_RANGE
.Lcoords_1:
    IF_NONE FRAME_OF, F_RELATIVE, .Lcoords_2
    IF_NONE FRAME_OF, F_STEPS, .Lcoords_3
    F add STEPS, AXIS
    GOTO .Lcoords_m2
.Lcoords_3:
    F add UM, AXIS
    GOTO .Lcoords_m2
.Lcoords_2:
    IF_ANY FRAME_OF, F_STEPS|F_MACHINE, aim_place
    F add OFFSET, AXIS
.Lcoords_m2:
    IF_OVERFLOW .Lcoords_m3
    .global aim_place
    ROUTINE_ODD aim_place, module.rules.coords
    IF_NONE FRAME_OF, F_STEPS, .Lcoords_8
    F store NEW_STEPS, AXIS
    DO to_um
    IF_CARRY .Lcoords_9
    F store NEW_UM, AXIS
    GOTO .Lcoords_10
.Lcoords_8:
    F store NEW_UM, AXIS
    DO to_steps
    IF_CARRY .Lcoords_9
    F store NEW_STEPS, AXIS
.Lcoords_10:
    F load NEW_STEPS, AXIS
    F sub ACTUAL, AXIS
    IF_OVERFLOW .Lcoords_m3
    IF_NOT_AXIS HOMED, .Lcoords_13
    FR load A_MAX, LONG
    F sub NEW_UM, AXIS
    IF_NEGATIVE .Lcoords_15
    F load NEW_UM, AXIS
    FR sub A_MIN, LONG
    IF_NOT_NEGATIVE .Lcoords_m1
.Lcoords_15:
    FAULT F_SOFT_LIMIT
.Lcoords_13:
    IF_NOT_AXIS PLACED, .Lcoords_18
.Lcoords_m0:
.Lcoords_m1:
.Lcoords_m4:
    DONE_
.Lcoords_18:
    IF_ANY FRAME_OF, F_RELATIVE, .Lcoords_m0
    F base STORED
    FR word PROGRAM_MACHINE+MC_FLAGS, SHORT
    TESTI MC_REQUIRE_HOMING
    IF_EQUAL .Lcoords_m4
    FAULT F_NOT_HOMED
.Lcoords_9:
.Lcoords_m3:
    FAULT F_OVERFLOW
    .global command
    ROUTINE_ODD command, module.rules.coords
    F load NEW_UM, AXIS
    F store UM, AXIS
    .if HAS_COURSES
    IF_ZERO JOINS, .Lcoords_20
    UP JOINS
    LIT 0
    DO test_long
    RETURN
    .endif
.Lcoords_20:
    F load NEW_STEPS, AXIS
    F store STEPS, AXIS
    F sub ACTUAL, AXIS
    DO test_long
    RETURN
    .global settle_here
    ROUTINE_ODD settle_here, module.rules.coords
    DO here
    .global settle
    ROUTINE_ODD settle, module.rules.coords
    F store STEPS, AXIS
    DO to_um
    DO zero_if_carry
    F store UM, AXIS
    RETURN
    .balign 2, 0
