//! Six functions of plain numbers, for JavaScript. It writes a request to the address of
//! `extricate_input`, calls `extricate_open`, `extricate_enter` or `extricate_call`, and reads the
//! reply at `extricate_output`.
//!
//! Unsafe code is allowed only for names that are not mangled; two vectors hold the memory.
#![allow(unsafe_code)]

use std::cell::RefCell;

use crate::session::Session;

thread_local! {
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static SESSION: RefCell<Option<Session>> = const { RefCell::new(None) };
}

/// Makes space for a request of `length` bytes, and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_input(length: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        input.resize(length, 0);
        input.as_mut_ptr()
    })
}

/// Opens the bytes of a scene or a model. Returns 0, or 1 if they cannot be used; the reply then
/// says why.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_open() -> u32 {
    let bytes = INPUT.take();
    match Session::open(&bytes) {
        Ok(session) => {
            SESSION.set(Some(session));
            reply(Ok(String::new()))
        }
        Err(error) => reply(Err(error)),
    }
}

/// Enters another scene, given as bytes, and keeps the model. Returns 0, or 1 if they cannot be
/// used; the reply then says why.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_enter() -> u32 {
    let bytes = INPUT.take();
    SESSION.with_borrow_mut(|session| match session {
        Some(session) => reply(session.enter(&bytes).map(|()| String::new())),
        None => reply(Err("nothing is open".into())),
    })
}

/// Answers the request, a JSON object. Returns 0, or 1 if that is impossible; the reply then says
/// why.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_call() -> u32 {
    let request = INPUT.take();
    SESSION.with_borrow_mut(|session| match session {
        Some(session) => reply(session.call(&request)),
        None => reply(Err("nothing is open".into())),
    })
}

/// Returns the address of the reply.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_output() -> *const u8 {
    OUTPUT.with_borrow(|output| output.as_ptr())
}

/// Returns the length of the reply \[bytes\].
#[unsafe(no_mangle)]
pub extern "C" fn extricate_output_length() -> usize {
    OUTPUT.with_borrow(Vec::len)
}

fn reply(result: Result<String, String>) -> u32 {
    let (status, text) = match result {
        Ok(text) => (0, text),
        Err(error) => (1, error),
    };
    OUTPUT.set(text.into_bytes());
    status
}
