//! Commands by MQTT: a word, or JSON with a reply topic and a correlation number.

use lang::wire::{self, Control, Table};
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::sync::mpsc::UnboundedSender;

use super::Note;
use crate::gateway::Gateway;
use crate::gateway::known::Program;
use crate::gateway::line::Board;
use crate::gateway::pdu::Touch;
use crate::gateway::turns::Asker;

/// Longest order, bytes.
const LONGEST: usize = 4096;
/// Longest topic for a reply, bytes.
const LONGEST_TOPIC: usize = 256;
/// Commands by MQTT are one client of a line.
const ASKER: Asker = 0;

/// What is asked.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Order {
    /// `start`, `stop`, `pause`, `resume`, `acknowledge`, `set`.
    #[serde(rename = "do")]
    what: String,
    /// Comes back with the reply.
    id: Option<Value>,
    /// Topic of the reply.
    reply: Option<String>,
    /// Of `set`: an output, from 1.
    output: Option<u16>,
    /// Of `set`: a register, or the low one of two.
    register: Option<u16>,
    /// Of `set`: a variable of the board's program, an array's with its index.
    variable: Option<String>,
    /// Of `set`: what it is to be; a variable in its unit.
    value: Option<f64>,
    /// Of `set` with `register`: 32 bits in two registers.
    #[serde(default)]
    long: bool,
}

/// What is written for an order.
enum Write {
    Control(Control),
    Coil(u16, bool),
    Registers(u16, Vec<u16>),
    /// A variable's register and value, if the board has the program with this CRC.
    Variable(u16, u16, i32),
}

impl Order {
    fn read(text: &[u8]) -> Result<Order, String> {
        if text.len() > LONGEST {
            return Err(format!("an order has at most {LONGEST} bytes"));
        }
        let text = std::str::from_utf8(text).map_err(|_| "an order is UTF-8 text".to_owned())?;
        let text = text.trim();
        if text.starts_with('{') {
            return serde_json::from_str(text).map_err(|error| format!("no order: {error}"));
        }
        serde_json::from_value(json!({ "do": text })).map_err(|error| error.to_string())
    }

    /// What is to be written; `program` is the one that the board is known to have.
    fn write(&self, program: Option<&Program>) -> Result<Write, String> {
        let control = match self.what.as_str() {
            "start" => Control::Start,
            "stop" => Control::Stop,
            "pause" => Control::Pause,
            "resume" => Control::Resume,
            "acknowledge" => Control::Acknowledge,
            "set" => return self.set(program),
            other => {
                return Err(format!(
                    "`{other}` is no order: start, stop, pause, resume, acknowledge, set"
                ));
            }
        };
        Ok(Write::Control(control))
    }

    fn set(&self, program: Option<&Program>) -> Result<Write, String> {
        let value = self.value.ok_or("set wants a value")?;
        if let (Some(name), None, None) = (&self.variable, self.output, self.register) {
            return variable(name, value, program);
        }
        let value = whole(value).ok_or("the value is a whole number of 32 bits")?;
        match (self.output, self.register) {
            _ if self.variable.is_some() => Err("set wants one thing".to_owned()),
            (Some(n @ 1..=16), None) => Ok(Write::Coil(wire::COILS + n - 1, value != 0)),
            (None, Some(register)) if self.long => Ok(Write::Registers(register, pair(value))),
            (None, Some(register)) => match u16::try_from(value) {
                Ok(value) => Ok(Write::Registers(register, vec![value])),
                Err(_) => Err("a register holds 0 to 65535; `long` is for 32 bits".to_owned()),
            },
            _ => Err("set wants an output from 1 to 16, a register or a variable".to_owned()),
        }
    }
}

/// A number that 32 bits hold.
fn whole(value: f64) -> Option<i32> {
    let fits = value.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&value);
    fits.then_some(value as i32)
}

