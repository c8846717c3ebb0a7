/* What the registers and bits of the link (`lang::wire`) show. Twin: firmware/src/machine/map.rs. */

    .section .text.map,"axR",@progbits
module.link.map:
/* The block of an address.
   takes r5, r8   leaves r9 at its tables, r12 the offset in it, r13 registers from there to its end, 0
   without a block */
map_find:
    mov #map_blocks, r9
1:  mov r5, r12
    sub @r9+, r12
    mov.b @r9+, r13
    tst r13
    jne 2f
    mov #UPLOAD_COUNT, r13
2:  sub r12, r13
    jeq 3f
    jlo 3f
    bit.b r8, 0(r9)
    jne 4f
3:  add #3, r9
    cmp #map_blocks_end, r9
    jne 1b
    clr r13
4:  ret

/* The register that comes next in the reply, or that holds the next bit.
   leaves r12 its value, r5 its address   for map_half: r4, r6   clobbers r8, r9, r11 to r15 */
map_next:
    mov &NEXT_REGISTER, r5
    inc &NEXT_REGISTER
    dec &REGISTERS_LEFT
    mov.b &FUNCTION, r8
    call #map_find
    cmp #4, r8
    jhs 1f
    mov r5, r12                 ; of the bits, 0 and 256 stand in registers 0 and 16
    rra r12
    rra r12
    rra r12
    rra r12
1:  mov.b 1(r9), r13
    add #MAP_LISTS, r13
2:  mov.b @r13+, r15
    mov.b @r13+, r14
    mov.b r15, r11
    sxt r11
    rra r11
    rra r11
    sub r11, r12
    jhs 2b
    add r11, r12
    bit #2, r15
    jne 4f
    tst r12
    jne map_zero
    bit #1, r15
    jne 3f
    mov.b BYTES(r14), r12
    ret
3:  mov r14, r11
    add #MAP_MICRO, r11
    br #micro_enter
4:  rla r14
    bit #1, r15
    jne 5f
    rla r12
    add r12, r14
    mov 0x200(r14), r12
    ret
5:  add #MAP_ROUTINES, r14
    br r14
map_zero:
    clr r12
    ret

MAP_ROUTINES:
map_features:
    add #AT_FEATURES, r12
map_identity:
    rla r12
    mov map_words(r12), r12
    ret
map_words:
    .word WIRE_VERSION, RELEASE, FINGERPRINT
    .if AT_FEATURES != 4
    .error "map_words is in the order of the registers"
    .endif
    .word 0                     /* the profile's hash stands elsewhere */
    .word PART_FEATURES, STORE_AREA

map_profile_hash:
    mov #B_CRC, r12
    jmp 1f
map_profile:
    rla r12
1:  tst.b &TRACING              ; T_LOCKED
    jn map_zero
    add &BOARD, r12
    mov @r12, r12
    ret

/* CRC, profile hash and cells of the stored program's header. */
map_program_header:
    mov &VM_CODE, r13
    tst r13
    jeq map_zero
    mov.b map_header_places(r12), r14
    sub r14, r13
    mov @r13, r13
    cmp #2, r12
    mov r13, r12
    jne 1f
    mov.b r12, r12
1:  ret
map_header_places:
    .byte IMAGE_CODE-HEADER_CRC, IMAGE_CODE-HEADER_PROFILE, IMAGE_CODE-HEADER_CELLS, 0

    .global free_bytes
/* r12 = the longest image that fits beside the stored one; uses r13. */
free_bytes:
    mov #AREA_BYTES, r12
    tst &STORED
    jeq 2f
    call #stored_end
    mov #AREA_END, r13
    sub r12, r13
    mov &STORED, r12
    sub #AREA, r12
    cmp r13, r12
    jhs 1f
    mov r13, r12
1:  tst r12
    jeq 2f
    sub #SLOT_HEAD, r12
2:  ret

    .global stack_free
/* r12 = bytes of the machine stack never used since reset; uses r13. */
stack_free:
    mov #POOL_END, r12
1:  mov.b @r12+, r13
    cmp.b #0xa5, r13
    jeq 1b
    sub #POOL_END+1, r12
    ret

/* The slot of the other parity reads 0, and to read it says that the event was received. */
    .global trace_slot
