//! The Modbus TCP server: any number of clients, one request of each at a time, answers in order.

use std::collections::HashMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;
use tokio::time::timeout;

use super::Gateway;
use super::rights::Rule;
use super::turns::Asker;
use crate::link::adu::{MAX_RTU, Mbap};

/// A client that does not take its answer for so long is gone.
const WRITE_TIME: Duration = Duration::from_secs(5);
/// A request that has begun is there by then.
const FRAME_TIME: Duration = Duration::from_secs(10);
/// A client that asked within this time, ms, makes room for nobody.
const IDLE: u64 = 5_000;
/// Files that the gateway itself takes: lines, brokers, the outbox.
#[cfg(unix)]
const OWN_FILES: u64 = 200;
/// Rest when the system has no room for another connection.
const NO_ROOM: Duration = Duration::from_millis(100);

struct Guest {
    address: IpAddr,
    manner: Arc<Manner>,
    end: AbortHandle,
}

/// How a guest behaves.
#[derive(Default)]
struct Manner {
    /// Milliseconds since the server's start when it came, or last got an answer.
    last: AtomicU64,
    /// It has asked something.
    asks: AtomicBool,
    /// It waits for an answer.
    waits: AtomicBool,
}

/// Who is connected.
pub struct Guests {
    begun: Instant,
    most: usize,
    list: Mutex<HashMap<Asker, Guest>>,
    next: AtomicU64,
}

impl Guests {
    /// Nobody yet; at most so many at a time.
    pub fn new(most: usize) -> Guests {
        Guests { begun: Instant::now(), most, list: Mutex::default(), next: AtomicU64::new(1) }
    }

    fn list(&self) -> MutexGuard<'_, HashMap<Asker, Guest>> {
        self.list.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> u64 {
        u64::try_from(self.begun.elapsed().as_millis()).unwrap_or(u64::MAX)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.list().len()
    }

    /// Ends the one that has asked nothing for longest, of the machine that has most connections; who
    /// never asked goes before who did. `false`: all of them are at work.
    fn displace(&self) -> bool {
        let (mut list, now) = (self.list(), self.now());
        let mut each: HashMap<IpAddr, usize> = HashMap::new();
        for guest in list.values() {
            *each.entry(guest.address).or_default() += 1;
        }
        let rank = |guest: &Guest| {
            let Manner { last, asks, .. } = &*guest.manner;
            let crowd = std::cmp::Reverse(each[&guest.address]);
            (crowd, asks.load(Ordering::Relaxed), last.load(Ordering::Relaxed))
        };
        let idle = |guest: &Guest| {
            let Manner { last, asks, waits } = &*guest.manner;
            let rest = now.saturating_sub(last.load(Ordering::Relaxed));
            let works = waits.load(Ordering::Relaxed) || rest < IDLE;
            !(works && asks.load(Ordering::Relaxed))
        };
        let oldest = list
            .iter()
            .filter(|(_, guest)| idle(guest))
            .min_by_key(|(_, guest)| rank(guest))
            .map(|(asker, _)| *asker);
        oldest.and_then(|asker| list.remove(&asker)).is_some_and(|guest| {
            guest.end.abort();
            true
        })
    }
}

/// Takes clients for as long as the task lives.
pub async fn serve(listener: TcpListener, gateway: Arc<Gateway>) {
    loop {
        let Ok((stream, address)) = listener.accept().await else {
            tokio::time::sleep(NO_ROOM).await;
            continue;
        };
        gateway.totals.connected.add();
        if gateway.guests.count() >= gateway.guests.most {
            if !gateway.guests.displace() {
                gateway.totals.turned_away.add();
                continue;
            }
            gateway.totals.displaced.add();
        }
        let asker = gateway.guests.next.fetch_add(1, Ordering::Relaxed);
        let manner = Arc::new(Manner::default());
        manner.last.store(gateway.guests.now(), Ordering::Relaxed);
        let (own, shown) = (gateway.clone(), manner.clone());
        let task = tokio::spawn(async move {
            let rule = own.rule(address.ip());
            // A connection that fails is its own end and nobody else's.
            let _ = client(stream, &own, asker, &rule, &shown).await;
            own.guests.list().remove(&asker);
        });
        let guest = Guest { address: address.ip(), manner, end: task.abort_handle() };
        gateway.guests.list().insert(asker, guest);
        if task.is_finished() {
            gateway.guests.list().remove(&asker);
        }
    }
}

async fn client(
    mut stream: TcpStream,
    gateway: &Gateway,
    asker: Asker,
    rule: &Rule,
    manner: &Manner,
) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    let mut received = Vec::new();
    let mut piece = [0; 2 * MAX_RTU];
    loop {
        loop {
            match Mbap::take(&mut received) {
                Ok(None) => break,
                Ok(Some(message)) => {
                    manner.asks.store(true, Ordering::Relaxed);
                    manner.waits.store(true, Ordering::Relaxed);
                    let Mbap { transaction, unit, pdu } = message;
                    let pdu = gateway.answer(asker, rule, unit, pdu).await;
                    let reply = Mbap { transaction, unit, pdu }.bytes();
                    timeout(WRITE_TIME, stream.write_all(&reply)).await??;
                    manner.last.store(gateway.guests.now(), Ordering::Relaxed);
                    manner.waits.store(false, Ordering::Relaxed);
                }
                Err(_) => {
                    gateway.totals.foreign.add();
                    return Ok(());
                }
            }
        }
        let read = stream.read(&mut piece);
        let count =
            if received.is_empty() { read.await } else { timeout(FRAME_TIME, read).await? }?;
        if count == 0 {
            return Ok(());
        }
        received.extend(&piece[..count]);
    }
}

/// Lets this process have the files that so many clients take, beside its own.
///
/// # Errors
/// The system does not allow it; in words.
pub fn make_room(clients: usize) -> Result<(), String> {
    #[cfg(not(unix))]
    let _ = clients;
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let (wanted, mut limit) = (clients as u64 + OWN_FILES, getrlimit(Resource::Nofile));
        if limit.current.is_none_or(|now| now >= wanted) {
            return Ok(());
        }
        if let Some(most) = limit.maximum.filter(|most| *most < wanted) {
            return Err(format!(
                "{clients} clients take {wanted} files, and the system allows {most}: lower `clients`, or \
                 raise `ulimit -n`"
            ));
        }
        limit.current = Some(wanted);
        setrlimit(Resource::Nofile, limit).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// Binds the address.
///
/// # Errors
/// It is taken, or not this machine's; in words.
pub fn bind(address: SocketAddr) -> Result<std::net::TcpListener, String> {
    let listener = std::net::TcpListener::bind(address)
        .and_then(|listener| listener.set_nonblocking(true).map(|()| listener));
    listener.map_err(|error| format!("{address} cannot be listened on: {error}"))
}
