//! The two halves of a page's WebSocket: one thread reads, another one writes. The protocol is
//! `tungstenite`'s, which wants one stream for both; so each half has its own state, and what the reading
//! half has to answer goes through the writing one's queue.

use std::io::{self, Read, Write};
use std::net::TcpStream;

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

pub use tungstenite::handshake::derive_accept_key as accept;

/// Longest message of a page, bytes.
pub const LONGEST: usize = 1 << 20;

fn config() -> WebSocketConfig {
    WebSocketConfig::default()
        .max_message_size(Some(LONGEST))
        .max_frame_size(Some(LONGEST))
        .read_buffer_size(16 << 10)
}

/// A stream that is read, and takes whole frames to be written elsewhere.
struct Half<R, A> {
    from: R,
    answer: A,
    frames: Vec<u8>,
}

impl<R: Read, A> Read for Half<R, A> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.from.read(buffer)
    }
}

impl<R, A: FnMut(Vec<u8>)> Write for Half<R, A> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.frames.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if !self.frames.is_empty() {
            (self.answer)(std::mem::take(&mut self.frames));
        }
        Ok(())
    }
}

/// Reads what a page sends.
pub struct Reader<R: Read, A: FnMut(Vec<u8>)>(WebSocket<Half<R, A>>);

impl<R: Read, A: FnMut(Vec<u8>)> Reader<R, A> {
    /// Reads from a stream behind the handshake; `answer` takes frames for the page: pongs, and the
    /// answer to its good-bye.
    pub fn new(from: R, answer: A) -> Reader<R, A> {
        let half = Half { from, answer, frames: Vec::new() };
        Reader(WebSocket::from_raw_socket(half, Role::Server, Some(config())))
    }

    /// The stream.
    pub fn stream(&mut self) -> &mut R {
        &mut self.0.get_mut().from
    }

    /// The next text; `None`: the page says good-bye.
    ///
    /// # Errors
    /// The page is gone, silent, or breaks the protocol.
    pub fn read(&mut self) -> io::Result<Option<String>> {
        loop {
            match self.0.read() {
                Ok(Message::Text(text)) => return Ok(Some(text.as_str().to_owned())),
                Ok(Message::Ping(_)) => self.0.flush().map_err(io::Error::other)?,
                Ok(Message::Pong(_)) => {}
                Ok(Message::Close(_)) => {
                    // The answer is written, and then the protocol is over.
                    let _ = self.0.flush();
                    let _ = self.0.get_mut().flush();
                    return Ok(None);
                }
                Ok(Message::Binary(_) | Message::Frame(_)) => {
                    return Err(io::Error::new(io::ErrorKind::InvalidData, "not a text"));
                }
                Err(Error::Io(error)) => return Err(error),
                Err(error) => return Err(io::Error::new(io::ErrorKind::InvalidData, error)),
            }
        }
    }
}

/// Sends to a page.
pub struct Writer(WebSocket<TcpStream>);

impl Writer {
    /// Writes to a stream behind the handshake.
    pub fn new(stream: TcpStream) -> Writer {
        Writer(WebSocket::from_raw_socket(stream, Role::Server, Some(config())))
    }

    /// Sends a message.
    ///
    /// # Errors
    /// The page is gone or takes nothing.
    pub fn send(&mut self, message: Message) -> io::Result<()> {
        self.0.send(message).map_err(io::Error::other)
    }

    /// Sends frames that the reading half made.
    ///
    /// # Errors
    /// The page is gone or takes nothing.
    pub fn frames(&mut self, frames: &[u8]) -> io::Result<()> {
        self.0.get_mut().write_all(frames)
    }
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Reader, accept};

    /// The texts of some bytes up to their end or to what is wrong with them, and what is answered.
    fn all(bytes: &[u8]) -> (Vec<String>, bool, Vec<u8>) {
        let mut answered = Vec::new();
        let mut texts = Vec::new();
        let mut reader = Reader::new(bytes, |frames| answered.extend(frames));
        let good = loop {
            match reader.read() {
                Ok(Some(text)) => texts.push(text),
                Ok(None) => break true,
                Err(error) => break error.kind() != std::io::ErrorKind::InvalidData,
            }
        };
        drop(reader);
        (texts, good, answered)
    }

    fn masked(op: u8, body: &[u8]) -> Vec<u8> {
        let mut out = vec![op, 0x80 | body.len() as u8, 1, 2, 3, 4];
        out.extend(body.iter().enumerate().map(|(i, byte)| byte ^ [1, 2, 3, 4][i % 4]));
        out
    }

    #[test]
    fn the_standards_examples_are_met() {
        assert_eq!(accept(b"dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
        // RFC 6455, 5.7: a masked "Hello", then an unmasked one, which a server must refuse.
        let hello = [0x81, 0x85, 0x37, 0xFA, 0x21, 0x3D, 0x7F, 0x9F, 0x4D, 0x51, 0x58];
        assert_eq!(all(&hello).0, ["Hello"]);
        assert!(!all(&[0x81, 0x05, 0x48, 0x65, 0x6C, 0x6C, 0x6F]).1);
    }

    #[test]
    fn fragments_are_joined_with_a_ping_between_that_is_answered() {
        let bytes = [masked(0x01, b"Hel"), masked(0x89, b"p"), masked(0x80, b"lo")].concat();
        let (texts, _, answered) = all(&bytes);
        assert_eq!((texts, answered), (vec!["Hello".to_owned()], vec![0x8A, 1, b'p']));
        let (_, good, answered) = all(&masked(0x88, &[]));
        assert!(good && answered == [0x88, 0], "{answered:?}");
    }

    #[test]
    fn nonsense_is_refused() {
        let long = [&[0x81, 0xFF][..], &u64::MAX.to_be_bytes(), &[0; 4]].concat();
        let over = [&[0x81, 0xFF][..], &(LONGEST as u64 + 1).to_be_bytes(), &[0; 4]].concat();
        let twice = [masked(0x01, b"a"), masked(0x81, b"b")].concat();
        for wrong in [
            long,
            over,
            twice,
            masked(0xC1, b"x"),
            masked(0x82, b"x"),
            masked(0x80, b"x"),
            masked(0x09, b"x"),
            masked(0x81, b"\xFF"),
        ] {
            let (texts, good, _) = all(&wrong);
            assert!(texts.is_empty() && !good, "{wrong:?} gave {texts:?}");
        }
    }

    proptest::proptest! {
        #[test]
        fn any_bytes_end(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..300)) {
            let _ = all(&bytes);
            let _ = super::super::http::parse(&bytes);
        }
    }
}
