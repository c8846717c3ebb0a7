/* The registers and bits of the link (`lang::wire`): blocks, what reads them and what writes them.
   The twin is board/map.rs. */

/* One row of a block: first address, count (0: UPLOAD_COUNT), tables, list of its registers (from
   MAP_KEYS), routine that writes it (from MAP_WRITERS, in words, 0 for none). */
    .macro MAP_BLOCK name, list, writer=MAP_WRITERS
    .word BLOCK_\name
    .byte COUNT_\name, TABLES_\name, \list-MAP_KEYS, (\writer-MAP_WRITERS)/2
    .endm

/* Registers of a list, in ascending order. A row holds from its offset to that of the next:
   MAP_VALUE: this number, at that offset only; MAP_WORD, MAP_BYTE: of RAM, at
   that offset only; MAP_CODE: a routine
   takes r12 = offset from the row's and leaves r12 = value, keeping r4..r10. */
    .macro MAP_VALUE offset, value
    .subsection 1
    .byte (\offset-1)&0xff
    .subsection 2
    .word \value
    .subsection 0
    .endm
    .set IN_WORD, 0x2000
    .set IN_BYTE, 0x4000
    .macro MAP_WORD offset, address
    MAP_VALUE \offset, IN_WORD+\address
    .endm
    .macro MAP_BYTE offset, address
    MAP_VALUE \offset, IN_BYTE+\address
    .endm
    .macro MAP_CODE offset, routine
    MAP_VALUE \offset, \routine
    .endm
    .macro MAP_LIST name
    .subsection 1
\name:
    .subsection 0
    .endm

    .section .text.map,"axR",@progbits
map_blocks:
    MAP_BLOCK COILS, map_list_outputs, map_write_outputs
    MAP_BLOCK INPUT_BITS, map_list_status
    MAP_BLOCK STATUS_BITS, map_list_status
    MAP_BLOCK STATUS, map_list_status
    MAP_BLOCK PROBE_RESULT_TEXT, map_list_probed
    MAP_BLOCK PROBE_RESULT, map_list_probed
    MAP_BLOCK CNC_STATUS, map_list_cnc
map_command_block:
    MAP_BLOCK COMMAND, map_list_command, map_write_command
    MAP_BLOCK OUTPUTS, map_list_outputs, map_write_outputs
    MAP_BLOCK POSITIONS, map_list_positions, map_write_position
    MAP_BLOCK SPEEDS, map_list_speeds
    MAP_BLOCK OVERRIDES, map_list_overrides, map_write_override
    MAP_BLOCK CELLS, map_list_cells, map_write_cell
    MAP_BLOCK KEEPS, map_list_keeps, map_write_keep
    MAP_BLOCK OWN, map_list_own, map_write_own
    MAP_BLOCK PROFILE_WINDOW, map_list_profile, map_write_profile
    MAP_BLOCK UPLOAD_WINDOW, map_list_upload, map_write_upload
map_blocks_end:

    .subsection 1
MAP_KEYS:
    .subsection 2
    .p2align 1
MAP_VALUES:
    .subsection 0

MAP_LIST map_list_own
    MAP_VALUE AT_VERSION, WIRE_VERSION
    MAP_VALUE AT_FIRMWARE_VERSION, RELEASE
    MAP_CODE AT_ISA_FINGERPRINT, map_fingerprint
    MAP_CODE AT_PROFILE_HASH, map_profile_hash
    MAP_VALUE AT_FEATURES, PART_FEATURES
    MAP_VALUE AT_AREA_BYTES, STORE_AREA
    MAP_CODE AT_FREE_BYTES, free_bytes
    MAP_CODE AT_PROGRAM_LENGTH, program_length
    MAP_CODE AT_PROGRAM_CRC, map_program_header
    MAP_BYTE AT_RESET_CAUSE, CAUSE
    MAP_CODE AT_STACK_FREE, stack_free
    MAP_CODE AT_MISSED_DEADLINES, map_missed
    MAP_VALUE AT_POOL_WORDS_REGISTER, POOL_WORDS
    MAP_CODE AT_RUN_STATE, map_run_state
    MAP_BYTE AT_FAULT, VM_FAULT
    MAP_CODE AT_FAULT_PC, map_fault_pc
    MAP_CODE AT_FAULT_LINE, map_fault_line
    MAP_BYTE AT_FAULT_INPUT, FAULT_IN
    MAP_CODE AT_PROGRAM_COUNTER, map_program_counter
    MAP_BYTE AT_LAST_END, LAST_END
    MAP_WORD AT_RUN_COUNT, RUNS
    MAP_BYTE AT_HOMED, HOMED
    MAP_CODE AT_BLOCKING_INPUT, blocking
    MAP_CODE AT_MACHINE_POSITIONS, map_machine_positions
    MAP_CODE AT_COMMANDED, map_commanded
    MAP_CODE AT_TRACE_MODE, map_trace_mode
    MAP_VALUE AT_TRACE_MODE+1, 0
    MAP_WORD AT_UPLOAD_LENGTH, UPLOAD
    MAP_BYTE AT_UPLOAD_RESULT, REFUSAL
    MAP_CODE AT_TRACE_EVEN, trace_slot
    MAP_BYTE AT_PRINT_COUNT, PRINT_READY
    MAP_WORD AT_PRINT_TAIL, PRINT_TAIL
    MAP_CODE AT_PRINT_TEXT, map_print_text
    MAP_WORD AT_CHAR_OUT, CHAR_OUT
    MAP_BYTE AT_CHAR_IN, CHAR_IN
