//! One page's session: what it may request, and who executes it.

use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;

use super::bench::{Bench, lock};
use super::client::Client;
use super::commission;
use super::machine;
use super::message::{FromPage, SetupWish, ToPage, Wish};
use super::streamed;
use super::teach;

/// A wrong proof costs so long: nobody tries many.
const WRONG: Duration = Duration::from_secs(1);

/// A page.
pub struct Session {
    bench: Arc<Bench>,
    client: Arc<Client>,
    challenge: String,
    joined: bool,
}

impl Session {
    /// A page that still has to answer `challenge`.
    pub fn new(bench: &Arc<Bench>, client: &Arc<Client>, challenge: String) -> Session {
        Session { bench: bench.clone(), client: client.clone(), challenge, joined: false }
    }

    /// Takes a message; `false`: the page is to go.
    pub fn hear(&mut self, text: &str) -> bool {
        let FromPage { ask, wish } = match serde_json::from_str(text) {
            Ok(message) => message,
            Err(error) => {
                self.refuse(0, format!("this is no message of the workbench: {error}"));
                return false;
            }
        };
        if !self.joined {
            return self.enter(ask, &wish);
        }
        match self.serve(ask, wish) {
            Ok(Answer::Done) => self.client.send(&ToPage::Done { ask, words: None }),
            Ok(Answer::Value(value)) => self.client.send(&ToPage::Answer { ask, value }),
            Ok(Answer::Later) => {}
            Err(words) => self.refuse(ask, words),
        }
        true
    }

    fn refuse(&self, ask: u32, words: String) {
        self.client.send(&ToPage::Refused { ask, words });
    }

    fn enter(&mut self, ask: u32, wish: &Wish) -> bool {
        let Wish::Hello { proof } = wish else {
            self.refuse(ask, "the key comes first".to_owned());
            return false;
        };
        if !self.bench.gate.knows(&self.challenge, proof) {
            std::thread::sleep(WRONG);
            self.refuse(ask, "this key or password is not the one of this start".to_owned());
            return false;
        }
        self.joined = true;
        self.bench.join(&self.client);
        true
    }

    fn serve(&self, ask: u32, wish: Wish) -> Result<Answer, String> {
        let bench = &self.bench;
        // Stop first, whoever says it.
        if matches!(wish, Wish::Stop) {
            bench.helm.stop();
            return Ok(Answer::Done);
        }
        if bench.setting.is_operators() && !is_operators(&wish, bench.setting.live.is_some()) {
            return Err("this page only starts, pauses and stops".to_owned());
        }
        if acts(&wish) && !bench.has_helm(&self.client) {
            return Err("another page has the helm: press Take the helm first".to_owned());
        }
        // What waits for the end of a job would be done when nobody thinks of it any more.
        if acts(&wish)
            && bench.is_streaming()
            && !streamed::takes(&wish, bench.setting.live.is_some())
        {
            return Err("a job is fed to the board: wait for its end, or stop it first".to_owned());
        }
        match wish {
            Wish::Hello { .. } => return Err("the key was given already".to_owned()),
            Wish::Helm(take) => bench.take_helm(&self.client, take),
            Wish::Lsp(message) => {
                lock(&bench.desk).request(self.client.number, &message)?;
                return Ok(Answer::Later);
            }
            Wish::Text { base, text } => self.text(base, text)?,
            Wish::Save(name) => {
                let before = lock(&bench.desk).name();
                lock(&bench.desk).save(name.as_deref())?;
                self.tell_text();
                bench.keep_drawn(before.as_deref())?;
            }
            Wish::Open(name) => {
                lock(&bench.desk).change(&name)?;
                self.tell_text();
                bench.want_simulation(false);
            }
            Wish::Reload(from_disk) => {
                lock(&bench.desk).settle(from_disk);
                self.tell_text();
                bench.want_simulation(false);
            }
            Wish::New { name, text } => {
                lock(&bench.desk).create(&name, text)?;
                self.tell_text();
                bench.want_simulation(false);
            }
            Wish::Take { name, text } => {
                lock(&bench.desk).take(&name, text.as_bytes())?;
                self.tell_text();
                bench.want_simulation(false);
            }
            Wish::Tables => return Ok(Answer::Value(teach::tables(&lock(&bench.desk)))),
            Wish::Table(wish) => {
                return Ok(Answer::Value(teach::table(&lock(&bench.desk), &wish)?));
            }
            Wish::Points { name, text } => return Ok(Answer::Value(teach::points(&name, &text)?)),
            Wish::Pattern { pattern, into } => {
                let profile = bench.profile()?;
                let text = lock(&bench.desk).text().to_owned();
                let into = into.then_some(text.as_str());
                return Ok(Answer::Value(teach::pattern(&pattern, &profile, into)?));
            }
            Wish::Pulses(drawn) => bench.draw(drawn)?,
            Wish::Simulate => bench.want_simulation(false),
            Wish::SimulateAll => bench.want_simulation(true),
            Wish::Quit => bench.end(),
            Wish::Keep { id, echo } => {
                if !self.client.is_fresh(echo) {
                    return Ok(Answer::Later);
                }
                if let Err(over) = bench.helm.keep(self.client.user, id) {
                    self.client.send(&ToPage::Ended { id, words: over.text().to_owned() });
                }
                return Ok(Answer::Later);
            }
            Wish::Setup(wish) => return commission::serve(bench, &self.client, ask, wish),
            wish => return machine::serve(bench, &self.client, ask, wish),
        }
        Ok(Answer::Done)
    }

