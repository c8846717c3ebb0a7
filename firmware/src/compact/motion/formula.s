    .section .text.formula,"axR",@progbits
    .global formula
formula:
    ret
