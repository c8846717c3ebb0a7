    .section .text.soft,"axR",@progbits
    .global soft
soft:
    ret
    .global line_of
line_of:
    ret
