//! Six functions of plain numbers. JavaScript writes a request where `extricate_input` says, calls
//! `extricate_open`, `extricate_enter` or `extricate_call`, and reads the reply at
//! `extricate_output`.
//!
//! The only unsafe thing is that their names are not mangled; memory is that of two vectors.
#![allow(unsafe_code)]

use std::cell::RefCell;

use crate::session::Session;

thread_local! {
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static OUTPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static SESSION: RefCell<Option<Session>> = const { RefCell::new(None) };
}

/// Makes room for a request of `length` bytes, and says where it is.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_input(length: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        input.resize(length, 0);
        input.as_mut_ptr()
    })
}

/// Opens the bytes of a scene or a model. 0, or 1 where they cannot be used; the reply then says
/// why.
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

/// Goes into another scene, whose bytes these are; a model stays. 0, or 1 if they cannot be used;
/// the reply then says why.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_enter() -> u32 {
    let bytes = INPUT.take();
    SESSION.with_borrow_mut(|session| match session {
        Some(session) => reply(session.enter(&bytes).map(|()| String::new())),
        None => reply(Err("nothing is open".into())),
    })
}

/// Does what the request, a JSON object, asks for. 0, or 1 where it cannot be done; the reply then
/// says why.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_call() -> u32 {
    let request = INPUT.take();
    SESSION.with_borrow_mut(|session| match session {
        Some(session) => reply(session.call(&request)),
        None => reply(Err("nothing is open".into())),
    })
}

/// Where the reply is.
#[unsafe(no_mangle)]
pub extern "C" fn extricate_output() -> *const u8 {
    OUTPUT.with_borrow(|output| output.as_ptr())
}

/// How long it is \[bytes\].
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
