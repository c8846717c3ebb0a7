/* The registers and bits of the link (`lang::wire`), who reads and writes them. Twin: board/map.rs. */

/* One row of a block: first address, count (0: UPLOAD_COUNT), tables, list of its registers (from
   MAP_KEYS), routine that writes it (from MAP_WRITERS, 0 for none). */
    .macro MAP_BLOCK name, list, writer=MAP_WRITERS
    .word BLOCK_\name
    .byte COUNT_\name, TABLES_\name, \list-MAP_KEYS, \writer-MAP_WRITERS
    .endm

/* Registers of a list, in ascending order. A row holds from its offset to that of the next:
   MAP_VALUE, MAP_BYTE: this number, this byte of RAM, at that offset only, 0 behind it;
   MAP_WORD: the words of RAM from this one on;
   MAP_CODE: a routine, or micro-code at an odd address, takes r12 = offset from the row's and leaves
   r12 = value, keeping r5..r8, r10. */
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

    .section .tail.limits,"axR",@progbits
module.link.map$limits:
/* Low byte: reference switches closed at the negative end, high byte: at the positive one.
   clobbers r4, r9 */
map_limit_switches:
    push r8
    clr r4
    mov #8, r8
1:  rla r4
    call #axis_at
    mov r8, r12
    rra r12
    rra r12
    call #reference
    call #input
    bit #AXIS_HOME_POSITIVE, A_FLAGS(r9)
    jeq 2f
    swpb r12
2:  bis r12, r4
    sub #4, r8
    jge 1b
    mov r4, r12
    pop r8
    ret

    .section .text.map,"axR",@progbits
module.link.map:
    .subsection 1
MAP_KEYS:
    .subsection 2
    .p2align 1, 0
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
    .if HAS_LINES
    MAP_CODE AT_FAULT_LINE, map_fault_line
    .else
    MAP_VALUE AT_FAULT_LINE, 0
    .endif
    MAP_BYTE AT_FAULT_INPUT, FAULT_IN
    MAP_CODE AT_PROGRAM_COUNTER, map_program_counter
    MAP_BYTE AT_LAST_END, LAST_END
    MAP_WORD AT_RUN_COUNT, RUNS
    MAP_BYTE AT_HOMED, HOMED
    MAP_CODE AT_BLOCKING_INPUT, blocking
    MAP_WORD AT_MACHINE_POSITIONS, ACTUAL
    MAP_WORD AT_COMMANDED, STEPS
    MAP_VALUE AT_COMMANDED+6, 0
    MAP_CODE AT_TRACE_MODE, map_trace_mode
    MAP_VALUE AT_TRACE_MODE+1, 0
    MAP_WORD AT_UPLOAD_LENGTH, UPLOAD
    MAP_BYTE AT_UPLOAD_RESULT, REFUSAL
    MAP_CODE AT_TRACE_EVEN, trace_slot
    MAP_CODE AT_PRINT_COUNT, map_print_count
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
    MAP_VALUE 1, 0
MAP_LIST map_list_command
    MAP_WORD 0, COMMAND_HEAD
    MAP_WORD 2, COMMAND+4
MAP_LIST map_list_probed
    MAP_WORD 0, PROBED
    MAP_VALUE 6, 0
MAP_LIST map_list_positions
    MAP_CODE 0, map_work_positions
MAP_LIST map_list_speeds
    MAP_CODE 0, map_speeds
MAP_LIST map_list_cells
    MAP_CODE 0, map_cells
    .if HAS_KEEP
MAP_LIST map_list_keeps
    MAP_CODE 0, map_keeps
    .endif
MAP_LIST map_list_profile
    MAP_CODE 0, map_profile
MAP_LIST map_list_upload
    MAP_VALUE 0, 0
    .subsection 1
    .byte 0xff
    .subsection 0

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
   takes r8   leaves r12 its value, r5 its address   clobbers r4, r9, r11..r15 */
map_next:
    mov &NEXT_REGISTER, r5
    inc &NEXT_REGISTER
    dec &REGISTERS_LEFT
/* The same at address r5. */
map_read:
    call #map_find
    cmp #4, r8
    jhs 1f
    mov r5, r12                 ; of the bits, 0 and 256 stand in registers 0 and 16
    rra r12
    rra r12
    rra r12
    rra r12
1:  mov.b 1(r9), r13
    /* the list's last row whose offset is not above; its first one and the next list have FF here */
2:  mov.b MAP_KEYS(r13), r15
    inc r13
    cmp.b r12, MAP_KEYS(r13)
    jlo 2b
    inc.b r15
    sub r15, r12
    rla r13
    mov MAP_VALUES-2(r13), r13
    tst r13
    jn 4f                       ; routines lie in the upper half of memory
    bit #IN_WORD, r13
    jne 3f
    tst r12
    jne map_zero
    mov r13, r12
    rla r13
    jn 2f
    ret
2:  mov.b -IN_BYTE(r12), r12
    ret
3:  rla r12
    add r12, r13
    mov -IN_WORD(r13), r12
    ret
4:  mov r13, r11
    br #micro_go
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

    .section .text.micro,"axR",@progbits
