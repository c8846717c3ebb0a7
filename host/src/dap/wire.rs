//! Messages of the Debug Adapter Protocol on a line: `Content-Length`, a blank line, JSON.

use std::io::{self, BufRead, Read, Write};

use serde_json::{Value, json};

/// Longest message of a debugger that is taken, bytes.
const LONGEST: usize = 16 << 20;
/// Longest head of a message, bytes.
const LONGEST_HEAD: u64 = 4096;

/// The next message of a debugger; `None` at the end of the input.
///
/// # Errors
/// The input breaks, or is no such message.
pub fn read(from: &mut impl BufRead) -> io::Result<Option<Value>> {
    read_up_to(from, LONGEST)
}

/// The next message of at most so many bytes; `None` at the end of the input. The language server's
/// messages have the same form.
///
/// # Errors
/// The input breaks, or is no such message.
pub fn read_up_to(from: &mut impl BufRead, longest: usize) -> io::Result<Option<Value>> {
    let wrong = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text.to_owned());
    let mut length = None;
    let mut head = from.take(LONGEST_HEAD);
    loop {
        let mut line = String::new();
        if head.read_line(&mut line)? == 0 {
            return if head.limit() == 0 { Err(wrong("a head without end")) } else { Ok(None) };
        }
        let line = line.trim_end();
        if line.is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("Content-Length")
        {
            length = value.trim().parse::<usize>().ok();
        }
    }
    let length = length.ok_or_else(|| wrong("a message without its length"))?;
    if length > longest {
        return Err(wrong(&format!("a message of {length} bytes; at most {longest} are taken")));
    }
    let mut body = vec![0; length];
    from.read_exact(&mut body)?;
    serde_json::from_slice(&body).map(Some).map_err(|error| wrong(&error.to_string()))
}

/// What is said to the editor, numbered.
pub struct Mouth<W> {
    to: W,
    seq: u64,
}

impl<W: Write> Mouth<W> {
    /// Begins with number 1.
    pub const fn new(to: W) -> Mouth<W> {
        Mouth { to, seq: 0 }
    }

    /// Something happened.
    ///
    /// # Errors
    /// The editor has gone.
    pub fn event(&mut self, event: &str, body: Value) -> io::Result<()> {
        self.say(json!({ "type": "event", "event": event, "body": body }))
    }

    /// The answer to a request; in words why not.
    ///
    /// # Errors
    /// The editor has gone.
    pub fn answer(&mut self, request: &Value, result: Result<Value, String>) -> io::Result<()> {
        let mut message = json!({
            "type": "response",
            "request_seq": request["seq"],
            "command": request["command"],
            "success": result.is_ok(),
        });
        match result {
            Ok(body) => message["body"] = body,
            Err(words) => {
                message["message"] = json!(words);
                message["body"] =
                    json!({ "error": { "id": 1, "format": words, "showUser": true } });
            }
        }
        self.say(message)
    }

    fn say(&mut self, mut message: Value) -> io::Result<()> {
        self.seq += 1;
        message["seq"] = json!(self.seq);
        let text = message.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::{Mouth, read};
    use serde_json::json;

    #[test]
    fn what_is_said_can_be_read() {
        let mut line = Vec::new();
        let mut mouth = Mouth::new(&mut line);
        mouth.event("initialized", json!({})).expect("it is written");
        let request = json!({ "seq": 7, "command": "threads" });
        mouth.answer(&request, Err("not \u{e9}ven".to_owned())).expect("it is written");
        let mut from = &line[..];
        let first = read(&mut from).expect("a message").expect("a message");
        assert_eq!((&first["seq"], &first["event"]), (&json!(1), &json!("initialized")));
        let second = read(&mut from).expect("a message").expect("a message");
        assert_eq!((&second["request_seq"], &second["success"]), (&json!(7), &json!(false)));
        assert_eq!(second["message"], "not \u{e9}ven");
        assert!(read(&mut from).expect("an end").is_none());
    }

    #[test]
    fn what_is_no_message_is_refused() {
        for wrong in [
            "Content-Length: 99999999999\r\n\r\n",
            "Content-Length: 5\r\n\r\n{}",
            "Content-Length: 2\r\n\r\nno",
            "\r\n",
            &"x".repeat(9000),
        ] {
            assert!(read(&mut wrong.as_bytes()).is_err(), "{wrong:.40}");
        }
    }
}
