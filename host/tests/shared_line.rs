//! Several clients at the TCP port of a virtual board: what one of them moves by command ends with it.

mod common;

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use common::Board;

/// A Modbus TCP client.
struct Master(TcpStream);

impl Master {
    fn new(port: u16) -> Master {
        let begun = Instant::now();
        let stream = loop {
            match TcpStream::connect(("127.0.0.1", port)) {
                Ok(stream) => break stream,
                Err(error) => assert!(begun.elapsed() < Duration::from_secs(20), "{error}"),
            }
            std::thread::sleep(Duration::from_millis(50));
        };
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a socket");
        Master(stream)
    }

    fn ask(&mut self, pdu: &[u8]) -> Vec<u8> {
        let length = (pdu.len() + 1) as u8;
        self.0.write_all(&[&[0, 7, 0, 0, 0, length, 1], pdu].concat()).expect("sent");
        let mut head = [0; 7];
        self.0.read_exact(&mut head).expect("a reply");
        let mut reply = vec![0; usize::from(head[5]) - 1];
        self.0.read_exact(&mut reply).expect("all of it");
        reply
    }

    /// Command 102: the axis runs at 500 steps/s until it is stopped.
    fn run(&mut self, axis: u8) {
        let mut pdu = vec![16, 0x07, 0xD0, 0, 6, 12, 0, 102, 0, axis];
        pdu.extend([0x4E, 0x20, 0, 0, 0x01, 0xF4, 0, 0]);
        assert_eq!(self.ask(&pdu)[0], 16);
    }

    /// The bits of the axes that move, of input register 1016.
    fn moving(&mut self) -> u8 {
        let reply = self.ask(&[4, 0x03, 0xF8, 0, 1]);
        reply[3] & 7
    }
}

fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind(("127.0.0.1", 0)).expect("a port");
    listener.local_addr().expect("its number").port()
}

#[test]
fn a_jog_of_a_client_that_is_gone_ends_though_another_one_polls() {
    for part in ["f5529", "g2553"] {
        let port = free_port();
        let _board = Board::start(&["--part", part, "--tcp", &port.to_string()]);
        let mut hmi = Master::new(port);
        let mut gone = Master::new(port);
        gone.run(1);
        assert_eq!(hmi.moving(), 1, "{part}");
        drop(gone);
        let begun = Instant::now();
        while hmi.moving() != 0 {
            assert!(begun.elapsed() < Duration::from_secs(10), "{part}: it goes on");
            std::thread::sleep(Duration::from_millis(100));
        }
        // Whoever goes on asking keeps its own.
        let mut stays = Master::new(port);
        stays.run(2);
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(4) {
            assert_eq!((hmi.moving(), stays.moving()), (2, 2), "{part}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }
}
