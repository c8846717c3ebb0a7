//! Scheduling of requests: one of each client in turn, stops before all of them.

use std::collections::VecDeque;

/// Who asks.
pub type Asker = u64;

/// Requests of one client that may wait.
const MOST_WAITING: usize = 32;

/// Requests that wait.
pub struct Turns<T> {
    urgent: VecDeque<T>,
    /// Clients with requests, the next one's turn first.
    queues: VecDeque<(Asker, VecDeque<T>)>,
}

impl<T> Default for Turns<T> {
    fn default() -> Turns<T> {
        Turns { urgent: VecDeque::new(), queues: VecDeque::new() }
    }
}

impl<T> Turns<T> {
    /// Queues a request after those of the same client; gives it back if too many wait already.
    pub fn push(&mut self, asker: Asker, request: T) -> Result<(), T> {
        match self.queues.iter_mut().find(|(own, _)| *own == asker) {
            Some((_, queue)) if queue.len() >= MOST_WAITING => return Err(request),
            Some((_, queue)) => queue.push_back(request),
            None => self.queues.push_back((asker, VecDeque::from([request]))),
        }
        Ok(())
    }

    /// Puts a request before all others but the urgent ones; gives it back if too many of them wait.
    pub fn push_urgent(&mut self, request: T) -> Result<(), T> {
        if self.urgent.len() >= MOST_WAITING {
            return Err(request);
        }
        self.urgent.push_back(request);
        Ok(())
    }

    /// The next one. Whoever was served goes behind the others.
    pub fn pop(&mut self) -> Option<T> {
        if let Some(request) = self.urgent.pop_front() {
            return Some(request);
        }
        let (asker, mut queue) = self.queues.pop_front()?;
        let request = queue.pop_front();
        if !queue.is_empty() {
            self.queues.push_back((asker, queue));
        }
        request
    }

    /// Takes all that waits.
    pub fn take(&mut self) -> Vec<T> {
        let queues = std::mem::take(&mut self.queues).into_iter().flat_map(|(_, queue)| queue);
        std::mem::take(&mut self.urgent).into_iter().chain(queues).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST_WAITING, Turns};

    #[test]
    fn a_request_of_each_in_turn_and_urgent_ones_first() {
        let mut turns = Turns::default();
        for n in 0..3 {
            turns.push(1, (1, n)).expect("room");
        }
        turns.push(2, (2, 0)).expect("room");
        turns.push(3, (3, 0)).expect("room");
        turns.push(2, (2, 1)).expect("room");
        turns.push_urgent((9, 9)).expect("room");
        let order: Vec<_> = std::iter::from_fn(|| turns.pop()).collect();
        assert_eq!(order, [(9, 9), (1, 0), (2, 0), (3, 0), (1, 1), (2, 1), (1, 2)]);
    }

    #[test]
    fn a_queue_has_an_end_and_it_is_its_askers_alone() {
        let mut turns = Turns::default();
        for n in 0..MOST_WAITING {
            turns.push(1, n).expect("room");
        }
        assert_eq!(turns.push(1, 99), Err(99));
        assert_eq!(turns.push(2, 7), Ok(()));
        assert_eq!(turns.take().len(), MOST_WAITING + 1);
        assert_eq!(turns.pop(), None);
    }
}
