//! Uploads through adapters that tear long requests apart, on this line and beyond a gateway.

use std::io;
use std::time::Duration;

use lang::profile::Profile;

use super::framed;
use super::late::emulated;
use crate::bench::stand::image_on;
use crate::board::F5529;
use crate::board::link::InProcess;
use crate::client::Client;
use crate::link::{Link, Mode};

/// Bytes of a packet.
const PACKET: usize = 64;

/// A link to an emulated board on which a request of more than a packet gets this in place of its reply.
struct Torn {
    link: InProcess,
    instead: Vec<u8>,
    heard: Vec<u8>,
    torn: usize,
}

impl Link for Torn {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        if bytes.len() <= PACKET {
            return self.link.send(bytes);
        }
        self.torn += 1;
        self.heard.clone_from(&self.instead);
        Ok(())
    }

    fn receive(&mut self, buffer: &mut [u8], patience: Duration) -> io::Result<usize> {
        if self.heard.is_empty() {
            return self.link.receive(buffer, patience);
        }
        let count = self.heard.len().min(buffer.len());
        buffer[..count].copy_from_slice(&self.heard[..count]);
        self.heard.drain(..count);
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.link.now()
    }

    fn pause(&mut self, time: Duration) {
        self.link.pause(time);
    }

    fn set_mode(&mut self, mode: Mode) -> io::Result<bool> {
        self.link.set_mode(mode)
    }
}

#[test]
fn a_program_comes_through_a_line_that_tears_long_requests() {
    let mill = Profile::built_in("mill").expect("built in");
    let script: String = (0..40).map(|n| format!("PRINT \"line {n}\"\n")).collect();
    let (_, image) = image_on(&F5529.part, &mill, &script).expect("a program");
    assert!(image.len() > 2 * PACKET);
    for instead in [Vec::new(), vec![0xA5; 9], framed(&[1, 0x90, 11])] {
        let link =
            Torn { link: emulated(&F5529), instead: instead.clone(), heard: Vec::new(), torn: 0 };
        let mut client = Client::new(link, 1);
        let uploaded = client.upload(&image, false, &mut |_| {});
        assert!(uploaded.is_ok(), "{instead:x?}: {}", uploaded.unwrap_err());
        assert!(client.link().torn > 0, "{instead:x?}: no request was long");
        assert!(client.identity().expect("it answers").holds(&image));
    }
}
