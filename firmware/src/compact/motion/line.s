    .section .text.line,"axR",@progbits
    .global motion_poll
motion_poll:
    ret
    .global line_begin
line_begin:
    ret
    .global axis_begin
axis_begin:
    ret
    .global motion_pause
motion_pause:
    ret
    .global motion_resume
motion_resume:
    ret
    .global motion_stop
motion_stop:
    ret
    .global motion_halt
motion_halt:
    ret
    .global motion_hit
motion_hit:
    ret
    .global motion_rests
motion_rests:
    ret
    .global motion_speed
motion_speed:
    clr r12
    clr r13
    ret
