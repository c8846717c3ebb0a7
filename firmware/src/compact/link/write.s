/* What writes the registers of the link. Twin: board/map.rs. */

    .section .text.map,"axR",@progbits
/* What writes a register.
   takes r12 = offset, r13 = word   leaves r12 = 0 or exception; keeps r5..r10, and r4 from the low
   half of a 32-bit value to its high one */
    .set MAP_WRITERS, .-2       /* 0 is none */
/* All but the command's head lies in the pool: not during a run, nor under a command's work. */
map_write_command:
    rla r12
    cmp #4, r12
    jlo 1f
    bit.b #RUN_ACTIVE, &RUN
    jne busy
    tst.b &EFFECT
    jne busy
    add #COMMAND-COMMAND_HEAD, r12
1:  mov r13, COMMAND_HEAD(r12)
map_written:
    clr r12
    ret

map_write_outputs:
    tst r12
    jne map_bad_address
    tst.b &P1SEL                ; its sign is the chain's data line
    jn 1f
    cmp #1<<2, r13              ; outputs 1 and 2 without the chain
    jhs illegal_value
1:  mov r13, &OUTPUT
    jmp map_written

map_write_cell:
    bit.b #RUN_ACTIVE, &RUN
    jeq refused
    call #map_cell_at
    jhs illegal_value
    mov r13, 0(r12)
    jmp map_written

map_write_position:
    cmp #6, r12
    jhs illegal_value
    bit.b #RUN_ACTIVE, &RUN
    jne busy
    mov #set_work_position, r11
    .if HAS_KEEP
    jmp 1f
map_write_keep:
    mov #keep_write, r11
    .endif
/* takes r11 = routine from r12 = index, r15:r14 = value */
1:  rra r12
    jc 2f
    mov r13, r4
    jmp map_written
2:  mov r4, r14
    mov r13, r15
    br r11

map_write_profile:
    jmp profile_word
map_write_upload:
    jmp upload_word

map_write_own:
    sub #AT_RUN_CONTROL, r12
    jeq 1f
    sub #AT_TRACE_MODE-AT_RUN_CONTROL, r12
    jeq 4f
    sub #AT_UPLOAD_CONTROL-AT_TRACE_MODE, r12
    jeq 5f
    sub #AT_UPLOAD_LENGTH-AT_UPLOAD_CONTROL, r12
    jeq 6f
    sub #AT_PRINT_TAIL-AT_UPLOAD_LENGTH, r12
    jeq 7f
    sub #AT_CHAR_IN-AT_PRINT_TAIL, r12
    jeq 8f
map_bad_address:
    mov #EX_ADDRESS, r12
    ret

    /* run control, the last of its request */
1:  cmp #1, r6
    jne illegal_value
    mov r13, r12
    dec r13
    cmp #CONTROLS, r13
    jhs illegal_value
    cmp #CONTROL_START, r12
    jne 2f
    tst &STORED
    jeq refused
2:  cmp #CONTROL_RESTART, r12
    jne 3f
    call #idle
    jne busy
3:  call #control               ; keeps no register
    mov #1, r6
    jmp map_written
    /* trace mode */
4:  bic.b #T_ON|T_FULL, &TRACING
    tst r13
    jeq map_written
    bis.b #T_ON, &TRACING
    jmp map_written
    /* upload control, the last too */
5:  cmp #1, r6
    jne illegal_value
    mov r13, r12
    call #upload_control        ; keeps no register either
    mov #1, r6
    ret
    /* another length is another upload */
6:  mov r13, &UPLOAD
    clr &OPEN
    jmp map_written
    /* print: bytes before this number were taken */
7:  mov.b &PRINT_READY, r14
    mov r13, r15
    sub &PRINT_TAIL, r15
    cmp r15, r14
    jlo illegal_value
    mov r13, &PRINT_TAIL
    sub.b r15, &PRINT_READY
    clr &UNHEARD
    jmp map_written
    /* a character for WaitChar, ! to } */
8:  mov r13, r14
    sub #33, r14
    cmp #125-33+1, r14
    jhs illegal_value
    mov.b r13, &CHAR_IN
    jmp map_written
