//! What differs from piece to piece of an MSP430F5529, and what is not known of any: each is an
//! option, so that firmware can be shown to hold either way.

/// Where in the data sheet's range the flash operations of this piece lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FlashSpeed {
    /// Shortest times: 64 us a word, 23 ms an erase.
    Fast,
    /// In the middle.
    #[default]
    Typical,
    /// Longest times: 85 us a word, 32 ms an erase.
    Slow,
}

/// How the frequency locked loop moves the DCO.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fll {
    /// It is at its rate at once and stays there.
    AtOnce,
    /// It steps towards its rate, one step at each reference period, and then stays exactly there.
    #[default]
    Ramp,
    /// It goes on stepping over and under its rate by a step of the modulator.
    Hunting,
}

/// A piece of silicon on a board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Silicon {
    /// A crystal or resonator of 4 MHz is fitted at XT2 and works.
    pub xt2_fitted: bool,
    /// Its rate in hertz.
    pub xt2_hz: u64,
    /// Its start-up time in microseconds.
    pub xt2_start_us: u64,
    /// A crystal of 32 768 Hz is fitted at XT1 and works.
    pub xt1_fitted: bool,
    /// Its start-up time in microseconds.
    pub xt1_start_us: u64,
    /// Rate of REFO in hertz: 32 768 less or more 3.5 %.
    pub refo_hz: u64,
    /// Behaviour of the frequency locked loop.
    pub fll: Fll,
    /// Flash times.
    pub flash: FlashSpeed,
    /// Interrupts are accepted while flash is busy and code runs from RAM. The guide says that they
    /// are switched off; nobody has seen it.
    pub interrupts_while_busy: bool,
    /// Two plain word writes into one long word are programmed together in long-word mode. If not,
    /// they are an access violation.
    pub long_word_pairs: bool,
    /// Time of the boot code behind a brown-out reset, in microseconds.
    pub boot_us: u64,
    /// Erratum TB25: in up mode Timer_B's latches hand a compare value over at once when they should wait for the next
    /// period (CLLD 1 and 2).
    pub tb25: bool,
    /// Erratum PORT16, at its worst: at each press of RST the contact bounces, and the boot code that is cut by
    /// that drives the pins low that the smallest package of the family lacks, until it has run.
    pub port16: bool,
    /// Delay of the supply supervisors after a setting, in microseconds.
    pub supervisor_us: u64,
}

impl Default for Silicon {
    fn default() -> Self {
        Silicon {
            xt2_fitted: true,
            xt2_hz: 4_000_000,
            xt2_start_us: 2_000,
            xt1_fitted: true,
            xt1_start_us: 500_000,
            refo_hz: 32_768,
            fll: Fll::default(),
            flash: FlashSpeed::default(),
            interrupts_while_busy: false,
            long_word_pairs: true,
            boot_us: 500,
            tb25: false,
            port16: false,
            supervisor_us: 100,
        }
    }
}
