//! One page as the server sees it: its queue of messages, and the thread that sends them.

use std::collections::VecDeque;
use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tungstenite::Message;

use super::message::{self, ToPage};
use super::ws;
use crate::helm::User;

/// Messages that may wait for a slow page, and their bytes; a page that is slower is dropped. A path is
/// one buffer for all pages.
const MOST_WAITING: usize = 500;
const MOST_BYTES: usize = 8 << 20;
/// Between two pings.
const PING: Duration = Duration::from_secs(5);
/// States whose times are remembered for their echoes.
const STATES: usize = 64;
/// A state that a page echoes must have left no longer ago.
pub const ECHO_FRESH: Duration = Duration::from_millis(250);

enum Out {
    Text(Arc<str>),
    Bytes(Arc<Vec<u8>>),
    /// Frames that the reading half of the socket made.
    Frames(Vec<u8>),
    Close,
}

impl Out {
    /// What it keeps in memory for this page.
    fn own_bytes(&self) -> usize {
        match self {
            Out::Text(text) => text.len(),
            Out::Frames(bytes) => bytes.len(),
            Out::Bytes(_) | Out::Close => 0,
        }
    }
}

/// A page.
pub struct Client {
    /// Its turn at the helm.
    pub user: User,
    /// Its number, for the language server's answers.
    pub number: u64,
    /// It proved that it knows the secret.
    known: AtomicBool,
    out: Mutex<VecDeque<Out>>,
    called: Condvar,
    stream: TcpStream,
    /// When the newest states left, by their numbers.
    states: Mutex<VecDeque<(u64, Instant)>>,
    gone: AtomicBool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Client {
    /// A page at the other end of a stream.
    ///
    /// # Errors
    /// The stream is gone.
    pub fn new(stream: &TcpStream) -> io::Result<Client> {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Ok(Client {
            user: User::new(),
            number: NEXT.fetch_add(1, Ordering::Relaxed),
            known: AtomicBool::new(false),
            out: Mutex::default(),
            called: Condvar::new(),
            stream: stream.try_clone()?,
            states: Mutex::default(),
            gone: AtomicBool::new(false),
        })
    }

    /// Whether it proved that it knows the secret.
    pub fn is_known(&self) -> bool {
        self.known.load(Ordering::SeqCst)
    }

    /// It proved it.
    pub fn welcome(&self) {
        self.known.store(true, Ordering::SeqCst);
    }

    /// Whether it was dropped.
    pub fn is_gone(&self) -> bool {
        self.gone.load(Ordering::SeqCst)
    }

    /// Sends a message as soon as it can be taken.
    pub fn send(&self, message: &ToPage) {
        self.send_text(message::text(message).into());
    }

    /// Sends a message that was written already: one buffer for all pages that get it.
    pub fn send_text(&self, text: Arc<str>) {
        self.push(Out::Text(text));
    }

    /// Sends bytes.
    pub fn send_bytes(&self, bytes: Arc<Vec<u8>>) {
        self.push(Out::Bytes(bytes));
    }

    /// Sends frames that the reading half of the socket made.
    pub fn frames(&self, bytes: Vec<u8>) {
        self.push(Out::Frames(bytes));
    }

    /// Says good-bye behind what waits.
    pub fn close(&self) {
        self.push(Out::Close);
    }

    /// Ends the connection at once.
    pub fn drop_it(&self) {
        self.gone.store(true, Ordering::SeqCst);
        let _ = self.stream.shutdown(Shutdown::Both);
        self.called.notify_one();
    }

    /// Whether the page takes what it is sent: a state is left out otherwise, an answer never.
    pub fn is_idle(&self) -> bool {
        lock(&self.out).is_empty()
    }

    fn push(&self, out: Out) {
        let mut waiting = lock(&self.out);
        waiting.push_back(out);
        let bytes: usize = waiting.iter().map(Out::own_bytes).sum();
        let slow = waiting.len() > MOST_WAITING || bytes > MOST_BYTES;
        if slow {
            waiting.clear();
        }
        drop(waiting);
        if slow {
            self.drop_it();
        }
        self.called.notify_one();
    }

    /// State number `n` leaves now.
    pub fn state_leaves(&self, n: u64) {
        let mut states = lock(&self.states);
        states.push_back((n, Instant::now()));
        if states.len() > STATES {
            states.pop_front();
        }
    }

    /// Whether the page has drawn a state that left a moment ago: both directions work, and somebody
    /// can see it.
    pub fn is_fresh(&self, echo: u64) -> bool {
        let states = lock(&self.states);
        states.iter().any(|(n, left)| *n == echo && left.elapsed() < ECHO_FRESH)
    }

    /// Sends what waits until the page is gone.
    pub fn write(&self) {
        let Ok(stream) = self.stream.try_clone() else {
            self.drop_it();
            return;
        };
        let mut to = ws::Writer::new(stream);
        let mut pinged = Instant::now();
        while !self.is_gone() {
            let mut waiting = lock(&self.out);
            if waiting.is_empty() {
                let left = PING.saturating_sub(pinged.elapsed());
                waiting = self
                    .called
                    .wait_timeout(waiting, left)
                    .unwrap_or_else(PoisonError::into_inner)
                    .0;
            }
            let next = waiting.pop_front();
            drop(waiting);
            let sent = match next {
                Some(Out::Text(text)) => to.send(Message::text(&*text)),
                Some(Out::Bytes(bytes)) => to.send(Message::binary(bytes.to_vec())),
                Some(Out::Frames(bytes)) => to.frames(&bytes),
                Some(Out::Close) => {
                    let _ = to.send(Message::Close(None));
                    break;
                }
                None if pinged.elapsed() >= PING => {
                    pinged = Instant::now();
                    to.send(Message::Ping(Vec::new().into()))
                }
                None => Ok(()),
            };
            if sent.is_err() {
                break;
            }
        }
        self.drop_it();
    }
}

#[cfg(test)]
mod tests {
    use std::net::{TcpListener, TcpStream};

    use super::{Client, MOST_BYTES, Out, lock};

    #[test]
    fn a_page_that_reads_nothing_is_dropped_with_what_waits() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let _page = TcpStream::connect(listener.local_addr().expect("an address")).expect("a page");
        let client = Client::new(&listener.accept().expect("a page").0).expect("a page");
        let text: std::sync::Arc<str> = "x".repeat(MOST_BYTES / 8).into();
        for _ in 0..8 {
            client.send_text(text.clone());
        }
        assert!(!client.is_gone() && lock(&client.out).len() == 8);
        client.push(Out::Frames(vec![0]));
        assert!(client.is_gone() && lock(&client.out).is_empty());
    }
}
