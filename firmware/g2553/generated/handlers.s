/* Made by `cargo run -p lower` of firmware/src/rules/handlers.rs: change that. */

    .if HAS_LINES
    .section .text.run,"axR",@progbits
module.rules.handlers:
    .balign 2, 0
    .global raise
raise:
    clr.b &PRINT_OPEN
    MICRO
    PUT VM_FAULT
    F word EFFECT_PC
    F put VM_FAULT_PC
    F clear EFFECT
    BITS_OFF TRACING, T_DROPPED+T_ANNOUNCED
    .if HAS_EVENTS
    BITS_OFF VM_FLAGS, VM_MORE|VM_WITHIN
    .endif
    IF_IS VM_FAULT, F_STACK, .Lhandlers_2
    IF_ANY VM_FLAGS, VM_ERROR, .Lhandlers_2
    F word VM_HANDLER
    IF_EQUAL .Lhandlers_2
    CALL handler_open
    IF_NOT_EQUAL .Lhandlers_1
.Lhandlers_2:
    GET VM_FAULT
    DO fail
    RETURN
.Lhandlers_1:
    BITS_ON VM_FLAGS, VM_ERROR
    F word VM_HANDLER
    F put VM_PC
    F load FEED
    F store FEED_ASIDE
    LIT 0
    F store FEED
    END
    jmp run_unwind
    .balign 2, 0
    .endif
