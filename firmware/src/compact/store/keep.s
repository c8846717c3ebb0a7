/* KEEP values: a journal in two segments of flash (firmware::keep). TEMP holds the record that is
   being put: index, value, CRC. */

    .section .text.store,"axR",@progbits
module.store.keep:
    .if HAS_KEEP
/* Leaves r11 = the journal's current segment, 0 for none; uses r14, r15. */
keep_current:
    clr r11
    mov #KEEP_FIRST, r15
1:  cmp.b #KEEP_COMMITTED/256, 1(r15)
    jne 3f
    mov.b @r15, r14
    tst r11
    jeq 2f
    sub.b @r11, r14
    dec.b r14
    jl 3f
2:  mov r15, r11
3:  add #SEGMENT, r15
    cmp #AREA_END, r15
    jne 1b
    ret

/* r12 = index; leaves r15 = its newest record, or zeros for none, r11 = the current segment, 0 for
   none; keeps r12; uses r13, r14. */
keep_find:
    call #keep_current
    mov r11, r15
    tst r15
    jeq 2f
    add #SEGMENT, r15
1:  sub #8, r15
    cmp r11, r15
    jeq 2f
    cmp @r15, r12
    jne 1b
    /* its CRC takes 1000 cycles, so only of records that may be the one */
    push r11
    mov #8, r11
    call #crc_of
    pop r11
    sub #8, r15
    tst r12
    mov @r15, r12
    jne 1b
    ret
2:  mov #BOARD_DEFAULT+B_RESERVED, r15
    ret

/* r12 = index; leaves r13:r12 = what the journal holds, r11 its segment; uses r14, r15. */
keep_value:
    call #keep_find
    mov 2(r15), r12
    mov 4(r15), r13
    ret

/* Leaves Z set when the journal holds the value of TEMP; uses r11 to r15. */
keep_same:
    mov &TEMP, r12
    call #keep_value
    cmp r12, &TEMP+2
    jne 1f
    cmp r13, &TEMP+4
1:  ret

/* Copies the record at r15 to r12; leaves both behind it; uses r13, r14. */
keep_put:
    mov @r15+, r13
    call #flash_write
    incd r12
    bit #6, r12
    jne keep_put
    ret

/* r13 = values of the program: a journal of another program begins anew, all 0; uses r11 to r15. */
keep_claim:
    call #keep_current
    mov #8, r12
    tst r11
    jeq keep_turn
    cmp r13, 2(r11)
    jne keep_turn
    ret

/* Writes the value of TEMP if it differs; there is a journal. Uses r11 to r15. */
keep_store:
    call #keep_same
    jeq keep_done
    mov #TEMP, r15
    mov #6, r11
    call #crc_of
    mov r12, &TEMP+6
    /* free are the records behind the last one of which any word was written */
    call #keep_current
    mov r11, r12
    add #SEGMENT+8, r12
1:  sub #16, r12
    mov @r12+, r14
    and @r12+, r14
    and @r12+, r14
    and @r12+, r14
    inc r14
    jeq 1b
    bit #SEGMENT-1, r12
    jeq 2f
    mov #TEMP, r15
    call #keep_put
    call #keep_same
    jeq keep_done
2:  call #keep_current
    mov 2(r11), r13
    clr r12

/* Begins the other segment. r12 = first index whose value goes along, of TEMP's index that of TEMP;
   r13 = values of the program. Uses r11 to r15. */
keep_turn:
    push r10
    mov r12, r10
    push r13
    call #keep_current
    mov #KEEP_FIRST, r12
    cmp r11, r12
    jne 1f
    mov #KEEP_SECOND, r12
1:  call #flash_erase
    push r12
    add #8, r12
2:  cmp #8, r10
    jhs 5f
    push r12
    mov r10, r12
    call #keep_find
    cmp r10, &TEMP
    jne 3f
    mov #TEMP, r15
3:  pop r12
    mov 2(r15), r14
    bis 4(r15), r14
    tst r14
    jeq 4f
    call #keep_put
4:  inc r10
    jmp 2b
    /* owner, then the commit word */
5:  pop r12
    pop r13
    pop r10
    incd r12
    call #flash_write
    decd r12
    mov.b #-1, r13
    tst r11
    jeq 6f
    mov.b @r11, r13
6:  inc.b r13
    add #KEEP_COMMITTED, r13
    br #flash_write
keep_done:
    ret

/* r12 = index of a KEEP value; leaves r15 = address of its cell and C clear, r14 = how many there
   are; C set when the program has no such value. Keeps r12. */
keep_cell:
    mov &VM_CODE, r15
    tst r15
    jeq 1f
    mov.b 16-IMAGE_CODE(r15), r14
    and #15, r14
    cmp r14, r12
    jhs 1f
    mov.b 17-IMAGE_CODE(r15), r15
    add r12, r15
    rla r15
    rla r15
    add &VM_CELLS, r15
1:  ret

    .global keep_load, keep_save
/* keep_load, as a run begins: the cells of KEEP values get what the journal holds. keep_save: of the
   active run the values that have changed go to the journal; nothing may move. Use r11 to r15. */
keep_load:
    push #keep_get
    jmp 1f
keep_save:
    push #keep_set
1:  push r10
    mov #8, r10
2:  dec r10
    jn 3f
    mov r10, r12
    call #keep_cell
    jc 2b
    call 2(r1)
    jmp 2b
3:  pop r10
    incd r1
    ret

/* Of the value r12 = r10, whose cell is at r15, in a program of r14. */
keep_get:
    push r15
    mov r14, r13
    call #keep_claim
    mov r10, r12
    call #keep_value
    pop r15
    mov r12, 0(r15)
    mov r13, 2(r15)
    ret
keep_set:
    mov @r15+, r14
    mov @r15, r15
    call #keep_record
    jmp keep_store

    .global keep_read
/* r12 = index; leaves r13:r12 = the KEEP value, of an active run its cell; uses r11, r14, r15. */
keep_read:
    bit.b #RUN_ACTIVE, &RUN
    jeq keep_value
    call #keep_cell
    jc keep_value
    mov @r15+, r12
    mov @r15, r13
    ret

    .global keep_write
/* r12 = index, r15:r14 = value; leaves r12 = 0 or an Exception; uses r11 to r15. */
keep_write:
    call #keep_record
    call #keep_cell
    jc illegal_value
    bit.b #RUN_ACTIVE, &RUN
    jeq 1f
    mov &TEMP+2, 0(r15)
    mov &TEMP+4, 2(r15)
    jmp 2f
1:  call #only_idle
    mov r14, r13
    call #keep_claim
    call #keep_store
2:  clr r12
    ret

keep_record:
    mov r12, &TEMP
    mov r14, &TEMP+2
    mov r15, &TEMP+4
    ret
    .endif
