/* The serial line: USCI_A0, frame gaps on Timer0_A CCR1, the interrupts of both and the millisecond.

   A character's interrupt sets CCR1 to the end of the 3.5 characters of silence that close a frame.
   One that comes after more than 1.5 characters of silence spoils the frame (Modbus over Serial
   Line V1.02, 2.5.1.1). Above 19200 bit/s the standard's fixed 750 us and 1750 us hold.

   The receiver drops characters with wrong parity or without stop bit (UCRXEIE is 0); the CRC tells.

   FRAME is the request while LINE_STATE is LINE_LISTEN or LINE_READY, HEAD its length or SPOILED;
   then it is the ring of RING_SIZE from which the reply is sent, its places being HEAD and TAIL modulo
   RING_SIZE; TAIL is the next byte to go.

   Cycles from request to RETI's end: receive 74, transmit 49, silence 19, millisecond 24. */

    .section .tail.uart,"axR",@progbits
module.link.uart:
    .global USCIAB0RX
USCIAB0RX:
    push r12
    push r13
    mov.b &UCA0RXBUF, r12
    tst.b &LINE_STATE
    jne 3f
    mov.b &HEAD, r13
    cmp.b #FRAME_SIZE, r13      ; also true of a spoiled one
    jhs 2f
    mov.b r12, FRAME(r13)
    inc.b &HEAD
2:  mov &TA0R, r12
    tst.b r13
    jeq 2f
    mov r12, r13
    sub &TA0CCR1, r13
    add &SLACK_TICKS, r13
    jl 2f
    mov.b #SPOILED, &HEAD
2:  add &SILENCE_TICKS, r12
    mov r12, &TA0CCR1
    mov #CCIE, &TA0CCTL1
3:  pop r13
    pop r12
    reti

    .global TIMER0_A1
TIMER0_A1:
    clr &TA0CCTL1
    mov.b #LINE_READY, &LINE_STATE
    reti

    .global USCIAB0TX
USCIAB0TX:
    push r12
    mov.b &TAIL, r12
    cmp.b &HEAD, r12
    jeq 1f
    and #RING_SIZE-1, r12
    mov.b FRAME(r12), &UCA0TXBUF
    inc.b &TAIL
    jmp 2f
1:  bic.b #UCA0TXIE, &IE2
    /* once the reply has left the ring the next request may begin */
    cmp.b #LINE_LAST, &LINE_STATE
    jne 2f
    call #link_drop
2:  pop r12
    reti

    .global TIMER0_A0
TIMER0_A0:
    add #TICKS_A_MS, &TA0CCR0
    inc &MILLIS
    mov.b #1, &VM_POLL
    reti

/* mov @r13+, &address and its byte form, which LLVM's assembler refuses. */
    .macro TAKE_WORD address
    .word 0x4db2, \address
    .endm
    .macro TAKE_BYTE address
    .word 0x4df2, \address
    .endm

/* Starts the line, which a reset holds, at a rate; interrupts are on then. With Stop held 9600 8N1 and
   address 1, whatever the profile says.
   takes r12 = rate code of the board's record: rate in bits 0 and 1, parity in bits 4 and 5
   clobbers r12, r13 */
    .global uart_open
uart_open:
    bit.b #P1_STOP, &P1IN
    jne 1f
    clr r12
    mov.b #1, &ADDRESS
1:  mov r12, r13
    and #3, r13
    sub r13, r12                ; parity alone
    rla r13
    rla r13
    rla r13
    add #rates, r13
    TAKE_WORD SILENCE_TICKS
    TAKE_WORD SLACK_TICKS
    TAKE_BYTE UCA0BR0
    TAKE_BYTE UCA0BR1
    TAKE_BYTE UCA0MCTL
    /* bit 4 even, bit 5 odd: become UCPAR and UCPEN, and even wants both */
    rla.b r12
    rla.b r12
    mov.b r12, &UCA0CTL0
    rla.b r12
    bis.b r12, &UCA0CTL0
    mov.b #0x81, &UCA0CTL1      ; SMCLK, still held
    bic.b #1, &UCA0CTL1
    bis.b #UCA0RXIE, &IE2
    eint
    ret

/* Silence that ends a frame and slack (silence less the latest end of the next character), both from
   a character's end in 0.5 us; divider and modulation (SLAU144, table 15-4) for 16 MHz. A character
   is 11 bits. */
    .macro RATE bits_per_second, silence, gap
    .word \silence, \silence-(\gap), 16000000/\bits_per_second
    .word (16000000%\bits_per_second*8+\bits_per_second/2)/\bits_per_second*2
    .endm
    .macro SLOW bits_per_second
    RATE \bits_per_second, 11*2000000/\bits_per_second*7/2, 11*2000000/\bits_per_second*5/2
    .endm
    .macro FAST bits_per_second
    RATE \bits_per_second, 3500, 1500+11*2000000/\bits_per_second
    .endm
rates:
    SLOW 9600
    SLOW 19200
    FAST 57600
    FAST 115200
