//! Programs streamed one after the other; each is kept as long as the first.

use std::cell::OnceCell;

use lang::back::Compiled;

/// A program that is fed, and the one behind it.
pub struct Chain {
    compiled: Compiled,
    next: OnceCell<Box<Chain>>,
}

impl Chain {
    /// A program that none follows yet.
    pub fn new(compiled: Compiled) -> Chain {
        Chain { compiled, next: OnceCell::new() }
    }

    /// The program.
    pub fn compiled(&self) -> &Compiled {
        &self.compiled
    }

    /// Puts another one behind it.
    pub fn push(&self, compiled: Compiled) -> &Chain {
        self.next.get_or_init(|| Box::new(Chain::new(compiled)))
    }
}

impl Drop for Chain {
    /// One after the other: there may be more of them than the stack has room for.
    fn drop(&mut self) {
        let mut next = self.next.take();
        while let Some(mut link) = next {
            next = link.next.take();
        }
    }
}
