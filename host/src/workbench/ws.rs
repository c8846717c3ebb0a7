//! WebSocket (RFC 6455), the server's side: texts from the page, texts and bytes to it. Reading and
//! writing may be in two threads.

use std::io::{self, Read, Write};

/// Longest message of a page, bytes.
pub const LONGEST: usize = 1 << 20;

/// What the page's key becomes in the server's answer (RFC 6455, 4.2.2).
pub fn accept(key: &str) -> String {
    let mut sha = sha1_smol::Sha1::new();
    sha.update(key.as_bytes());
    sha.update(b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11");
    base64(&sha.digest().bytes())
}

fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let bits = chunk.iter().fold(0u32, |bits, byte| bits << 8 | u32::from(*byte));
        let bits = bits << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let sign = SIGNS[(bits >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= chunk.len() { char::from(sign) } else { '=' });
        }
    }
    out
}

/// What a page sends.
#[derive(Debug, PartialEq, Eq)]
pub enum Message {
    /// A text, its fragments joined.
    Text(String),
    /// To be answered by a pong with the same bytes.
    Ping(Vec<u8>),
    /// The answer to a ping.
    Pong,
    /// It goes.
    Close,
}

/// Opcodes (RFC 6455, 5.2).
pub mod opcode {
    /// A text.
    pub const TEXT: u8 = 1;
    /// Bytes.
    pub const BYTES: u8 = 2;
    /// Good-bye.
    pub const CLOSE: u8 = 8;
    /// Are you there?
    pub const PING: u8 = 9;
    /// I am.
    pub const PONG: u8 = 10;
}

/// The next message. `whole` keeps the fragments of a text while control frames come between.
///
/// # Errors
/// The page is gone, silent, or breaks the protocol.
pub fn read(from: &mut impl Read, whole: &mut Option<Vec<u8>>) -> io::Result<Message> {
    let bad = |why| io::Error::new(io::ErrorKind::InvalidData, why);
    loop {
        let mut head = [0; 2];
        from.read_exact(&mut head)?;
        let (last, op) = (head[0] & 0x80 != 0, head[0] & 0x0F);
        if head[0] & 0x70 != 0 {
            return Err(bad("reserved bits"));
        }
        if head[1] & 0x80 == 0 {
            return Err(bad("a page must mask"));
        }
        let length = match head[1] & 0x7F {
            126 => {
                let mut bytes = [0; 2];
                from.read_exact(&mut bytes)?;
                u64::from(u16::from_be_bytes(bytes))
            }
            127 => {
                let mut bytes = [0; 8];
                from.read_exact(&mut bytes)?;
                u64::from_be_bytes(bytes)
            }
            short => u64::from(short),
        };
        let have = whole.as_ref().map_or(0, Vec::len);
        let control = op >= opcode::CLOSE;
        if length > (LONGEST - have.min(LONGEST)) as u64 || (control && (length > 125 || !last)) {
            return Err(bad("too long"));
        }
        let mut mask = [0; 4];
        from.read_exact(&mut mask)?;
        // Grows as the bytes come: a length alone takes no memory.
        let mut body = Vec::new();
        from.take(length).read_to_end(&mut body)?;
        if body.len() as u64 != length {
            return Err(bad("cut short"));
        }
        for (i, byte) in body.iter_mut().enumerate() {
            *byte ^= mask[i % 4];
        }
        match (op, whole.is_some()) {
            (opcode::CLOSE, _) => return Ok(Message::Close),
            (opcode::PING, _) => return Ok(Message::Ping(body)),
            (opcode::PONG, _) => return Ok(Message::Pong),
            (opcode::TEXT, false) | (0, true) => whole.get_or_insert_default().extend(body),
            _ => return Err(bad("opcode")),
        }
        if last {
            let text = whole.take().unwrap_or_default();
            return String::from_utf8(text).map(Message::Text).map_err(|_| bad("not UTF-8"));
        }
    }
}

/// Writes a frame in one piece.
///
/// # Errors
/// The page is gone or takes nothing.
pub fn write(to: &mut impl Write, op: u8, body: &[u8]) -> io::Result<()> {
    let mut out = Vec::with_capacity(body.len() + 10);
    out.push(0x80 | op);
    match (u8::try_from(body.len()), u16::try_from(body.len())) {
        (Ok(n @ 0..=125), _) => out.push(n),
        (_, Ok(n)) => {
            out.push(126);
            out.extend(n.to_be_bytes());
        }
        _ => {
            out.push(127);
            out.extend((body.len() as u64).to_be_bytes());
        }
    }
    out.extend_from_slice(body);
    to.write_all(&out)
}

#[cfg(test)]
mod tests {
    use super::{LONGEST, Message, accept, read, write};

    /// Frames one after the other.
    fn all(mut bytes: &[u8]) -> Vec<Result<Message, String>> {
        let mut whole = None;
        let mut found = Vec::new();
        while !bytes.is_empty() {
            let next = read(&mut bytes, &mut whole).map_err(|error| error.to_string());
            let failed = next.is_err();
            found.push(next);
            if failed {
                break;
            }
        }
        found
    }

    fn masked(op: u8, body: &[u8]) -> Vec<u8> {
        let mut out = vec![op, 0x80 | body.len() as u8, 1, 2, 3, 4];
        out.extend(body.iter().enumerate().map(|(i, byte)| byte ^ [1, 2, 3, 4][i % 4]));
        out
    }

    #[test]
    fn the_standards_examples_are_met() {
        assert_eq!(accept("dGhlIHNhbXBsZSBub25jZQ=="), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
        // RFC 6455, 5.7: a masked "Hello", then an unmasked one, which a server must refuse.
        let masked = [0x81, 0x85, 0x37, 0xFA, 0x21, 0x3D, 0x7F, 0x9F, 0x4D, 0x51, 0x58];
        assert_eq!(all(&masked), [Ok(Message::Text("Hello".to_owned()))]);
        let mut sent = Vec::new();
        write(&mut sent, 1, b"Hello").expect("memory");
        assert_eq!(sent, [0x81, 0x05, 0x48, 0x65, 0x6C, 0x6C, 0x6F]);
        assert!(all(&sent)[0].is_err());
    }

    #[test]
    fn fragments_are_joined_with_a_ping_between() {
        let bytes = [masked(0x01, b"Hel"), masked(0x89, b"p"), masked(0x80, b"lo")].concat();
        let wanted = [Ok(Message::Ping(b"p".to_vec())), Ok(Message::Text("Hello".to_owned()))];
        assert_eq!(all(&bytes), wanted);
    }

    #[test]
    fn nonsense_is_refused_without_memory() {
        let long = [&[0x81, 0xFF][..], &u64::MAX.to_be_bytes(), &[0; 4]].concat();
        let over = [&[0x81, 0xFF][..], &(LONGEST as u64 + 1).to_be_bytes(), &[0; 4]].concat();
        for wrong in [
            long,
            over,
            masked(0xC1, b"x"),
            masked(0x82, b"x"),
            masked(0x80, b"x"),
            masked(0x09, b"x"),
            masked(0x81, b"\xFF"),
            vec![0x81, 0x84, 1, 2],
        ] {
            let found = all(&wrong);
            assert!(found.last().is_some_and(Result::is_err), "{wrong:?} gave {found:?}");
        }
        let twice = [masked(0x01, b"a"), masked(0x81, b"b")].concat();
        assert!(all(&twice).last().is_some_and(Result::is_err));
    }

    proptest::proptest! {
        #[test]
        fn any_bytes_end(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..300)) {
            let _ = all(&bytes);
            let _ = super::super::http::parse(&bytes);
        }
    }
}
