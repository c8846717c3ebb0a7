    .section .text.ticks,"axR",@progbits
    .global ticks
ticks:
    ret
