//! As much of HTTP/1.1 (RFC 9112) as a page of our own needs: GET, a request a connection, or the
//! upgrade to a socket.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// The whole head must have come by then.
const HEAD_TIME: Duration = Duration::from_secs(2);
/// Longest head.
const HEAD_BYTES: usize = 8192;
/// No script, style or connection but our own files and socket; nobody may frame the page.
const CSP: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A request's head.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// Without its query.
    pub path: String,
    /// Host.
    pub host: Option<String>,
    /// Origin.
    pub origin: Option<String>,
    /// Sec-WebSocket-Key of an upgrade by version 13.
    pub key: Option<String>,
}

/// Why a head is none.
#[derive(Debug)]
pub enum Bad {
    /// The connection failed or was too slow.
    Io(io::Error),
    /// It is not what we answer.
    Head(&'static str),
}

impl From<io::Error> for Bad {
    fn from(error: io::Error) -> Bad {
        Bad::Io(error)
    }
}

/// Reads a head; what comes behind it is not ours to read, so it is read byte by byte at its end only.
///
/// # Errors
/// See [`Bad`].
pub fn read(stream: &mut TcpStream) -> Result<Request, Bad> {
    let end = Instant::now() + HEAD_TIME;
    let mut head = Vec::with_capacity(1024);
    let mut piece = [0; 1024];
    while !head.ends_with(b"\r\n\r\n") {
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(Bad::Io(io::ErrorKind::TimedOut.into()));
        }
        stream.set_read_timeout(Some(left))?;
        let count = stream.read(&mut piece)?;
        if count == 0 {
            return Err(Bad::Head("cut short"));
        }
        head.extend_from_slice(&piece[..count]);
        if head.len() > HEAD_BYTES {
            return Err(Bad::Head("too long"));
        }
    }
    parse(&head)
}

/// Reads the text of a head.
///
/// # Errors
/// [`Bad::Head`].
pub fn parse(head: &[u8]) -> Result<Request, Bad> {
    let text = std::str::from_utf8(head).map_err(|_| Bad::Head("not text"))?;
    let mut lines = text.split("\r\n");
    let mut first = lines.next().unwrap_or_default().split(' ');
    let (Some("GET"), Some(path), Some("HTTP/1.1"), None) =
        (first.next(), first.next(), first.next(), first.next())
    else {
        return Err(Bad::Head("not a GET"));
    };
    let mut request = Request {
        path: path.split('?').next().unwrap_or_default().to_owned(),
        ..Request::default()
    };
    let (mut key, mut version, mut upgrade) = (None, None, None);
    for line in lines.filter(|line| !line.is_empty()) {
        let (name, value) = line.split_once(':').ok_or(Bad::Head("no header"))?;
        let slot = match name.to_ascii_lowercase().as_str() {
            "host" => &mut request.host,
            "origin" => &mut request.origin,
            "sec-websocket-key" => &mut key,
            "sec-websocket-version" => &mut version,
            "upgrade" => &mut upgrade,
            "content-length" | "transfer-encoding" => return Err(Bad::Head("a GET with a body")),
            _ => continue,
        };
        if slot.replace(value.trim().to_owned()).is_some() {
            return Err(Bad::Head("a header twice"));
        }
    }
    let upgrades = upgrade.is_some_and(|to| to.eq_ignore_ascii_case("websocket"));
    request.key = key.filter(|_| upgrades && version.as_deref() == Some("13"));
    Ok(request)
}

/// Answers with a whole body; the connection ends behind it.
///
/// # Errors
/// The client is gone.
pub fn answer(stream: &mut TcpStream, status: &str, kind: &str, body: &[u8]) -> io::Result<()> {
    let mut all = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
         Content-Security-Policy: {CSP}\r\nX-Content-Type-Options: nosniff\r\n\
         Referrer-Policy: no-referrer\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
        body.len()
    )
    .into_bytes();
    all.extend_from_slice(body);
    stream.write_all(&all)
}

#[cfg(test)]
mod tests {
    use super::{Bad, parse};

    #[test]
    fn a_head_is_read_strictly() {
        let head = b"GET /a.js?x=1 HTTP/1.1\r\nHost: localhost:1\r\nX-Other: y\r\n\r\n";
        let request = parse(head).expect("a head");
        assert_eq!(
            (request.path.as_str(), request.host.as_deref()),
            ("/a.js", Some("localhost:1"))
        );
        assert_eq!((request.key, request.origin), (None, None));
        let upgrade = b"GET /ws HTTP/1.1\r\nUpgrade: WebSocket\r\nSec-WebSocket-Key: k\r\n\
            Sec-WebSocket-Version: 13\r\n\r\n";
        assert_eq!(parse(upgrade).expect("a head").key.as_deref(), Some("k"));
        let old = b"GET /ws HTTP/1.1\r\nUpgrade: websocket\r\nSec-WebSocket-Key: k\r\n\
            Sec-WebSocket-Version: 8\r\n\r\n";
        assert_eq!(parse(old).expect("a head").key, None);
        for wrong in [
            &b"POST / HTTP/1.1\r\n\r\n"[..],
            b"GET / HTTP/1.0\r\n\r\n",
            b"GET / HTTP/1.1 x\r\n\r\n",
            b"GET /\xFF HTTP/1.1\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: a\r\nhost: b\r\n\r\n",
            b"GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\n",
            b"",
        ] {
            assert!(matches!(parse(wrong), Err(Bad::Head(_))), "{wrong:?}");
        }
    }
}
