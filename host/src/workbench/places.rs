//! Limits of connections. Connections that have not authenticated have a limit of their own:
//! however many come, they never keep a page out.

use std::collections::VecDeque;
use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Pages at a time.
const MOST_PAGES: usize = 64;
/// Connections that have not proved who they are. A page loads its files by six at a time.
const MOST_STRANGERS: usize = 32;

/// The places of a server.
#[derive(Default)]
pub struct Places {
    pages: usize,
    /// The oldest one first.
    strangers: VecDeque<(u64, TcpStream)>,
    next: u64,
}

/// A connection's place; it is given back however the connection ends.
pub struct Place {
    all: Arc<Mutex<Places>>,
    number: u64,
    page: bool,
}

fn lock(places: &Mutex<Places>) -> MutexGuard<'_, Places> {
    places.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Place {
    /// A stranger's place. When there are too many, the one that has been a stranger longest is cut off:
    /// a page proves who it is within a fraction of a second.
    ///
    /// # Errors
    /// The stream is gone.
    pub fn take(all: &Arc<Mutex<Places>>, stream: &TcpStream) -> io::Result<Place> {
        let own = stream.try_clone()?;
        let mut places = lock(all);
        if places.strangers.len() >= MOST_STRANGERS
            && let Some((_, oldest)) = places.strangers.pop_front()
        {
            let _ = oldest.shutdown(Shutdown::Both);
        }
        places.next += 1;
        let number = places.next;
        places.strangers.push_back((number, own));
        drop(places);
        Ok(Place { all: all.clone(), number, page: false })
    }

    /// The stranger is a page: whether there is room for it.
    #[must_use]
    pub fn is_of_a_page(&mut self) -> bool {
        let mut places = lock(&self.all);
        if !self.page && places.pages < MOST_PAGES {
            places.strangers.retain(|(number, _)| *number != self.number);
            places.pages += 1;
            self.page = true;
        }
        self.page
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut places = lock(&self.all);
        if self.page {
            places.pages -= 1;
        } else {
            places.strangers.retain(|(number, _)| *number != self.number);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::{TcpListener, TcpStream};
    use std::sync::{Arc, Mutex};

    use super::{MOST_PAGES, MOST_STRANGERS, Place, Places, lock};

    #[test]
    fn strangers_make_room_for_the_newest_and_pages_stay() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let pair = || {
            let outside = TcpStream::connect(address).expect("a connection");
            (outside, listener.accept().expect("a connection").0)
        };
        let places = Arc::new(Mutex::new(Places::default()));
        let (mut outside, mut held) = (Vec::new(), Vec::new());
        for _ in 0..=MOST_STRANGERS {
            let (out, inside) = pair();
            held.push(Place::take(&places, &inside).expect("a place"));
            outside.push(out);
        }
        // The first one is cut off, the newest is there.
        assert_eq!(outside[0].read(&mut [0; 1]).expect("an end"), 0);
        assert_eq!(lock(&places).strangers.len(), MOST_STRANGERS);
        assert!(held.pop().expect("the newest").is_of_a_page());
        let pages: Vec<Place> = (0..MOST_PAGES)
            .map(|_| {
                let (out, inside) = pair();
                outside.push(out);
                let mut place = Place::take(&places, &inside).expect("a place");
                assert!(place.is_of_a_page());
                place
            })
            .collect();
        let (_out, inside) = pair();
        assert!(!Place::take(&places, &inside).expect("a place").is_of_a_page(), "one too many");
        drop((pages, held));
        let places = lock(&places);
        assert_eq!((places.pages, places.strangers.len()), (0, 0));
    }
}