module.link.map$micro:
    ROUTINE_ODD map_missed
    F load MISSED
    F add LATE
    RETURN
    ROUTINE_ODD map_run_state
    GET RUN
    IF_IS_NOT RUN, RUN_RUNNING, 1f
    IF_NONE RUN_FLAGS, R_WAITING, 1f
    LIT RUN_WAIT_START
1:  RETURN
    .if HAS_LINES
    ROUTINE_ODD map_fault_line
    F load VM_FAULT_PC
    CALL line_of
    RETURN
    .endif
    ROUTINE_ODD map_program_counter
    F load EFFECT_PC
    GOTO 1f
    ROUTINE_ODD map_fault_pc
    F load VM_FAULT_PC
1:  F sub VM_CODE
    RETURN
    ROUTINE_ODD map_trace_mode
    GET TRACING
    ANDI T_ON
    RETURN
    /* Who finds nothing to take listens, and so does who takes what there is. */
    ROUTINE_ODD map_print_count
    GET PRINT_READY
    IF_SET PRINT_READY, 1f
    LET UNHEARD, 0
    LET UNHEARD+1, 0
1:  RETURN
    ROUTINE_ODD map_probe_input
    LIT 17
    DO input
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

/* Halves of 32-bit values. */
    .if HAS_KEEP
map_keeps:
    mov #keep_read, r14
    jmp map_half
    .endif
map_speeds:
    mov #motion_speed, r14
    jmp 1f
map_targets:
    mov #target_steps, r14
    jmp 1f
map_work_positions:
    mov #work_steps, r14
1:  cmp #6, r12
    jhs map_zero
/* takes r12 = offset, r14 = routine from r12 = index to r13:r12 */
map_half:
    push r12
    rra r12
    call r14
    pop r14
    rra r14
    jnc 2f
    mov r13, r12
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

map_command_room:
    call #idle
    jne map_zero
    mov #COMMAND_WORDS, r12
    ret

map_moving:
    mov &MOVING, r12            ; and NEGATIVE
    xor #0x0700, r12            ; direction: 1 is positive
    ret
map_homing:
    call #map_under_way
    jlo 1f
    clr r14
1:  mov.b &HOMING_ERROR, r12
    swpb r12
    bis r14, r12
    ret
map_probing:
    call #map_under_way
    jne map_zero
    mov r14, r12
    swpb r12
    ret
/* leaves r14 = bit of the axis at work; lower while it homes, equal while it probes */
map_under_way:
    mov.b &N, r12
    inc r12
    call #mask_of
    mov.b &EFFECT, r12
    sub #OP_HOME, r12
    cmp #OP_PROBE-OP_HOME, r12
    ret
map_plc_status:
    mov.b &RUN, r12
    and #RUN_ACTIVE, r12        ; bit 1 becomes bit 10
    swpb r12
    rla r12
    ret

/* InterpCNC's state word. clobbers r4, r9 */
map_cnc_state:
    mov.b &RUN, r12
    mov.b map_run_states(r12), r9
    call #map_under_way
    jhs 1f
    bis #1<<2, r9
1:  mov &BOARD, r4
    mov.b B_DOOR(r4), r12
    call #input
    jeq 2f
    bis #1<<6, r9
2:  mov.b B_EMERGENCY(r4), r12
    call #input
    jeq 3f
    bis #1<<8, r9
3:  mov r9, r12
    ret
/* The low byte of InterpCNC's state word by RunState: fault 1, active 8, paused 16. */
map_run_states:
    .byte 0, 0, 8, 8|16, 1, 8, 8, 0

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
MAP_WRITERS:
map_written:
    clr r12
    ret
map_write_profile:
    br #profile_word
map_write_upload:
    br #upload_word

/* All but the command's head lies in the pool: not during a run, nor under a command's work. */
map_write_command:
    rla r12
    cmp #4, r12
    jlo 1f
    bit.b #RUN_ACTIVE, &RUN
    jne map_busy
    tst.b &EFFECT
    jne map_busy
    mov r13, COMMAND(r12)
    jmp map_written
1:  mov r13, COMMAND_HEAD(r12)
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

map_bad_value:
    mov #EX_VALUE, r12
    ret

map_write_cell:
    bit.b #RUN_ACTIVE, &RUN
    jeq map_no_program
    call #map_cell_at
    jhs map_bad_value
    mov r13, 0(r12)
    jmp map_written

map_write_position:
    cmp #6, r12
    jhs map_bad_value
    bit.b #RUN_ACTIVE, &RUN
    jne map_busy
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

    /* run control, the last of its request */
1:  cmp #1, r6
    jne map_bad_value
    mov r13, r12
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
    jne map_bad_value
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
    jlo map_bad_value
    mov r13, &PRINT_TAIL
    sub.b r15, &PRINT_READY
    clr &UNHEARD
    jmp map_written
    /* a character for WaitChar, ! to } */
8:  mov r13, r14
    sub #33, r14
    cmp #125-33+1, r14
    jhs map_bad_value
    mov.b r13, &CHAR_IN
    jmp map_written
