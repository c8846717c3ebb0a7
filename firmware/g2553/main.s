/* From reset into the loop that does everything but interrupts. */
    .section .Reset,"ax",@progbits
module.main:
    .global Reset
Reset:
    mov #RAM_END, r1
    mov #WATCHDOG_OFF, &WATCHDOG
    mov #CLEARED, r12
    call #clear_ram
    /* what the stack never reaches stays painted */
1:  mov #0xa5a5, 0(r12)
    incd r12
    cmp #RAM_END, r12
    jne 1b
    call #boot
    /* The pin of an emergency stop interrupts. Another edge than before may be taken for one that has
       come. */
    mov &BOARD, r12
    mov.b B_EMERGENCY_FALLS(r12), &P1IES
    clr.b &P1IFG
    mov.b B_EMERGENCY_PIN(r12), &P1IE
loop:
    mov #KICK, &WATCHDOG
    call #link_poll
    call #ticks
    call #motion_poll
    call #emergency_input
    call #run
    jmp loop
