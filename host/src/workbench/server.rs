//! The port that pages come to: a thread for each connection, a second one for what a socket is sent.

use std::io::{self, Read};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::bench::Bench;
use super::client::Client;
use super::message::ToPage;
use super::places::{Place, Places};
use super::{assets, gate, http, session, ws};

/// A page that takes nothing for so long is dropped.
const WRITE_TIME: Duration = Duration::from_secs(2);
/// A socket must have said who it is by then, however slowly its bytes come.
const HELLO_TIME: Duration = Duration::from_secs(2);
/// A page answers pings; one that is silent for so long is gone.
const SILENCE: Duration = Duration::from_secs(15);

/// Takes connections for as long as the process lives.
pub fn serve(listener: TcpListener, bench: &Arc<Bench>) {
    let places = Arc::new(Mutex::new(Places::default()));
    for stream in listener.incoming().flatten() {
        let Ok(place) = Place::take(&places, &stream) else { continue };
        let bench = bench.clone();
        std::thread::spawn(move || {
            // A connection that fails is its own end and nobody else's.
            let _ = connection(&bench, stream, place);
        });
    }
}

fn connection(bench: &Arc<Bench>, mut stream: TcpStream, place: Place) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(WRITE_TIME))?;
    let words = |stream: &mut TcpStream, status, text: &str| {
        http::answer(stream, status, "text/plain; charset=utf-8", text.as_bytes())
    };
    let request = match http::read(&mut stream) {
        Ok(request) => request,
        Err(http::Bad::Io(error)) => return Err(error),
        Err(http::Bad::Head(why)) => return words(&mut stream, "400 Bad Request", why),
    };
    let socket = request.path == "/ws";
    if !bench.gate.may(request.host.as_deref(), request.origin.as_deref(), socket) {
        let text = "this address or page is not one of this tool's own\n";
        return words(&mut stream, "403 Forbidden", text);
    }
    if !socket {
        return match assets::find(&request.path) {
            Some((kind, bytes)) => http::answer(&mut stream, "200 OK", kind, bytes),
            None => words(&mut stream, "404 Not Found", "no such file\n"),
        };
    }
    let Some(key) = request.key else {
        return words(&mut stream, "400 Bad Request", "a socket is opened by a page\n");
    };
    let upgrade = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {}\r\n\r\n",
        ws::accept(&key)
    );
    io::Write::write_all(&mut stream, upgrade.as_bytes())?;
    socket_of(bench, stream, place)
}

fn socket_of(bench: &Arc<Bench>, stream: TcpStream, mut place: Place) -> io::Result<()> {
    let client = Arc::new(Client::new(&stream)?);
    let challenge = gate::random().map_err(io::Error::other)?;
    let mut stream = Until { stream, end: Some(Instant::now() + HELLO_TIME) };
    let writer = client.clone();
    std::thread::spawn(move || writer.write());
    client.send(&ToPage::Challenge(challenge.clone()));
    let mut session = session::Session::new(bench, &client, challenge);
    let mut whole = None;
    loop {
        match ws::read(&mut stream, &mut whole) {
            Ok(ws::Message::Text(text)) => {
                if !session.hear(&text) {
                    client.close();
                    break;
                }
                if client.is_known() && stream.end.take().is_some() {
                    if !place.is_of_a_page() {
                        client.drop_it();
                        break;
                    }
                    stream.stream.set_read_timeout(Some(SILENCE))?;
                }
            }
            Ok(ws::Message::Ping(bytes)) => client.pong(bytes),
            Ok(ws::Message::Pong) => {}
            Ok(ws::Message::Close) => {
                client.close();
                break;
            }
            Err(_) => {
                client.drop_it();
                break;
            }
        }
    }
    Ok(())
}

/// A stream whose bytes must have come by a moment, if one is set: a limit for each read alone would
/// let a sender that drips a byte a second stay for ever.
struct Until {
    stream: TcpStream,
    end: Option<Instant>,
}

impl Read for Until {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if let Some(end) = self.end {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Err(io::ErrorKind::TimedOut.into());
            }
            self.stream.set_read_timeout(Some(left))?;
        }
        self.stream.read(buffer)
    }
}
