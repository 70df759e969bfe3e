//! Reports failures as a number and a message that the thread keeps, and lets no panic pass.

use std::cell::RefCell;
use std::ffi::{CStr, CString};
use std::panic::{AssertUnwindSafe, catch_unwind};

use extricate::Error;

use crate::abi::types::{
    EXTRICATE_ARGUMENT, EXTRICATE_CONFIGURATION, EXTRICATE_FILE, EXTRICATE_INPUT, EXTRICATE_INTERNAL, EXTRICATE_MODEL,
    EXTRICATE_NOTHING_FREE, EXTRICATE_OK, ExtricateStatus,
};

/// A failure on its way to the caller.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// One of the `EXTRICATE_*` codes.
    pub status: ExtricateStatus,
    /// Names the element, its value and what was expected.
    pub message: String,
}

pub type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    /// Makes the fault of an argument that makes no sense.
    pub fn argument(message: impl Into<String>) -> Self {
        Self { status: EXTRICATE_ARGUMENT, message: message.into() }
    }

    /// Puts the name of the argument before the message.
    pub fn of(self, argument: &str) -> Self {
        Self { message: format!("{argument}: {}", self.message), ..self }
    }
}

impl From<Error> for Fault {
    fn from(error: Error) -> Self {
        let status = match &error {
            Error::Read { .. } | Error::Write { .. } | Error::Named { .. } => EXTRICATE_FILE,
            Error::Config { .. } => EXTRICATE_CONFIGURATION,
            Error::Option { .. } => EXTRICATE_ARGUMENT,
            Error::Model { .. } => EXTRICATE_MODEL,
            Error::NothingFree { .. } => EXTRICATE_NOTHING_FREE,
            _ => EXTRICATE_INPUT,
        };
        Self { status, message: error.to_string() }
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// Runs `work`, and keeps the message if it fails. Panics are bugs of this library and end here,
/// because C callers cannot unwind.
pub fn guarded(work: impl FnOnce() -> Result<()>) -> ExtricateStatus {
    let fault = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return EXTRICATE_OK,
        Ok(Err(fault)) => fault,
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(ToString::to_string);
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            Fault { status: EXTRICATE_INTERNAL, message: format!("internal error, please report it: {text}") }
        }
    };
    // While a thread ends, its message may be gone already: destructors of other variables of the
    // thread may run after that of this one.
    let _ = LAST.try_with(|last| last.replace(c_string(&fault.message)));
    fault.status
}

/// Passes the message of the last failure on this thread to `read`.
pub fn last_error<T>(read: impl Fn(&CStr) -> T) -> T {
    LAST.try_with(|last| read(&last.borrow())).unwrap_or_else(|_| read(c"the thread ends: its messages are gone"))
}

/// Converts a text for C, up to its first zero; names of files hold none, but messages might.
pub fn c_string(text: &str) -> CString {
    let text: Vec<u8> = text.bytes().take_while(|byte| *byte != 0).collect();
    CString::new(text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message() -> String {
        last_error(|text| text.to_string_lossy().into_owned())
    }

    #[test]
    fn panics_stop_here() {
        let hook = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let status = guarded(|| panic!("a {}", "fault"));
        std::panic::set_hook(hook);
        assert_eq!(status, EXTRICATE_INTERNAL);
        assert_eq!(message(), "internal error, please report it: a fault");
    }

    #[test]
    fn calls_that_fail_while_a_thread_ends_give_a_status() {
        use std::sync::mpsc::{Sender, channel};
        /// Makes a call that fails while its thread ends, and sends what the call returned.
        struct AtTheEnd(Sender<(ExtricateStatus, String)>);
        impl Drop for AtTheEnd {
            fn drop(&mut self) {
                let status = guarded(|| Err(Fault::argument("late")));
                let _ = self.0.send((status, message()));
            }
        }
        thread_local! {
            static END: RefCell<Option<AtTheEnd>> = const { RefCell::new(None) };
        }
        let (sender, told) = channel();
        let work = move || {
            // The first variable of a thread is destroyed last.
            END.set(Some(AtTheEnd(sender)));
            assert_eq!(guarded(|| Err(Fault::argument("early"))), EXTRICATE_ARGUMENT);
        };
        std::thread::spawn(work).join().unwrap();
        let (status, message) = told.recv().unwrap();
        assert_eq!(status, EXTRICATE_ARGUMENT);
        assert_eq!(message, "the thread ends: its messages are gone");
    }

    #[test]
    fn messages_are_those_of_the_library_and_of_this_thread() {
        let failing = || Err(extricate::load_scene("none.toml").map(drop).unwrap_err().into());
        assert_eq!(guarded(failing), EXTRICATE_FILE);
        assert!(message().starts_with("cannot read none.toml: "), "{}", message());
        std::thread::spawn(|| assert_eq!(message(), "")).join().unwrap();
        assert_eq!(guarded(|| Ok(())), EXTRICATE_OK);
        assert!(!message().is_empty(), "a success changes nothing");
        assert_eq!(c_string("a\0b").to_str(), Ok("a"));
    }
}
