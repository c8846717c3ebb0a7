//! Clients of the board: a pseudo-terminal and TCP connections, each with its requests and the replies
//! still to be sent.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{IpAddr, TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

use super::pty::Pty;
use super::turns::{Answer, Ask, Manner, Question, Turns};
use crate::link::adu::{open_rtu, rtu};
use crate::link::mover::{END_JOG, Mover};
use crate::link::{Link, Pipe};

/// Clients at the TCP port at a time.
const MOST_CLIENTS: usize = 32;
/// A client that does not read its answers is let go when so many bytes wait for it.
const MOST_WAITING: usize = 65_536;
/// A client's requests are not read further while so many bytes of them wait.
const MOST_ASKED: usize = 4_096;
/// The number of who ends the motion of a client that is gone; no client has it.
const KEEPER: u64 = u64::MAX;
/// Bytes that make no whole frame go to the line when no more come for this long.
const GATHER: Duration = Duration::from_millis(4);

enum Port {
    Pty(Pty),
    Tcp(TcpStream),
    Pipe(Pipe),
}

struct Client {
    id: u64,
    port: Port,
    ask: Ask,
    /// When bytes came last.
    grown: Instant,
    outgoing: Vec<u8>,
}

/// The connections of a board, which share its one line.
#[derive(Default)]
pub struct Clients {
    listener: Option<(TcpListener, Manner)>,
    list: Vec<Client>,
    next_id: u64,
    /// Whose turn is looked for first.
    first: usize,
    turns: Turns,
    /// Who moves the board, whose address is with it.
    mover: (Mover, u8),
}

impl Clients {
    /// Opens a pseudo-terminal, with `link` pointing to it if that is given. Its device's path
    /// comes back.
    ///
    /// # Errors
    /// The system has none, or `link` exists and is no link.
    pub fn open_pty(&mut self, link: Option<&Path>) -> io::Result<String> {
        let pty = Pty::open(link)?;
        let device = pty.device().to_owned();
        self.add(Port::Pty(pty), Manner::Serial);
        Ok(device)
    }

    /// Listens on a TCP port of one of this machine's addresses; 0 takes a free one. The port comes
    /// back.
    ///
    /// # Errors
    /// The port is taken, or the address is not this machine's.
    pub fn open_tcp(&mut self, on: IpAddr, port: u16, manner: Manner) -> io::Result<u16> {
        let listener = TcpListener::bind((on, port))?;
        listener.set_nonblocking(true)?;
        let port = listener.local_addr()?.port();
        self.listener = Some((listener, manner));
        Ok(port)
    }

    /// Takes the other end of a host in this process, instead of the one before.
    pub fn attach(&mut self, pipe: Pipe) {
        self.list.retain(|client| !matches!(client.port, Port::Pipe(_)));
        self.add(Port::Pipe(pipe), Manner::Serial);
    }

    fn add(&mut self, port: Port, manner: Manner) {
        let (id, grown) = (self.next_id, Instant::now());
        self.next_id += 1;
        self.list.push(Client { id, port, ask: Ask::new(manner), grown, outgoing: Vec::new() });
    }

    fn accept(&mut self) {
        let Some((listener, manner)) = &self.listener else { return };
        let (manner, room) = (*manner, MOST_CLIENTS.saturating_sub(self.list.len()));
        let mut came = Vec::new();
        while let Ok((client, _)) = listener.accept() {
            let ready = client.set_nonblocking(true).and_then(|()| client.set_nodelay(true));
            if ready.is_ok() && came.len() < room {
                came.push(client);
            }
        }
        for client in came {
            self.add(Port::Tcp(client), manner);
        }
    }

