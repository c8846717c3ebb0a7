    .section .text.commands,"axR",@progbits
    .global command_execute
command_execute:
    ret
