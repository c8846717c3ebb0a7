    .section .text.uart,"axR",@progbits
    .global uart_open
uart_open:
    ret
