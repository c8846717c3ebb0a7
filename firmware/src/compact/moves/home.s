    .section .text.home,"axR",@progbits
    .global fx_home
fx_home:
    ret
    .global limits
limits:
    ret
