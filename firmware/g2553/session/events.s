/* ON IN and ON EVERY: the table of ON lines, what comes, and their handlers.

   A program with ON lines leaves the end of its pool to them: EVENT_ASIDE holds what the handler has
   interrupted, and below it lie the ON lines, the first one highest. A line is

   | byte | holds |
   |---|---|
   | 0 | what the line is for (EVENT_KIND), 0 off; bit 0: level of the input; EVENT_PENDING: it has come |
   | 1 | input |
   | 2 | period less one, ms |
   | 6 | milliseconds to the next tick, less one |

   Twin: board/controller.rs (serve, listen), board/effects.rs (event). */

    .if HAS_EVENTS
    .set EVENT_ASIDE, POOL_END-EVENT_ASIDE_SIZE
    .set EVENT_LINE, EVENT_ASIDE-EVENT_SIZE

    .section .text.events,"axR",@progbits
module.session.events:

/* r14 = ON lines of the program that runs, 0 without a run; r15 = address of the first. */
event_lines:
    clr r14
    bit.b #RUN_ACTIVE, &RUN
    jeq 1f
    mov &VM_CODE, r15
    bit.b #FEATURE_EVENTS, 1-IMAGE_CODE(r15)
    jeq 1f
    mov &VM_DATA, r15
    mov.b @r15, r14
1:  mov #EVENT_LINE, r15
    ret

/* r12 = end of what the program's stack has: below the ON lines. Clobbers r14, r15. */
    .global stack_end
stack_end:
    call #event_lines
    mov #POOL_END, r12
    .if HAS_COURSES
    /* no program has both */
    mov &VM_CODE, r15
    bit #MC_COURSES, MC_FLAGS-MACHINE_SIZE(r15)
    jeq 2f
    mov #COURSE, r12
2:
    .endif
    tst r14
    jeq 2f
    sub #EVENT_ASIDE_SIZE, r12
1:  sub #EVENT_SIZE, r12
    dec r14
    jne 1b
2:  ret

/* A millisecond of the ON lines. Edges in a pause are remembered, the clocks of ON EVERY stand still
   there. Destroys r8 to r15. */
    .global event_tick
event_tick:
    bit.b #VM_EVENT, &VM_FLAGS
    jeq 1f
    /* the wait that a handler interrupts goes on; a pulse in a pause, too */
    cmp.b #OP_PULSE, &EVENT_ASIDE
    jeq 2f
    cmp.b #RUN_RUNNING, &RUN
    jne 1f
2:  MICRO
    LIT 1
    DO negate
    F add EVENT_ASIDE+4
    IF_NEGATIVE 3f
    F store EVENT_ASIDE+4
    DO test_long
    IF_NOT_EQUAL 3f
    CALL event_pulse_over
3:  END
1:  call #event_lines
    mov r14, r9
    mov r15, r10
1:  dec r9
    jn 9f
    mov.b @r10, r8
    mov r8, r12
    and #EVENT_KIND, r12
    jeq 4f
    cmp #ON_EVERY, r12
    jeq 5f
    mov.b 1(r10), r12
    call #input
    xor r12, r8
    bit #1, r8
    jeq 4f
    xor.b #1, 0(r10)
    /* a rise waits for 1, a fall for 0 */
    rla r12
    rla r12
    xor r12, r8
    bit #ON_FALL-ON_RISE, r8
    jeq 4f
3:  bis.b #EVENT_PENDING, 0(r10)
4:  sub #EVENT_SIZE, r10
    jmp 1b
5:  cmp.b #RUN_RUNNING, &RUN
    jne 4b
    sub #1, 6(r10)
    sbc 8(r10)
    jc 4b
    mov 2(r10), 6(r10)
    mov 4(r10), 8(r10)
    jmp 3b

/* What a handler has interrupted is over: a pulse ends with it. */
event_pulse_over:
    cmp.b #OP_PULSE, &EVENT_ASIDE
    jne 9b
    mov.b &EVENT_ASIDE+2, r12
    br #output_off

