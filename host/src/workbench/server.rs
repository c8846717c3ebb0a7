//! The port that pages come to: a thread for each connection, a second one for what a socket is sent.

use std::io;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use super::bench::Bench;
use super::client::Client;
use super::message::ToPage;
use super::{assets, gate, http, session, ws};

/// Connections at a time.
const MOST: usize = 64;
/// A page that takes nothing for so long is dropped.
const WRITE_TIME: Duration = Duration::from_secs(2);
/// A socket must say who it is by then.
const HELLO_TIME: Duration = Duration::from_secs(2);
/// A page answers pings; one that is silent for so long is gone.
const SILENCE: Duration = Duration::from_secs(15);

/// Takes connections for as long as the process lives.
pub fn serve(listener: TcpListener, bench: &Arc<Bench>) {
    let open = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming().flatten() {
        if open.fetch_add(1, Ordering::SeqCst) >= MOST {
            open.fetch_sub(1, Ordering::SeqCst);
            continue;
        }
        let (bench, open) = (bench.clone(), open.clone());
        std::thread::spawn(move || {
            // A connection that fails is its own end and nobody else's.
            let _ = connection(&bench, stream);
            open.fetch_sub(1, Ordering::SeqCst);
        });
    }
}

fn connection(bench: &Arc<Bench>, mut stream: TcpStream) -> io::Result<()> {
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
    socket_of(bench, stream)
}

fn socket_of(bench: &Arc<Bench>, mut stream: TcpStream) -> io::Result<()> {
    let client = Arc::new(Client::new(&stream)?);
    let challenge = gate::random().map_err(io::Error::other)?;
    stream.set_read_timeout(Some(HELLO_TIME))?;
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
                if client.is_known() {
                    stream.set_read_timeout(Some(SILENCE))?;
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
    session.leave();
    Ok(())
}
