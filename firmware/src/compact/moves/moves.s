    .section .text.moves,"axR",@progbits
    .global fx_move
fx_move:
    ret
    .global fx_linear
fx_linear:
    ret
    .global fx_feed
fx_feed:
    ret
    .global fx_set_pos
fx_set_pos:
    ret
    .global fx_set_pos_zero
fx_set_pos_zero:
    ret
    .global fx_stop
fx_stop:
    ret
    .global fx_wait_move
fx_wait_move:
    ret
    .global fx_read
fx_read:
    ret
