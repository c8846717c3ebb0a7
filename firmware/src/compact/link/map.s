    .section .text.map,"axR",@progbits
    .global map_read
map_read:
    ret