MAP_LIST map_list_status
    MAP_WORD 0, INPUT
    MAP_CODE AT_INPUTS_HIGH, map_probe_input
    MAP_VALUE AT_INPUTS_HIGH+1, 0
    MAP_CODE AT_MOVING, map_moving
    MAP_CODE AT_HOMING, map_homing
    MAP_CODE AT_LIMITS, map_limit_switches
    MAP_VALUE AT_LIMITS+1, 0
    MAP_CODE AT_PLC_STATUS, map_plc_status
    MAP_CODE AT_PROBING, map_probing
    MAP_BYTE AT_PROBE_ERROR, PROBE_ERROR
    MAP_CODE AT_WORK_POSITIONS, map_work_positions
    MAP_CODE AT_ACTUAL_SPEEDS, map_speeds
    MAP_CODE AT_TARGETS, map_targets
MAP_LIST map_list_cnc
    MAP_CODE AT_COMMAND_ROOM, map_command_room
    MAP_VALUE AT_COMMAND_ROOM+1, 0
    MAP_CODE AT_CNC_STATE, map_cnc_state
    MAP_CODE AT_CNC_ALARM, map_alarm
MAP_LIST map_list_outputs
    MAP_WORD 0, OUTPUT
MAP_LIST map_list_command
    MAP_CODE 0, map_command_word
MAP_LIST map_list_probed
    MAP_CODE 0, map_probed
MAP_LIST map_list_positions
    MAP_CODE 0, map_work_positions
MAP_LIST map_list_speeds
    MAP_CODE 0, map_speeds
MAP_LIST map_list_overrides
    MAP_VALUE 0, 100
    MAP_VALUE 1, 100
MAP_LIST map_list_cells
    MAP_CODE 0, map_cells
MAP_LIST map_list_keeps
    MAP_CODE 0, map_keeps
MAP_LIST map_list_profile
    MAP_CODE 0, map_profile
MAP_LIST map_list_upload
    MAP_VALUE 0, 0
    .subsection 1
    .byte 0xff
    .subsection 0

/* The block of an address.
   takes r5, r8   leaves r9 its row, r12 the offset in it, r13 registers from there to its end, 0
   without a block */
map_find:
    mov #map_blocks, r9
1:  mov r5, r12
    sub @r9, r12
    mov.b 2(r9), r13
    tst r13
    jne 2f
    mov #UPLOAD_COUNT, r13
2:  sub r12, r13
    jeq 3f
    jlo 3f
    bit.b r8, 3(r9)
    jne 4f
3:  add #6, r9
    cmp #map_blocks_end, r9
    jne 1b
    clr r13
4:  ret

/* The register that comes next in the reply, or that holds the next bit.
   takes r7, r8   leaves r12 its value, r5 its address   clobbers r4, r9, r11..r15 */
map_next:
    mov &NEXT_REGISTER, r5
    inc &NEXT_REGISTER
    dec &REGISTERS_LEFT
/* The same at address r5. */
map_read:
    call #map_find
    cmp #2, r7
    jhs 1f
    mov r5, r12                 ; of the bits, 0 and 256 stand in registers 0 and 16
    rra r12
    rra r12
    rra r12
    rra r12
1:  mov.b 4(r9), r13
    add #MAP_KEYS, r13
    mov.b r12, r12
    /* the list's last row whose offset is not above; its first one and the next list have FF here */
2:  mov.b @r13+, r15
    cmp.b r12, 0(r13)
    jlo 2b
    inc.b r15
    sub r15, r12
    sub #MAP_KEYS+1, r13
    rla r13
    mov MAP_VALUES(r13), r13
    /* routines lie in the upper half of memory */
    tst r13
    jn 5f
    tst r12
    jne map_zero
    mov r13, r14
    bic #IN_WORD+IN_BYTE, r14
    rla r13
    jn 4f
    rla r13
    jn 3f
    mov r14, r12
    ret
