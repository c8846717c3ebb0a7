//! A board that lies: random bytes, replies that are sound frames with any content, exceptions,
//! a line that never rests.

use std::collections::VecDeque;
use std::io;
use std::time::Duration;

use lang::profile::Profile;

use super::super::stand::framed;
use crate::client::Client;
use crate::client::trace::Tracer;
use crate::link::{Link, Mode};

/// Bytes that a client hears at most: then the line is dead.
const TALK: u64 = 200_000;
/// Longest that a client may deal with such a board, on the link's clock.
const PATIENCE: Duration = Duration::from_secs(3_600);

/// A board whose answers are made of some bytes.
struct Liar<'a> {
    data: &'a [u8],
    at: usize,
    said: u64,
    now: Duration,
    out: VecDeque<u8>,
}

impl Liar<'_> {
    /// The next byte of the input, over and over.
    fn next(&mut self) -> u8 {
        let byte = self.data.get(self.at % self.data.len().max(1)).copied().unwrap_or(0);
        self.at += 1;
        // The same bytes are other ones the next time round.
        byte.wrapping_add((self.at / self.data.len().max(1)) as u8)
    }

    /// An answer to a request, sound or not.
    fn answer(&mut self, request: &[u8]) {
        let (address, function) =
            (request.first().copied().unwrap_or(1), request.get(1).copied().unwrap_or(3));
        let count = usize::from(request.get(5).copied().unwrap_or(1));
        let sound = |body: Vec<u8>| framed(&body);
        let bytes: Vec<u8> = match self.next() % 8 {
            0 => Vec::new(),
            1 => (0..self.next()).map(|_| self.next()).collect(),
            2 => sound(vec![address, function | 0x80, self.next()]),
            3 => sound((0..self.next() % 60).map(|_| self.next()).collect()),
            _ if function <= 2 => {
                let bytes = count.div_ceil(8);
                let body = (0..bytes).map(|_| self.next());
                sound([address, function, bytes as u8].into_iter().chain(body).collect())
            }
            _ if function <= 4 => {
                let body = (0..2 * count).map(|_| self.next());
                sound([address, function, (2 * count) as u8].into_iter().chain(body).collect())
            }
            _ => sound(request.get(..6).unwrap_or(request).to_vec()),
        };
        self.out.extend(bytes);
    }
}

impl Link for Liar<'_> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.now += Mode::DEFAULT.time_of(bytes.len());
        self.answer(bytes);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        // Now and then it talks without being asked.
        if self.out.is_empty() && self.next() == 0 {
            let byte = self.next();
            self.out.push_back(byte);
        }
        if self.out.is_empty() || self.said > TALK {
            self.now += patience.max(Duration::from_micros(10));
            return Ok(0);
        }
        let count = buffer.len().min(self.out.len()).min(1 + usize::from(self.next() % 32));
        for (place, byte) in buffer.iter_mut().zip(self.out.drain(..count)) {
            *place = byte;
        }
        self.said += count as u64;
        self.now += Mode::DEFAULT.time_of(count);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.now
    }

    fn pause(&mut self, time: Duration) {
        self.now += time;
    }

    fn set_mode(&mut self, _mode: Mode) -> io::Result<bool> {
        Ok(true)
    }
}

/// A client with a board whose answers are made of `data`: whatever it is told, it ends.
///
/// # Errors
/// The client does not end.
pub fn client_replies(data: &[u8]) -> Result<(), String> {
    let liar = Liar { data, at: 0, said: 0, now: Duration::ZERO, out: VecDeque::new() };
    let mut client = Client::new(liar, 1);
    // Each may succeed or fail: what counts is that it comes back.
    let _ = client.find();
    let _ = client.identity();
    let _ = client.board_record();
    let _ = client.status();
    let _ = client.take_print();
    let _ = client.unlock("code");
    let _ = client.set_lock([1, 2]);
    let _ = client.upload(&[0x55; 300], true, &mut |_| {});
    let profile = Profile::built_in("mill").map_err(|error| error.to_string())?;
    let queued = client.begin_trace(data.len().is_multiple_of(2)).unwrap_or_default();
    let mut tracer = Tracer::new(profile, Box::new(u32::from)).queued(queued);
    for _ in 0..40 {
        let _ = tracer.poll(&mut client);
    }
    let _ = client.restart();
    match client.link().now() <= PATIENCE {
        true => Ok(()),
        false => Err("the client does not come back within an hour".to_owned()),
    }
}
