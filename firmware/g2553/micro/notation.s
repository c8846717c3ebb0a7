/* Micro-code: what is seldom in a hurry, in a third fewer bytes than instructions take. An
   accumulator machine on r13:r12 (a 32-bit integer or a scaled number; or r12 alone) whose program
   stands inline:

       MICRO                       instructions end, micro-code begins
       F load STEPS, AXIS          acc = STEPS[axis]
       F sub ACTUAL, AXIS          acc -= ACTUAL[axis]
       IF_NEGATIVE 1f
       FR times A_ACCEL, LONG, NEW acc *= new(accel of the axis record)
   1:  DO to_um                    calls a routine of the table
       END                         instructions go on

   An operation is a byte. Bit 7 set: a formula (F, FR), whose operand byte names a word of RAM, with
   AXIS indexed by r8 = 4 * axis, or with FR a 16-bit field (SHORT) or a 32-bit field (LONG) of the
   axis record at r9; NEW makes a scaled number of it first. Else it is a number in the table:
   operations of this machine, whose operands follow, and routines of the firmware, which find and
   leave r4 to r9, r12 and r13 and the flags as instructions do, must keep r10, and get no r14, r15.
   Words: F word, put, cmp and clear look at and change one word of RAM, with r12. F base makes a word
   of RAM the pointer r9, from which FR then reads: of the profile (F base BOARD, FR word B_SPIN_UP,
   SHORT), the stored program, an image. LIT16 is a word, PROFILE a byte of the board's profile.
   Flags of the last operation, the accumulator's sign behind a load or a difference among them,
   stand until the next one; a jump that is taken leaves them, but for one that looks at a byte.

   A routine may be micro-code as a whole: ROUTINE_ODD begins one at an odd address, which is how the
   table's user knows; RETURN, DONE, NOT_YET_DONE and FAULT end it. Behind MICRO they return from the
   routine of instructions that it stands in.

   Registers besides: r10 = the next byte; r11, r14, r15 are lost.

   The table is firmware/micro/src/isa: each operation and routine with its number, its operands, what it takes and
   leaves. Its numbers, tables and macros are made of it (asm.rs there); here is what is left. */

    /* Bytes that one byte names: from LOCALS on. Words from 0x0200 on. */
    .set BYTES, LOCALS
    .global BYTES
    .global FRAME_OF

    /* An effect: its first code, and its micro-code. The assembler puts the rows of the table in order, the
       highest code first; effects/effects.s looks them up. */
    .macro EFFECT code, label
    .pushsection .text.effects,0x100-(\code),"axR",@progbits
    .byte \code
    .popsection
    .pushsection .text.effects,0x200-(\code),"axR",@progbits
    .short \label
    .popsection
    .endm

    .macro F op, x, flag=0, more=0
    .byte FORMULA | F_\op | \flag | \more, (\x-0x200)/2
    .endm
    .macro FR op, x, width, flag=0
    .byte FORMULA | F_RECORD | F_\op | \width | \flag, \x
    .endm

    .macro MICRO
    call #micro
    .endm
    /* base: an even place of its section */
    .macro ROUTINE_ODD name, base=micro
    .skip (\base - . + 1) & 1
\name:
    .endm
    .macro DO name
    .byte DO_\name
    .endm
    /* acc = n from 0 to 255 */
    .macro LIT n
    .if (\n) == 0
    .byte DO_zero
    .else
    .byte DO_micro_literal, \n
    .endif
    .endm

    /* jumps, -128 to 127 bytes: beyond, the assembler refuses a negative .skip */
    .macro TO l
    .byte \l - .
    .skip -(((\l - . + 129) & 0xff00) >> 8)
    .endm
    /* behind the places of a switch, for who reads the code again */
    .macro PLACES_END
micro.places.\@:
    .endm
