    .section .text.store,"axR",@progbits
    .global store_mount
store_mount:
    ret
    .global upload_control
upload_control:
    ret
    .global upload_word
upload_word:
    ret
    .global program_check
program_check:
    ret
    .global free_bytes
free_bytes:
    ret
    .global program_length
program_length:
    ret
