/* Operands: cells, data, axes. */

    /* cells, data, axes and event slots that the instruction names */
verify_operands:
    mov @r10, r15
    mov.b CHECK_CELLS-CHECK_CODE(r15), r14
    cells_of r14
    mov.b 1(r4), r12
    .if CHECK_HAS_EVENTS
    cmp.b #CHECK_EVENT, r5
    jeq 6f
    .endif
    mov.b r6, r11
    rra r11
    rra r11
    rra r11
    mov.b verify_table(r11), r11
    add r11, r0
verify_first:
verify_low:
    mov r5, r12
    and #CHECK_LOW_CELLS-1, r12
    jmp verify_cell
verify_short:
    mov r5, r12
    and #CHECK_SHORT_CELLS-1, r12
verify_cell:
    cmp r14, r12
    jhs 7f
verify_none:
    ret
verify_array:
    mov.b 2(r4), r13
    add r13, r12
    cmp r12, r14
    jlo 7f
    ret
verify_axis_number:
    cmp #3, r12
    jhs 7f
    ret
verify_axis:
    cmp #3, r12
    jhs 7f
2:  dec r12
    jn 3f
    add #CHECK_AXIS_SIZE, r15
    jmp 2b
3:  bit #CHECK_PRESENT, CHECK_AXES-CHECK_CODE(r15)
    jeq 7f
    ret
    .if CHECK_HAS_EVENTS
6:  /* ON IN and ON EVERY name a slot that has a handler */
    mov r12, r13
    and #CHECK_EVENT_KIND, r13
    cmp #CHECK_ON_RISE, r13
    jeq 8f
    cmp #CHECK_ON_FALL, r13
    jeq 8f
    cmp #CHECK_ON_EVERY, r13
    jne verify_none
8:  bit.b #CHECK_EVENTS, 1-CHECK_CODE(r15)
    jeq 7f
    mov CHECK_CODE_END(r10), r13
    cmp CHECK_IMAGE_END(r10), r13
    jhs 7f
    mov.b @r13, r13
    and #3, r12
    cmp r13, r12
    jhs 7f
    ret
    .endif
    /* whole thousands in the code: as many as the flags behind them ask for */
verify_inline_probe:
    bit.b #CHECK_SENSOR, -1(r7)
    jne 7f
    mov.b -2(r7), r12
    jmp verify_speed
verify_inline:
    mov.b -1(r7), r12
    and #7, r12
    call #verify_count
    mov r5, r12
    sub #CHECK_LINEAR_MM_LESS_ONE, r12
    cmp r12, r8
    jne 7f
    clr r8
    ret
verify_inline_move:
    mov.b -1(r7), r12
verify_speed:
    bit #CHECK_SPEED, r12
    jeq 7f
    ret
verify_text_far:
    mov.b 2(r4), r13
    swpb r13
    bis r13, r12
verify_text:
    call #verify_inside
    mov.b @r12+, r11
    add r11, r12
    jmp verify_ends_inside
verify_column_far:
    mov.b 2(r4), r13
    swpb r13
    bis r13, r12
verify_column:
    call #verify_inside
    mov.b @r12+, r11
    dec r11
    cmp #4, r11
    jhs 7f
    mov.b @r12+, r15
    mov.b @r12+, r13
    swpb r13
    bis r13, r15
    incd r12
6:  add r15, r12
    jc 7f
    dec r11
    jge 6b
verify_ends_inside:
    cmp r12, CHECK_IMAGE_END(r10)
    jlo 7f
    ret
    /* r12 = address of the data offset r12 */
verify_inside:
    add CHECK_CODE_END(r10), r12
    jc 7f
    cmp CHECK_IMAGE_END(r10), r12
    jhs 7f
    ret
verify_broken_kind:
7:  jmp verify_fail

    .section .rodata.verify,"a",@progbits
module.check$tables:
    /* one for each Kind, in their order: distances, which must fit: a negative .skip is refused */
    .skip -((verify_broken_kind - verify_first) >> 8)
verify_table:
    .byte verify_inline - verify_first
    .byte verify_inline_move - verify_first
    .byte verify_inline_probe - verify_first
    .byte verify_none - verify_first
    .byte verify_none - verify_first
    .byte verify_cell - verify_first
    .byte verify_low - verify_first
    .byte verify_short - verify_first
    .byte verify_array - verify_first
    .byte verify_column - verify_first
    .byte verify_column_far - verify_first
    .byte verify_text - verify_first
    .byte verify_text_far - verify_first
    .byte verify_axis_number - verify_first
    .byte verify_axis - verify_first
    .byte verify_broken_kind - verify_first
    .byte verify_none - verify_first
    .byte verify_none - verify_first
    .byte verify_none - verify_first
    .byte verify_none - verify_first
    .byte verify_cell - verify_first
    .byte verify_low - verify_first
