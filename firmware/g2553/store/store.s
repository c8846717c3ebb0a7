/* The program store: images in segments of flash, one of them current (firmware::store). */

    .section .text.store,"axR",@progbits
module.store:
    .global store_mount, program_attach
/* After a reset: finds the current program and discards an older one. Destroys all. */
store_mount:
    mov #AREA, r8
1:  mov r8, r12
    add #SLOT_HEAD, r12
    call #image_sound
    jne 4f
    /* r11 = what is to go: a whole image whose commit word is not, as it might read well later, or the
       older one; sequence numbers differ by one, and the signed difference says which is later */
    mov r8, r11
    cmp.b #SLOT_COMMITTED/256, 1(r8)
    jne 3f
    mov.b @r8, r9
    mov &STORED, r12
    tst r12
    jeq 2f
    sub.b @r12, r9
    dec.b r9
    jl 3f
2:  mov r12, r11
    mov r8, &STORED
    /* a commit word that was cut short may read badly later: written again it is settled, and the spare
       word says so */
    mov r8, r12
    mov @r12+, r13
    tst 0(r12)
    jeq 3f
    mov r8, r12
    call #flash_write
    incd r12
    clr r13
    call #flash_write
3:  mov r11, r12
    call #flash_erase
4:  add #SEGMENT, r8
    cmp #AREA_END, r8
    jne 1b
/* The stored program has changed, or is to run: it is checked, and the VM knows where it lies. Of r4
   to r9 keeps none. */
program_attach:
    clr &VM_CODE
    mov &STORED, r12
    tst r12
    jeq 1f
    call #slot_check
    mov.b &MILLIS, &TICKS_DONE  /* its milliseconds are not served late */
    mov.b r12, &REFUSAL
    tst r12
    mov #0, r12
    jne 1f
/* The program that the check has just taken is the stored one: it leaves the addresses of its code
   and data. */
    .global attach_checked
attach_checked:
    mov &CHECK_SCRATCH+CHECK_CODE, &VM_CODE
    mov &CHECK_SCRATCH+CHECK_DATA, &VM_DATA
    mov #1, r12
1:  br #program_stored

/* r12 = a slot; leaves r12 = 0 when its image may run, or its Refusal; of r4 to r9 keeps none. Takes about
   60 ms for each KB and kicks the watchdog. */
slot_check:
    add #SLOT_HEAD, r12
    call #image_sound
    mov #REFUSAL_CRC, r12
    jne 1f
    mov r15, r12
    mov #CHECK_SCRATCH, r14
    push r10
    call #pasapas_verify
    pop r10
    .if AT_ROOM
    clr &LEFT
    clr &LEFT+2
    .endif
1:  ret

/* r12 = address behind the current slot. slot_bytes: r12 = bytes of the slot for an image of r12. */
stored_end:
    mov &STORED, r12
    add SLOT_HEAD+6(r12), r12
slot_bytes:
    add #SLOT_HEAD+SEGMENT-1, r12
    and #-SEGMENT, r12
    ret

    .global idle
/* Leaves Z set when no run is active and nothing moves; keeps all. */
idle:
    bit.b #RUN_ACTIVE, &RUN
    jne 1f
    tst.b &MOVING
1:  ret

/* Called first by what replaces a program: otherwise its caller gets the answer to who has not opened
   the lock, or Busy. Below the vectors, where there is room. */
    .section .tail.unlocked,"axR",@progbits
module.store$unlocked:
only_unlocked:
    tst.b &TRACING
    jn 1f
    br #only_idle
1:  incd r1
    mov #EX_DEVICE_FAILURE, r12
    ret

    .section .text.store,"axR",@progbits
/* Called first by what needs that: otherwise its caller gets the answer Busy. */
only_idle:
    call #idle
    jeq 1f
    incd r1
busy:
    mov #EX_BUSY, r12
1:  ret

    .global upload_control
/* r12 = Upload code; leaves r12 = 0 or an Exception; keeps no register. */
upload_control:
    call #only_unlocked
    mov r12, r15
    dec r12
    cmp #UPLOAD_ERASE, r12
    jhs illegal_value
    call #upload
    mov.b r12, &REFUSAL
    tst r12
    jne refused
    ret
illegal_value:
    mov #EX_ILLEGAL_VALUE, r12
    ret

/* r15 = Upload code; leaves r12 = 0 or a Refusal; keeps no register. */
upload:
    cmp #UPLOAD_COMMIT, r15
    jeq commit
    mov #AREA_END, r11
    cmp #UPLOAD_ERASE, r15
    jeq upload_erase

/* Begin, Replace: r11 = end of what the image may take */
    clr &OPEN
    mov &UPLOAD, r12
    rla r12
    jnc 1f
    mov #KEEP_FIRST, r11
    clrc
1:  rrc r12
    jeq upload_not_begun
    cmp #AREA_BYTES+1, r12
    jhs 4f
    call #slot_bytes
    mov r12, r13
    cmp #UPLOAD_REPLACE, r15
    jne 2f
    call #discard
    /* in front of the current slot, or behind it; without one that is 0 and leaves more than the area */
2:  mov #AREA, r12
    mov &STORED, r14
    sub r12, r14
    cmp r13, r14
    jhs 3f
    call #stored_end
3:  sub r12, r11
    cmp r13, r11
    jl 4f
    mov r12, r15
    add r12, r13
5:  call #flash_erase
    add #SEGMENT, r12
    cmp r13, r12
    jne 5b
    mov r15, &OPEN
    jmp upload_good
4:  mov #REFUSAL_TOO_LONG, r12
    ret

/* Erase */
upload_erase:
    call #discard
upload_good:
    clr r12
    ret

upload_not_begun:
    mov #REFUSAL_NOT_BEGUN, r12
    ret

/* Commit */
commit:
    mov &OPEN, r12
    tst r12
    jeq upload_not_begun
    mov #REFUSAL_CRC, r15
    /* bit 15 apart, the length as announced */
    mov &UPLOAD, r13
    xor SLOT_HEAD+6(r12), r13
    rla r13
    jne 1f
    call #slot_check
    mov r12, r15
    tst r12
    jne 1f
    mov &OPEN, r12
    mov &STORED, r11
    mov.b #-1, r13
    tst r11
    jeq 2f
    mov.b @r11, r13
2:  inc.b r13
    add #SLOT_COMMITTED, r13
    mov #REFUSAL_FLASH, r15
    call #flash_write
    cmp @r12, r13
    jne 1f
    mov r12, &STORED
    clr &OPEN
    mov r11, r12
    call #flash_erase
    call #attach_new
    clr r15
1:  mov r15, r12
    ret

    .global upload_word
/* r12 = index of a register in the window, r13 = word; leaves r12 = 0 or an Exception; uses r14. */
upload_word:
    call #only_unlocked
    rla r12
    mov &UPLOAD, r14
    bic #0x8000, r14
    cmp r14, r12
    jhs 1f
    mov &OPEN, r14
    tst r14
    jeq 1f
    add r14, r12
    add #SLOT_HEAD, r12
    cmp #-1, 0(r12)
    jne word_held
    .global word_write
/* Writes r13 at r12; leaves r12 = 0, or an Exception when it is not there then. */
word_write:
    call #flash_write
word_held:
    cmp r13, 0(r12)
    jeq upload_good
1:
refused:
    mov #EX_DEVICE_FAILURE, r12
    ret
