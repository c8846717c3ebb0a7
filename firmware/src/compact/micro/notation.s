/* Micro-code: what is seldom in a hurry, in a third fewer bytes than instructions take. An
   accumulator machine on r13:r12 (a 32-bit integer or a scaled number; or r12 alone) whose program
   stands inline:

       MICRO                       instructions end, micro-code begins
       F load STEPS, AXIS          acc = STEPS[axis]
       F sub ACTUAL, AXIS          acc -= ACTUAL[axis]
       IF_NEGATIVE 1f
       FR times A_ACCEL, LONG, NEW acc *= new(accel of the axis record)
   1:  DO to_um                    calls a routine of the table below
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

   Registers besides: r10 = the next byte; r11, r14, r15 are lost. */

    /* Bytes that one byte names: from LOCALS on. Words from 0x0200 on. */
    .set BYTES, LOCALS
    .global BYTES
    /* bytes of the statement or command that begins */
    .set FLAGS, LOCALS          /* the instruction's flags */
    .set RAMPS, LOCALS+1        /* its second byte of them; bits of axes that have steps to make */
    .set UNIT, LOCALS+2         /* what rate takes; an operation code */
    .set FRAME_OF, LOCALS+3     /* F_STEPS: steps, else um; F_MACHINE, F_RELATIVE, else work */
    .global FRAME_OF
    .set SHIFT_BIAS, 64
    .set F_RECORD, 0x40
    .set F_AXIS, 0x20           /* with F_RECORD: of 16 bits */
    .set F_NEW, 0x10

    /* acc = x, x = acc; scaled: acc + x, acc - x or 0, acc * x, acc / x, smaller, larger;
       integers: acc + x, acc - x; words: r12 = x with its flags, x = r12, flags of r12 - x, x = 0;
       r9 = x; x and acc = the smaller scaled one */
    .set F_load, 0
    .set F_store, 1
    .set F_plus, 2
    .set F_minus, 3
    .set F_times, 4
    .set F_over, 5
    .set F_least, 6
    .set F_most, 7
    .set F_add, 8
    .set F_sub, 9
    .set F_word, 10
    .set F_put, 11
    .set F_cmp, 12
    .set F_clear, 13
    .set F_base, 14
    .set F_bound, 15

    /* what may stand behind an operand */
    .set AXIS, F_AXIS
    .set NEW, F_NEW
    .set LONG, 0
    .set SHORT, F_AXIS

    .macro F op, x, flag=0, more=0
    .byte 0x80 | F_\op | \flag | \more, (\x-0x200)/2
    .endm
    .macro FR op, x, width, flag=0
    .byte 0x80 | F_RECORD | F_\op | \width | \flag, \x
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
    /* what the table does not have */
    .macro CALL name
    .byte DO_micro_call
    .short \name
    .endm
    .macro END
    .byte DO_micro_end
    .balign 2, 0
    .endm
    .macro RETURN
    .byte DO_micro_return
    .endm
    .macro DONE_
    .byte DO_micro_done
    .endm
    .macro NOT_YET_
    .byte DO_micro_not_yet
    .endm
    .macro FAULT n
    .byte DO_micro_fault, \n
    .endm

    /* numbers: acc = n from 0 to 255; r12 = its low byte + n, modulo 256; r12 &= n; flags of r12 - n, of r12 & n;
       scaled acc * 2^n */
    .macro LIT n
    .if (\n) == 0
    .byte DO_zero
    .else
    .byte DO_micro_literal, \n
    .endif
    .endm
    /* r12 = n; r13 is kept */
    .macro LIT16 n
    .byte DO_micro_word
    .short \n
    .endm
    /* r12 = this byte of the board's profile, with its flags; r13 is kept */
    .macro PROFILE at
    .byte DO_micro_profile, \at
    .endm
    .macro ADDI n
    .byte DO_micro_addi, (\n) & 0xff
    .endm
    .macro ANDI n
    .byte DO_micro_andi, \n
    .endm
    .macro CMPI n
    .byte DO_micro_cmpi, \n
    .endm
    /* returns ILLEGAL_VALUE unless r12 < n, unless Z is clear */
    .macro BELOW n
    .byte DO_micro_below, \n
    .endm
    .macro WANTED
    .byte DO_micro_wanted
    .endm
    .macro TESTI n
    .byte DO_micro_testi, \n
    .endm
    .macro SHIFT n
    .byte DO_micro_shift, \n + SHIFT_BIAS
    .endm

    /* bytes: r13:r12 = v, flags of r12 - v, v = r12, v = n, v |= n, v &= ~n, v += 1; with the bits of
       r12: v |= r12, v &= ~r12 */
    .macro BYTE_OP op, v
    .if (\v) < BYTES || (\v) > BYTES+255
    .error "the byte is out of reach"
    .endif
    .byte DO_micro_\op, (\v)-BYTES
    .endm
    .macro GET v
    BYTE_OP get, \v
    .endm
    .macro PUT v
    BYTE_OP put, \v
    .endm
    .macro LET v, n
    BYTE_OP let, \v
    .byte \n
    .endm
    .macro BITS_ON v, n
    BYTE_OP bits_on, \v
    .byte \n
    .endm
    .macro BITS_OFF v, n
    BYTE_OP bits_off, \v
    .byte \n
    .endm
    .macro COMPARE v
    BYTE_OP compare, \v
    .endm
    .macro UP v
    BYTE_OP up, \v
    .endm
    .macro AXIS_ON v
    BYTE_OP axis_on, \v
    .endm
    .macro AXIS_OFF v
    BYTE_OP axis_off, \v
    .endm

    /* r12 = the top, taken; F20 unless it is from 0 <= least to most <= 255 */
    .macro POP_NUMBER least, most
    .byte DO_pop_number, \least, \most
    .endm

    /* events of the axis N, or with its number as the argument */
    .macro EVENT kind
    .byte DO_micro_event, \kind
    .endm
    .macro EVENT_OK kind
    .byte DO_micro_event_ok, \kind
    .endm

    /* jumps, -128 to 127 bytes: beyond, the assembler refuses a negative .skip */
    .macro TO l
    .byte \l - .
    .skip -(((\l - . + 129) & 0xff00) >> 8)
    .endm
    .macro GOTO l
    .byte DO_micro_goto
    TO \l
    .endm
    .macro IF_EQUAL l
    .byte DO_micro_if_equal
    TO \l
    .endm
    .macro IF_NOT_EQUAL l
    .byte DO_micro_if_not_equal
    TO \l
    .endm
    /* r12 is n, from 0 to 255; it is not */
    .macro CASE n, l
    .byte DO_micro_case, \n
    TO \l
    .endm
    .macro CASE_NOT n, l
    .byte DO_micro_case_not, \n
    TO \l
    .endm
    .macro IF_CARRY l
    .byte DO_micro_if_carry
    TO \l
    .endm
    .macro IF_NEGATIVE l
    .byte DO_micro_if_negative
    TO \l
    .endm
    .macro IF_NOT_NEGATIVE l
    .byte DO_micro_if_not_negative
    TO \l
    .endm
    .macro IF_OVERFLOW l
    .byte DO_micro_if_overflow
    TO \l
    .endm
    /* while there is another axis, r8 = 8, 4, 0 */
    .macro NEXT_AXIS l
    .byte DO_micro_next_axis
    TO \l
    .endm
    /* the same upward from X */
    .macro UP_AXIS l
    .byte DO_micro_up_axis
    TO \l
    .endm
    /* the bit of axis r8 is not set in v; acc is kept */
    .macro IF_NOT_AXIS v, l
    BYTE_OP if_not_axis, \v
    TO \l
    .endm
    /* v is 0, is not; a bit of n is set in v, none is; v is n, is not */
    .macro IF_ZERO v, l
    BYTE_OP if_zero, \v
    TO \l
    .endm
    .macro IF_SET v, l
    BYTE_OP if_set, \v
    TO \l
    .endm
    .macro IF_ANY v, n, l
    BYTE_OP if_any, \v
    .byte \n
    TO \l
    .endm
    .macro IF_NONE v, n, l
    BYTE_OP if_none, \v
    .byte \n
    TO \l
    .endm
    .macro IF_IS v, n, l
    BYTE_OP if_is, \v
    .byte \n
    TO \l
    .endm
    .macro IF_IS_NOT v, n, l
    BYTE_OP if_is_not, \v
    .byte \n
    TO \l
    .endm