    /// Takes what has come; waits up to `wait` for it.
    pub fn read(&mut self, wait: Duration) {
        self.accept();
        let mut waited = false;
        self.list.retain_mut(|client| {
            let before = client.ask.waiting();
            if before >= MOST_ASKED {
                return true;
            }
            let alive = match &mut client.port {
                Port::Pty(pty) => {
                    pty.read(client.ask.bytes(), wait);
                    waited = true;
                    true
                }
                Port::Tcp(stream) => read_tcp(stream, client.ask.bytes()),
                Port::Pipe(pipe) => {
                    let mut buffer = [0; 512];
                    waited = true;
                    pipe.receive(&mut buffer, wait)
                        .map(|count| client.ask.bytes().extend(&buffer[..count]))
                        .is_ok()
                }
            };
            if client.ask.waiting() != before {
                client.grown = Instant::now();
            }
            alive
        });
        if !waited {
            std::thread::sleep(wait);
        }
    }

    /// Whether nobody asks or is to be told anything, and whoever does next ends the wait of [`Clients::read`].
    pub fn rest(&self) -> bool {
        let rests = |client: &Client| {
            matches!(client.port, Port::Pipe(_))
                && client.ask.waiting() == 0
                && client.outgoing.is_empty()
        };
        self.listener.is_none()
            && !self.list.is_empty()
            && self.turns.is_free()
            && self.mover.0.until().is_none()
            && self.list.iter().all(rests)
    }

    /// Bytes for the board, when the line is free and somebody has asked; `now` in us.
    pub fn next(&mut self, now: u64) -> Option<Vec<u8>> {
        if !self.turns.is_free() {
            return None;
        }
        let time = Duration::from_micros(now);
        if self.mover.0.ends(time) {
            let frame = rtu(self.mover.1, &END_JOG);
            return Some(self.turns.begin(KEEPER, Question::Serial(frame), now));
        }
        let count = self.list.len();
        for place in 0..count {
            let at = (self.first + place) % count;
            let client = &mut self.list[at];
            match client.ask.next(client.grown.elapsed() >= GATHER) {
                Ok(Some(question)) => {
                    self.first = at + 1;
                    let frame = self.turns.begin(client.id, question, now);
                    if let Some((address, pdu)) = open_rtu(&frame) {
                        self.mover.0.asks(client.id, pdu, time);
                        self.mover.1 = address;
                    }
                    return Some(frame);
                }
                Ok(None) => {}
                Err(_) => {
                    // As nothing behind it can be understood, the client goes.
                    self.list.remove(at);
                    return None;
                }
            }
        }
        None
    }

    /// The board sent these bytes, each with its time, us.
    pub fn heard(&mut self, bytes: &[(u64, u8)]) {
        self.turns.heard(bytes);
    }

    /// Passes on what is to be passed on at `now`, in us.
    pub fn answer(&mut self, now: u64) {
        for answer in self.turns.answers(now) {
            for client in &mut self.list {
                match &answer {
                    Answer::To(id, bytes) if *id == client.id => client.outgoing.extend(bytes),
                    Answer::Unasked(bytes) if client.ask.is_serial() => {
                        client.outgoing.extend(bytes);
                    }
                    _ => {}
                }
            }
        }
        self.list.retain_mut(|client| match &mut client.port {
            Port::Pty(pty) => {
                if !client.outgoing.is_empty() {
                    pty.write(&client.outgoing);
                    client.outgoing.clear();
                }
                true
            }
            Port::Tcp(stream) => write_tcp(stream, &mut client.outgoing),
            Port::Pipe(pipe) => {
                client.outgoing.is_empty()
                    || pipe.send(&std::mem::take(&mut client.outgoing)).is_ok()
            }
        });
    }
}

/// Appends what has come; `false`: the client is gone.
fn read_tcp(stream: &mut TcpStream, bytes: &mut Vec<u8>) -> bool {
    let mut buffer = [0; 512];
    match stream.read(&mut buffer) {
        Ok(0) => false,
        Ok(count) => {
            bytes.extend(&buffer[..count]);
            true
        }
        Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted),
    }
}

/// Sends what the connection takes now; `false`: the client is gone, or does not read.
fn write_tcp(stream: &mut TcpStream, bytes: &mut Vec<u8>) -> bool {
    if bytes.is_empty() {
        return true;
    }
    let alive = match stream.write(bytes) {
        Ok(count) => {
            bytes.drain(..count);
            true
        }
        Err(error) => matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted),
    };
    alive && bytes.len() <= MOST_WAITING
}
