//! Keyboard input while a job runs: single keys at a terminal, else lines.

use std::io::{BufRead, IsTerminal};
use std::sync::mpsc::{self, Receiver};

use crate::interrupt;

/// What a key asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Key {
    /// `p`
    Pause,
    /// `r`, Enter or the space bar
    Resume,
    /// `q`, Escape, or Ctrl-C
    Stop,
    /// Any other
    Unknown,
}

impl Key {
    fn of(byte: u8) -> Key {
        match byte {
            b'p' | b'P' => Key::Pause,
            b'r' | b'R' | b'\r' | b'\n' | b' ' => Key::Resume,
            // In this mode the terminal sends Ctrl-C as a character: the job stops on a ramp.
            b'q' | b'Q' | 3 | 0x1B => Key::Stop,
            _ => Key::Unknown,
        }
    }
}

/// What the user asks for: by keys, or by Ctrl-C and SIGTERM where no terminal turns that into one.
#[derive(Debug)]
pub(super) struct Keys {
    from: Typed,
    /// The signal was told.
    stopped: bool,
}

/// Where keys come from.
#[derive(Debug)]
enum Typed {
    /// A terminal without line editing.
    #[cfg(unix)]
    Terminal(terminal::Terminal<std::io::Stdin>),
    /// Lines of a pipe, or of a terminal that has no other mode.
    Lines(Receiver<String>),
}

impl Keys {
    /// Listens to standard input and to signals. `busy` when something else is read from there.
    pub(super) fn open(busy: bool) -> Keys {
        interrupt::watch();
        Keys { from: Typed::open(busy), stopped: false }
    }

    /// What they do, for the user; nothing where nobody types.
    pub(super) fn help(&self) -> Option<&'static str> {
        match self.from {
            #[cfg(unix)]
            Typed::Terminal(_) => Some("p pauses, r goes on, q stops"),
            Typed::Lines(_) if std::io::stdin().is_terminal() => {
                Some("p pauses, r goes on, q stops (each with Enter)")
            }
            Typed::Lines(_) => None,
        }
    }

    /// The next key, if one was pressed; the first signal is one.
    pub(super) fn next(&mut self) -> Option<Key> {
        if !self.stopped && interrupt::asked() {
            self.stopped = true;
            return Some(Key::Stop);
        }
        self.from.next()
    }
}

impl Typed {
    fn open(busy: bool) -> Typed {
        let (send, receive) = mpsc::channel();
        if busy {
            return Typed::Lines(receive);
        }
        #[cfg(unix)]
        if let Some(terminal) = terminal::Terminal::open(std::io::stdin()) {
            return Typed::Terminal(terminal);
        }
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines() {
                let Ok(line) = line else { return };
                if send.send(line).is_err() {
                    return;
                }
            }
        });
        Typed::Lines(receive)
    }

    fn next(&mut self) -> Option<Key> {
        match self {
            #[cfg(unix)]
            Typed::Terminal(terminal) => terminal.byte().map(Key::of),
            Typed::Lines(lines) => {
                let line = lines.try_recv().ok()?;
                match line.trim().as_bytes() {
                    [byte] => Some(Key::of(*byte)),
                    _ => Some(Key::Unknown),
                }
            }
        }
    }
}

#[cfg(unix)]
pub(super) mod terminal {
    //! A terminal that gives each key at once.

    use std::os::fd::AsFd;

    use rustix::termios::{
        LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcsetattr,
    };

    /// Set back to what it was when it goes, also while a panic unwinds.
    #[derive(Debug)]
    pub struct Terminal<F: AsFd> {
        file: F,
        before: Termios,
    }

    impl<F: AsFd> Terminal<F> {
        /// `None` when it is no terminal, or belongs to another job of the shell.
        pub fn open(file: F) -> Option<Terminal<F>> {
            let group = rustix::termios::tcgetpgrp(&file).ok()?;
            if group != rustix::process::getpgrp() {
                return None;
            }
            Self::change(file)
        }

