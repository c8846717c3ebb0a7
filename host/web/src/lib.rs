//! Compiler, simulator and language server for a page of the browser, without a tool on the computer.

pub mod desk;

use std::cell::RefCell;
use std::collections::VecDeque;

use desk::{Desk, Said};

thread_local! {
    static PAGE: RefCell<Page> = RefCell::new(Page::default());
}

#[derive(Default)]
struct Page {
    desk: Desk,
    input: Vec<u8>,
    said: VecDeque<Said>,
    output: Vec<u8>,
}

/// A place for the next message of this many bytes; it holds until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn input(bytes: usize) -> *mut u8 {
    PAGE.with_borrow_mut(|page| {
        page.input = vec![0; bytes];
        page.input.as_mut_ptr()
    })
}

/// Takes the message; what it gives is fetched by [`next`].
#[unsafe(no_mangle)]
pub extern "C" fn hear() {
    PAGE.with_borrow_mut(|page| {
        let message = std::mem::take(&mut page.input);
        let said = page.desk.hear(&message);
        page.said.extend(said);
    });
}

/// Makes the next thing to be said ready at [`output`]. 0: there is none; 1: a text; 2: bytes.
#[unsafe(no_mangle)]
pub extern "C" fn next() -> u32 {
    PAGE.with_borrow_mut(|page| {
        let (kind, bytes) = match page.said.pop_front() {
            None => (0, Vec::new()),
            Some(Said::Text(text)) => (1, text.into_bytes()),
            Some(Said::Bytes(bytes)) => (2, bytes),
        };
        page.output = bytes;
        kind
    })
}

/// Where it is; it holds until the next call.
#[unsafe(no_mangle)]
pub extern "C" fn output() -> *const u8 {
    PAGE.with_borrow(|page| page.output.as_ptr())
}

/// How long it is, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn length() -> usize {
    PAGE.with_borrow(|page| page.output.len())
}
