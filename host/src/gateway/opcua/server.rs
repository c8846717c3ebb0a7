//! The server's thread: puts polled values into the address space, and sends method calls to the
//! boards.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::mpsc::channel;
use std::sync::{Arc, Weak};
use std::thread::JoinHandle;
use std::time::Duration;

use lang::wire::{self, Control, Table};
use opcua::crypto::SecurityPolicy;
use opcua::server::diagnostics::NamespaceMetadata;
use opcua::server::node_manager::memory::{SimpleNodeManager, simple_node_manager};
use opcua::server::{ANONYMOUS_USER_TOKEN_ID, ServerBuilder, ServerHandle, ServerUserToken};
use opcua::types::{MessageSecurityMode, StatusCode};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender};

use super::OpcuaSetting;
use super::space::Space;
use crate::client::ClientError;
use crate::gateway::Gateway;
use crate::gateway::line::Board;
use crate::gateway::mqtt::Note;
use crate::gateway::pdu::Touch;
use crate::gateway::rights::Ranges;
use crate::gateway::turns::Asker;

/// Namespace of everything that is ours.
pub const NAMESPACE: &str = "urn:pasapas:gateway";
/// The server itself; the crate keeps nodes of its own in the namespace of this name.
const APPLICATION: &str = "urn:pasapas:gateway:server";
/// Client number of OPC UA, apart from those of clients, cards and G-code.
const ASKER: Asker = 1 << 60;
/// Longest wait for a board that a method asks something of.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time to say goodbye.
const GOODBYE: Duration = Duration::from_secs(2);

/// The server; it ends with this.
pub struct Opcua {
    address: SocketAddr,
    notes: UnboundedSender<Note>,
    thread: Option<JoinHandle<()>>,
}

impl Opcua {
    /// Starts it.
    ///
    /// # Errors
    /// The address cannot be listened on, or certificates cannot be made; in words.
    pub fn start(
        setting: &OpcuaSetting,
        gateway: &Arc<Gateway>,
        (notes, heard): (UnboundedSender<Note>, UnboundedReceiver<Note>),
    ) -> Result<Opcua, String> {
        let words = |error: std::io::Error| error.to_string();
        let listener = crate::gateway::server::bind(setting.listen)?;
        let address = listener.local_addr().map_err(words)?;
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .map_err(words)?;
        keep_private(&setting.pki.join("private"))?;
        // The crate begins tasks while it builds its server.
        let (server, handle) = {
            let _inside = runtime.enter();
            builder(setting, address)?.build()?
        };
        let manager = handle.node_managers().get_of_type::<SimpleNodeManager>();
        let manager = manager.ok_or("the OPC UA server has no room for nodes")?;
        let namespace = handle.get_namespace_index(NAMESPACE);
        let namespace = namespace.ok_or("the OPC UA server has no namespace of ours")?;
        let rights = Ranges::parse(setting.write.iter().map(String::as_str))?;
        let orders = Orders { gateway: Arc::downgrade(gateway), rights };
        let space = Space::new(namespace, manager, &gateway.names, &Arc::new(orders));
        let thread = std::thread::spawn(move || {
            runtime.block_on(async {
                // The listener was bound here, so it belongs to this runtime.
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else { return };
                let serving = tokio::spawn(server.run_with(listener));
                hear(heard, space, &handle).await;
                handle.cancel();
                let _ = tokio::time::timeout(GOODBYE, serving).await;
            });
            runtime.shutdown_background();
        });
        Ok(Opcua { address, notes, thread: Some(thread) })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Opcua {
    fn drop(&mut self) {
        let _ = self.notes.send(Note::Close);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Makes the folder of the key, for this user alone: the crate writes it as readable to all.
fn keep_private(folder: &Path) -> Result<(), String> {
    let mut maker = std::fs::DirBuilder::new();
    maker.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut maker, 0o700);
    maker.create(folder).map_err(|error| format!("{} cannot be made: {error}", folder.display()))
}

/// The server's configuration: without a password on this machine alone, with one encrypted.
fn builder(setting: &OpcuaSetting, address: SocketAddr) -> Result<ServerBuilder, String> {
    let (policy, mode, who) = match setting.user {
        None => (SecurityPolicy::None, MessageSecurityMode::None, ANONYMOUS_USER_TOKEN_ID),
        Some(_) => (SecurityPolicy::Basic256Sha256, MessageSecurityMode::SignAndEncrypt, "user"),
    };
    let metadata =
        NamespaceMetadata { namespace_uri: NAMESPACE.to_owned(), ..NamespaceMetadata::default() };
    let host = address.ip().to_string();
    let mut builder = ServerBuilder::new()
        .application_name("Pasapas gateway")
        .application_uri(APPLICATION)
        .product_uri(APPLICATION)
        .create_sample_keypair(true)
        .certificate_path("own/cert.der")
        .private_key_path("private/private.pem")
        .pki_dir(setting.pki.clone())
        // Whoever knows the password may bring any certificate.
        .trust_client_certs(true)
        .discovery_urls(vec![format!("opc.tcp://{address}/")])
        .host(host)
        .port(address.port())
        .max_sessions(64)
        .with_node_manager(simple_node_manager(metadata, "pasapas"))
        .add_endpoint("main", ("/", policy, mode, &[who] as &[&str]));
    if let (Some(user), Some(file)) = (&setting.user, &setting.password_file) {
        crate::gateway::secret::warn(file);
        let text = std::fs::read_to_string(file)
            .map_err(|error| format!("{} cannot be read: {error}", file.display()))?;
        let password = text.lines().next().unwrap_or_default();
        builder =
            builder.add_user_token("user", ServerUserToken::user_pass(user.as_str(), password));
    }
    Ok(builder)
}

/// Takes what looks bring until the gateway ends.
async fn hear(mut heard: UnboundedReceiver<Note>, mut space: Space, handle: &ServerHandle) {
    while let Some(note) = heard.recv().await {
        match note {
            Note::Look(board, look) => {
                space.show(board, look, handle.subscriptions());
            }
            Note::Close => return,
            Note::Reply(..) => {}
        }
    }
}

/// What methods may do, and where.
pub struct Orders {
    gateway: Weak<Gateway>,
    rights: Ranges,
}

impl Orders {
    /// Writes a run control to a board and waits for its answer.
    ///
    /// # Errors
    /// It is not allowed, or the board does not do it.
    pub fn control(&self, board: usize, control: Control) -> Result<(), StatusCode> {
        let (table, first) = (Table::Holding, wire::RUN_CONTROL);
        if !self.rights.hold(&Touch { table, first, count: 1, write: true }) {
            return Err(StatusCode::BadUserAccessDenied);
        }
        let gateway = self.gateway.upgrade().ok_or(StatusCode::BadShutdown)?;
        let place = &gateway.places[board];
        let (to, done) = channel();
        let job = Box::new(move |board: Result<&mut Board, &str>| {
            // Whoever called may be gone.
            let _ = to.send(match board {
                Ok(board) => board.control(control).map_err(|error| match error {
                    ClientError::Exception(_) => StatusCode::BadInvalidState,
                    _ => StatusCode::BadNoCommunication,
                }),
                Err(_) => Err(StatusCode::BadNoCommunication),
            });
        });
        let urgent = matches!(control, Control::Stop | Control::Pause);
        gateway.lines[place.line].order(ASKER, place.station, urgent, job);
        // The crate calls methods from a task; others go on meanwhile.
        let wait = || done.recv_timeout(PATIENCE).unwrap_or(Err(StatusCode::BadTimeout));
        tokio::task::block_in_place(wait)
    }
}
