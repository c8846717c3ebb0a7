; Writes flash of an MSP430F5529 from its RAM, where the chip's USB boot loader has put it and its data.
;
; That boot loader writes RAM and starts what is there, no more, and answers nothing while this runs. So
; each start does one round and ends in a brown-out reset: as long as the reset vector is blank, that leads
; back into the boot loader, which takes the next round; what has been written stays. The last rounds
; compare all of the flash by sums: one that finds something wrong resets `late`, by which the computer knows
; it, and the very last one writes the segment with the vectors if nothing is.
;
;   2500  this code
;   25EC  two sums of what follows, as `sum` makes them: what came incompletely changes nothing
;   25F0  number of flash segments to compare
;   25F2  numbers (address / 512) of six segments to write, 0 for none
;   25FE  where to go on behind a difference: `reset` or `late`
;   2600  six segments; or one, or `late`, and from 2800 on (number, two sums) of each segment to compare
;   3200  end
;
; Words that the assembler does not know are written as numbers (SLAU208, 6.6.2).

        .text
start:  dint
        mov #0x5A80, &0x015C    ; the watchdog is held
        mov #256, r4
        mov #0x25F0, r15
        mov #0x0608, r11
        call #(sum - start + 0x2500)
        cmp r12, &0x25EC
        jne reset
        cmp r13, &0x25EE
        jne reset

        mov &0x25F0, r10
        mov #0x2800, r9
compare:
        dec r10
        jn write
        mov @r9+, r15
        call #(place - start + 0x2500)
        mov r4, r11
        call #(sum - start + 0x2500)
        cmp @r9+, r12
        jne leave
        cmp @r9+, r13
        jne leave
        jmp compare

write:  mov #0x25F2, r9
        mov #0x2600, r8
        mov #6, r10
segment:
        mov @r9+, r15
        call #(place - start + 0x2500)
        jz next
        call #(same - start + 0x2500)
        jeq next
        call #(erase - start + 0x2500)
        .word 0x0FC5            ; mova r15, r5
        mov r8, r7
        mov r4, r11
        mov #0xA540, &0x0140    ; word writes
word:   mov @r7+, r6
        cmp #-1, r6
        jeq written
        mov r6, 0(r5)
busy:   bit #1, &0x0144
        jnz busy
written:
        .word 0x00A5, 0x0002    ; adda #2, r5
        dec r11
        jnz word
        call #(same - start + 0x2500)
        jeq next
        ; A segment that does not take its words must not start anything.
        call #(erase - start + 0x2500)
leave:  mov &0x25FE, pc
next:   add #512, r8
        dec r10
        jnz segment

reset:  mov #0xA504, &0x0120    ; brown-out reset, which locks the flash too
halt:   jmp halt

; r12, r13: sum of r11 words from r15 on, and sum of those sums.
sum:    clr r12
        clr r13
more:   add @r15+, r12
        add r12, r13
        dec r11
        jnz more
        ret

; r15: from the number of a segment to its address. Z: it is none.
place:  .word 0x0E4F, 0x0E4F, 0x024F    ; rlam.a #4, #4, #1
        ret

; Z: the segment at r15 holds what is at r8.
same:   .word 0x0FCE            ; mova r15, r14
        mov r8, r7
        mov r4, r11
both:   cmp @r7+, 0(r14)
        jne differs
        .word 0x00AE, 0x0002    ; adda #2, r14
        dec r11
        jnz both
differs:
        ret

; Erases the segment at r15, and leaves the controller open.
erase:  mov #0xA500, &0x0144
        mov #0xA502, &0x0140
        clr 0(r15)
gone:   bit #1, &0x0144
        jnz gone
        ret

; Goes to 2600 where a round only compares: 6 s of the boot loader's 8 MHz, then the reset.
        .section .late, "ax", @progbits
late:   mov #256, r12
slow:   clr r11
wait:   dec r11
        jnz wait
        dec r12
        jnz slow
        mov #0xA504, &0x0120
hold:   jmp hold
