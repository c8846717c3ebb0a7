    .section .text.session,"axR",@progbits
    .global control
control:
    ret
    .global fail
fail:
    ret
    .global emergency
emergency:
    ret
    .global program_stored
program_stored:
    ret
