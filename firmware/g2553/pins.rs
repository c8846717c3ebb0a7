//! The pin table of the 20-pin MSP430G2553 (device pins of both wirings).

/// P1.0: Stop, to ground.
pub const P1_STOP: u8 = 1 << 0;
/// P1.1: UART receive. P1.2: UART transmit.
pub const P1_UART: u8 = 1 << 1 | 1 << 2;
/// P1.3: Start, to ground (the LaunchPad's button).
pub const P1_START: u8 = 1 << 3;
/// P1.4, direct wiring: reference X, input 1. Chain wiring: probe, input 17.
pub const P1_REF_X_OR_PROBE: u8 = 1 << 4;
/// P1.5, direct wiring: reference Y, input 2. Chain wiring: SPI clock.
pub const P1_REF_Y_OR_CLOCK: u8 = 1 << 5;
/// P1.6, direct wiring: reference Z, input 3. Chain wiring: SPI in, from the 74HC165.
pub const P1_REF_Z_OR_MISO: u8 = 1 << 6;
/// P1.7, direct wiring: probe, input 4. Chain wiring: SPI out, to the 74HC595.
pub const P1_PROBE_OR_MOSI: u8 = 1 << 7;

/// P2.0, P2.1, P2.4: STEP X, Y, Z, the outputs TA1.0, TA1.1, TA1.2.
pub const P2_STEP: u8 = 1 << 0 | 1 << 1 | 1 << 4;
/// P2.3, P2.6, P2.7: DIR X, Y, Z.
pub const P2_DIR: [u8; 3] = [1 << 3, 1 << 6, 1 << 7];
/// P2.2, direct wiring: output 1. Chain wiring: latch of both shift registers.
pub const P2_OUT1_OR_LATCH: u8 = 1 << 2;
/// P2.5, direct wiring: output 2. Chain wiring: output enable of the 74HC595, active low.
pub const P2_OUT2_OR_ENABLE: u8 = 1 << 5;
