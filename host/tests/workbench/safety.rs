//! Who may not come in, and what two pages may do to each other.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use crate::cdp::Outcome;
use crate::stand::{PATIENCE, Stand};

/// Sends bytes to the server, with what comes `behind` once it has answered those, and gives what comes
/// back.
fn raw(address: &str, bytes: &[u8], behind: &[u8]) -> Outcome<String> {
    let words = |error: std::io::Error| error.to_string();
    let mut stream = TcpStream::connect(address).map_err(words)?;
    stream.set_read_timeout(Some(Duration::from_secs(4))).map_err(words)?;
    stream.write_all(bytes).map_err(words)?;
    let mut all = Vec::new();
    if !behind.is_empty() {
        let mut some = [0; 1024];
        let count = stream.read(&mut some).map_err(words)?;
        all.extend(&some[..count]);
        stream.write_all(behind).map_err(words)?;
    }
    let _ = stream.read_to_end(&mut all);
    Ok(String::from_utf8_lossy(&all).into_owned())
}

fn upgrade(host: &str, origin: &str) -> String {
    format!(
        "GET /ws HTTP/1.1\r\nHost: {host}\r\n{origin}Upgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
}

/// A masked text frame.
fn frame(text: &str) -> Vec<u8> {
    let mut out = vec![0x81, 0x80 | text.len() as u8, 0, 0, 0, 0];
    out.extend(text.bytes());
    out
}

#[test]
fn strangers_are_turned_away_and_nothing_moves() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    let address = stand.url.trim_start_matches("http://");
    let address = address.split('/').next().ok_or("no address")?.to_owned();
    let before = stand.board()?.status()?;
    let own = format!("Origin: http://{address}\r\n");
    for (host, origin) in [
        ("evil.example", "Origin: http://evil.example\r\n"),
        (address.as_str(), "Origin: http://evil.example\r\n"),
        (address.as_str(), ""),
        ("evil.example", own.as_str()),
    ] {
        let answer = raw(&address, upgrade(host, origin).as_bytes(), &[])?;
        assert!(answer.starts_with("HTTP/1.1 403"), "{host} {origin}: {answer}");
    }
    let page = raw(&address, format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n").as_bytes(), &[])?;
    assert!(page.contains("script-src 'self'") && page.contains("frame-ancestors 'none'"));
    assert!(!page.to_ascii_lowercase().contains("access-control"));
    for nonsense in ["", "\r\n\r\n", "GET", "POST / HTTP/1.1\r\n\r\n", "\u{0}\u{1}\u{2}\r\n\r\n"] {
        let answer = raw(&address, nonsense.as_bytes(), &[])?;
        assert!(answer.is_empty() || answer.starts_with("HTTP/1.1 400"), "{nonsense:?}: {answer}");
    }
    // A socket of our own page, without the key, with a wrong one, and with nonsense.
    let hello = upgrade(&address, &own);
    let jog = frame(r#"{"do":{"jog":{"axis":"X","um":5000,"speed":9000}}}"#);
    let answer = raw(&address, hello.as_bytes(), &jog)?;
    assert!(answer.contains("the key comes first"), "{answer}");
    let wrong = frame(r#"{"do":{"hello":{"proof":"00"}}}"#);
    let answer = raw(&address, hello.as_bytes(), &wrong)?;
    assert!(answer.contains("not the one of this start"), "{answer}");
    for nonsense in [
        &b"\x81\x85\0\0\0\0hello"[..],
        b"\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff",
        b"\x82\x80\0\0\0\0",
    ] {
        let answer = raw(&address, hello.as_bytes(), nonsense)?;
        assert!(!answer.contains("welcome"), "{answer}");
    }
    // A page of another origin, in the same browser as ours.
    let stranger = stand.browser.page("data:text/html,<title>stranger</title>")?;
    stranger.eval(&format!(
        "(() => {{ const s = new WebSocket('ws://{address}/ws'); s.onopen = () => document.title = 'open'; s.onerror = () => document.title = 'refused' }})()"
    ))?;
    stranger.wait("document.title === 'refused'", PATIENCE)?;
    stranger.eval(&format!("fetch('http://{address}/').then(() => document.title = 'read', () => document.title = 'kept')"))?;
    stranger.wait("document.title === 'kept'", PATIENCE)?;
    // The key is not in the address bar, and another page without it is asked for a password.
    let page = stand.page()?;
    assert_eq!(page.eval("location.href")?, format!("http://{address}/"));
    let keyless = stand.browser.page(&format!("http://{address}/"))?;
    keyless.wait("!document.querySelector('#lock').hidden", PATIENCE)?;
    keyless.eval("document.querySelector('#password').value = 'wrong'")?;
    keyless.click("#lock button")?;
    keyless.says("#lock-words", "not the one of this start")?;
    // With the key our page's messages are read strictly: nonsense ends it, and moves nothing.
    let after = stand.board()?.status()?;
    assert_eq!((before.pos, before.outputs, before.runs), (after.pos, after.outputs, after.runs));
    Ok(())
}

#[test]
fn one_page_has_the_helm_and_every_page_can_stop() -> Outcome<()> {
    let Some(mut stand) = Stand::with_board("MoveAxe X, 100mm, 5mm/s\n")? else { return Ok(()) };
    let first = stand.page()?;
    first.says("#helm", "You have the helm")?;
    first.upload()?;
    let second = stand.page()?;
    second.says("#helm", "another page has it")?;
    second.tab("run")?;
    second.wait("document.querySelector('#start').disabled", PATIENCE)?;
    // Asked past the disabled button the tool refuses by itself.
    second.eval("document.querySelector('#start').disabled = false; document.querySelector('#start').click()")?;
    second.says("#notes", "another page has the helm")?;
    assert_eq!(stand.board()?.status()?.runs, 0);
    first.front()?;
    first.push("#start")?;
    stand
        .board()?
        .until("a run", |status| status.state == "running" && !status.moving.is_empty())?;
    second.front()?;
    second.click("#stop")?;
    let rest = stand.board()?.until("its end", |status| status.state == "ready")?;
    assert_eq!(rest.last_end, Some("stopped"));
    // The helm goes over, and what the first page held stops.
    first.front()?;
    first.tab("machine")?;
    let at = first.centre(".jog.Xm")?;
    first.mouse("mousePressed", at)?;
    stand.board()?.until("a jog", |status| status.moving.contains(&'X'))?;
    second.eval("document.querySelector('#helm').click()")?;
    stand.board()?.until("rest", |status| status.moving.is_empty())?;
    first.says("#helm", "another page has it")?;
    first.mouse("mouseReleased", at)?;
    second.says("#helm", "You have the helm")?;
    // A page that goes leaves a stored program running, and the helm free.
    second.front()?;
    second.push("#start")?;
    stand.board()?.until("a run", |status| status.state == "running")?;
    second.close()?;
    first.says("#helm", "Take the helm")?;
    first.wait("!document.querySelector('#helm').textContent.includes('another')", PATIENCE)?;
    assert_eq!(stand.board()?.status()?.state, "running");
    first.front()?;
    first.press("Escape", "Escape", 27, "", 8)?;
    stand.board()?.until("its end", |status| status.state == "ready")?;
    Ok(())
}

/// Connections that drip their bytes, and pages that break the language server's protocol, keep nobody
/// out and nothing taken.
#[test]
fn strangers_and_broken_pages_keep_nobody_out() -> Outcome<()> {
    let Some(stand) = Stand::with_board("Wait 1s\n")? else { return Ok(()) };
    let address = stand.url.trim_start_matches("http://");
    let address = address.split('/').next().ok_or("no address")?.to_owned();
    let own = format!("Origin: http://{address}\r\n");
    let hello = upgrade(&address, &own);
    let mut drips = Vec::new();
    for _ in 0..70 {
        let mut stream = TcpStream::connect(&address).map_err(|error| error.to_string())?;
        stream.write_all(hello.as_bytes()).map_err(|error| error.to_string())?;
        drips.push(stream);
    }
    let page = stand.page()?;
    page.says("#helm", "You have the helm")?;
    // Three seconds later every one of them is gone, although each sent a byte again and again.
    let end = std::time::Instant::now() + Duration::from_secs(3);
    while std::time::Instant::now() < end {
        drips.retain_mut(|stream| stream.write_all(&[0x81]).is_ok());
        std::thread::sleep(Duration::from_millis(200));
    }
    let mut left = 0;
    for stream in &mut drips {
        stream.set_read_timeout(Some(Duration::from_millis(200))).map_err(|e| e.to_string())?;
        let end = stream.read_to_end(&mut Vec::new()).map_err(|error| error.kind());
        left += usize::from(matches!(end, Err(ErrorKind::WouldBlock | ErrorKind::TimedOut)));
    }
    assert_eq!(left, 0, "a stranger stays");
    // A page that breaks the protocol keeps its place and its helm, and the others theirs.
    let wrong = "(async () => { const { Link } = await import('/link.js'); const link = new Link(); await new Promise(done => link.addEventListener('welcome', done)); const told = []; for (const lsp of [{ id: 1, method: 'textDocument/hover', params: 5 }, { id: 2, method: 'x', params: [1] }, { id: 3, method: 'shutdown', params: {} }, 7]) try { await link.ask({ lsp }); told.push('done') } catch (e) { told.push(e.message) } return told.join('; ') })()";
    let told = page.eval(wrong)?;
    assert!(!told.as_str().unwrap_or("done").contains("done"), "{told}");
    page.says("#helm", "You have the helm")?;
    page.select_script("G1 Q\n")?;
    page.says("#problem-count", "error")
}
