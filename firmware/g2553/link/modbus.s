/* The Modbus RTU slave: one request, checked whole, then its reply made while it is sent, so that a
   reply may be longer than FRAME (64 registers are 133 bytes). The twin is modbus.rs.
   Source: Modbus Application Protocol V1.1b3 (functions, exceptions), Modbus over Serial Line V1.02
   (address, CRC, broadcast).

   Registers in this file, in map.s and in write.s:
   r5 address, of a write the offset in its block   r6 count
   r7 function less 1, but 4 and 5 for 15 and 16   r8 table: bit n-1 for reading function n,
   which FUNCTION keeps while that function's data is being sent
   r9 tables in the row of the block   r10 next byte of data */

    .section .text.modbus,"axR",@progbits
module.link.modbus:
/* Answers a frame that has come and feeds a reply under way; has the chip reset when that was asked
   for and the reply stands in the ring. May destroy all registers. */
    .global link_poll
link_poll:
    tst.b &FUNCTION
    jne link_feed
    cmp.b #LINE_READY, &LINE_STATE
    jne link_restart
    mov.b &HEAD, r4
    cmp.b #4, r4
    jl link_drop                ; too short, or spoiled, which is -1
    mov #FRAME, r15
    mov r4, r11
    call #crc_of
    tst r12
    jne link_drop
    mov.b &FRAME, r13
    tst r13
    jeq 2f                      ; broadcast
    cmp.b &ADDRESS, r13
    jne link_drop
2:  bis.b #R_HOST, &RUN_FLAGS
    /* 2 s for a jog, which has the time when nothing else does */
    tst.b &EFFECT
    jne 1f
    mov #2000, &TIME
1:  call #link_perform
    tst.b &FRAME
    jeq link_drop
    mov #3, r6                  ; the reply's head, its data comes by FUNCTION
    tst.b r12
    jne 3f
    tst.b &FUNCTION
    jne 4f
    rla r6                      ; a write is answered by its first bytes
    jmp 4f
3:  bis.b #0x80, &FRAME+1
    mov.b r12, &FRAME+2
4:  mov #FRAME, r15
    mov r6, r11
    call #crc_of
    mov r12, &REPLY_CRC
    mov r6, &HEAD               ; and TAIL = 0
    tst.b &FUNCTION
    jne link_poll
link_finish:
    call #link_crc
    call #link_crc
    mov #LINE_LAST, &LINE_STATE      ; and no FUNCTION
    jmp link_send               ; should all be out already: let its interrupt see the state
link_drop:
    clr &HEAD                   ; and TAIL
    clr &LINE_STATE             ; LINE_LISTEN, and no FUNCTION
    ret

/* Puts more of the reply into the ring while there is room for two registers and the CRC. Both
   halves of a 32-bit value go there at once, so that they are of one instant. */
link_feed:
    mov.b &HEAD, r12
    sub.b &TAIL, r12
    cmp.b #RING_SIZE-6, r12
    jhs link_send
    clr r6
1:  cmp.b #4, &FUNCTION
    jhs 5f
    mov #8, r6                  ; a byte of bits, filled up with 0
2:  mov &REGISTERS_LEFT, r12
    tst r12
    jeq 4f
    call #map_next
    and #15, r5
    jeq 4f
3:  rra r12
    dec r5
    jne 3b
4:  rra r12
    rrc.b r10
    dec r6
    jne 2b
    jmp 6f
5:  call #map_next
    mov r12, r10
    mov r12, r13
    swpb r13
    call #link_put
6:  mov r10, r13
    call #link_put
    tst &REGISTERS_LEFT
    jeq link_finish
    bit #1, &NEXT_REGISTER
    jne 1b
    /* values take long, the step engine must not starve; it keeps no register */
    call #motion_poll
    .if HAS_COURSES
    /* nor must a line wait that is to be planned while the one before plays */
    bit.b #M_THROUGH, &MOTION
    jeq link_poll
    ret
    .else
    jmp link_poll
    .endif

    /* What has been put into the ring goes out by interrupts, in 10 ms at most, before the watchdog
       bites. */
link_restart:
    tst.b &RUN_FLAGS
    jge link_done
1:  jmp 1b

