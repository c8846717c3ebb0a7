/* The table of the instructions: the rows of `lang::isa` follow, then the effects behind short forms. */

    .section .rodata.vm,"a",@progbits
module.vm$tables:
    .balign 2
vm_handlers:
