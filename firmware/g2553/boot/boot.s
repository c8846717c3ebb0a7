/* From reset to a board that knows its profile and its program. */

    .section .text.boot,"axR",@progbits
module.boot:
    .global boot, R_BOOTED, R_HOST, RUNS_MARK
/* Everything before the main loop; interrupts are on at its end. Destroys all. */
boot:
    MICRO
    /* Pins safe: STEP and DIR low, outputs as their resistors have them until the first exchange. All of port
       1 is pulled up, the receive pin of a cable that is off too. UART on P1.1 and P1.2. */
    DO poke
    .byte BCSCTL3, 0x20         /* ACLK from the VLO, P2.6 and P2.7 free */
    .byte P2OUT, 0, P2SEL, 0, P2DIR, 0xff&~(P2_OUT1_OR_LATCH|P2_OUT2_OR_ENABLE)
    .byte P1OUT, 0xff, P1REN, 0xff, P1SEL, P1_UART, P1SEL2, P1_UART, 0
    END
    /* 16 MHz not before the supply has come up: half of it against the reference of 2.5 V, sampled for
       100 us, which the reference needs 30 of. Then 15 ms more, for the rest of a slow rise, and for wires
       that the pull-ups bring up before Stop is looked at. The handlers leave no room for that: 60 ms in
       all. The watchdog works from here on. */
    .if HAS_EVENTS
    mov #4, r13
1:  mov #KICK, &WATCHDOG
    .else
    mov #ADC_HALF_SUPPLY, &ADC10CTL1
1:  mov #KICK, &WATCHDOG
    mov #ADC_SAMPLE, &ADC10CTL0
2:  bit #ADC_BUSY, &ADC10CTL1
    jne 2b
    cmp #SUPPLY_UP, &ADC10MEM
    jlo 1b
    clr &ADC10CTL0
    .endif
    mov #15*1100/3, r12
3:  dec r12
    jne 3b
    .if HAS_EVENTS
    dec r13
    jne 1b
    .endif
    /* Erased calibration bytes (FF) would run the DCO beyond the chip's limit: then the reset value
       of 1.1 MHz stays, the link is dead and nothing moves. */
    mov.b &CALBC1_16MHZ, r12
    cmp.b #-1, r12
    jeq 1f
    clr.b &DCOCTL
    mov.b r12, &BCSCTL1
    mov.b &CALDCO_16MHZ, &DCOCTL
1:  /* Timer0_A: SMCLK / 8 = 2 MHz, continuous; CCR0 is the millisecond, CCR1 the link's silence */
    clr &TA0CCTL1
    mov #TICKS_A_MS, &TA0CCR0
    mov #CCIE, &TA0CCTL0
    mov #0x02e4, &TA0CTL
    /* IFG1: bit 0 watchdog, 2 power on, 3 RST pin, 4 NMI */
    mov.b &IFG1, r12
    clr.b &IFG1
    MICRO
    ANDI 0x1d
    PUT CAUSE
    CALL profile_newest
    CALL step_init
    CALL io_open
    F base BOARD
    FR word B_RESET_ON, SHORT
    F put OUTPUT
    FR word B_LOCK, SHORT
    IF_EQUAL 1f
    BITS_ON TRACING, T_LOCKED
1:  PROFILE B_ADDRESS
    PUT ADDRESS
    PROFILE B_RATE
    CALL uart_open
    LIT16 100*0x101
    F put OVERRIDE
    CALL store_mount
    CALL boot_log
    /* a run that a reset broke off */
    LIT16 RUNS_MARK
    F cmp RUNNING
    IF_NOT_EQUAL 2f
    F clear RUNNING
    IF_ANY CAUSE, 4, 2f
    F word VM_CODE
    F put EFFECT_PC
    LIT F_WATCHDOG
    IF_ANY CAUSE, 1, 1f
    LIT F_EMERGENCY_STOP
1:  DO fail
2:  RETURN
    .balign 2, 0

/* The last fault of the log. */
boot_log:
    mov #LOG, r15
1:  mov @r15+, r12
    mov @r15+, r13
    mov r12, r11
    xor r13, r11
    xor @r15+, r11
    xor @r15+, r11
    jne 2f
    cmp #-1, r12
    jeq 2f
    /* FAULT_IN lies in the high half */
    mov r12, &VM_FAULT
    add &VM_CODE, r13
    mov r13, &VM_FAULT_PC
2:  cmp #LOG+64, r15
    jne 1b
    ret