3:  mov @r14, r12
    ret
4:  mov.b @r14, r12
    ret
5:  br r13

map_zero:
    clr r12
    ret

map_fingerprint:
    mov #FINGERPRINT, r12
    ret
map_profile_hash:
    mov #B_CRC, r12
    jmp 1f
map_profile:
    rla r12
1:  add &BOARD, r12
    mov @r12, r12
    ret

/* CRC, profile hash and cells of the stored program's header. */
map_program_header:
    mov &VM_CODE, r13
    tst r13
    jeq map_zero
    mov.b map_header_places(r12), r14
    add r14, r13
    mov -IMAGE_CODE(r13), r13
    cmp #2, r12
    mov r13, r12
    jne 1f
    mov.b r12, r12
1:  ret
map_header_places:
    .byte HEADER_CRC, HEADER_PROFILE, HEADER_CELLS, 0

map_missed:
    mov &MISSED, r12
    add &LATE, r12
    ret
map_run_state:
    mov.b &RUN, r12
    cmp #RUN_RUNNING, r12
    jne 1f
    bit.b #R_WAITING, &RUN_FLAGS
    jeq 1f
    mov #RUN_WAIT_START, r12
1:  ret
map_fault_line:
    mov &VM_FAULT_PC, r12
    br #line_of
map_program_counter:
    mov &EFFECT_PC, r12
    jmp 1f
map_fault_pc:
    mov &VM_FAULT_PC, r12
1:  sub &VM_CODE, r12
    ret
map_trace_mode:
    mov.b &TRACING, r12
    and #T_ON, r12
    ret

/* Two bytes of text, the earlier one in the high byte. */
map_print_text:
    rla r12
    add &PRINT_TAIL, r12
    call #1f
    mov r13, r14
    swpb r14
    call #1f
    bis r14, r13
    mov r13, r12
    ret
1:  mov r12, r13
    and #PRINT_SIZE-1, r13
    mov.b PRINT(r13), r13
    inc r12
    ret

/* 32-bit values of axes and cells: both halves are of one instant, the high one is kept in LATCH
   when the low one is read. */
map_machine_positions:
    mov #ACTUAL, r13
    jmp 1f
map_commanded:
    mov #STEPS, r13
    jmp 1f
map_probed:
    mov #PROBED, r13
1:  mov #map_axis_long, r14
    jmp 2f
map_speeds:
    mov #motion_speed, r14
    jmp 2f
map_targets:
    mov #target_steps, r14
    jmp 2f
map_work_positions:
    mov #work_steps, r14
2:  cmp #6, r12
    jhs map_zero
    jmp map_half
map_cells:
    mov #map_cell, r14
    jmp map_half
map_keeps:
    mov #keep_read, r14
/* takes r12 = offset, r14 = routine from r12 = index to r13:r12 */
map_half:
    bit #1, r12
    jne 1f
    rra r12
    call r14
    mov r13, &LATCH
    ret
1:  mov &LATCH, r12
    ret

/* r12 = n: the cell's value, 0 without a run or beyond the program's. */
map_cell:
    clr r13
    bit.b #RUN_ACTIVE, &RUN
    jeq map_zero
    mov.b &VM_CELL_COUNT, r14
    cmp r14, r12
    jhs map_zero
    mov &VM_CELLS, r13
/* r12 = n: the nth of the 32-bit values at r13. */
map_axis_long:
    rla r12
    rla r12
    add r12, r13
    mov @r13+, r12
    mov @r13, r13
    ret

map_command_word:
    rla r12
    mov COMMAND(r12), r12
    ret

map_command_room:
    call #idle
    jne map_zero
    mov #COMMAND_WORDS, r12
    ret

map_probe_input:
    mov #17, r12
    br #input
map_moving:
    mov.b &NEGATIVE, r13
    xor #0b111, r13             ; direction: 1 is positive
    mov.b &MOVING, r12
    jmp map_two_bytes
map_homing:
    call #map_homing_axis
    mov.b &HOMING_ERROR, r13
map_two_bytes:
    swpb r13
    bis r13, r12
    ret
map_probing:
    cmp.b #OP_PROBE, &EFFECT
    jne map_zero
    call #map_axis_bit
    swpb r12
    ret
map_homing_axis:
    mov.b &EFFECT, r12
    sub #OP_HOME, r12
    cmp #OP_HOME_QUERY-OP_HOME+1, r12
    jhs map_zero
map_axis_bit:
    mov.b &N, r12
    inc r12
    call #mask_of
    mov r14, r12
    ret
map_plc_status:
    mov.b &RUN, r12
    and #RUN_ACTIVE, r12        ; bit 1 becomes bit 10
    swpb r12
    rla r12
    ret

