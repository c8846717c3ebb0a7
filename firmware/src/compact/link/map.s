/* The registers and bits of the link (`lang::wire`), who reads and writes them. Twin: board/map.rs. */

/* One row of a block: first address, count (0: UPLOAD_COUNT), tables, list of its registers (from
   MAP_LISTS), routine that writes it (from MAP_WRITERS, 0 for none). */
    .macro MAP_BLOCK name, list, writer=MAP_WRITERS
    .word BLOCK_\name
    .byte COUNT_\name, TABLES_\name, \list-MAP_LISTS, \writer-MAP_WRITERS
    .endm

/* Registers of a list, in ascending order: a row has two bytes, 4 times the number of registers that
   it holds (1 to 31, or REST) and what they are:
   MAP_BYTE: the first is this byte of RAM, the others 0;
   MAP_CODE: the first is what this micro-code leaves in r12, which is 0 at its beginning, as are the
   others; it keeps r5 to r7;
   MAP_WORDS: the words of RAM from this one on;
   MAP_ROUTINE: takes r12 = place in the row, leaves r12 = value, keeps r5 to r7, r10. */
    .set REST, 0x20             /* a negative number */
    .macro MAP_ROW count, kind, operand
    .byte (\count)<<2 | \kind, \operand
    .skip -((\operand)>>8)      /* the assembler refuses what a byte does not hold */
    .endm
    .macro MAP_BYTE count, address
    MAP_ROW \count, 0, \address-BYTES
    .endm
    .macro MAP_CODE count, code
    MAP_ROW \count, 1, \code-MAP_MICRO
    .endm
    .macro MAP_WORDS count, address
    MAP_ROW \count, 2, (\address-0x200)/2
    .endm
    .macro MAP_ROUTINE count, routine
    MAP_ROW \count, 3, (\routine-MAP_ROUTINES)/2
    .endm

/* Below the vectors, where there is room. */
    .section .tail.blocks,"axR",@progbits
module.link.map$blocks:
map_blocks:
    MAP_BLOCK COILS, map_list_outputs
    MAP_BLOCK INPUT_BITS, map_list_status
    MAP_BLOCK STATUS_BITS, map_list_status
    MAP_BLOCK STATUS, map_list_status
    MAP_BLOCK PROBE_RESULT_TEXT, map_list_probed
    MAP_BLOCK PROBE_RESULT, map_list_probed
    MAP_BLOCK CNC_STATUS, map_list_cnc
    MAP_BLOCK COMMAND, map_list_command, map_write_command
    MAP_BLOCK OUTPUTS, map_list_outputs, map_write_outputs
    MAP_BLOCK POSITIONS, map_list_positions, map_write_position
    MAP_BLOCK SPEEDS, map_list_speeds
    MAP_BLOCK CELLS, map_list_cells, map_write_cell
    .if HAS_KEEP
    MAP_BLOCK KEEPS, map_list_keeps, map_write_keep
    .endif
    MAP_BLOCK OWN, map_list_own, map_write_own
    MAP_BLOCK PROFILE_WINDOW, map_list_profile, map_write_profile
    MAP_BLOCK UPLOAD_WINDOW, map_list_upload, map_write_upload
map_blocks_end:

    .section .text.lists,"axR",@progbits
module.link.map$lists:
MAP_LISTS:
map_list_own:
    MAP_ROUTINE AT_PROFILE_HASH-AT_VERSION, map_identity
    MAP_ROUTINE 1, map_profile_hash
    MAP_ROUTINE 2, map_features
    MAP_ROUTINE 1, free_bytes
    MAP_CODE 1, program_length
    MAP_ROUTINE AT_RESET_CAUSE-AT_PROGRAM_CRC, map_program_header
    MAP_BYTE 1, CAUSE
    MAP_ROUTINE 1, stack_free
    MAP_CODE 1, map_missed
    MAP_CODE AT_RUN_STATE-AT_POOL_WORDS_REGISTER, map_pool_words
    MAP_CODE 1, map_run_state
    MAP_BYTE 1, VM_FAULT
    .if HAS_LINES
    MAP_CODE 1, map_fault_pc
    MAP_CODE 1, map_fault_line
    .else
    MAP_CODE 2, map_fault_pc    /* and line 0 */
    .endif
    MAP_BYTE 1, FAULT_IN
    MAP_CODE 1, map_program_counter
    MAP_BYTE 1, LAST_END
    MAP_WORDS 1, RUNS
    MAP_BYTE 1, HOMED
    MAP_CODE 1, map_blocking
    MAP_WORDS 6, ACTUAL
    MAP_WORDS 6, STEPS
    MAP_CODE AT_TRACE_MODE-AT_COMMANDED-6, map_nothing
    MAP_CODE AT_UPLOAD_LENGTH-AT_TRACE_MODE, map_trace_mode
    MAP_WORDS 1, UPLOAD
    MAP_BYTE 31, REFUSAL
    MAP_CODE AT_TRACE_EVEN-AT_UPLOAD_RESULT-31, map_nothing
    MAP_ROUTINE AT_PRINT_COUNT-AT_TRACE_EVEN, trace_slot
    MAP_CODE 1, map_print_count
    MAP_WORDS 1, PRINT_TAIL
    MAP_ROUTINE AT_CHAR_OUT-AT_PRINT_TEXT, map_print_text
    MAP_WORDS 1, CHAR_OUT
    MAP_BYTE REST, CHAR_IN
