//! The debug adapter: an editor's debugger over the Debug Adapter Protocol, on a simulated machine, a
//! virtual board or a real one.

mod board;
mod breaks;
mod eval;
mod launch;
mod names;
mod program;
mod session;
mod show;
mod sim;
mod snapshot;
pub(crate) mod wire;

use std::io::{self, BufRead, Write};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, PoisonError};

use serde_json::Value;

pub use launch::Setup;
use session::Session;
use snapshot::Report;

/// What comes to a session.
enum Heard {
    Editor(Value),
    Run(Report),
    Gone,
}

/// Serves one editor until it goes.
///
/// # Errors
/// The connection breaks.
pub fn serve(from: impl BufRead + Send + 'static, to: impl Write, setup: Setup) -> io::Result<()> {
    let (said, heard) = mpsc::channel();
    let run = Mutex::new(said.clone());
    let ear: sim::Ear = Arc::new(move |report| {
        // A session that is over hears nothing.
        let _ = run.lock().unwrap_or_else(PoisonError::into_inner).send(Heard::Run(report));
    });
    std::thread::spawn(move || {
        let mut from = from;
        while let Ok(Some(message)) = wire::read(&mut from) {
            if said.send(Heard::Editor(message)).is_err() {
                return;
            }
        }
        let _ = said.send(Heard::Gone);
    });
    let mut session = Session::new(to, setup, ear);
    for heard in heard {
        match heard {
            Heard::Editor(request) if !session.serve(&request)? => return Ok(()),
            Heard::Editor(_) => {}
            Heard::Run(report) => session.report(report)?,
            Heard::Gone => {
                session.close();
                return Ok(());
            }
        }
    }
    Ok(())
}
