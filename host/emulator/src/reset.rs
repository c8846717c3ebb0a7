//! Why a chip resets.

/// Cause of a reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reset {
    /// Supply came up or fell below the brown-out level.
    Power,
    /// The RST pin.
    Pin,
    /// The watchdog ran out.
    Watchdog,
    /// A wrong key was written to the watchdog.
    WatchdogKey,
    /// A wrong key was written to the flash controller.
    FlashKey,
    /// An instruction fetch from the peripherals.
    Fetch,
    /// A wrong key was written to the power management module.
    PowerKey,
    /// The program asked for a brown-out reset.
    SoftwareBrownOut,
    /// The program asked for a power-on reset.
    SoftwarePowerOn,
    /// The supply voltage supervisor, high side.
    Supervisor,
}
