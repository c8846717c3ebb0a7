//! Modbus RTU master for the board's registers: `upload`, `status`, `jog`, the engine
//! `board` and all other commands use it.
//!
//! Every exchange ends: a reply is waited for at most [`Patience::reply`] on the link's own clock,
//! a lost one is asked for again, and noise is skipped until the time is over.

pub mod aout;
pub mod axes;
mod error;
mod frame;
pub mod hall;
pub mod identity;
pub mod library;
pub mod lock;
pub mod orders;
pub mod print;
pub mod standing;
pub mod status;
pub mod stream;
pub mod trace;
pub mod upload;

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::link::adu::{MAX_RTU, open_rtu, rtu};
use crate::link::{Link, Mode};
pub use error::ClientError;
use error::TARGET_SILENT;
use frame::{Bits, Registers, Reply, Request, Scan};

/// How long to wait and how often to ask.
#[derive(Clone, Copy, Debug)]
pub struct Patience {
    /// Longest wait for the end of a reply, beside the time that its bytes take.
    pub reply: Duration,
    /// Attempts in all.
    pub attempts: u32,
}

/// Between two attempts when a gateway says that the board did not answer it.
const BEYOND_GATEWAY: Duration = Duration::from_millis(150);
/// A gateway leaves a board alone after a lost reply, for 500 ms and then for 1 s, and answers in its place meanwhile.
/// So attempts beyond a gateway are bounded by time: this much for each attempt after the first. The usual four last
/// until the gateway has asked the board twice more.
const BEYOND_LONGEST: Duration = Duration::from_millis(900);
/// Modbus function 8, diagnostics: with 0 behind it the echo of two more bytes.
const ECHO: u8 = 8;

/// Longest wait for a reply over TCP, where other clients may have their turns first.
const BY_TCP: Duration = Duration::from_millis(2_000);

impl Default for Patience {
    /// A board answers within some ms; an erase of flash keeps it for 200 ms (wire.rs, Upload).
    fn default() -> Patience {
        Patience { reply: Duration::from_millis(500), attempts: 4 }
    }
}

/// What came of the newest exchange with a board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Heard {
    /// There was none since this was taken.
    #[default]
    Unasked,
    /// A reply, be it that the board refuses.
    Reply,
    /// No reply came, or a gateway on the way said that there is none.
    Nothing,
    /// The port failed.
    Broken,
}

/// A master on a link, for the board with one address.
pub struct Client<L> {
    link: L,
    address: u8,
    mode: Mode,
    patience: Patience,
    /// When the last character came, by the link's clock.
    last_byte: Duration,
    /// Addresses of boards that gave no reply to a request in time. It may still come.
    owed: BTreeSet<u8>,
    /// What came of the newest exchange.
    heard: Heard,
    /// While this is set no exchange begins.
    interrupt: Option<Arc<AtomicBool>>,
}

impl<L: Link> Client<L> {
    /// A master that assumes the link's mode to be right.
    pub fn new(link: L, address: u8) -> Client<L> {
        Client {
            link,
            address,
            mode: Mode::DEFAULT,
            patience: Patience::default(),
            last_byte: Duration::ZERO,
            owed: BTreeSet::new(),
            heard: Heard::Unasked,
            interrupt: None,
        }
    }

    /// The link, for its clock.
    pub fn link(&mut self) -> &mut L {
        &mut self.link
    }

    /// The board that it talks to.
    pub fn address(&self) -> u8 {
        self.address
    }

    /// Talks to another board from now on.
    pub fn set_address(&mut self, address: u8) {
        self.address = address;
    }

    /// Waits otherwise from now on; gives how it waited.
    pub fn set_patience(&mut self, patience: Patience) -> Patience {
        std::mem::replace(&mut self.patience, patience)
    }

    /// Does what makes the board check an image of so many bytes, and waits longer for each reply meanwhile.
    fn while_it_checks<T>(&mut self, length: usize, action: impl FnOnce(&mut Client<L>) -> T) -> T {
        let usual = self.patience;
        self.patience.reply +=
            Duration::from_millis(lang::wire::check_ms(length) - lang::wire::check_ms(0));
        let result = action(self);
        self.patience = usual;
        result
    }

