/* The program store: images in segments of flash, one of them current (firmware::store). */

    .section .text.store,"axR",@progbits
    .global store_mount, program_attach
/* After a reset: finds the current program and discards an older one. Destroys all. */
store_mount:
    mov #AREA, r10
1:  mov @r10, r9
    sub #SLOT_COMMITTED, r9
    cmp #256, r9
    jhs 4f
    mov r10, r12
    add #SLOT_HEAD, r12
    call #image_sound
    jne 4f
    /* sequence numbers differ by one: the signed difference says which is later; r11 = the other */
    mov r10, r11
    mov &STORED, r12
    tst r12
    jeq 2f
    sub.b @r12, r9
    dec.b r9
    jl 3f
2:  mov r12, r11
    mov r10, &STORED
3:  tst r11
    jeq 4f
    /* a commit word that was cut short may read badly later: written again it is settled */
    mov &STORED, r12
    mov @r12, r13
    call #flash_write
    mov r11, r12
    call #flash_erase
4:  add #SEGMENT, r10
    cmp #AREA_END, r10
    jne 1b
/* The stored program has changed: it is checked, and the VM knows where it lies. Uses r11 to r15. */
program_attach:
    clr &VM_CODE
    mov &STORED, r12
    tst r12
    jeq 1f
    call #slot_check
    mov.b r12, &REFUSAL
    tst r12
    mov #0, r12
    jne 1f
    mov &STORED, r15
    mov.b SLOT_HEAD+9(r15), r13
    mov.b SLOT_HEAD+10(r15), r14
    swpb r14
    bis r14, r13
    add #SLOT_HEAD+IMAGE_CODE, r15
    mov r15, &VM_CODE
    add r15, r13
    mov r13, &VM_DATA
    mov #1, r12
1:  br #program_stored

    .global program_check
/* The stored program may run: leaves r12 = 0 or its Refusal; uses r11 to r15. Takes about 30 ms for
   each KB and kicks the watchdog; the pool is scratch. slot_check: the same of the slot at r12. */
program_check:
    mov &STORED, r12
slot_check:
    add #SLOT_HEAD, r12
    call #image_sound
    mov #REFUSAL_CRC, r12
    jne 1f
    mov r15, r12
    mov #FEATURES, r13
    mov #POOL, r14
    br #pasapas_verify
1:  ret

    .global program_length
/* r12 = length of the stored image, 0 for none. */
program_length:
    mov &STORED, r12
    tst r12
    jeq 1f
    mov SLOT_HEAD+6(r12), r12
1:  ret

/* r12 = address behind the current slot. slot_bytes: r12 = bytes of the slot for an image of r12. */
stored_end:
    mov &STORED, r12
    add SLOT_HEAD+6(r12), r12
slot_bytes:
    add #SLOT_HEAD+SEGMENT-1, r12
    and #-SEGMENT, r12
    ret

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

    .global upload_control
upload_control:
    ret
    .global upload_word
upload_word:
    ret
