//! Ctrl-C during long work: the first requests a stop, the second ends the process. While a file is
//! written, Ctrl-C is ignored.

use std::sync::Once;
use std::sync::atomic::{AtomicU8, Ordering};

const IDLE: u8 = 0;
const LEARNING: u8 = 1;
const STOP_ASKED: u8 = 2;
const WRITING: u8 = 3;
/// Exit status that a shell reports for a process ended by SIGINT.
#[cfg(not(target_family = "wasm"))]
const EXIT_INTERRUPTED: i32 = 130;

static STATE: AtomicU8 = AtomicU8::new(IDLE);
static INSTALL: Once = Once::new();

/// While it lives, the first Ctrl-C only sets [`StopOnInterrupt::asked`]; otherwise Ctrl-C ends the
/// process.
pub struct StopOnInterrupt(());

impl StopOnInterrupt {
    pub fn new() -> Self {
        INSTALL.call_once(|| {
            // If no handler can be installed, Ctrl-C keeps its usual meaning, which is acceptable.
            #[cfg(not(target_family = "wasm"))]
            let _ = ctrlc::set_handler(|| {
                match STATE.compare_exchange(LEARNING, STOP_ASKED, Ordering::SeqCst, Ordering::SeqCst) {
                    Ok(_) | Err(WRITING) => {}
                    Err(_) => std::process::exit(EXIT_INTERRUPTED),
                }
            });
        });
        STATE.store(LEARNING, Ordering::SeqCst);
        Self(())
    }

    /// Whether the user requested a stop.
    pub fn asked(&self) -> bool {
        STATE.load(Ordering::SeqCst) == STOP_ASKED
    }
}

/// Runs `write`, which takes moments, and ignores Ctrl-C meanwhile, so that no temporary file is
/// left.
pub fn uninterrupted<T>(write: impl FnOnce() -> T) -> T {
    STATE.store(WRITING, Ordering::SeqCst);
    let written = write();
    STATE.store(IDLE, Ordering::SeqCst);
    written
}

impl Drop for StopOnInterrupt {
    fn drop(&mut self) {
        STATE.store(IDLE, Ordering::SeqCst);
    }
}
