//! From reset to the main loop.

use crate::chip::Chip;

/// IFG1 (SLAU144, 2.2.4): bit 0 watchdog, 2 power on, 3 RST pin.
const IFG1: u16 = 0x0002;
/// P1IN.
const P1IN: u16 = 0x0020;

#[test]
fn an_erased_board_starts_with_the_default_profile() {
    let mut chip = Chip::new();
    chip.call("boot", &[]);
    assert_eq!(chip.word("BOARD"), chip.at("BOARD_DEFAULT"));
    assert_eq!(chip.word("STORED"), 0);
    assert_eq!(chip.word("VM_CODE"), 0);
    assert_eq!(chip.byte("CAUSE"), 1 << 2, "power on");
    assert_eq!(chip.board.bus_read8(IFG1), 0);
    assert_ne!(chip.board.bus_read8(P1IN) & 1, 0, "Stop is not held: the pull-up holds it");
    assert_eq!(chip.byte("VM_FAULT"), 0);
    assert_eq!(chip.byte("FAULT_IN"), 0);
}
