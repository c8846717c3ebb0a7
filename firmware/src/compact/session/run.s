    .section .text.run,"axR",@progbits
    .global run
run:
    ret
    .global pop_value
pop_value:
    ret
    .global push_value
push_value:
    ret
    .global operand_byte
operand_byte:
    ret
    .global pop_small
pop_small:
    ret
