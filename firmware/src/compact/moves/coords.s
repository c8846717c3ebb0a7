    .section .text.coords,"axR",@progbits
    .global aim
aim:
    ret
    .global convert
convert:
    ret
    .global settle
settle:
    ret
    .global place
place:
    ret
    .global axis_record
axis_record:
    ret
    .global motion_reset
motion_reset:
    ret
