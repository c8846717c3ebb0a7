/* Probing (firmware/src/rules/probe.rs): inputs that answer, and the pins that are watched. */
    .section .text.micro,"axR",@progbits
module.moves.probe:

    /* r13:r12 = the inputs that must be off, then those that count. Use r7, r12, r13. */
probe_xor:
    mov r12, &PROBE_XOR
    mov r13, r7
    ret
probe_and:
    mov r12, &PROBE_AND
    jmp probe_high
    /* Waits for input r12, from 1, to be on (UNIT not 0) or off; those above 16 are 17. Uses r7, r11
       to r15. */
probe_input:
    call #mask_of
    mov r14, &PROBE_AND
    clr &PROBE_XOR
    clr r7
    clr r13
    tst r14
    jne 1f
    inc r13
1:  tst.b &UNIT
    jne probe_high
    mov r13, r7
    mov r14, &PROBE_XOR
    /* BITS = those of the masks' high halves r13 and r7, and QUERY of FLAGS. Uses r7, r12. */
probe_high:
    and #PROBE_AND_17, r13
    rra r7
    jnc 1f
    bis #PROBE_XOR_17, r13
1:  tst r7
    jeq 3f
    bis #PROBE_ALWAYS, r13
3:  mov.b &FLAGS, r12
    and #FL_QUERY, r12
    bis r12, r13
    mov.b r13, &BITS
    ret

    /* Z clear when (inputs AND and) XOR xor is not 0. Uses r11 to r15. */
probe_answers:
    mov #17, r12
    call #unfiltered
    mov.b &BITS, r13
    and r13, r12
    rra r13
    and #(PROBE_XOR_17+PROBE_ALWAYS)/2, r13
    xor r13, r12
    mov &RAW, r13
    and &PROBE_AND, r13
    xor &PROBE_XOR, r13
    bis r13, r12
    tst r12
    ret

    /* The pins at rest, and in r12 those of inputs 1 to 4 of the direct wiring that count. */
probe_pins:
    mov.b &P1IN, &IDLE
    mov.b &PROBE_AND, r12
    bic.b &FORCED, r12          ; the level of a forced one is looked at
    rla.b r12
    rla.b r12
    rla.b r12
    rla.b r12
    ret