        /// Line editing, echo and signals off; what is printed keeps its line ends.
        pub(super) fn change(file: F) -> Option<Terminal<F>> {
            let before = tcgetattr(&file).ok()?;
            let mut modes = before.clone();
            modes.local_modes.remove(LocalModes::ICANON | LocalModes::ECHO | LocalModes::ISIG);
            // A read returns at once, with or without a key.
            modes.special_codes[SpecialCodeIndex::VMIN] = 0;
            modes.special_codes[SpecialCodeIndex::VTIME] = 0;
            tcsetattr(&file, OptionalActions::Now, &modes).ok()?;
            Some(Terminal { file, before })
        }

        /// The next key's first byte. What follows it in the same instant, as behind Escape for an
        /// arrow, is part of that key and means nothing here.
        pub fn byte(&mut self) -> Option<u8> {
            let mut bytes = [0; 64];
            match rustix::io::read(&self.file, &mut bytes) {
                Ok(0) | Err(_) => None,
                Ok(count) if bytes[0] == 0x1B && count > 1 => Some(0),
                Ok(_) => Some(bytes[0]),
            }
        }
    }

    impl<F: AsFd> Drop for Terminal<F> {
        fn drop(&mut self) {
            // Nothing is left to do for a terminal that has gone.
            let _ = tcsetattr(&self.file, OptionalActions::Drain, &self.before);
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::terminal::Terminal;
    use super::{Key, Keys, Typed};
    use rustix::fs::{Mode, OFlags};
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    use rustix::termios::{LocalModes, SpecialCodeIndex, tcgetattr};
    use std::os::fd::OwnedFd;
    use std::time::{Duration, Instant};

    fn pair() -> (OwnedFd, OwnedFd) {
        let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
        grantpt(&near).and_then(|()| unlockpt(&near)).expect("unlocked");
        let name = ptsname(&near, Vec::new()).expect("its name");
        let far = rustix::fs::open(name, OFlags::RDWR | OFlags::NOCTTY, Mode::empty());
        (near, far.expect("its far end"))
    }

    #[test]
    fn keys_need_no_enter_and_the_terminal_is_set_back() {
        let (near, far) = pair();
        let before = tcgetattr(&far).expect("its modes");
        assert!(before.local_modes.contains(LocalModes::ICANON | LocalModes::ECHO));
        let mut terminal = Terminal::change(&far).expect("changed");
        assert_eq!(terminal.byte(), None, "nobody waits for a key");
        let mut press = |bytes: &[u8]| {
            rustix::io::write(&near, bytes).expect("written");
            let begun = Instant::now();
            loop {
                if let Some(byte) = terminal.byte() {
                    return Key::of(byte);
                }
                assert!(begun.elapsed() < Duration::from_secs(5), "{bytes:?}");
            }
        };
        assert_eq!(press(b"p"), Key::Pause);
        assert_eq!(press(b"r"), Key::Resume);
        assert_eq!(press(b" "), Key::Resume);
        assert_eq!(press(b"\x1B[A"), Key::Unknown, "an arrow is no Escape");
        assert_eq!(press(b"\x03"), Key::Stop);
        assert_eq!(press(b"q"), Key::Stop);
        assert_eq!(press(b"x"), Key::Unknown);
        drop(terminal);
        let after = tcgetattr(&far).expect("its modes");
        assert_eq!(after.local_modes, before.local_modes);
        for code in [SpecialCodeIndex::VMIN, SpecialCodeIndex::VTIME] {
            assert_eq!(after.special_codes[code], before.special_codes[code]);
        }
    }

    #[test]
    fn a_pipe_gives_lines() {
        let (send, lines) = std::sync::mpsc::channel();
        let mut keys = Keys { from: Typed::Lines(lines), stopped: false };
        assert_eq!(keys.next(), None);
        for line in ["p", " q \r", "quit"] {
            send.send(line.to_owned()).expect("sent");
        }
        assert_eq!(keys.next(), Some(Key::Pause));
        assert_eq!(keys.next(), Some(Key::Stop));
        assert_eq!(keys.next(), Some(Key::Unknown));
        drop(send);
        assert_eq!(keys.next(), None);
    }
}
