    .section .text.modbus,"axR",@progbits
    .global link_poll
link_poll:
    ret
