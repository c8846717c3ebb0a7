/* Formulas: an accumulator machine for 32-bit and scaled numbers. Its code stands behind the call,
   two bytes an operation where instructions take eight to twelve:

       call #formula
       F load STEPS, AXIS          acc = STEPS[axis]
       F sub ACTUAL, AXIS          acc -= ACTUAL[axis]
       FA abs
       F store TEMP
       FR times A_ACCEL, LONG      acc *= new(accel of the axis record)
       FN shift, -4                acc /= 16
       F store ACCEL2, LAST        the last operation; execution goes on behind it

   F's operand is a word of RAM, with AXIS indexed by r8 = 4 * axis; FR's a 16-bit field, with LONG a
   32-bit field, of the axis record at r9. NEW turns either into a scaled number first. FN's is a
   number: of `int` 0 to 254, of `shift` -64 to 64. FA's operations have none. Each is a byte of
   flags and operation, then the operand's byte. */
    /* keeps the operand, which is also read as if it named a word, below the end of RAM */
    .set SHIFT_BIAS, 64
    .set F_LAST, 0x20
    .set F_AXIS, 0x40
    .set F_RECORD, 0x80         /* of 32 bits; with F_AXIS of 16 bits */
    .set F_NEW, 0x01

    /* acc = x, x = acc; scaled: acc + x, acc - x or 0, acc * x, acc / x, smaller, larger */
    .set F_load, 0
    .set F_store, 2
    .set F_plus, 4
    .set F_minus, 6
    .set F_times, 8
    .set F_over, 10
    .set F_least, 12
    .set F_most, 14
    /* scaled: root of acc; integer of acc, at most 2^31-1; acc * 2^n */
    .set F_root, 16
    .set F_floor, 18
    .set F_shift, 20
    /* integers: acc + x, acc - x, n, |acc|; acc as a scaled number */
    .set F_add, 22
    .set F_sub, 24
    .set F_int, 26
    .set F_abs, 28
    .set F_new, 30

    /* what may stand behind an operand */
    .set LAST, F_LAST
    .set AXIS, F_AXIS
    .set NEW, F_NEW
    .set LONG, 0
    .set SHORT, F_AXIS

    .macro F op, x=0x200, flag=0, more=0
    .byte F_\op | \flag | \more, (\x-0x200)/2
    .endm
    .macro FA op, flag=0
    .byte F_\op | \flag, 0
    .endm
    .macro FR op, x, width, flag=0, more=0
    .byte F_\op | F_RECORD | \width | \flag | \more, \x
    .endm
    .macro FN op, n, flag=0
    .if F_\op == F_shift
    .byte F_\op | \flag, \n + SHIFT_BIAS
    .else
    .byte F_\op | \flag, \n
    .endif
    .endm

    .section .text.formula,"axR",@progbits
module.motion.formula:
    /* Takes r13:r12, the formula behind the call, r8 and r9 as it names them. Leaves r13:r12;
       r11, r14, r15 lost. Some 60 cycles for each operation besides what it does. */
    .global formula
formula:
    push r10
    push r7
    mov 4(r1), r10
1:  mov.b @r10+, r7
    mov.b @r10+, r11
    tst.b r7
    jn 2f
    rla r11
    add #0x200, r11
    bit #F_AXIS, r7
    jeq 3f
    add r8, r11
    jmp 3f
2:  add r9, r11
3:  mov @r11, r14
    mov 2(r11), r15
    cmp #F_RECORD+F_AXIS, r7
    jlo 4f
    clr r15
4:  bit #F_NEW, r7
    jeq 5f
    push r12
    push r13
    mov r14, r12
    mov r15, r13
    call #pasapas_scaled_new
    mov r12, r14
    mov r13, r15
    pop r13
    pop r12
5:  and #0x1e, r7
    call formula_table(r7)
    bit.b #F_LAST, -2(r10)
    jeq 1b
    mov r10, 4(r1)
    pop r7
    pop r10
    ret

formula_load:
    mov r14, r12
    mov r15, r13
    ret
formula_store:
    mov r12, 0(r11)
    mov r13, 2(r11)
    ret
formula_shift:
    tst r13
    jeq 1f
    mov.b -1(r10), r14
    swpb r14
    sub #SHIFT_BIAS<<8, r14
    add r14, r13
1:  ret
formula_add:
    add r14, r12
    addc r15, r13
    ret
formula_sub:
    sub r14, r12
    subc r15, r13
    ret
formula_int:
    mov.b -1(r10), r12
    clr r13
    ret
    .global formula_abs, negate
    /* |r13:r12| */
formula_abs:
    tst r13
    jge 1f
    br #negate
    /* -(r13:r12) */
    .set negate, pasapas_neg
1:  ret

formula_table:
    .short formula_load, formula_store
    .short pasapas_scaled_plus, pasapas_scaled_minus
    .short pasapas_scaled_times, pasapas_scaled_over
    .short pasapas_scaled_min, pasapas_scaled_max
    .short pasapas_scaled_root, pasapas_scaled_floor, formula_shift
    .short formula_add, formula_sub, formula_int, formula_abs, pasapas_scaled_new
