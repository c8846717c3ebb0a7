    .section .text.commands,"axR",@progbits
    .global command_execute
command_execute:
    ret
    .global command_done
command_done:
    ret
