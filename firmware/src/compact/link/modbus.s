/* The Modbus RTU slave: one request, checked whole, then its reply made while it is sent, so that a
   reply may be longer than FRAME (64 registers are 133 bytes). The twin is modbus.rs.
   Source: Modbus Application Protocol V1.1b3 (functions, exceptions), Modbus over Serial Line V1.02
   (address, CRC, broadcast).

   Registers in this file and in map.s:
   r5 address, of a write the offset in its block   r6 count   r7 function
   r8 table: bit n-1 for reading function n   r9 row of the block   r10 next byte of data */

/* push &address and pop &address, which LLVM's assembler refuses. */
    .macro PUSH_WORD address
    .word 0x1212, \address
    .endm
    .macro POP_WORD address
    .word 0x41b2, \address
    .endm

    .section .text.modbus,"axR",@progbits
/* Answers a frame that has come and feeds a reply under way; resets the chip when that was asked for
   and the line rests. May destroy all registers. */
    .global link_poll
link_poll:
    cmp.b #READY, &LINE_STATE
    jne link_feed
    mov.b &HEAD, r4
    cmp.b #4, r4
    jl link_drop                     ; too short, or spoiled, which is -1
    mov #FRAME, r10
    mov r4, r9
    mov #-1, r12
1:  mov.b @r10+, r13
    call #pasapas_crc16
    dec r9
    jne 1b
    tst r12
    jne link_drop
    mov.b &FRAME, r13
    tst r13
    jeq 2f                      ; broadcast
    mov #1, r12
    tst.b &RUN_FLAGS            ; R_ADDRESS_1 is its sign
    jn 1f
    mov &BOARD, r12
    mov.b B_ADDRESS(r12), r12
1:  cmp r12, r13
    jne link_drop
2:  clr &SILENT
    bis.b #R_HOST, &RUN_FLAGS
    call #link_perform
    tst.b &FRAME
    jeq link_drop
    mov #6, r6                  ; a write is answered by its first bytes
    tst r12
    jeq 3f
    bis.b #0x80, &FRAME+1
    jmp 4f
3:  tst.b &FUNCTION
    jeq 5f
    mov r11, r12
4:  mov.b r12, &FRAME+2         ; exception, or bytes of data
    mov #3, r6
5:  clr &HEAD                   ; and TAIL
    mov.b #SENDING, &LINE_STATE
    mov #-1, &REPLY_CRC
    mov #FRAME, r10
6:  mov.b @r10+, r13
    call #link_put
    dec r6
    jne 6b
    tst.b &FUNCTION
    jne link_feed
link_finish:
    mov &REPLY_CRC, r13
    call #link_put_only
    swpb r13
    call #link_put_only
    mov #LAST, &LINE_STATE      ; and no FUNCTION
    ret
link_drop:
    clr &HEAD                   ; and TAIL
    clr &LINE_STATE             ; LISTEN, and no FUNCTION
    ret

/* Puts more of the reply into the ring while there is room for a register and the CRC. */
link_feed:
    mov.b &FUNCTION, r7
    tst r7
    jeq link_restart
    mov.b &HEAD, r12
    sub.b &TAIL, r12
    jc 1f
    add.b #FRAME_SIZE, r12
1:  cmp.b #FRAME_SIZE-4, r12
    jhs link_done
    mov.b link_masks-1(r7), r8
    cmp #3, r7
    jhs 5f
    mov #8, r6                  ; a byte of bits, filled up with 0
2:  mov &REGISTERS_LEFT, r12
    tst r12
    jeq 4f
    call #link_next
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
5:  call #link_next
    mov r12, r10
    mov r12, r13
    swpb r13
    call #link_put
6:  mov r10, r13
    call #link_put
    tst &REGISTERS_LEFT
    jne link_feed
    jmp link_finish

link_restart:
    bit.b #R_RESTART, &RUN_FLAGS
    jeq link_done
    cmp.b &TAIL, &HEAD
    jne link_done
    bit.b #UCBUSY, &UCA0STAT
    jne link_done
    clr &WATCHDOG               ; without its password: reset
link_done:
    ret

/* The register, or the one that holds the bit, that comes next in the reply.
   takes r7, r8   leaves r12 its value, r5 its address   clobbers r9, r11..r15 */
link_next:
    mov &NEXT_REGISTER, r5
    inc &NEXT_REGISTER
    dec &REGISTERS_LEFT
    br #map_read

/* Appends a byte to the reply and its CRC.
   takes r13 = byte in its low half   leaves r13 = byte   clobbers r12, r14 */
link_put:
    mov.b r13, r13
    mov &REPLY_CRC, r12
    call #pasapas_crc16
    mov r12, &REPLY_CRC