    /// From now on no exchange begins while `interrupt` is set, so that a long job makes room for who
    /// sets it.
    pub fn set_interrupt(&mut self, interrupt: Arc<AtomicBool>) {
        self.interrupt = Some(interrupt);
    }

    fn is_interrupted(&self) -> bool {
        self.interrupt.as_ref().is_some_and(|flag| flag.load(Ordering::SeqCst))
    }

    /// Ends the master and gives the link back.
    pub fn into_link(self) -> L {
        self.link
    }

    /// Rate and parity that the board answered at.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Runs `action` with one attempt for each request, for requests that must not be repeated.
    pub(crate) fn once<T>(
        &mut self,
        action: impl FnOnce(&mut Self) -> Result<T, ClientError>,
    ) -> Result<T, ClientError> {
        let attempts = std::mem::replace(&mut self.patience.attempts, 1);
        let result = action(self);
        self.patience.attempts = attempts;
        result
    }

    /// Tries every rate and parity until the board answers. A link without a rate is asked once.
    ///
    /// # Errors
    /// The board answered at none, or the port failed.
    pub fn find(&mut self) -> Result<(), ClientError> {
        let mut usual = self.patience;
        let mut heard = 0;
        for mode in Mode::all() {
            let has_modes = self.link.set_mode(mode).map_err(ClientError::Port)?;
            if !has_modes && mode != Mode::DEFAULT {
                break;
            }
            self.mode = mode;
            self.owed.clear();
            let reply = if has_modes { Duration::from_millis(150) } else { BY_TCP };
            if !has_modes {
                usual.reply = BY_TCP;
            }
            self.patience = Patience { reply, attempts: 2 };
            let answer = self.holding(lang::wire::VERSION, 1);
            self.patience = usual;
            match answer {
                // A gateway's word that there is no board.
                Err(error @ ClientError::Exception(10 | 11)) => return Err(error),
                // Any answer with a right CRC says that the mode is right.
                Ok(_) | Err(ClientError::Exception(_)) => return Ok(()),
                Err(ClientError::Noise(bytes)) => heard += bytes,
                Err(ClientError::Silent) => {}
                Err(error) => return Err(error),
            }
        }
        Err(if heard > 0 { ClientError::Noise(heard) } else { ClientError::Silent })
    }