    fn text(&self, base: u64, text: String) -> Result<(), String> {
        let mut desk = lock(&self.bench.desk);
        let taken = desk.set(base, text);
        let shown = desk.shown();
        drop(desk);
        if taken.is_err() {
            self.client.send(&ToPage::Text(shown));
            return taken;
        }
        self.bench.tell_others(&self.client, &ToPage::Text(shown));
        self.bench.want_simulation(false);
        Ok(())
    }

    fn tell_text(&self) {
        let text = lock(&self.bench.desk).shown();
        self.bench.tell(&ToPage::Text(text));
    }
}

/// However a page goes, by a panic of its thread too, it lets go of what it held.
impl Drop for Session {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.client.drop_it();
        }
        self.bench.leave(&self.client);
    }
}

/// Whether an answer was sent already, or comes later.
pub enum Answer {
    /// It is done.
    Done,
    /// It comes later.
    Later,
    /// What was asked for.
    Value(Value),
}

/// Whether only the page with the helm may ask it.
fn acts(wish: &Wish) -> bool {
    !matches!(
        wish,
        Wish::Hello { .. }
            | Wish::Helm(_)
            | Wish::Stop
            | Wish::Lsp(_)
            | Wish::Text { .. }
            | Wish::Save(_)
            | Wish::Open(_)
            | Wish::Reload(_)
            | Wish::New { .. }
            | Wish::Take { .. }
            | Wish::Place
            | Wish::Tables
            | Wish::Table(_)
            | Wish::Points { .. }
            | Wish::Pattern { .. }
            | Wish::Setup(SetupWish::Look)
            | Wish::Pulses(_)
            | Wish::Simulate
            | Wish::SimulateAll
            | Wish::Library
            | Wish::Release(_)
            | Wish::Quit
    )
}

/// Whether a page for the person at the machine may ask it. Contacts and buttons are `emulated`: an
/// input of a real board is not forced by an operator.
fn is_operators(wish: &Wish, emulated: bool) -> bool {
    matches!(
        wish,
        Wish::Helm(_)
            | Wish::Bring(_)
            | Wish::Run(_)
            | Wish::Pause
            | Wish::Resume
            | Wish::Set { .. }
            | Wish::Override(_)
    ) || emulated && matches!(wish, Wish::Input(..) | Wish::Press { .. })
}

#[cfg(test)]
mod tests {
    use super::{Wish, is_operators};

    #[test]
    fn an_operator_forces_no_input_of_a_real_board() {
        for wish in [Wish::Input(5, Some(true)), Wish::Press { stop: false, down: true }] {
            assert!(!is_operators(&wish, false) && is_operators(&wish, true));
        }
        assert!(!is_operators(&Wish::Output(1, true), true));
    }
}
