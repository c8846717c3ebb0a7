    .section .text.profile,"axR",@progbits
    .global profile_word
profile_word:
    ret
    .global profile_newest
profile_newest:
    ret
    .global fault_log
fault_log:
    ret
    .global fault_logged
fault_logged:
    ret
    .global stack_free
stack_free:
    ret
