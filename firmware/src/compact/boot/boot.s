/* From reset to a board that knows its profile and its program. */

    .section .rodata.boot,"aR",@progbits
module.boot$tables:
/* Peripheral register, value: pins safe, UART on P1.1 and P1.2, pull-ups at the buttons. */
boot_table:
    .byte 0x53, 0x20            /* BCSCTL3: ACLK from the VLO, P2.6 and P2.7 free */
    .byte 0x29, 0               /* P2OUT */
    .byte 0x2e, 0               /* P2SEL */
    .byte 0x2a, 0xff            /* P2DIR */
    .byte 0x21, P1_STOP|P1_START /* P1OUT */
    .byte 0x27, P1_STOP|P1_START /* P1REN */
    .byte 0x26, P1_UART         /* P1SEL */
    .byte 0x41, P1_UART         /* P1SEL2 */
    .byte 0
    .balign 2, 0

    .section .text.boot,"axR",@progbits
module.boot:
    .global boot, R_BOOTED, R_HOST, RUNS_MARK
/* Everything before the main loop; interrupts are on at its end. Destroys all. */
boot:
    /* Erased calibration bytes (FF) would run the DCO beyond the chip's limit: then the reset value
       of 1.1 MHz stays, the link is dead and nothing moves. */
    mov.b &0x10f9, r12
    cmp.b #-1, r12
    jeq 1f
    clr.b &0x0056
    mov.b r12, &0x0057
    mov.b &0x10f8, &0x0056
1:  mov #boot_table, r12
    call #poke_table
    /* Timer0_A: SMCLK / 8 = 2 MHz, continuous; CCR0 is the millisecond, CCR1 the link's silence */
    clr &TA0CCTL1
    mov #2000, &0x0172
    mov #0x0010, &0x0162
    mov #0x02e4, &0x0160
    call #profile_newest
    call #step_init
    call #io_open
    /* IFG1: bit 0 watchdog, 2 power on, 3 RST pin, 4 NMI */
    mov.b &0x0002, r12
    clr.b &0x0002
    and #0x1d, r12
    mov.b r12, &CAUSE
    mov &BOARD, r15
    mov B_RESET_ON(r15), &OUTPUT
    tst B_LOCK(r15)
    jeq 6f
    bis.b #T_LOCKED, &TRACING
6:  mov.b B_RATE(r15), r12
    /* Stop held: 9600 8N1, address 1, whatever the profile says */
    bit.b #P1_STOP, &0x0020
    jne 3f
    clr r12
    bis.b #R_ADDRESS_1, &RUN_FLAGS
3:  call #uart_open
    /* watchdog resets in a row */
    bit.b #1, &CAUSE
    jne 4f
    mov #NO_WATCHDOGS-1, &WATCHDOGS
4:  inc &WATCHDOGS
    cmp #NO_WATCHDOGS+3, &WATCHDOGS
    jlo 5f
    bis.b #R_BOOTED, &RUN_FLAGS /* the third and all that follow it: no autorun */
    /* another edge than before may be taken for one that has come */
5:  clr.b &P1IFG
    eint
    call #store_mount
    /* the last fault of the log */
    mov #LOG, r15
8:  mov @r15+, r12
    mov @r15+, r13
    mov r12, r11
    xor r13, r11
    xor @r15+, r11
    xor @r15+, r11
    jne 9f
    cmp #-1, r12
    jeq 9f
    /* FAULT_IN lies in the high half */
    mov r12, &VM_FAULT
    add &VM_CODE, r13
    mov r13, &VM_FAULT_PC
9:  cmp #LOG+64, r15
    jne 8b
    /* a run that a reset broke off */
    sub #RUNS_MARK, &RUNNING
    jne 7f
    mov #F_WATCHDOG, r12
    bit.b #4, &CAUSE
    jne 7f
    bit.b #1, &CAUSE
    jne 6f
    mov #F_EMERGENCY_STOP, r12
6:  mov &VM_CODE, &EFFECT_PC
    br #fail
7:  ret
