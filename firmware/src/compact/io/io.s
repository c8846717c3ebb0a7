/* Inputs and outputs at the pins: shift registers of the chain wiring, pins of the direct one.

   Bit order of the chain: the first byte read holds inputs 1 to 8, the first byte sent outputs 9 to
   16. While the latch is low the 74HC165 load; its rise shows what the 74HC595 were sent. */

    .section .text.io,"axR",@progbits

/* Makes the pins what the profile's wiring says, outputs off. Clobbers r12. */
    .global io_open
io_open:
    mov #P1_REF_X_OR_PROBE, r12
    mov &BOARD, r14
    bit.b #BOARD_CHAIN, B_FLAGS(r14)
    jeq 1f
    /* SPI master at 8 MHz, data valid at the rising edge */
    mov.b #UCB_RESET, &UCB0CTL1
    mov.b #UCB_MASTER, &UCB0CTL0
    mov.b #2, &UCB0BR0
    mov.b #0, &UCB0BR1
    mov.b #UCB_RUN, &UCB0CTL1
    mov.b #P1_REF_Y_OR_CLOCK+P1_REF_Z_OR_MISO+P1_PROBE_OR_MOSI, r14
    bis.b r14, &P1SEL
    bis.b r14, &P1SEL2
    /* the registers hold what the chip sends before their outputs are enabled */
    bis.b #P2_OUT1_OR_LATCH+P2_OUT2_OR_ENABLE, &P2OUT
    jmp 2f
1:  mov #P1_REF_X_OR_PROBE+P1_REF_Y_OR_CLOCK+P1_REF_Z_OR_MISO+P1_PROBE_OR_MOSI, r12
2:  bis.b r12, &P1REN
    bis.b r12, &P1OUT
    ret

/* Sends the outputs; leaves the inputs' levels in RAW. Clobbers r11 to r15. */
    .global io_exchange
io_exchange:
    call #motion_rests
    mov &OUTPUT, r13
    mov &BOARD, r15
    jne 1f
    /* a laser is off whenever nothing moves */
    mov.b B_LASER(r15), r12
    call #mask_of
    bic r14, r13
1:  xor B_OUTPUT_INVERT(r15), r13
    bit.b #BOARD_CHAIN, B_FLAGS(r15)
    jeq 2f
    call #io_latch
    call #spi_byte
    mov r12, r14
    call #spi_byte
    swpb r12
    bis r14, r12
    call #io_latch
    bic.b #P2_OUT2_OR_ENABLE, &P2OUT
    jmp 6f
2:  mov #P2_OUT1_OR_LATCH, r14
3:  rra r13
    jc 4f
    bic.b r14, &P2OUT
    jmp 5f
4:  bis.b r14, &P2OUT
5:  xor #P2_OUT1_OR_LATCH+P2_OUT2_OR_ENABLE, r14
    cmp #P2_OUT1_OR_LATCH, r14
    jne 3b
    mov.b &P1IN, r12
    inv.b r12
    rra r12
    rra r12
    rra r12
    rra r12
6:  xor B_INPUT_INVERT(r15), r12
    mov r12, &RAW
    ret

io_latch:
    bic.b #P2_OUT1_OR_LATCH, &P2OUT
    bis.b #P2_OUT1_OR_LATCH, &P2OUT
    ret

/* Sends the high byte of r13, whose halves are swapped then; the byte that came is in r12. */
spi_byte:
    swpb r13
    mov.b r13, &UCB0TXBUF
1:  bit.b #UCB_BUSY, &UCB0STAT
    jne 1b
    mov.b &UCB0RXBUF, r12
    ret

/* r14 = bit r12-1; 0 when r12 is 0 or above 16. Leaves r12 = 0 for r12 up to 16, Z as of r14. */
    .global mask_of
mask_of:
    clr r14
    tst r12
    jeq 2f
    inc r14
1:  dec r12
    jeq 2f
    rla r14
    jne 1b
    clr r12
2:  tst r14
    ret

/* r12 = level, 0 or 1, of input r12, filtered; 0 beyond those there are. Clobbers r13, r14. */
    .global input
input:
    mov &INPUT, r13
    jmp 1f
/* The same before the filter. */
    .global unfiltered
unfiltered:
    mov &RAW, r13
1:  cmp #17, r12
    jeq 2f
    call #mask_of
    clr r12
    and r13, r14
    adc r12
    ret
    /* the probe pin of the chain wiring, on when closed to ground */
2:  clr r12
    mov &BOARD, r14
    bit.b #BOARD_CHAIN, B_FLAGS(r14)
    jeq 3f
    bit.b #P1_REF_X_OR_PROBE, &P1IN
    jne 1f
    inc r12
1:  tst B_INPUT_INVERT_HIGH(r14)
    jeq 3f
    xor #1, r12
3:  ret

/* Sets output r12 on (r13 not 0) or off. Leaves r12 = 0, or 1 beyond those there are. Clobbers
   r14. */
    .global set_output
set_output:
    call #mask_of
    mov &BOARD, r12
    bit.b #BOARD_CHAIN, B_FLAGS(r12)
    jne 1f
    and #3, r14
1:  mov #1, r12
    tst r14
    jeq 2f
    dec r12
    bic r14, &OUTPUT
    tst r13
    jeq 2f
    bis r14, &OUTPUT
2:  ret

/* Outputs take the states for an occasion: r12 = offset of its masks in the profile. */
    .global output_states
output_states:
    add &BOARD, r12
    and @r12+, &OUTPUT
    bis @r12, &OUTPUT
    ret

/* r12 = the input with a role that keeps the machine from working, 0 for none; Z set for none.
   Clobbers r11, r13 to r15. */
    .global blocking
blocking:
    mov &BOARD, r15
    mov.b B_STOP(r15), r12
    call #1f
    jne 2f
    mov.b B_HOLD(r15), r12
    call #1f
    jne 2f
    mov.b B_DOOR(r15), r12
    call #1f
    jne 2f
    mov.b B_EMERGENCY(r15), r12
1:  mov r12, r11
    call #input
    tst r12
    jeq 2f
    mov r11, r12
2:  ret

/* One sample of eight inputs: a change is accepted after four samples in a row. Takes r12 = levels
   (filter_raw: they lie 6 bytes behind r13), r13 = address of the accepted ones; the low and the high
   bits of the inputs' counters lie 2 and 4 bytes behind. Leaves r12 = the inputs that went on.
   Clobbers r11, r14, r15. */
    .global filter
filter_raw:
    mov.b RAW-INPUT(r13), r12
filter:
    xor.b @r13, r12
    mov.b r12, r14
    and.b 2(r13), r14
    mov.b r14, r15
    and.b 4(r13), r15
    mov.b r12, r11
    bic.b 2(r13), r11
    mov.b r11, 2(r13)
    xor.b r14, 4(r13)
    and.b r12, 4(r13)
    xor.b r15, 0(r13)
    mov.b @r13, r12
    and.b r15, r12
    ret
