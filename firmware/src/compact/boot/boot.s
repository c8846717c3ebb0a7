    .section .text.boot,"axR",@progbits
    .global boot
boot:
    ret
