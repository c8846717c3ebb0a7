/* The flash controller (SLAU144, chapter 7) and checksums over what flash holds. */

    .section .text.store,"axR",@progbits
module.store.flash:
/* Gives the current program up; keeps all but r12, r14. */
discard:
    clr &VM_CODE
    clr r12
    call #program_stored
    mov &STORED, r12
    clr &STORED
/* flash_erase: r12 = address in a segment to erase, 12 ms. flash_write: r12 = even address,
   r13 = word whose 0 bits are cleared there, 75 us. Only the program area and segments D, C and B
   of the information memory; other addresses, 0 too, do nothing. The processor stands still
   meanwhile and interrupts wait. Keep all but r14. Interrupts are on afterwards.
   The password comes with the mode on entry: who strays into the middle brings none. */
flash_erase:
    mov #FLASH_ERASE, r14
    jmp 1f
flash_write:
    mov #FLASH_WRITE, r14
1:  cmp #AREA_END, r12
    jhs 4f
    cmp #AREA, r12
    jhs 2f
    cmp #0x10c0, r12
    jhs 4f
    cmp #LOG, r12
    jlo 4f
2:  mov #KICK, &WATCHDOG
    dint
    mov r14, &FCTL1
    bit #FLASH_ERASE&~FLASH_WRITE, r14
    jeq 3f
    /* the milliseconds of an erase; their interrupt waits and adds the one that began */
    add #12*TICKS_A_MS, &TA0CCR0
    add #12, &MILLIS
    /* FCTL2: MCLK / 40 = 400 kHz, in its limits with a DCO that is 19 % too fast or 35 % too slow. FCTL3:
       unlocked, then locked. */
3:  bis #FLASH_CLOCK, r14
    mov r14, &FCTL2
    bic #FLASH_CLOCK, r14
    mov r14, &FCTL3
    mov r13, 0(r12)
    bis #FLASH_LOCK, r14
    mov r14, &FCTL3
    eint
4:  ret

    .global crc_of
/* r15 = address, r11 = bytes; leaves their CRC in r12, the address behind them in r15, 0 in r11;
   uses r13, r14. The watchdog is kicked: 3 KB take 20 ms. */
crc_of:
    mov #-1, r12
1:  mov #KICK, &WATCHDOG
    mov.b @r15+, r13
    call #pasapas_crc16
    dec r11
    jne 1b
    ret

    .global image_sound
/* r12 = address of an image; leaves Z set when its length and its CRC are right, and then the
   address in r15; uses r11 to r14. */
image_sound:
    mov 6(r12), r11
    mov #AREA_END, r15
    sub r12, r15
    cmp r11, r15
    jlo 1f
    cmp #IMAGE_CODE, r11
    jlo 1f
    push r12
    mov r12, r15
    call #crc_of
    pop r15
    tst r12
1:  ret
