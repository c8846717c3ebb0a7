//! MQTT: the state of each board, its events, and commands with a reply.
//!
//! It has a thread with its own tasks, so that a slow disk of the [outbox](super::outbox)
//! delays no Modbus client. `session` is the conversation with the broker, `report`
//! publishes boards, `order` executes commands.

mod order;
mod report;
mod session;
mod setting;
#[cfg(test)]
mod tests;

use std::sync::Arc;
use std::thread::JoinHandle;

use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender};

pub use order::carry_out;
pub use setting::MqttSetting;

use super::Gateway;
use super::line::Look;
use super::outbox::Outbox;
use session::{End, Session};

/// What the conversation is told.
#[derive(Debug)]
pub enum Note {
    /// A look at the board with this number in the file.
    Look(usize, Look),
    /// The reply to an order: topic and text.
    Reply(String, String),
    /// The gateway ends.
    Close,
}

/// The conversation with a broker; it ends with this.
pub struct Mqtt {
    notes: UnboundedSender<Note>,
    thread: Option<JoinHandle<()>>,
}

impl Mqtt {
    /// Starts it.
    ///
    /// # Errors
    /// A file cannot be read, or the outbox cannot be written; in words.
    pub fn start(
        setting: &MqttSetting,
        gateway: &Arc<Gateway>,
        (notes, heard): (UnboundedSender<Note>, UnboundedReceiver<Note>),
    ) -> Result<Mqtt, String> {
        let options = setting.options()?;
        let outbox = Outbox::open(&setting.outbox, setting.keep).map_err(|error| {
            format!("the outbox {} cannot be opened: {error}", setting.outbox.display())
        })?;
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| error.to_string())?;
        let reports = gateway.names.iter().map(|name| report::Report::new(name)).collect();
        let mut session = Session::new(setting, options, outbox, reports);
        // Weak: the gateway holds the way to this thread, and ends with its last user.
        let (own, gateway) = (notes.clone(), Arc::downgrade(gateway));
        let replies = setting.replies.clone();
        let orders = Box::new(move |board: usize, text: &[u8], reply: String| {
            if let Some(gateway) = gateway.upgrade() {
                order::carry_out(&gateway, board, text, (reply, &replies), &own);
            }
        });
        let thread = std::thread::spawn(move || {
            runtime.block_on(async {
                if let End::Disk(error) = session.run(heard, orders).await {
                    eprintln!("pasapas: MQTT ends: the outbox cannot be written: {error}");
                }
            });
            runtime.shutdown_background();
        });
        Ok(Mqtt { notes, thread: Some(thread) })
    }
}

impl Drop for Mqtt {
    fn drop(&mut self) {
        let _ = self.notes.send(Note::Close);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