/* Begins the handler of the first line that has come: between statements, and in waits that have
   begun. Destroys r11 to r15. */
    .global event_serve
event_serve:
    cmp.b #RUN_RUNNING, &RUN
    jne 9f
    bit.b #VM_EVENT|VM_ERROR|VM_MORE|VM_WITHIN, &VM_FLAGS
    jne 9f
    cmp &VM_BASE, &VM_SP
    jne 9f
    mov.b &EFFECT, r12
    tst r12
    jeq 1f
    sub #OP_WAIT_START, r12
    cmp #OP_WAIT-OP_WAIT_START+1, r12
    jhs 9f
1:  call #event_lines
    mov &VM_DATA, r13
    inc r13
2:  dec r14
    jn 9f
    tst.b 0(r15)
    jn 3f
    sub #EVENT_SIZE, r15
    incd r13
    jmp 2b
3:  bic.b #EVENT_PENDING, 0(r15)
    mov &VM_PC, r12
    mov #CALL_EVENT, r11
    call #call_entry
    jeq event_full
    mov r13, r14
    call #word_at
    add &VM_CODE, r11
    mov r11, &VM_PC
    bis.b #VM_EVENT, &VM_FLAGS
    MICRO
    F load EFFECT
    F store EVENT_ASIDE
    F load TIME
    F store EVENT_ASIDE+4
    F load FEED
    F store EVENT_ASIDE+8
    LIT 0
    F store EFFECT
    F store TIME
    F store FEED
    RETURN
    .balign 2, 0
event_full:
    mov &VM_PC, &EFFECT_PC
    mov #F_STACK, r12
    br #fail

/* The handler of an ON line is left: what it had interrupted goes on. */
    .global event_left
event_left:
    MICRO
    BITS_OFF VM_FLAGS, VM_EVENT
    F load EVENT_ASIDE
    F store EFFECT
    F load EVENT_ASIDE+4
    F store TIME
    F load EVENT_ASIDE+8
    F store FEED
    RETURN
    .balign 2, 0

/* ON IN, ON EVERY and their OFF: slot and kind in the operand, input or time on the stack. */
    EFFECT OP_EVENT, fx_event
fx_event:
    END
    call #operand_byte
    mov r12, r8
    mov r12, r10
    and #EVENT_KIND, r8
    jeq event_off
    call #pop_value
    cmp #OFF_INPUT, r8
    jeq event_off
    /* neither an input 0 nor a period of 0 */
    sub #1, r12
    sbc r13
    jl event_range
    cmp #ON_EVERY, r8
    jeq 2f
    tst r13
    jne event_range
    cmp #17, r12
    jhs event_range
    inc r12
2:  and #3, r10
    mov #EVENT_LINE, r15
3:  dec r10
    jn 4f
    sub #EVENT_SIZE, r15
    jmp 3b
4:  mov r12, 2(r15)
    mov r13, 4(r15)
    mov r12, 6(r15)
    mov r13, 8(r15)
    mov.b r12, 1(r15)
    call #input
    bis r12, r8
    mov.b r8, 0(r15)
event_done:
    clr r12
9:  ret
event_range:
    mov #FAULTED+F_VALUE_RANGE, r12
    ret
/* OFF: of every tick (r8 = 0), or of the input r13:r12 */
event_off:
    mov r12, r10
    call #event_lines
1:  dec r14
    jn event_done
    mov.b @r15, r11
    and #EVENT_KIND, r11
    tst r8
    jeq 2f
    cmp #ON_EVERY, r11
    jeq 4f
    tst r13
    jne 4f
    mov.b 1(r15), r11
    cmp r10, r11
    jmp 3f
2:  cmp #ON_EVERY, r11
3:  jne 4f
    clr.b 0(r15)
4:  sub #EVENT_SIZE, r15
    jmp 1b
    .endif
