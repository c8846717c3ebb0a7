    .section .text.probe,"axR",@progbits
    .global fx_probe
fx_probe:
    ret
