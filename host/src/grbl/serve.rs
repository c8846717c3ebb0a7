//! Serves a client: reads its port, runs the session, passes commands on to the machine.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use lang::profile::Profile;

use super::desk::Desk;
use super::drive::{Drive, Open};
use super::keep::{KeepFile, Kept};
use super::port::{Event, Ports};
use super::session::Session;
use crate::link::Link;

/// Longest wait for a byte, between two looks at the machine.
const WAIT: Duration = Duration::from_millis(3);
/// Longest wait for rest when the server ends.
const ENDING: Duration = Duration::from_secs(5);

/// What a server is for.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The machine.
    pub profile: Profile,
    /// Where offsets are kept; without it they end with the server.
    pub offsets: Option<PathBuf>,
    /// Name of the board, for people.
    pub name: String,
    /// Whether who comes and goes is told on standard error.
    pub tells: bool,
}

/// A server that serves until this is dropped.
pub struct Server {
    closing: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    driven: Arc<AtomicBool>,
}

impl Server {
    /// Serves the ports, for the board that `open` gives.
    ///
    /// # Errors
    /// The file of offsets is none; in words.
    pub fn start<L: Link + 'static>(
        setting: Setting,
        ports: Ports,
        open: Open<L>,
    ) -> Result<Server, String> {
        let kept = setting.offsets.as_deref().map_or(Ok(Kept::default()), Kept::read)?;
        let desk = Arc::new(Desk::default());
        let closing = Arc::new(AtomicBool::new(false));
        let driven = Arc::new(AtomicBool::new(false));
        let (drive_desk, profile) = (desk.clone(), setting.profile.clone());
        let drive = std::thread::spawn(move || Drive::new(drive_desk, profile, open).run());
        let (over, shown) = (closing.clone(), driven.clone());
        let session = Session::new(&setting.profile, kept);
        let file = KeepFile::new(setting.offsets.clone());
        let talk = std::thread::spawn(move || {
            Talk { setting, ports, session, file, desk, driven: shown }.run(&over);
        });
        // The talk ends first: it stops what runs.
        Ok(Server { closing, threads: vec![talk, drive], driven })
    }

    /// Whether a client is there.
    pub fn is_driven(&self) -> bool {
        self.driven.load(Ordering::SeqCst)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.closing.store(true, Ordering::SeqCst);
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

struct Talk {
    setting: Setting,
    ports: Ports,
    session: Session,
    file: KeepFile,
    desk: Arc<Desk>,
    driven: Arc<AtomicBool>,
}

impl Talk {
    fn run(mut self, over: &AtomicBool) {
        while !over.load(Ordering::SeqCst) {
            let event = self.ports.wait(WAIT);
            let view = self.desk.view();
            match event {
                Event::Came(from) => {
                    self.tell(&format!("{from} drives"));
                    self.session.open(&view);
                }
                Event::Bytes(bytes) => self.session.take(&bytes, &view),
                Event::Gone => {
                    let left = self.session.left_over(&view);
                    self.session.gone(&view);
                    let words = match left {
                        None => "its client is gone".to_owned(),
                        Some(lines) => format!(
                            "its client is gone while it ran: it is stopped, {lines} lines had not begun"
                        ),
                    };
                    self.tell(&words);
                }
                Event::Nothing => {}
            }
            self.session.tick(&view);
            self.driven.store(self.ports.is_driven(), Ordering::SeqCst);
            self.pass_on();
        }
        self.end();
    }

    fn pass_on(&mut self) {
        self.desk.take(self.session.deeds());
        // Before the client hears that it is done.
        if let Some(kept) = self.session.changed()
            && let Err(words) = self.file.write(kept)
        {
            eprintln!("pasapas: grbl: {words}");
        }
        let out = self.session.outgoing();
        if !out.is_empty() {
            self.ports.send(&out);
        }
    }

    /// Nobody is there any more who could stop it.
    fn end(&mut self) {
        let view = self.desk.view();
        self.session.gone(&view);
        self.desk.take(self.session.deeds());
        let begun = Instant::now();
        loop {
            let view = self.desk.view();
            self.session.tick(&view);
            if !self.session.is_stopping() || begun.elapsed() > ENDING {
                break;
            }
            std::thread::sleep(WAIT);
        }
        self.desk.close();
    }

    fn tell(&self, words: &str) {
        if self.setting.tells {
            eprintln!("pasapas: grbl of {}: {words}", self.setting.name);
        }
    }
}
