/* Reference runs and switches: what firmware/src/rules/home.rs builds on. */
    .section .text.micro,"axR",@progbits
module.moves.home:
    EFFECT OP_HOME, fx_home

    /* Where the switch opened: nothing is watched meanwhile. */
    .set OPENED, CAUGHT

home_record:
    mov #HOME_RECORD, r9
    ret

    /* r12 = input number of the reference switch of axis r8, of axis r12. */
reference_at:
    mov r8, r12
    rra r12
    rra r12
reference:
    add &BOARD, r12
    mov.b B_REFERENCE(r12), r12
    ret