trace_slot:
    bis.b #T_HEARD, &TRACING
    clr r13
    cmp #TRACE_ODD_AT, r12
    rlc r13
    xor &TRACE_NUMBER, r13
    and #7, r12
    bit #1, r13
    jne 1f
    rla r12
    cmp #2*TRACE_LENGTH, r12
    jhs map_zero
    mov TRACE_NUMBER(r12), r12
    ret
1:  bic.b #T_FULL, &TRACING
    jmp map_zero

    .section .text.micro,"axR",@progbits
module.link.map$micro:
MAP_MICRO:
    /* 0 for none */
    ROUTINE_ODD program_length, module.link.map$micro
    F word STORED
    IF_EQUAL map_nothing
    F base STORED
    FR word SLOT_HEAD+6, SHORT
    RETURN
map_pool_words:
    LIT POOL_WORDS
map_nothing:
    RETURN
map_run_state:
    GET RUN
    IF_IS_NOT RUN, RUN_RUNNING, 1f
    IF_NONE RUN_FLAGS, R_WAITING, 1f
    LIT RUN_WAIT_START
1:  RETURN
    .if HAS_LINES
map_fault_line:
    F load VM_FAULT_PC
    CALL line_of
    RETURN
    .endif
    .if HAS_HALTS
    /* an effect that has not begun waits for the host */
map_waits:
    IF_NONE TRACING, T_FULL, map_nothing
    IF_ZERO EFFECT, map_nothing
    IF_SET PHASE, map_nothing
    LIT 1
    RETURN
    .endif
    /* Who finds nothing to take listens, and so does who takes what there is. */
map_print_count:
    GET PRINT_READY
    IF_SET PRINT_READY, 1f
    F clear UNHEARD
1:  RETURN
    .balign 2, 0

    .section .text.map,"axR",@progbits
/* Two bytes of text, the earlier one in the high byte. */
map_print_text:
    mov r12, r13
    rla r13
    add &PRINT_TAIL, r13
    clr r12
    call #1f
1:  swpb r12
    mov r13, r14
    and #PRINT_SIZE-1, r14
    mov.b PRINT(r14), r14
    bis r14, r12
    inc r13
    ret

/* Halves of 32-bit values, which begin at even addresses. */
map_keeps:
    mov #keep_read, r11
    jmp map_half
map_speeds:
    mov #motion_speed, r11
    jmp 1f
map_targets:
    mov #target_steps, r11
    jmp 1f
map_work_positions:
    mov #work_steps, r11
1:  cmp #6, r12
    jhs map_zero
/* takes r12 = place in the row, r11 = routine from r12 = index to r13:r12, r6 = 0 or, with the high half
   in r4, 1: values take long */
map_half:
    tst r6
    jne 1f
    inc r6
    rra r12
    call #micro_go
    mov r13, r4
    bit #1, r5
    jeq 2f
1:  mov r4, r12
2:  ret

/* Cells: of the program that runs, else those that live between runs; others are 0. */
map_cells:
    call #map_cell_at
    jhs map_zero
    mov @r12, r12
    ret
/* r12 = word of the cells   leaves r12 = its address, or carry set   clobbers r14, r15 */
map_cell_at:
    mov.b &VM_CELL_COUNT, r14
    rla r14
    bit.b #RUN_ACTIVE, &RUN
    jne 2f
    .if AT_ROOM
    mov &VM_CODE, r14
    tst r14
    jeq 2f
    call #kept_bytes
    rra r14
    .else
    clr r14
    .endif
2:  cmp r14, r12
    jhs 1f
    rla r12
    add &VM_CELLS, r12
1:  ret

    .if HAS_HALTS
/* Open calls, 0 behind the newest. */
map_calls:
    rla r12
    add #POOL, r12
    cmp &VM_CALLS, r12
    jhs map_zero
    mov @r12, r12
    ret
    .endif

map_moving:
    mov &MOVING, r12            ; and NEGATIVE
    xor #0x0700, r12            ; direction: 1 is positive
    ret

/* InterpCNC's code of the latched fault. */
map_alarm:
    cmp.b #RUN_FAULT, &RUN
    jne map_zero
    mov.b &VM_FAULT, r12
    mov.b ALARMS(r12), r12
    ret
