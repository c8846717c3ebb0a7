    .section .text.ramp,"axR",@progbits
    .global segment
segment:
    ret