/// The write of a variable by its name.
fn variable(name: &str, value: f64, program: Option<&Program>) -> Result<Write, String> {
    let program = program.ok_or("nobody told the names of this board's program: upload it")?;
    for variable in &program.variables {
        if let Some((_, register)) = variable.values().find(|(own, _)| own == name) {
            let (_, scale) = variable.unit();
            let value = whole((value / scale).round()).ok_or("the value is too large")?;
            return Ok(Write::Variable(program.crc, register, value));
        }
    }
    Err(format!("{} shows no variable `{name}`", program.script))
}

fn pair(value: i32) -> Vec<u16> {
    let bits = value.cast_unsigned();
    vec![bits as u16, (bits >> 16) as u16]
}

impl Write {
    fn touch(&self) -> Touch {
        let (table, first, count) = match self {
            Write::Control(_) => (Table::Holding, wire::RUN_CONTROL, 1),
            Write::Coil(address, _) => (Table::Coils, *address, 1),
            Write::Registers(first, values) => (Table::Holding, *first, values.len() as u16),
            Write::Variable(_, first, _) => (Table::Holding, *first, 2),
        };
        Touch { table, first, count, write: true }
    }

    fn is_stop(&self) -> bool {
        matches!(self, Write::Control(Control::Stop | Control::Pause))
    }

    fn send(&self, board: &mut Board) -> Result<(), String> {
        let sent = match self {
            Write::Control(control) => board.control(*control),
            Write::Coil(address, on) => board.set_coil(*address, *on),
            Write::Registers(first, values) => board.write_all(*first, values),
            Write::Variable(crc, first, value) => match board.holding(wire::PROGRAM_CRC, 1) {
                Ok(words) if words[0] != *crc => {
                    return Err("the board has another program by now".to_owned());
                }
                Ok(_) => board.write_all(*first, &pair(*value)),
                Err(error) => Err(error),
            },
        };
        sent.map_err(|error| error.to_string())
    }
}

/// A topic to which a reply may go: `usual`, one below it, or one with an allowed beginning. The gateway
/// may write topics by which other machines take orders, which the sender of the order may not.
fn is_topic(topic: &str, usual: &str, allowed: &[String]) -> bool {
    let below =
        topic.strip_prefix(usual).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
    let own = below || allowed.iter().any(|start| topic.starts_with(start.as_str()));
    own && topic.len() <= LONGEST_TOPIC && !topic.contains(['+', '#', '\0'])
}

/// Carries an order out; its reply goes to `usual` unless it names another topic that is allowed. An
/// order that names one that is not is carried out all the same, since it may be a stop; its reply
/// says so.
pub fn carry_out(
    gateway: &Gateway,
    board: usize,
    text: &[u8],
    (usual, allowed): (String, &[String]),
    notes: &UnboundedSender<Note>,
) {
    let order = Order::read(text);
    let (what, id) = match &order {
        Ok(order) => (order.what.clone(), order.id.clone()),
        Err(_) => (String::new(), None),
    };
    let (topic, note) = match order.as_ref().ok().and_then(|order| order.reply.clone()) {
        Some(topic) if is_topic(&topic, &usual, allowed) => (topic, None),
        Some(_) => (usual, Some("[mqtt] `replies` does not allow the topic that was named")),
        None => (usual, None),
    };
    let notes = notes.clone();
    let reply = move |result: Result<(), String>| {
        let mut text = json!({ "do": what, "ok": result.is_ok() });
        if let Some(id) = id {
            text["id"] = id;
        }
        if let Err(error) = result {
            text["error"] = json!(error);
        }
        if let Some(note) = note {
            text["note"] = json!(note);
        }
        // The conversation is over when nobody hears it.
        let _ = notes.send(Note::Reply(topic, text.to_string()));
    };
    let program = gateway.book.known(board).and_then(|known| known.program);
    let write = match order.and_then(|order| order.write(program.as_ref())) {
        Ok(write) => write,
        Err(words) => return reply(Err(words)),
    };
    if !gateway.orders.hold(&write.touch()) {
        return reply(Err("[mqtt] `write` does not allow it".to_owned()));
    }
    let place = &gateway.places[board];
    let urgent = write.is_stop();
    let job = Box::new(move |board: Result<&mut Board, &str>| {
        reply(match board {
            Ok(board) => write.send(board),
            Err(why) => Err(why.to_owned()),
        });
    });
    gateway.lines[place.line].order(ASKER, place.station, urgent, job);
}

