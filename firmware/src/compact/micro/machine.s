/* The machine that runs micro-code (notation.s), and the table of its operations and routines. */

    .section .text.micro,"axR",@progbits
module.micro:
    .global micro
micro:
    pop r11
    /* r11 = where micro-code begins */
micro_enter:
    push r10
    mov r11, r10
micro_next:
    mov r2, r15
    push #micro_next
    mov.b @r10+, r14
    rla.b r14
    jc micro_formula
    cmp #2*MICRO_OWNS, r14
    jhs 1f
    mov micro_table(r14), r11
micro_go:
    bit #1, r11
    jne micro_enter
    br r11
1:  rra r14
    mov.b micro_offsets-MICRO_OWNS(r14), r11
    rla r11
    cmp #MICRO_BYTES, r14
    jlo 2f
    mov.b @r10+, r14
2:  add r11, r0
micro_base:

micro_formula:
    mov r14, r11
    and #0x1e, r11
    .short 0x121b, formula_table /* push formula_table(r11): LLVM's assembler has none */
    mov.b @r10+, r11
    /* the flags leave r14 one by one: F_RECORD, F_AXIS, F_NEW */
    rla.b r14
    jc 5f
    rla r11
    add #0x200, r11
    rla.b r14
    jnc 3f
    add r8, r11
3:  mov 2(r11), r15
4:  rla.b r14
    mov @r11, r14
    jc 6f
    ret
5:  add r9, r11
    rla.b r14
    jnc 3b
    clr r15
    jmp 4b
6:  call #pasapas_swap
    call #pasapas_scaled_new
    br #pasapas_swap

formula_load:
    mov r14, r12
    mov r15, r13
    tst r13
    ret
formula_store:
    mov r13, 2(r11)
formula_put:
    mov r12, 0(r11)
    ret
formula_word:
    mov r14, r12
    tst r12
    ret
formula_clear:
    clr 0(r11)
    ret
formula_base:
    mov r14, r9
    ret
formula_bound:
    call #pasapas_scaled_min
    jmp formula_store
formula_add:
    add r14, r12
    addc r15, r13
    ret
formula_sub:
    sub r14, r12
    subc r15, r13
    ret

    .global negate
    .set negate, pasapas_neg

    /* in the order of F_load to F_bound */
formula_table:
    .short formula_load, formula_store
    .short pasapas_scaled_plus, pasapas_scaled_minus
    .short pasapas_scaled_times, pasapas_scaled_over
    .short pasapas_scaled_min, pasapas_scaled_max
    .short formula_add, formula_sub
    .short formula_word, formula_put, micro_cmpi, formula_clear, formula_base, formula_bound

micro_call:
    mov.b @r10+, r11
    mov.b @r10+, r15
    swpb r15
    bis r15, r11
    jmp micro_go

micro_end:
    incd r1
    mov r10, r14
    inc r14
    bic #1, r14
    pop r10
    mov r15, r2
    br r14

micro_fault:
    mov.b @r10+, r12
    add #FAULTED, r12
    jmp micro_return
micro_not_yet:
    mov #NOT_YET, r12
    jmp micro_return
micro_done:
    clr r12
    jmp micro_return
micro_below:
    cmp r14, r12
    jhs micro_refuse
    ret
micro_wanted:
    bit #2, r15
    jeq micro_nothing
micro_refuse:
    mov #ILLEGAL_VALUE, r12
micro_return:
    incd r1
    pop r10
    mov r15, r2
    ret

micro_literal:
    mov.b @r10+, r12
    clr r13
    ret
micro_word:
    mov.b @r10+, r12
    mov.b @r10+, r14
    swpb r14
    bis r14, r12
    ret
    /* a byte of the board's profile */
micro_profile:
    mov.b @r10+, r12
    add &BOARD, r12
    mov.b @r12, r12
    tst r12
    ret
micro_addi:
    add.b @r10+, r12
    ret
micro_andi:
    and.b @r10+, r12
    ret
micro_cmpi:
    cmp r14, r12
    ret
micro_testi:
    bit.b @r10+, r12
    ret
micro_shift:
    tst r13
    jeq 1f
    swpb r14
    sub #SHIFT_BIAS<<8, r14
    add r14, r13
1:  ret

    /* of a byte of RAM: r14 = its number */
micro_get:
    mov.b BYTES(r14), r12
    clr r13
    ret
micro_put:
    mov.b r12, BYTES(r14)
    ret
micro_let:
    .short 0x4afe, BYTES        /* mov.b @r10+, BYTES(r14): the same */
    ret
micro_bits_on:
    bis.b @r10+, BYTES(r14)
    ret
micro_bits_off:
    bic.b @r10+, BYTES(r14)
    ret
micro_compare:
    cmp.b BYTES(r14), r12
    ret
micro_up:
    inc.b BYTES(r14)
    ret
