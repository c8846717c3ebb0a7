    .section .text.step,"axR",@progbits
    .global step_init
step_init:
    ret
    .global TIMER1_A0
TIMER1_A0:
    reti
    .global TIMER1_A1
TIMER1_A1:
    reti
