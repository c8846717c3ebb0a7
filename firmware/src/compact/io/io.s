/* Inputs and outputs at the pins: shift registers of the chain wiring, pins of the direct one.

   Bit order of the chain: the first byte read holds inputs 1 to 8, the first byte sent outputs 9 to
   16. While the latch is low the 74HC165 load; its rise shows what the 74HC595 were sent. */

    .section .text.io,"axR",@progbits
module.io:

poke_next:
    .short 0x4afe, 0            /* mov.b @r10+, 0(r14), which LLVM's assembler refuses */
/* For micro-code, which goes on behind them: writes bytes to peripherals, register and value, 0 at
   the end. */
    .global poke
poke:
    mov.b @r10+, r14
    tst r14
    jne poke_next
    ret

/* Makes the pins what the chain wiring needs; the direct one has them already. No output is driven before
   the first exchange. */
    .global io_open
    ROUTINE_ODD io_open, module.io
    PROFILE B_FLAGS
    TESTI BOARD_CHAIN
    IF_EQUAL 1f
    /* SPI master at 4 MHz, data valid at the rising edge: a 74HC165 at 3.3 V may take 60 ns, the chip
       wants its data 75 ns earlier. The outputs' enable stays high until the registers hold what the chip
       sends. A register's other bits are those of boot.s. */
    DO poke
    .byte UCB0CTL1, UCB_RUN|1, UCB0CTL0, UCB_MASTER, UCB0BR0, 4, UCB0CTL1, UCB_RUN
    .byte P1SEL, P1_UART|P1_SPI, P1SEL2, P1_UART|P1_SPI
    .byte P2OUT, P2_OUT1_OR_LATCH|P2_OUT2_OR_ENABLE, P2DIR, 0xff, 0
1:  RETURN
    .balign 2, 0

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
    bic.b #P2_OUT1_OR_LATCH, &P2OUT
    bis.b #P2_OUT1_OR_LATCH, &P2OUT
    call #spi_byte
    mov r12, r14
    call #spi_byte
    swpb r12
    bis r14, r12
    bic.b #P2_OUT1_OR_LATCH, &P2OUT
    bis.b #P2_OUT1_OR_LATCH, &P2OUT
    bic.b #P2_OUT2_OR_ENABLE, &P2OUT
    jmp 6f
    /* output 1 to bit 2, output 2 by way of bit 3 to bit 5; only what differs is touched */
2:  rla r13
    rla r13
    bit #8, r13
    jeq 3f
    xor #8|P2_OUT2_OR_ENABLE, r13
3:  xor.b &P2OUT, r13
    and #P2_OUT1_OR_LATCH|P2_OUT2_OR_ENABLE, r13
    xor.b r13, &P2OUT
    /* not before they have their levels */
    bis.b #P2_OUT1_OR_LATCH|P2_OUT2_OR_ENABLE, &P2DIR
    mov.b &P1IN, r12
    inv.b r12
    rra r12
    rra r12
    rra r12
    rra r12
6:  xor B_INPUT_INVERT(r15), r12
    /* a forced input has the level that it keeps behind the filter */
    xor &INPUT, r12
    bic &FORCED, r12
    xor &INPUT, r12
    mov r12, &RAW
    ret

/* Sends the high byte of r13, whose halves are swapped then; the byte that came is in r12. */
spi_byte:
    swpb r13
    mov.b r13, &UCB0TXBUF
1:  bit.b #UCB_BUSY, &UCB0STAT
    jne 1b
    mov.b &UCB0RXBUF, r12
    ret

/* r14 = bit r12-1, Z as of it; 0 when r12 is 0 or above 16. Clobbers r12. */
    .global mask_of
mask_of:
    mov #1, r14
1:  dec r12
    jeq 3f
    jn 2f
    rla r14
    jne 1b
2:  clr r14
3:  tst r14
    ret

/* r12 = level, 0 or 1, of input r12, filtered; 0 beyond those there are; Z set for 0. Clobbers r13,
   r14. */
    .global input
input:
    mov &INPUT, r13
    jmp 1f
/* The same of output r12. */
    .global output
output:
    mov &OUTPUT, r13
    jmp 1f
/* Of an input before the filter. */
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
    mov.b B_INPUT_INVERT_HIGH(r14), r12
    bit.b #P1_REF_X_OR_PROBE, &P1IN
    jne 3f
    xor #1, r12
3:  tst r12
    ret

/* Sets output r12 on (r13 not 0) or off. Leaves Z set beyond those there are. Clobbers r12, r14. */
    .global set_output
set_output:
    call #mask_of
    tst.b &P1SEL                ; its sign is the chain's data line
    jn 1f
    and #3, r14
1:  bic r14, &OUTPUT
    tst r13
    jeq 2f
    bis r14, &OUTPUT
2:  tst r14
    ret

/* Outputs take the states for an occasion: r12 = offset of its masks in the profile. */
    .global output_states
output_states:
    add &BOARD, r12
    and @r12+, &OUTPUT
    bis @r12, &OUTPUT
    ret

/* r12 = the first input that is on, 0 for none; Z set for none. Clobber r11, r13 to r15. Of the emergency
   stops, before the filter: */
    .global emergency_now
emergency_now:
    mov #B_EMERGENCY, r15
    mov #unfiltered, r11
    jmp first_on
/* Of all that keep the machine from working: */
    .global blocking
blocking:
    mov #B_STOPS, r15
    mov #input, r11
first_on:
    add &BOARD, r15
1:  mov.b @r15+, r12
    tst.b r12
    jn 2f
    call r11
    jeq 1b
    mov.b -1(r15), r12
    ret
2:  clr r12
    tst r12
    ret

/* One sample of eight inputs: a change is accepted after four samples in a row. Takes r12 = levels
   (filter_raw: they lie 6 bytes behind r13), r13 = address of the accepted ones; the low and the high
   bits of the inputs' counters lie 2 and 4 bytes behind. Leaves r12 = the inputs that went on.
   Clobbers r14, r15. */
    .global filter
filter_raw:
    mov.b RAW-INPUT(r13), r12
filter:
    xor.b @r13, r12
    mov.b r12, r14
    and.b 2(r13), r14
    mov.b r14, r15
    and.b 4(r13), r15
    xor.b r14, 4(r13)
    and.b r12, 4(r13)
    xor.b r14, r12
    mov.b r12, 2(r13)
    xor.b r15, 0(r13)
    mov.b @r13, r12
    and.b r15, r12
    ret