micro_axis_on:
    bis.b r12, BYTES(r14)
    ret
micro_axis_off:
    bic.b r12, BYTES(r14)
    ret

    /* The next of the axes from 8 = 4 * Z down: jumps while there is one. */
micro_next_axis:
    sub #4, r8
    jge micro_goto
    jmp 1f
micro_up_axis:
    add #4, r8
    cmp #12, r8
    jmp if_not_equal
micro_if_zero:
    tst.b BYTES(r14)
    jmp if_equal
micro_if_none:
    bit.b @r10+, BYTES(r14)
    jmp if_equal
micro_if_is:
    cmp.b @r10+, BYTES(r14)
    jmp if_equal
micro_if_not_axis:
    push r12
    call #axis_bit
    bit.b r12, BYTES(r14)
    pop r12
    jmp if_equal
    /* of r12 - r14 */
micro_case:
    cmp r14, r12
    jmp if_equal
micro_if_equal:
    mov r15, r2
if_equal:
    jeq micro_goto
1:  inc r10
    ret
micro_if_set:
    tst.b BYTES(r14)
    jmp if_not_equal
micro_if_any:
    bit.b @r10+, BYTES(r14)
    jmp if_not_equal
micro_if_is_not:
    cmp.b @r10+, BYTES(r14)
    jmp if_not_equal
micro_case_not:
    cmp r14, r12
    jmp if_not_equal
micro_if_not_equal:
    mov r15, r2
if_not_equal:
    jeq 1b
micro_goto:
    mov.b @r10, r14
    sxt r14
    add r14, r10
    mov r15, r2
    ret
micro_if_carry:
    bit #1, r15
    jmp if_not_equal
micro_if_negative:
    bit #4, r15
    jmp if_not_equal
micro_if_not_negative:
    bit #4, r15
    jmp if_equal
micro_if_overflow:
    bit #0x100, r15
    jmp if_not_equal

    /* r13:r12 = 0 when carry is set */
micro_zero_if_carry:
    bit #1, r15
    jeq 1f
    clr r12
    clr r13
1:  ret
    /* flags of r13:r12 as a whole: Z, N */
micro_test_long:
    mov r12, r14
    bis r13, r14
    tst r14
    ret

micro_half:
    rra r12
    ret
    /* the next axes are 8 = 4 * Z down to 0 */
micro_first_axis:
    mov #8, r8
micro_nothing:
    ret
    /* on with the r12th of the places that follow, from 0: a byte each as of a jump */
micro_switch:
    add r12, r10
    jmp micro_goto
    /* returns a fault in r12, goes on with 0 */
micro_or_return:
    tst r12
    jne micro_return
    ret

    /* The table: addresses, then of the machine's own operations how far they lie behind micro_base. A pad
       byte that execution comes over is number 0. */
    .set MICRO_NEXT, 0
    .macro MICRO_NUMBER name
    .set DO_\name, MICRO_NEXT
    .global DO_\name
    .set MICRO_NEXT, MICRO_NEXT+1
    .endm
    .macro MICRO_DO name, routine
    MICRO_NUMBER \name
    .short \routine
    .endm
    .macro MICRO_KNOWN name
    MICRO_DO \name, \name
    .endm
    .macro MICRO_OWN name, routine
    MICRO_NUMBER \name
    .if \routine-micro_base > 2*255
    .error "the operation is out of reach"
    .endif
    .byte (\routine-micro_base)/2
    .endm