/* The same without the CRC; keeps r12. */
link_put_only:
    mov.b &HEAD, r14
    mov.b r13, FRAME(r14)
    inc.b r14
    cmp.b #FRAME_SIZE, r14
    jne 1f
    clr.b r14
1:  mov.b r14, &HEAD
    bis.b #UCA0TXIE, &IE2
    ret

/* Executes a request.
   takes r4 = length of the frame
   leaves r12 = 0 or exception; FUNCTION and r11 = bytes of data when it reads
   clobbers all but r4 */
link_perform:
    mov.b &FRAME+1, r7
    mov #EX_FUNCTION, r12
    mov r7, r13
    dec r13
    cmp #6, r13
    jlo 1f
    sub #14, r13                ; 15, 16 are like 5, 6
    cmp #2, r13
    jhs link_refused
    add #4, r13
1:  mov.b link_masks(r13), r8
    mov #EX_VALUE, r12
    mov &FRAME+2, r5
    swpb r5
    mov &FRAME+4, r6
    swpb r6
    mov #FRAME+4, r10
    cmp #5, r7
    jlo 3f
    cmp #7, r7
    jhs 3f
    bit #3, r8
    jeq 2f
    tst r6
    jeq 2f
    cmp #0xff00, r6
    jne link_refused
2:  mov #1, r6                  ; 5 and 6: the value is the first of one
    jmp 5f
    /* bytes of data: 1 to 250 */
3:  mov r6, r11
    bit #3, r8
    jeq 4f
    add #7, r11
    rra r11
    rra r11
    rra r11
    jmp 6f
4:  rla r11
    jc link_refused
6:  mov r11, r13
    dec r13
    cmp #250, r13
    jhs link_refused
    cmp #5, r7
    jlo 5f
    mov #FRAME+7, r10
    mov.b &FRAME+6, r13
    cmp r13, r11
    jne link_refused
    sub r13, r4
    dec r4
5:  cmp #8, r4
    jne link_refused
    call #map_find
    cmp r6, r13
    jlo link_no_address
    cmp #5, r7
    jhs link_write
    mov.b r7, &FUNCTION
    mov r5, &NEXT_REGISTER
    mov r6, &REGISTERS_LEFT
    clr &LATCHED
link_ok:
    clr r12
link_refused:
    ret
link_no_address:
    mov #EX_ADDRESS, r12
    ret

/* Writes r6 values from r10 on into the block at r9, from its offset r12 on.
   leaves r12 = 0 or exception */
link_write:
    mov r12, r5
    mov.b 5(r9), r13
    tst r13
    jeq link_no_address
    bit #3, r8
    jne link_write_bits
    rla r13
    mov r13, r8
    add #MAP_WRITERS, r8
    mov #EX_VALUE, r12
    tst.b 3(r9)
    jge 2f
    /* function 6 sets a 32-bit value by its low register, extending the sign */
    cmp #6, r7
    jne 1f
    mov.b &FRAME+4, r13
    swpb r13
    sxt r13
    mov r13, &FRAME+6
    mov #2, r6
1:  mov r5, r13
    bis r6, r13
    bit #1, r13
    jne link_refused
2:  cmp #map_command_block, r9
    jne link_write_words
    bit.b #RUN_ACTIVE, &RUN
    jne 3f
    tst.b &EFFECT
    jeq link_write_words
    /* The buffer lies in the pool, which the program uses: what may be commanded then has one
       argument at most. */
3:  mov #EX_BUSY, r12
    mov r5, r13
    add r6, r13
    cmp #3, r13
    jhs link_refused
    PUSH_WORD COMMAND
    PUSH_WORD COMMAND+2
    call #link_write_words
    POP_WORD COMMAND+2
    POP_WORD COMMAND
    ret

link_write_words:
    call #link_take
    mov r13, r14
    tst.b 3(r9)
    jge 1f
    call #link_take
    mov r13, r15
    dec r6
1:  mov r5, r12
    call r8
    tst r12
    jne 9f
    inc r5
    tst.b 3(r9)
    jge 2f
    inc r5
2:  dec r6
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
    rla r12                     ; 1 becomes EX_ADDRESS
    jne 9b
    dec r6
    jne 1b
    ret

/* The next word of the request's data.
   takes r10   leaves r13   clobbers r15 */
link_take:
    mov.b @r10+, r15
    swpb r15
    mov.b @r10+, r13
    bis r15, r13
    ret

/* Tables by function 1 to 6; 15 and 16 are like 5 and 6. */
link_masks:
    .byte 1, 2, 4, 8, 1, 4
