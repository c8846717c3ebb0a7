/* Made by `cargo run -p lower` of firmware/src/rules/segments.rs: change that. */

    .section .text.ramp,"axR",@progbits
module.rules.segments:
    .balign 2, 0
    .global segment
segment:
    clr r8
    MICRO
    F load LEFT
    DO test_long
    IF_EQUAL .Lsegments_1
    IF_NONE MOTION, M_PAUSE|M_STOP, .Lsegments_2
    LIT (START2-NOMINAL2)/4
    DO axis_select
    F load START2
    F sub V2
    IF_CARRY .Lsegments_1
.Lsegments_2:
    F load TICK
    F sub V
    CALL segment_by_time
    F load V2
    F sub NOMINAL2, AXIS
    DO segment_sign
    IF_NOT_EQUAL .Lsegments_4
    F load LEFT, NEW
    F times DECEL2
    F minus V2
    CALL segment_cruises
    IF_CARRY .Lsegments_3
.Lsegments_4:
    .if HAS_COURSES
    IF_ANY MOTION, M_THROUGH, .Lsegments_5
    .endif
    F load ACCEL2
    F most DECEL2
    F sub V2
    CALL segment_by_speed
.Lsegments_5:
.Lsegments_3:
    CALL segment_take
    IF_NOT_NEGATIVE .Lsegments_6
    F times ACCEL2
    F plus V2
    F least NOMINAL2, AXIS
    GOTO .Lsegments_m0
.Lsegments_1:
    TESTI 0
    RETURN
.Lsegments_6:
    F times DECEL2
    F store TEMP+4
    F load V2
    F minus TEMP+4
    F most NOMINAL2, AXIS
.Lsegments_m0:
    F store TEMP+4
    F load LEFT, NEW
    F times DECEL2
    .if HAS_COURSES
    IF_NONE MOTION, M_THROUGH, .Lsegments_8
    F plus EXIT2
    GOTO .Lsegments_9
    .endif
.Lsegments_8:
    F plus START2
.Lsegments_9:
    F bound TEMP+4
    DO root
    F store TEMP
    F plus V
    F store TEMP+8
    F sub TICK
    CALL segment_divide
shape:
    F load V
    F most TEMP
    F store SLOT0, AXIS
    F load TICK
    F over SLOT0, AXIS
    DO segment_scale
    F store SLOT0, AXIS
    F load TEMP+4
    F sub V2
    DO segment_sign
    IF_NOT_EQUAL .Lsegments_10
    F store SLOT0+CHANGE, AXIS
    GOTO .Lsegments_11
.Lsegments_10:
    F load TICK
    F over TEMP+8
    SHIFT 1
    DO segment_scale
    F sub SLOT0, AXIS
    DO not_negative
    CALL segment_change
    F store SLOT0+CHANGE, AXIS
    CALL segment_half
    F add SLOT0, AXIS
    F store SLOT0, AXIS
.Lsegments_11:
    F load TEMP
    F store V
    F load TEMP+4
    F store V2
    END
    mov r5, SLOT0+EVENTS(r6)
    setc
    ret
    .balign 2, 0
