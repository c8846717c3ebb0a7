/* KEEP values: a ring of records in two segments of flash (firmware::keep). */

    .section .text.store,"axR",@progbits
module.store.keep:
/* Below the vectors, where there is room. */
    .section .tail.keep,"axR",@progbits
module.store.keep$tail:
/* r12 = index of a KEEP value; leaves r13 = 4 * r12 and the others as keep_cells does, with C set when
   the program has no such value. */
keep_place:
    rla r12
    rla r12
    mov r12, r13
    call #keep_cells
    cmp r12, r13
    ret

    .section .text.store,"axR",@progbits
/* Of the stored program: leaves r12 = bytes of its KEEP values, with Z set when it has none, r8 = their
   first cell in a run; uses r15. */
keep_cells:
    mov &VM_CODE, r15
    mov r15, r12
    tst r15
    jeq 1f
    mov.b IMAGE_KEEP_BASE-IMAGE_CODE(r15), r8
    rla r8
    rla r8
    add &VM_CELLS, r8
    mov.b IMAGE_KEEPS-IMAGE_CODE(r15), r12
    rla r12
    rla r12
1:  ret

/* r12 = bytes of the values; leaves r12 = bytes of a record, r9 = the newest, 0 for none, r15 = the
   ring's first place, less r12; uses r11, r13, r14. From the last place down, so that most need no CRC:
   130 cycles a byte. */
keep_find:
    add #4, r12
    clr r9
    mov #AREA_END, r15
1:  sub r12, r15
    cmp #KEEP_FIRST, r15
    jlo 3f
    mov &VM_CODE, r14
    cmp.b MC_KEEPS-MACHINE_SIZE(r14), 1(r15)
    jne 1b
    tst r9
    jeq 2f
    mov.b @r15, r14
    sub.b @r9, r14
    dec.b r14
    jl 1b
2:  push r12
    push r15
    mov r12, r11
    call #crc_of
    tst r12
    pop r15
    pop r12
    jne 1b
    mov r15, r9
    jmp 1b
3:  ret

/* Copies r12 bytes of values from flash to r8, which is kept, zeros for nothing; uses r9, r11 to r15. */
keep_fetch:
    call #keep_find
    mov r8, r14
1:  clr r13
    tst r9
    jeq 2f
    incd r9
    mov @r9, r13
2:  mov r13, 0(r14)
    incd r14
    decd r12
    cmp #4, r12
    jne 1b
    ret

    .global keep_load, keep_save
/* keep_load, as a run begins: the cells of KEEP values get what flash holds. keep_save: of the
   active run the values go to flash when one has changed; nothing may move. Keep r4 to r7 and r10. */
keep_load:
    call #keep_cells
    jeq keep_done
    call #keep_fetch
keep_save:
    call #keep_cells
    jeq keep_done
/* The values at r8, r12 bytes, go to flash unless it holds them. Destroys r8, r9, r11 to r15. */
keep_store:
    call #keep_find
    mov r12, r11
    mov #1, r13
    tst r9
    jeq 4f
    mov r8, r13
    mov r9, r14
2:  incd r14
    cmp @r13+, 0(r14)
    jne 3f
    decd r12
    cmp #4, r12
    jne 2b
keep_done:
    ret
3:  mov.b @r9, r13
    jmp 5f
    /* the values of another program go */
4:  mov #KEEP_SECOND, r12
    call #flash_erase
    jmp 7f
    /* The place behind the newest. The record that crosses into a segment has it erased, which is never
       where the newest lies; behind the area that does nothing. Where a cut has left something is
       passed over, with its number. */
5:  inc.b r13
    add r11, r9
    cmp #AREA_END, r9
    jeq 7f
    mov r9, r12
    add r11, r12
    mov r12, r14
    xor r9, r14
    bit #SEGMENT, r14
    jeq 6f
    call #flash_erase
6:  cmp #-1, 0(r9)
    jne 5b
    jmp 8f
7:  mov r15, r9
    add r11, r9
    mov #KEEP_FIRST, r12
    call #flash_erase
8:
    mov &VM_CODE, r14
    mov.b MC_KEEPS-MACHINE_SIZE(r14), r14
    swpb r14
    bis r14, r13
    mov r9, r12
1:  call #flash_write
    incd r12
    mov @r8+, r13
    decd r11
    cmp #2, r11
    jne 1b
    mov r9, r15
    mov r12, r11
    sub r9, r11
    call #crc_of
    mov r12, r13
    mov r15, r12
    jmp word_write

    .global keep_read
/* r12 = index; leaves r13:r12 = the KEEP value, of an active run its cell; uses r8, r9, r11 to r15. */
keep_read:
    call #keep_place
    jhs 2f
    bit.b #RUN_ACTIVE, &RUN
    jne 1f
    push r13
    call #keep_find
    pop r13
    mov r9, r8
    incd r8
    tst r9
    jeq 2f
1:  add r13, r8
    mov @r8+, r12
    mov @r8, r13
    ret
2:  br #scaled_zero

    .global keep_write
/* r12 = index, r15:r14 = value; leaves r12 = 0 or an Exception; uses r4, r8, r9, r11 to r15. Without a
   run the planner's numbers have room for the values. */
keep_write:
    mov r14, r4
    mov r15, &TEMP
    call #keep_place
    jhs illegal_value
    bit.b #RUN_ACTIVE, &RUN
    jne 2f
    call #only_idle
    push r12
    push r13
    mov #V2, r8
    call #keep_fetch
    pop r13
    pop r12
    call #1f
    call #keep_store
    jmp upload_good
2:  push #upload_good
1:  add r8, r13
    mov r4, 0(r13)
    mov &TEMP, 2(r13)
    ret
