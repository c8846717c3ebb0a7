/* The table of the instructions, in the order of their codes. */

    .section .rodata.vm,"a",@progbits
module.vm$tables:
    .balign 2
vm_table:
    .short vm_soft, vm_byte, vm_tens, vm_hundreds, vm_thousands, vm_word, vm_wordtens, vm_long
    .short vm_loadfar, vm_storefar, vm_inc, vm_addcell, vm_loadelem, vm_storeelem, vm_shift, vm_shift
    .short vm_add, vm_sub, vm_mul, vm_div, vm_mod, vm_min, vm_max, vm_and
    .short vm_or, vm_compare_value, vm_compare_value, vm_compare_value
    .short vm_compare_value, vm_compare_value, vm_compare_value, vm_xor
    .short vm_neg, vm_abs, vm_sqr, vm_drop, vm_jumpzero, vm_jumpzero, vm_jump, vm_jumpfar
    .short vm_dup, vm_compare_jump, vm_compare_jump, vm_compare_jump
    .short vm_compare_jump, vm_compare_jump, vm_compare_jump, vm_over
    .short vm_forstep, vm_nextstep, vm_nextword, vm_column
    .short vm_nextshort, vm_nextshort, vm_nextshort, vm_nextshort
    .short vm_incshort, vm_incshort, vm_incshort, vm_incshort
    .short vm_zero, vm_zero, vm_zero, vm_zero
    .short vm_call, vm_callfar, vm_gosub, vm_func, vm_return, vm_exitsub, vm_give, vm_tablefar
    .short vm_check, vm_soft, vm_soft, vm_soft, vm_soft
    /* what only parts with error handlers, with events have */
    .if CORE_LINES | CORE_EVENTS
    .short vm_soft, vm_soft, vm_soft, vm_soft
    .endif
    .if CORE_EVENTS
    .short vm_more
    .endif
    /* effect and number of further values of the codes from 0xA0 on */
vm_inlines:
    .byte CORE_MOVE_TO, 0, CORE_MOVE_TO+1, 0, CORE_MOVE_TO+2, 0
    .byte CORE_LINE, 0, CORE_LINE+1, 0, CORE_LINE+3, 0, CORE_RAPID+3, 0
    .byte CORE_FEED, 0, CORE_WAIT, 0, CORE_RAPID+2, 1, CORE_LINE+2, 1
    .byte CORE_LINEAR, 0, CORE_LINEAR, 1, CORE_LINEAR, 2
    .byte CORE_MOVE, 1, CORE_PROBE, 1
