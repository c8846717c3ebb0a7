//! The interrupt vectors (SLAS590, "Interrupt Vector Addresses"). Unused ones lead to a loop, which the watchdog ends.

core::arch::global_asm!(
    r#"
    .section .text.vectors,"ax",@progbits
module.chip.vectors:
    .global DefaultHandler
DefaultHandler:
    jmp DefaultHandler

    /* one vector for both directions; the character that came goes first */
pasapas_uart:
    bit.b #1, &{flags}
    jne 1f
    br #pasapas_transmit
1:  br #pasapas_receive

    .section .vector_table.interrupts,"a",@progbits
    .global __INTERRUPTS
__INTERRUPTS:
    /* FF80 on */
    .rept 42
    .short DefaultHandler
    .endr
    .short pasapas_pins         /* FFD4 PORT2 */
    .short DefaultHandler       /* FFD6 TIMER2_A1 */
    .short DefaultHandler       /* FFD8 TIMER2_A0 */
    .short DefaultHandler       /* FFDA USCI_B1 */
    .short pasapas_uart         /* FFDC USCI_A1 */
    .short DefaultHandler       /* FFDE PORT1 */
    .short pasapas_silences     /* FFE0 TIMER1_A1 */
    .short pasapas_millisecond  /* FFE2 TIMER1_A0 */
    .short DefaultHandler       /* FFE4 DMA */
    .short DefaultHandler       /* FFE6 USB_UBM */
    .short pasapas_channels     /* FFE8 TIMER0_A1 */
    .short pasapas_event        /* FFEA TIMER0_A0 */
    .short DefaultHandler       /* FFEC ADC12 */
    .short DefaultHandler       /* FFEE USCI_B0 */
    .short pasapas_bus          /* FFF0 USCI_A0 */
    .short DefaultHandler       /* FFF2 WDT */
    .short pasapas_power        /* FFF4 TIMER0_B1 */
    .short DefaultHandler       /* FFF6 TIMER0_B0 */
    .short DefaultHandler       /* FFF8 COMP_B */
    .short pasapas_oscillator   /* FFFA UNMI */
    .short pasapas_supply       /* FFFC SYSNMI */
    "#,
    flags = const super::reg::UCA1IFG.0,
);