micro_table:
    MICRO_DO micro_nothing, micro_nothing
    MICRO_DO micro_event, micro_event
    MICRO_DO micro_event_ok, micro_event_ok
    MICRO_DO scaled_most, scaled_most
    MICRO_DO zero, scaled_zero
    MICRO_DO new, pasapas_scaled_new
    MICRO_DO root, pasapas_scaled_root
    MICRO_DO floor, pasapas_scaled_floor
    MICRO_DO abs, pasapas_abs
    MICRO_DO negate, pasapas_neg
    MICRO_KNOWN axis_n
    MICRO_KNOWN axis_select
    MICRO_KNOWN axis_at
    MICRO_KNOWN axis_bit
    MICRO_KNOWN axis_there
    MICRO_KNOWN here
    MICRO_KNOWN to_steps
    MICRO_KNOWN to_um
    MICRO_KNOWN aim
    MICRO_KNOWN command
    MICRO_KNOWN settle_here
    MICRO_KNOWN offset_steps
    MICRO_KNOWN pop_value
    MICRO_KNOWN pop_level
    MICRO_KNOWN pop_number
    MICRO_KNOWN time_up
    MICRO_KNOWN pop_time
    MICRO_KNOWN wait_begin
    MICRO_KNOWN fx_output
    MICRO_KNOWN operand_byte
    MICRO_KNOWN rate
    MICRO_KNOWN speed_least
    MICRO_KNOWN begin_axis
    MICRO_KNOWN line_rapid
    MICRO_KNOWN poke
    MICRO_KNOWN output
    MICRO_KNOWN fail
    MICRO_KNOWN blocking
    MICRO_KNOWN unfiltered
    MICRO_KNOWN run_start
    MICRO_KNOWN output_states
    MICRO_KNOWN output_unit
    MICRO_KNOWN motion_rests
    MICRO_KNOWN motion_stop
    MICRO_KNOWN motion_halt
    MICRO_KNOWN ticks_a_second
    MICRO_KNOWN short_flags
    MICRO_KNOWN axis_flags
    MICRO_KNOWN speed_flags
    MICRO_KNOWN rate_of
    MICRO_KNOWN axis_pace
    MICRO_KNOWN not_negative
    MICRO_KNOWN home_closed
    MICRO_KNOWN home_by_profile
    MICRO_KNOWN motion_hit
    MICRO_KNOWN probe_input
    MICRO_KNOWN probe_xor
    MICRO_KNOWN probe_and
    MICRO_KNOWN probe_begin
    MICRO_KNOWN probe_answers
    MICRO_KNOWN home_missed
    MICRO_KNOWN input
    MICRO_KNOWN segment_by_speed
    MICRO_KNOWN segment_by_time
    MICRO_KNOWN segment_divide
    MICRO_KNOWN segment_scale
    MICRO_KNOWN segment_sign
    MICRO_KNOWN segment_take
    MICRO_KNOWN command_target
    MICRO_KNOWN command_pace
    MICRO_KNOWN command_axes
    MICRO_KNOWN command_float
    MICRO_KNOWN command_long
    MICRO_KNOWN rounded
    MICRO_KNOWN motion_nominal
    MICRO_KNOWN idle
    MICRO_KNOWN map_homes
    .set MICRO_OWNS, MICRO_NEXT
micro_offsets:
    MICRO_OWN micro_call, micro_call
    MICRO_OWN micro_end, micro_end
    MICRO_OWN micro_return, micro_return
    MICRO_OWN micro_done, micro_done
    MICRO_OWN micro_not_yet, micro_not_yet
    MICRO_OWN micro_fault, micro_fault
    MICRO_OWN micro_literal, micro_literal
    MICRO_OWN micro_word, micro_word
    MICRO_OWN micro_profile, micro_profile
    MICRO_OWN micro_addi, micro_addi
    MICRO_OWN micro_andi, micro_andi
    MICRO_OWN micro_testi, micro_testi
    MICRO_OWN micro_goto, micro_goto
    MICRO_OWN micro_switch, micro_switch
    MICRO_OWN micro_if_equal, micro_if_equal
    MICRO_OWN micro_if_not_equal, micro_if_not_equal
    MICRO_OWN micro_if_carry, micro_if_carry
    MICRO_OWN micro_if_negative, micro_if_negative
    MICRO_OWN micro_if_not_negative, micro_if_not_negative
    MICRO_OWN micro_if_overflow, micro_if_overflow
    MICRO_OWN micro_first_axis, micro_first_axis
    MICRO_OWN micro_next_axis, micro_next_axis
    MICRO_OWN micro_up_axis, micro_up_axis
    MICRO_OWN or_return, micro_or_return
    MICRO_OWN micro_wanted, micro_wanted
    MICRO_OWN zero_if_carry, micro_zero_if_carry
    MICRO_OWN test_long, micro_test_long
    MICRO_OWN half, micro_half
    /* only operations whose byte comes in r14; nothing else stands behind them */
    .set MICRO_BYTES, MICRO_NEXT
    MICRO_OWN micro_below, micro_below
    MICRO_OWN micro_cmpi, micro_cmpi
    MICRO_OWN micro_case, micro_case
    MICRO_OWN micro_case_not, micro_case_not
    MICRO_OWN micro_shift, micro_shift
    MICRO_OWN micro_get, micro_get
    MICRO_OWN micro_put, micro_put
    MICRO_OWN micro_let, micro_let
    MICRO_OWN micro_bits_on, micro_bits_on
    MICRO_OWN micro_bits_off, micro_bits_off
    MICRO_OWN micro_compare, micro_compare
    MICRO_OWN micro_up, micro_up
    MICRO_OWN micro_if_not_axis, micro_if_not_axis
    MICRO_OWN micro_axis_on, micro_axis_on
    MICRO_OWN micro_axis_off, micro_axis_off
    MICRO_OWN micro_if_zero, micro_if_zero
    MICRO_OWN micro_if_set, micro_if_set
    MICRO_OWN micro_if_any, micro_if_any
    MICRO_OWN micro_if_none, micro_if_none
    MICRO_OWN micro_if_is, micro_if_is
    MICRO_OWN micro_if_is_not, micro_if_is_not
    .if MICRO_NEXT > 0x80
    .error "a number in the table has 7 bits"
    .endif
    .balign 2, 0
