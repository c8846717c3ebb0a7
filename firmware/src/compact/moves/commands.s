    .section .text.commands,"axR",@progbits
    .global command_execute
command_execute:
    clr r12
    ret
    .global command_done
command_done:
    ret
    .global set_work_position
set_work_position:
    ret