map_list_status:
    MAP_WORDS AT_INPUTS_HIGH, INPUT
    MAP_CODE AT_MOVING-AT_INPUTS_HIGH, map_probe_input
    MAP_ROUTINE 1, map_moving
    MAP_CODE 1, map_homing
    MAP_CODE AT_PLC_STATUS-AT_LIMITS, map_limit_switches
    MAP_CODE 1, map_plc_status
    MAP_CODE 1, map_probing
    MAP_BYTE AT_WORK_POSITIONS-AT_PROBE_ERROR, PROBE_ERROR
map_list_positions:
    MAP_ROUTINE AT_ACTUAL_SPEEDS-AT_WORK_POSITIONS, map_work_positions
map_list_speeds:
    MAP_ROUTINE AT_TARGETS-AT_ACTUAL_SPEEDS, map_speeds
    MAP_ROUTINE REST, map_targets
map_list_cnc:
    MAP_CODE AT_CNC_STATE, map_command_room
    MAP_CODE 1, map_cnc_state
    MAP_ROUTINE REST, map_alarm
map_list_outputs:
    MAP_WORDS 1, OUTPUT
map_list_upload:
    MAP_CODE REST, map_nothing
map_list_command:
    MAP_WORDS 2, COMMAND_HEAD
    MAP_WORDS REST, COMMAND+4
map_list_probed:
    MAP_WORDS 6, PROBED
    MAP_CODE REST, map_nothing
map_list_cells:
    MAP_ROUTINE REST, map_cells
    .if HAS_KEEP
map_list_keeps:
    MAP_ROUTINE REST, map_keeps
    .endif
map_list_profile:
    MAP_ROUTINE REST, map_profile

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
map_blocking:
    DO blocking
    RETURN
map_pool_words:
    LIT POOL_WORDS
map_nothing:
    RETURN
map_missed:
    F load MISSED
    F add LATE
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
map_program_counter:
    F load EFFECT_PC
    GOTO 1f
map_fault_pc:
    F load VM_FAULT_PC
1:  F sub VM_CODE
    RETURN
map_trace_mode:
    GET TRACING
    ANDI T_ON
    RETURN
    /* Who finds nothing to take listens, and so does who takes what there is. */
map_print_count:
    GET PRINT_READY
    IF_SET PRINT_READY, 1f
    F clear UNHEARD
1:  RETURN
map_probe_input:
    LIT 17
    DO input
    RETURN
map_command_room:
    CALL idle
    IF_NOT_EQUAL 1b
    LIT COMMAND_WORDS
    RETURN
map_plc_status:
    IF_NONE RUN, RUN_ACTIVE, 1b
    LIT16 1<<10
    RETURN

    /* bits of axes in TEMP, in TEMP+1 */
map_homing:
    F clear TEMP
    GET HOMING_ERROR
    PUT TEMP+1
    CALL map_homes
    IF_CARRY map_temp
    DO axis_n
    DO axis_bit
    PUT TEMP
map_temp:
    F word TEMP
    RETURN
map_probing:
    F clear TEMP
    IF_IS_NOT EFFECT, OP_PROBE, map_temp
    DO axis_n
    DO axis_bit
    PUT TEMP+1
    GOTO map_temp
    /* Reference switches that are closed, at the negative end, at the positive one. */
map_limit_switches:
    F clear TEMP
    DO micro_first_axis
1:  DO axis_at
    CALL reference_at
    DO input
    IF_EQUAL 3f
    FR word A_FLAGS, SHORT
    TESTI AXIS_HOME_POSITIVE
    IF_EQUAL 2f
    DO axis_bit
    AXIS_ON TEMP+1
    GOTO 3f
2:  DO axis_bit
    AXIS_ON TEMP
3:  NEXT_AXIS 1b
    GOTO map_temp

    /* InterpCNC's state word */
map_cnc_state:
    F clear TEMP
    IF_IS_NOT RUN, RUN_FAULT, 1f
    LET TEMP, 1<<0
1:  IF_NONE RUN, RUN_ACTIVE, 2f
    LET TEMP, 1<<3
    IF_IS_NOT RUN, RUN_PAUSED, 2f
    LET TEMP, 1<<3|1<<4
2:  CALL map_homes
    IF_CARRY 3f
    BITS_ON TEMP, 1<<2
3:  PROFILE B_DOOR
    DO input
    IF_EQUAL 4f
    BITS_ON TEMP, 1<<6
4:  PROFILE B_EMERGENCY
    DO input
    IF_EQUAL map_temp
    LET TEMP+1, 1<<(8-8)
    GOTO map_temp

    /* Carry unless an axis homes. */
    ROUTINE_ODD map_homes, module.link.map$micro
    GET EFFECT
    ADDI -OP_HOME
    CMPI OP_PROBE-OP_HOME
    RETURN
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
    .if HAS_KEEP
map_keeps:
    mov #keep_read, r11
    jmp map_half
    .endif
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

/* Cells, 0 without a run or beyond the program's. */
map_cells:
    bit.b #RUN_ACTIVE, &RUN
    jeq map_zero
    call #map_cell_at
    jhs map_zero
    mov @r12, r12
    ret
/* r12 = word of the cells   leaves r12 = its address, or carry set   clobbers r14 */
map_cell_at:
    mov.b &VM_CELL_COUNT, r14
    rla r14
    cmp r14, r12
    jhs 1f
    rla r12
    add &VM_CELLS, r12
1:  ret

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
