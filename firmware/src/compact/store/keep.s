    .section .text.keep,"axR",@progbits
    .global keep_load
keep_load:
    ret
    .global keep_save
keep_save:
    ret
    .global keep_read
keep_read:
    ret
    .global keep_write
keep_write:
    ret
