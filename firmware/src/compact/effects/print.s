    .section .text.print,"axR",@progbits
    .global print_byte
print_byte:
    ret
