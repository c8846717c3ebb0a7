    .section .text.effects,"axR",@progbits
    .global effect_poll
effect_poll:
    ret
