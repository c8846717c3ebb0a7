//! What a page of our own needs of HTTP/1.1: GET, one request a connection, or the upgrade to a socket.
//! The bytes are read by `httparse`; what is allowed is decided here.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// The whole head must have come by then.
const HEAD_TIME: Duration = Duration::from_secs(2);
/// Longest head, and headers in it.
const HEAD_BYTES: usize = 8192;
const MOST_HEADERS: usize = 64;
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

/// Reads a head. Nothing may follow it: a page waits for the answer.
///
/// # Errors
/// See [`Bad`].
pub fn read(stream: &mut TcpStream) -> Result<Request, Bad> {
    let end = Instant::now() + HEAD_TIME;
    let mut head = Vec::with_capacity(1024);
    let mut piece = [0; 1024];
    loop {
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
        if let Some(request) = parse(&head)? {
            return Ok(request);
        }
    }
}

/// Reads the bytes of a head; `None`: its end is not there yet.
///
/// # Errors
/// [`Bad::Head`].
pub fn parse(head: &[u8]) -> Result<Option<Request>, Bad> {
    let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
    let mut found = httparse::Request::new(&mut headers);
    match found.parse(head) {
        Ok(httparse::Status::Partial) => return Ok(None),
        Ok(httparse::Status::Complete(length)) if length == head.len() => {}
        Ok(httparse::Status::Complete(_)) => return Err(Bad::Head("more than a head")),
        Err(_) => return Err(Bad::Head("not a request")),
    }
    let (Some("GET"), Some(path), Some(1)) = (found.method, found.path, found.version) else {
        return Err(Bad::Head("not a GET"));
    };
    let mut request = Request {
        path: path.split('?').next().unwrap_or_default().to_owned(),
        ..Request::default()
    };
    let (mut key, mut version, mut upgrade) = (None, None, None);
    for header in &*found.headers {
        let slot = match header.name.to_ascii_lowercase().as_str() {
            "host" => &mut request.host,
            "origin" => &mut request.origin,
            "sec-websocket-key" => &mut key,
            "sec-websocket-version" => &mut version,
            "upgrade" => &mut upgrade,
            "content-length" | "transfer-encoding" => return Err(Bad::Head("a GET with a body")),
            _ => continue,
        };
        let value = std::str::from_utf8(header.value).map_err(|_| Bad::Head("not text"))?;
        if slot.replace(value.trim().to_owned()).is_some() {
            return Err(Bad::Head("a header twice"));
        }
    }
    let upgrades = upgrade.is_some_and(|to| to.eq_ignore_ascii_case("websocket"));
    request.key = key.filter(|_| upgrades && version.as_deref() == Some("13"));
    Ok(Some(request))
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
    use super::{Bad, Request, parse};

    fn whole(head: &[u8]) -> Request {
        parse(head).expect("a head").expect("all of it")
    }

    #[test]
    fn a_head_is_read_strictly() {
        let head = b"GET /a.js?x=1 HTTP/1.1\r\nHost: localhost:1\r\nX-Other: y\r\n\r\n";
        let request = whole(head);
        assert_eq!(
            (request.path.as_str(), request.host.as_deref()),
            ("/a.js", Some("localhost:1"))
        );
        assert_eq!((request.key, request.origin), (None, None));
        let upgrade = b"GET /ws HTTP/1.1\r\nUpgrade: WebSocket\r\nSec-WebSocket-Key: k\r\n\
            Sec-WebSocket-Version: 13\r\n\r\n";
        assert_eq!(whole(upgrade).key.as_deref(), Some("k"));
        let old = b"GET /ws HTTP/1.1\r\nUpgrade: websocket\r\nSec-WebSocket-Key: k\r\n\
            Sec-WebSocket-Version: 8\r\n\r\n";
        assert_eq!(whole(old).key, None);
        for wrong in [
            &b"POST / HTTP/1.1\r\n\r\n"[..],
            b"GET / HTTP/1.0\r\n\r\n",
            b"GET / HTTP/1.1 x\r\n\r\n",
            b"GET /\xFF HTTP/1.1\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: a\r\nhost: b\r\n\r\n",
            b"GET / HTTP/1.1\r\nContent-Length: 5\r\n\r\n",
            b"GET / HTTP/1.1\r\n\r\nGET / HTTP/1.1\r\n\r\n",
            b"\0\x01\r\n\r\n",
        ] {
            assert!(matches!(parse(wrong), Err(Bad::Head(_))), "{wrong:?}");
        }
        for cut in [&b""[..], b"GET", b"GET / HTTP/1.1\r\n", b"GET / HTTP/1.1\r\nHost: a\r\n"] {
            assert!(matches!(parse(cut), Ok(None)), "{cut:?}");
        }
    }
}