/* Low byte: reference switches closed at the negative end, high byte: at the positive one.
   clobbers r4, r9 */
map_limit_switches:
    clr r9
    mov #3, r4
1:  rla r9
    dec r4
    mov &BOARD, r12
    add r4, r12
    mov.b B_REFERENCE(r12), r12
    call #input
    tst r12
    jeq 3f
    mov r4, r12
    call #axis_record
    bit #AXIS_HOME_POSITIVE, A_FLAGS(r12)
    jeq 2f
    bis #0x0100, r9
    jmp 3f
2:  bis #1, r9
3:  tst r4
    jne 1b
    mov r9, r12
    ret

/* InterpCNC's state word. clobbers r4, r9 */
map_cnc_state:
    mov.b &RUN, r12
    mov.b map_run_states(r12), r9
    call #map_homing_axis
    tst r12
    jeq 1f
    bis #1<<2, r9
1:  mov &BOARD, r4
    mov.b B_DOOR(r4), r12
    call #input
    tst r12
    jeq 2f
    bis #1<<6, r9
2:  mov.b B_EMERGENCY(r4), r12
    call #input
    tst r12
    jeq 3f
    bis #1<<8, r9
3:  mov r9, r12
    ret

/* InterpCNC's code of the latched fault. */
map_alarm:
    cmp.b #RUN_FAULT, &RUN
    jne 1f
    mov.b &VM_FAULT, r12
    mov.b ALARMS(r12), r12
    ret
1:  jmp map_zero

/* What writes a register or, of blocks of 32-bit values, a pair.
   takes r12 = offset, r13 = word or r15:r14 = value   leaves r12 = 0 or exception; keeps r4..r10 */
MAP_WRITERS:
map_written:
    clr r12
    ret
map_write_profile:
    br #profile_word
map_write_upload:
    br #upload_word

map_write_command:
    rla r12
    mov r13, COMMAND(r12)
    jmp map_written

map_write_outputs:
    tst r12
    jne map_bad_address
    mov &BOARD, r14
    bit #BOARD_CHAIN, B_FLAGS(r14)
    jne 1f
    cmp #1<<2, r13              ; outputs 1 and 2 without the chain
    jhs map_bad_value
1:  mov r13, &OUTPUT
    jmp map_written

map_write_override:
    cmp #100, r13
    jeq map_written
map_bad_value:
    mov #EX_VALUE, r12
    ret

map_write_cell:
    bit.b #RUN_ACTIVE, &RUN
    jeq map_no_program
    rra r12
    mov.b &VM_CELL_COUNT, r13
    cmp r13, r12
    jhs map_bad_value
    rla r12
    rla r12
    add &VM_CELLS, r12
    mov r14, 0(r12)
    mov r15, 2(r12)
    jmp map_written

map_write_keep:
    rra r12
    br #keep_write

/* As command 105. */
map_write_position:
    cmp #6, r12
    jhs map_bad_value
    bit.b #RUN_ACTIVE, &RUN
    jne map_busy
    rra r12
    inc r12
    mov #COMMAND_SET_POSITION, &COMMAND
    mov r12, &COMMAND+2
    mov r14, &COMMAND+4
    mov r15, &COMMAND+6
    br #command_execute

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
map_no_program:
    mov #EX_FAILURE, r12
    ret
map_busy:
    mov #EX_BUSY, r12
    ret

    /* run control */
1:  mov r13, r12
    dec r13
    cmp #CONTROLS, r13
    jhs map_bad_value
    cmp #CONTROL_START, r12
    jne 2f
    tst &STORED
    jeq map_no_program
2:  cmp #CONTROL_RESTART, r12
    jne 3f
    call #idle
    jne map_busy
3:  call #control
    jmp map_written
    /* trace mode */
4:  bic.b #T_ON|T_FULL, &TRACING
    tst r13
    jeq map_written
    bis.b #T_ON, &TRACING
    jmp map_written
5:  mov r13, r12
    br #upload_control
6:  mov r13, &UPLOAD
    jmp map_written
    /* print: bytes before this number were taken */
7:  mov.b &PRINT_READY, r14
    mov r13, r15
    sub &PRINT_TAIL, r15
    cmp r15, r14
    jlo map_bad_value
    mov r13, &PRINT_TAIL
    sub.b r15, &PRINT_READY
    jmp map_written
    /* a character for WaitChar, ! to } */
8:  mov r13, r14
    sub #33, r14
    cmp #125-33+1, r14
    jhs map_bad_value
    mov.b r13, &CHAR_IN
    jmp map_written

/* The low byte of InterpCNC's state word by RunState: fault 1, active 8, paused 16. */
map_run_states:
    .byte 0, 0, 8, 8|16, 1, 8, 8, 0
