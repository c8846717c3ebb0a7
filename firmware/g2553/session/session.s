/* What firmware/src/rules/session.rs builds on: a stored program, and what a run begins with. */

    .section .text.session,"axR",@progbits
module.session:

/* The stored program has changed: r12 = 1 for one that may run, 0 for none. */
    .balign 2, 0
    .global program_stored
program_stored:
    /* the cells follow the call stack, whose entries have two bytes */
    mov &VM_CODE, r14
    mov.b IMAGE_CALLS-IMAGE_CODE(r14), r14
    rla r14
    add #POOL, r14
    mov r14, &VM_CELLS
    bit.b #RUN_ACTIVE+RUN_FAULT, &RUN
    jne 1f
    mov.b r12, &RUN
1:  ret

/* The program that the check has just taken is a new one: all its cells are 0. */
    .if AT_ROOM
    .global attach_new
attach_new:
    mov #POOL, r12
    call #clear_ram
    br #attach_checked
    .else
    .set attach_new, attach_checked
    .global attach_new
    .endif

/* Clears what a run begins with as 0, but not the cells that live between runs. Leaves r12 = POOL_END,
   clobbers r13 to r15. */
clear_run:
    .if AT_ROOM
    call #kept_bytes
    mov r14, r13
    mov #RUN_CLEARED, r12
    jmp 1f
    .else
    mov #RUN_CLEARED, r12
    .endif
/* Clears RAM from r12 on to the pool's end, which r12 is then; clobbers r13. */
    .global clear_ram
clear_ram:
    .if AT_ROOM
    clr r13
1:  cmp &VM_CELLS, r12
    jne 2f
    add r13, r12
2:  clr 0(r12)
    incd r12
    cmp #POOL_END, r12
    jne 1b
    ret

/* r14 = bytes of the cells that live between runs, those of AT variables: none where they reach into the
   command buffer. Needs a program; clobbers r15. */
    .global kept_bytes
kept_bytes:
    mov &VM_CODE, r15
    mov.b IMAGE_KEEP_BASE-IMAGE_CODE(r15), r14
    rla r14
    rla r14
    mov &VM_CELLS, r15
    add r14, r15
    cmp #HOME_RECORD+1, r15
    jlo 1f
    clr r14
1:
    .else
1:  clr 0(r12)
    incd r12
    cmp #POOL_END, r12
    jne 1b
    .endif
    ret
