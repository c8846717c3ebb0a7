    .section .text.trace,"axR",@progbits
    .global emit
emit:
    ret
    .global trace_slot
trace_slot:
    ret
