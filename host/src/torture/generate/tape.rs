//! The choices of which a program is made: shorter and smaller tapes make simpler programs, so
//! that proptest can shrink a failing one.

/// See the module.
pub struct Tape<'t> {
    data: &'t [u16],
    at: usize,
}

impl<'t> Tape<'t> {
    /// A tape at its beginning.
    pub fn new(data: &'t [u16]) -> Tape<'t> {
        Tape { data, at: 0 }
    }

    /// The next choice of `n`; 0 when the tape is over.
    pub fn pick(&mut self, n: usize) -> usize {
        let value = self.data.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        usize::from(value) % n.max(1)
    }

    /// One of a list.
    pub fn of<'a, T: ?Sized>(&mut self, list: &[&'a T]) -> &'a T {
        list[self.pick(list.len())]
    }

    /// True `n` times in 16.
    pub fn chance(&mut self, n: usize) -> bool {
        self.pick(16) >= 16 - n
    }

    /// Whether the tape is over.
    pub fn is_over(&self) -> bool {
        self.at >= self.data.len()
    }
}
