/* What writes the registers of the link. Twin: firmware/src/machine/map.rs. */

    .section .text.map,"axR",@progbits
/* What writes a register.
   takes r12 = offset, r13 = word   leaves r12 = 0 or exception in its low byte, nothing else is written
   then when it is not 0; keeps r5..r7, r10, and r4 from the low half of a 32-bit value to its high one */
    .set MAP_WRITERS, .-2       /* 0 is none */
/* All but the command's head lies in the pool: not during a run, nor under a command's work. */
map_write_command:
    rla r12
    cmp #4, r12
    jlo 1f
    jne 2f
    mov r13, r4
2:  bit.b #RUN_ACTIVE, &RUN
    jne 3f
    tst.b &EFFECT
    jne 3f
    add #COMMAND-COMMAND_HEAD, r12
1:  mov r13, COMMAND_HEAD(r12)
    jmp map_written
    /* 110, which has no more, is always taken */
3:  cmp #4, r12
    jne busy
map_written:
    clr r12
    ret

map_bad_address:
    mov #EX_ADDRESS, r12
    ret

map_write_outputs:
    tst.b &P1SEL                ; its sign is the chain's data line
    jn 1f
    cmp #1<<2, r13              ; outputs 1 and 2 without the chain
    jhs illegal_value
1:  mov r13, &OUTPUT
    jmp map_written

/* Takes effect at the motion's next segment. */
map_write_override:
    mov r13, r14
    sub #10, r14
    cmp #200-10+1, r14
    jhs illegal_value
    tst r12
    jeq 1f
    cmp #100-10+1, r14
    jhs illegal_value
1:  mov.b r13, OVERRIDE(r12)
    MICRO
    IF_ZERO MOVING, 1f
    DO motion_nominal
1:  DONE_
    .balign 2, 0

map_write_cell:
    call #map_cell_at
    jhs 1f
    .if HAS_COURSES
    /* slow points are of the program as it is */
    bit.b #R_COURSES, &RUN_FLAGS
    jne busy
    .endif
    mov r13, 0(r12)
    jmp map_written
1:  bit.b #RUN_ACTIVE, &RUN
    jeq refused
    jmp illegal_value

map_write_position:
    cmp #6, r12
    jhs illegal_value
    bit.b #RUN_ACTIVE, &RUN
    jne busy
    mov #set_work_position, r11
    jmp 1f
map_write_keep:
    mov #keep_write, r11
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

    /* takes r12 = offset, r13 = word */
map_write_own:
    mov r12, &TEMP
    mov r13, r12
    MICRO
    IF_IS TEMP, AT_RUN_CONTROL, 1f
    IF_IS TEMP, AT_TRACE_MODE, 4f
    IF_IS TEMP, AT_UPLOAD_CONTROL, 5f
    IF_IS TEMP, AT_UPLOAD_LENGTH, 6f
    IF_IS TEMP, AT_PRINT_TAIL, 7f
    IF_IS TEMP, AT_CHAR_IN, 8f
    FAULT EX_ADDRESS

    /* run control, the last of its request */
1:  IF_IS_NOT REGISTERS_LEFT, 1, map_illegal
    CMPI CONTROLS+1
    IF_CARRY map_illegal
    CASE 0, map_illegal
    CASE_NOT CONTROL_START, 2f
    /* an address of a slot, which is a segment's */
    IF_ZERO STORED+1, map_refused
2:  CASE_NOT CONTROL_RESTART, 3f
    DO idle
    IF_NOT_EQUAL map_busy
3:  DO control
    /* neither routine keeps a register that another word would need */
map_last:
    FAULT 0
    /* trace mode */
4:  BITS_OFF TRACING, T_ON|T_FULL
    CASE 0, 9f
    BITS_ON TRACING, T_ON|T_HEARD
9:  DONE_
    /* upload control, the last too */
5:  IF_IS_NOT REGISTERS_LEFT, 1, map_illegal
    CALL upload_control
    DO or_return
    GOTO map_last
    /* another length is another upload */
6:  F put UPLOAD
    F clear OPEN
    DONE_
    /* print: bytes before this number were taken */
7:  F put TEMP
    F sub PRINT_TAIL
    F put TEMP+2
    GET PRINT_READY
    F cmp TEMP+2
    IF_CARRY 1f
map_illegal:
    FAULT EX_VALUE
1:  F sub TEMP+2
    PUT PRINT_READY
    F word TEMP
    F put PRINT_TAIL
    F clear UNHEARD
    DONE_
    /* a character for WaitChar, ! to } */
8:  CMPI 126
    IF_CARRY map_illegal
    CMPI 33
    IF_NEGATIVE map_illegal
    PUT CHAR_IN
    DONE_
map_busy:
    FAULT EX_BUSY
map_refused:
    FAULT EX_DEVICE_FAILURE
    .balign 2, 0
