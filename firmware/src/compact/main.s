/* From reset into the loop that does everything but interrupts. */
    .section .Reset,"ax",@progbits
module.main:
    .global Reset
Reset:
    mov #0x0400, r1
    mov #0x5a80, &0x0120
    mov #CLEARED, r12
1:  clr 0(r12)
    incd r12
    cmp #POOL, r12
    jne 1b
    /* what the stack never reaches stays painted */
2:  mov #0xa5a5, 0(r12)
    incd r12
    cmp #0x0400, r12
    jne 2b
    call #boot
loop:
    mov #KICK, &WATCHDOG
    call #link_poll
    call #ticks
    call #motion_poll
    call #run
    jmp loop
