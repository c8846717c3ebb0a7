/* The tables of the register map: blocks of addresses, and what stands at each register of a block. */

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
    /* one block up to the last of them: there is no room for the rows of more */
    .word BLOCK_STATUS
    .byte BLOCK_GOALS+AT_TARGET_SPEEDS-BLOCK_STATUS, TABLES_STATUS, map_list_status-MAP_LISTS, 0
    MAP_BLOCK PROBE_RESULT_TEXT, map_list_probed
    MAP_BLOCK PROBE_RESULT, map_list_probed
    MAP_BLOCK CNC_STATUS, map_list_cnc
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
    MAP_WORDS 1, MISSED
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
    .if HAS_HALTS
    MAP_BYTE 1, CHAR_IN
    MAP_CODE 1, map_waits
    MAP_CODE 1, map_program_counter
    MAP_ROUTINE REST, map_calls
    .else
    MAP_BYTE REST, CHAR_IN
    .endif
map_list_status:
    MAP_WORDS AT_INPUTS_HIGH, INPUT
    MAP_CODE AT_MOVING-AT_INPUTS_HIGH, map_probe_input
    MAP_ROUTINE 1, map_moving
    MAP_CODE 1, map_homing
    MAP_CODE AT_PLC_STATUS-AT_LIMITS, map_limit_switches
    MAP_CODE 1, map_plc_status
    MAP_CODE 1, map_probing
    MAP_BYTE AT_PRINT_LENGTH-AT_PROBE_ERROR, PROBE_ERROR
    MAP_CODE BLOCK_PLACES-BLOCK_STATUS-AT_PRINT_LENGTH, map_print_count
map_list_positions:
    MAP_ROUTINE AT_ACTUAL_SPEEDS-AT_WORK_POSITIONS, map_work_positions
map_list_speeds:
    MAP_ROUTINE BLOCK_GOALS-BLOCK_PLACES-AT_ACTUAL_SPEEDS, map_speeds
    MAP_ROUTINE REST, map_targets
map_list_cnc:
    MAP_CODE AT_CNC_STATE, map_command_room
    MAP_CODE 1, map_cnc_state
    MAP_ROUTINE REST, map_alarm
map_list_overrides:
    MAP_BYTE 1, OVERRIDE
    MAP_BYTE REST, OVERRIDE+1
map_list_outputs:
    MAP_WORDS REST, OUTPUT
map_list_command:
    MAP_WORDS 2, COMMAND_HEAD
    MAP_WORDS REST, COMMAND+4
map_list_probed:
    MAP_WORDS 6, PROBED
map_list_upload:
    MAP_CODE REST, map_nothing
map_list_cells:
    MAP_ROUTINE REST, map_cells
map_list_keeps:
    MAP_ROUTINE REST, map_keeps
map_list_profile:
    MAP_ROUTINE REST, map_profile
