//! Ctrl-C and SIGTERM: a long command ends early and writes what it has.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

#[cfg(feature = "desktop")]
use signal_hook::{
    consts::{SIGINT, SIGTERM},
    flag,
};

static ASKED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// From now on Ctrl-C and SIGTERM ask for the end ([`asked`]); the second one ends the process at
/// once, with the exit code that a shell shows for it.
#[cfg(feature = "desktop")]
pub fn watch() {
    for signal in [SIGINT, SIGTERM] {
        // Without handlers the signals end the process, as they always do.
        let shutdown = flag::register_conditional_shutdown(signal, 128 + signal, ASKED.clone());
        if shutdown.is_ok() {
            let _ = flag::register(signal, ASKED.clone());
        }
    }
}

/// Asks for the end, as Ctrl-C does.
pub fn ask() {
    ASKED.store(true, Ordering::Relaxed);
}

/// Whether somebody has asked for the end.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