/* Appends the CRC's next byte: behind its low one it is the high one shifted down. */
link_crc:
    mov &REPLY_CRC, r13
/* Appends a byte to the reply and its CRC. It goes out once the ring is full or the reply whole: what else has to be done
   in between makes no gap in it.
   takes r13 = byte in its low half   clobbers r12 to r14 */
link_put:
    mov.b r13, r13
    mov &REPLY_CRC, r12
    mov.b &HEAD, r14
    and #RING_SIZE-1, r14
    mov.b r13, FRAME(r14)
    inc.b &HEAD
    call #pasapas_crc16
    mov r12, &REPLY_CRC
link_done:
    ret
link_send:
    bis.b #UCA0TXIE, &IE2
    ret

/* Executes a request.
   takes r4 = length of the frame, r11 = 0
   leaves r12 = 0 or exception in its low byte, FUNCTION when it reads   clobbers all */
link_perform:
    mov #FRAME+1, r10
    mov #EX_FUNCTION, r12
    mov.b @r10+, r7
    dec r7
    cmp #6, r7
    jlo 1f
    sub #14, r7
    cmp #2, r7
    jhs link_refused
    add #4, r7
    mov r7, r11
1:  mov.b link_tables(r7), r8
    add #EX_VALUE-EX_FUNCTION, r12
    mov @r10+, r5
    swpb r5
    mov @r10, r6
    swpb r6
    cmp #4, r7
    jlo 3f
    tst r11
    jne 3f
    /* 5 and 6: the value is the first of one */
    cmp #4, r8
    jhs 2f
    tst r6
    jeq 2f
    cmp #0xff00, r6
    jne link_refused
2:  mov #1, r6
    jmp 6f
    /* r11 = bytes of data, 1 to 250 */
3:  mov r6, r11
    dec r11
    cmp #4, r8
    jhs 4f
    rra r11
    rra r11
    rra r11
    jmp 5f
4:  rlc r11                     ; carry is set
    jc link_refused
5:  cmp #250, r11
    jhs link_refused
    inc r11
    cmp #4, r7
    jlo 6f
    incd r10
    mov.b @r10+, r13
    cmp r13, r11
    jne link_refused
    sub r13, r4
    dec r4
6:  cmp #8, r4
    jne link_refused
    call #map_find
    cmp r6, r13
    jlo map_bad_address
    mov r6, &REGISTERS_LEFT
    cmp #4, r7
    jhs link_write
    mov.b r11, &FRAME+2
    mov r5, &NEXT_REGISTER
    mov.b r8, &FUNCTION
    clr r12
link_refused:
    ret

/* Writes r6 values from r10 on into the block at r9, from its offset r12 on.
   leaves r12 = 0 or exception */
link_write:
    mov r12, r5
    cmp #4, r8
    jlo link_write_bits
    mov.b 2(r9), r7
    tst r7
    jeq map_bad_address
    add #MAP_WRITERS, r7
    tst.b 0(r9)
    jge link_write_words
    /* function 6 sets a 32-bit value by its low register, extending the sign */
    tst r11
    jne 1f
    mov.b @r10, r13
    sxt r13
    swpb r13
    sxt r13
    mov r13, 2(r10)
    mov #2, r6
1:  mov r5, r13
    bis r6, r13
    mov #EX_VALUE, r12
    bit #1, r13
    jne link_refused
link_write_words:
    mov.b @r10+, r15
    swpb r15
    mov.b @r10+, r13
    bis r15, r13
    mov r5, r12
    call r7
    tst r12
    jne 9f
    inc r5
    dec r6
    jne link_write_words
    /* the command's number starts it; its arguments may have come before */
    cmp #BLOCK_COMMAND/256+BLOCK_COMMAND%256*256, &FRAME+2
    jne 9f
    br #command_execute
9:  ret

link_write_bits:
    mov.b @r10+, r8
    mov.b @r10, r13
    swpb r13
    bis r13, r8
1:  clr r13
    rra r8
    rlc r13
    inc r5
    mov r5, r12
    call #set_output
    mov #EX_ADDRESS, r12
    jeq 9b
    dec r6
    jne 1b
    jmp map_written

/* r8 by r7. */
link_tables:
    .byte 1, 2, 4, 8, 1, 4