#[cfg(test)]
mod tests {
    use super::{Order, Write, is_topic};
    use crate::gateway::known::{Program, Variable};

    fn good(text: &str) -> bool {
        Order::read(text.as_bytes()).and_then(|order| order.write(None)).is_ok()
    }

    #[test]
    fn orders_are_words_or_json() {
        for text in [
            "start",
            " stop\n",
            r#"{"do":"pause","id":7,"reply":"a/b"}"#,
            r#"{"do":"set","output":16,"value":1}"#,
            r#"{"do":"set","register":3000,"value":-5,"long":true}"#,
        ] {
            assert!(good(text), "{text}");
        }
        for text in [
            "",
            "jump",
            "{",
            r#"{"do":"set","output":17,"value":1}"#,
            r#"{"do":"set","register":3000,"value":-5}"#,
            r#"{"do":"set","register":3000}"#,
            r#"{"do":"set","register":3000,"output":1,"value":1}"#,
            r#"{"do":"set","register":3000,"value":1.5,"long":true}"#,
            r#"{"do":"set","register":3000,"value":3e9,"long":true}"#,
            r#"{"do":"set","variable":"made","value":1}"#,
            r#"{"do":"start","colour":1}"#,
            &"x".repeat(10_000),
        ] {
            assert!(!good(text), "{text}");
        }
    }

    /// The gateway may write what the sender may not: other boards' orders, other machines'.
    #[test]
    fn a_reply_goes_below_its_own_topic_or_where_it_is_allowed() {
        let usual = "pasapas/hall/drill/reply";
        let allowed = ["panel/".to_owned()];
        let may = |topic: &str| is_topic(topic, usual, &allowed);
        for topic in [usual, "pasapas/hall/drill/reply/7", "panel/5/told"] {
            assert!(may(topic), "{topic}");
        }
        let long = format!("panel/{}", "x".repeat(300));
        for topic in [
            "",
            "a/b",
            "panel",
            "panel/#",
            "pasapas/hall/drill/command",
            "pasapas/hall/drill/replyx",
            "pasapas/hall/mill/reply",
            "spBv1.0/g/NDEATH/n",
            &long,
        ] {
            assert!(!may(topic), "{topic}");
        }
    }

    #[test]
    fn a_variable_is_set_by_its_name_in_its_unit() {
        let variable = |name: &str, register, count, kind: &str| Variable {
            name: name.to_owned(),
            register,
            count,
            array: count > 1,
            kind: kind.to_owned(),
            keep: false,
        };
        let program = Program {
            crc: 7,
            script: "a.bas".to_owned(),
            profile: "mill".to_owned(),
            variables: vec![
                variable("depth", 3000, 1, "Length"),
                variable("list", 3010, 3, "Number"),
            ],
            lines: Vec::new(),
        };
        let write = |text: &str| {
            let order = Order::read(text.as_bytes()).expect("an order");
            order.write(Some(&program)).map(|write| match write {
                Write::Variable(crc, register, value) => (crc, register, value),
                _ => panic!("{text}"),
            })
        };
        let set = |name: &str, value: &str| {
            write(&format!(r#"{{"do":"set","variable":"{name}","value":{value}}}"#))
        };
        assert_eq!(set("depth", "-1.1"), Ok((7, 3000, -1100)));
        assert_eq!(set("list[2]", "5"), Ok((7, 3014, 5)));
        for (name, value) in [("list", "1"), ("list[3]", "1"), ("depth", "3e9"), ("none", "1")] {
            assert!(set(name, value).is_err(), "{name}");
        }
        let both = r#"{"do":"set","variable":"depth","register":3000,"value":1}"#;
        assert!(write(both).is_err());
    }
}