    /// Reads holding registers.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn holding(&mut self, first: u16, count: u16) -> Result<Vec<u16>, ClientError> {
        self.registers(Registers::Holding, first, count)
    }

    /// Reads input registers.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn input(&mut self, first: u16, count: u16) -> Result<Vec<u16>, ClientError> {
        self.registers(Registers::Input, first, count)
    }

    /// Reads coils: the outputs.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn coils(&mut self, first: u16, count: u16) -> Result<Vec<bool>, ClientError> {
        self.bits(Bits::Coils, first, count)
    }

    /// Reads discrete inputs: inputs and status bits.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn inputs(&mut self, first: u16, count: u16) -> Result<Vec<bool>, ClientError> {
        self.bits(Bits::Inputs, first, count)
    }

    /// Writes one coil.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn set_coil(&mut self, address: u16, on: bool) -> Result<(), ClientError> {
        self.exchange(&Request::WriteCoil { address, on }).map(drop)
    }

    /// Writes one register.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn write(&mut self, address: u16, value: u16) -> Result<(), ClientError> {
        self.exchange(&Request::WriteRegister { address, value }).map(drop)
    }

    /// Writes registers in one request.
    ///
    /// # Errors
    /// See [`ClientError`].
    pub fn write_all(&mut self, first: u16, values: &[u16]) -> Result<(), ClientError> {
        self.exchange(&Request::WriteRegisters { first, values }).map(drop)
    }

    fn registers(
        &mut self,
        table: Registers,
        first: u16,
        count: u16,
    ) -> Result<Vec<u16>, ClientError> {
        match self.exchange(&Request::ReadRegisters { table, first, count })? {
            Reply::Registers(values) => Ok(values),
            _ => Err(ClientError::Silent),
        }
    }

    fn bits(&mut self, table: Bits, first: u16, count: u16) -> Result<Vec<bool>, ClientError> {
        match self.exchange(&Request::ReadBits { table, first, count })? {
            Reply::Bits(values) => Ok(values),
            _ => Err(ClientError::Silent),
        }
    }

    /// What came of the newest exchange since the last call.
    pub fn take_heard(&mut self) -> Heard {
        std::mem::take(&mut self.heard)
    }

    fn exchange(&mut self, request: &Request<'_>) -> Result<Reply, ClientError> {
        let result = self.ask(request);
        self.heard = match &result {
            Ok(_) => Heard::Reply,
            Err(ClientError::Port(_)) => Heard::Broken,
            Err(ClientError::Exception(10 | TARGET_SILENT) | ClientError::Silent)
            | Err(ClientError::Noise(_)) => Heard::Nothing,
            Err(ClientError::Interrupted) => self.heard,
            Err(_) => Heard::Reply,
        };
        result
    }

    /// Sends a request until its reply comes. Our writes may all be repeated: they set values, and
    /// run control and uploads are made so that a second write of the same changes nothing
    /// (wire.rs).
    fn ask(&mut self, request: &Request<'_>) -> Result<Reply, ClientError> {
        let frame = request.frame(self.address);
        let mut noise = 0;
        if self.is_interrupted() {
            return Err(ClientError::Interrupted);
        }
        let (address, length) = (self.address, request.reply_length());
        let scan = |received: &[u8]| match request.scan(address, received) {
            Scan::Found(reply) => Some(reply),
            Scan::Incomplete => None,
        };
        self.settle(address)?;
        let mut left = self.patience.attempts.max(1);
        let beyond = BEYOND_LONGEST * (left - 1);
        // Since when a gateway says that the board does not answer.
        let mut told = None;
        while left > 0 {
            let result = self.attempt(&frame, length, scan)?;
            let now = self.link.now();
            match result {
                // Beyond a gateway a reply is lost as on a line of ours.
                Ok(Reply::Exception(TARGET_SILENT))
                    if now.saturating_sub(*told.get_or_insert(now)) < beyond =>
                {
                    self.link.pause(BEYOND_GATEWAY);
                }
                Ok(Reply::Exception(code)) => return Err(ClientError::Exception(code)),
                Ok(reply) => return Ok(reply),
                Err(heard) => {
                    noise += heard;
                    left -= 1;
                    self.owed.insert(self.address);
                }
            }
            if self.is_interrupted() {
                break;
            }
        }
        Err(if noise > 0 { ClientError::Noise(noise) } else { ClientError::Silent })
    }

    /// After a request without a reply in time: waits until nothing can come any more that was asked for before.
    ///
    /// A board that is late answers each of the repeated requests. The second reply comes while the next request
    /// waits for its own, and looks like that one where the function is the same: an exception names no register,
    /// and neither do the registers of a read. So a request is sent whose reply cannot be taken for another one's:
    /// function 8, an echo, which nothing else here uses. Our boards do not know it, and their exception names it, too.
    /// A board answers in order: what comes before that reply is old.
    ///
    /// Whether nothing is open any more; `false` when the board does not answer this either.
    fn settle(&mut self, address: u8) -> Result<bool, ClientError> {
        if !self.owed.remove(&address) {
            return Ok(true);
        }
        let answers = |received: &[u8], length: usize| {
            let frames = received.windows(length).filter_map(open_rtu);
            frames.into_iter().any(|(own, pdu)| own == address && pdu[0] & 0x7F == ECHO)
        };
        // The echo, or an exception of two bytes.
        let scan = |received: &[u8]| (answers(received, 8) || answers(received, 5)).then_some(());
        self.attempt(&rtu(address, &[ECHO, 0, 0, 0, 0]), 8, scan).map(|answer| answer.is_ok())
    }

    /// Passes another master's request on, once, to the board with this address: its function and data
    /// as they are. The reply's come back, those of an exception too; without one they are
    /// `length` bytes.
    ///
    /// If the board owes the reply to an earlier request, that is waited for first, as before a request of this
    /// master's own, unless the request is `urgent`: a stop must not wait. A board that owes a reply and is still
    /// silent is not sent the request.
    ///
    /// # Errors
    /// [`ClientError::Silent`], [`ClientError::Noise`], [`ClientError::Port`].
    pub fn pass_on(
        &mut self,
        address: u8,
        pdu: &[u8],
        length: usize,
        urgent: bool,
    ) -> Result<Vec<u8>, ClientError> {
        if !urgent && !self.settle(address)? {
            return Err(ClientError::Silent);
        }
        let function = pdu.first().copied().unwrap_or_default();
        // Address before it, CRC behind it; an exception is two bytes.
        let lengths = [length + 3, 2 + 3];
        // A read's reply has so many bytes as were asked for; a write's repeats its register and its value or count.
        let is_good = |reply: &[u8]| match function {
            1..=4 => reply.get(1).is_some_and(|bytes| usize::from(*bytes) + 2 == reply.len()),
            5 | 6 | 15 | 16 => reply.get(..5) == pdu.get(..5),
            _ => true,
        };
        let found = |received: &[u8], from: usize, length: usize| {
            let (own, reply) = open_rtu(received.get(from..from + length)?)?;
            let refused = length == lengths[1] && reply[0] == function | 0x80;
            let answers = refused || reply[0] == function && is_good(reply);
            (own == address && answers).then(|| reply.to_vec())
        };
        let scan = |received: &[u8]| {
            let places = (0..received.len()).flat_map(|from| lengths.map(|length| (from, length)));
            places.into_iter().find_map(|(from, length)| found(received, from, length))
        };
        match self.attempt(&rtu(address, pdu), lengths[0], scan)? {
            Ok(reply) => Ok(reply),
            Err(heard) => {
                self.owed.insert(address);
                Err(if heard == 0 { ClientError::Silent } else { ClientError::Noise(heard) })
            }
        }
    }

    /// Sets rate and parity of the link. `false`: it has none.
    ///
    /// # Errors
    /// The port does not know the rate.
    pub fn set_mode(&mut self, mode: Mode) -> Result<bool, ClientError> {
        self.owed.clear();
        self.mode = mode;
        self.link.set_mode(mode).map_err(ClientError::Port)
    }

    /// One attempt: what `scan` finds in what has come, or the number of bytes in which it found
    /// nothing. The reply is waited for the time that `length` bytes take and
    /// [`Patience::reply`].
    fn attempt<T>(
        &mut self,
        frame: &[u8],
        length: usize,
        scan: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Result<T, usize>, ClientError> {
        // While it rests the line is free for other processes.
        self.rest();
        if self.link.claim(self.mode).map_err(ClientError::Port)? {
            self.last_byte = self.link.now();
        }
        let result = self.attempt_alone(frame, length, scan);
        self.link.release();
        result
    }

    /// The line rests before a request (Modbus over serial line V1.02, 2.5.1.1), or a slave takes it
    /// for more of the frame before.
    fn rest(&mut self) {
        let rested = self.link.now().saturating_sub(self.last_byte);
        self.link.pause(self.mode.silence().saturating_sub(rested));
    }

    fn attempt_alone<T>(
        &mut self,
        frame: &[u8],
        length: usize,
        scan: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Result<T, usize>, ClientError> {
        self.drain()?;
        self.rest();
        self.link.send(frame).map_err(ClientError::Port)?;
        let on_the_line = self.mode.time_of(frame.len() + length);
        let deadline = self.link.now() + on_the_line + self.patience.reply;
        let mut received: Vec<u8> = Vec::with_capacity(MAX_RTU);
        let mut heard = 0;
        let mut buffer = [0; MAX_RTU];
        loop {
            let left = deadline.saturating_sub(self.link.now());
            if left.is_zero() {
                return Ok(Err(heard));
            }
            let count = self.link.receive(&mut buffer, left).map_err(ClientError::Port)?;
            heard += count;
            self.last_byte = self.link.now();
            received.extend(&buffer[..count]);
            if let Some(reply) = scan(&received) {
                return Ok(Ok(reply));
            }
            // A reply cannot begin further back than its longest length: noise is forgotten.
            let excess = received.len().saturating_sub(MAX_RTU);
            received.drain(..excess);
        }
    }

    /// Drops what came unasked, such as the late reply to an earlier attempt; a line that never
    /// rests is drained for 20 ms only.
    fn drain(&mut self) -> Result<(), ClientError> {
        let end = self.link.now() + Duration::from_millis(20);
        let mut buffer = [0; MAX_RTU];
        while self.link.receive(&mut buffer, Duration::ZERO).map_err(ClientError::Port)? > 0 {
            if self.link.now() >= end {
                break;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
pub(crate) mod tests;
