//! Ctrl-C while learning: the first asks the learner to stop, the second ends the process. While a
//! file is written, none does.

use std::sync::Once;
use std::sync::atomic::{AtomicU8, Ordering};

const IDLE: u8 = 0;
const LEARNING: u8 = 1;
const STOP_ASKED: u8 = 2;
const WRITING: u8 = 3;
/// What a shell reports for a process that SIGINT ended.
#[cfg(not(target_family = "wasm"))]
const EXIT_INTERRUPTED: i32 = 130;

static STATE: AtomicU8 = AtomicU8::new(IDLE);
static INSTALL: Once = Once::new();

/// While this lives, the first Ctrl-C only sets [`StopOnInterrupt::asked`]; outside of it Ctrl-C
/// ends the process.
pub struct StopOnInterrupt(());

impl StopOnInterrupt {
    /// Starts to listen.
    pub fn new() -> Self {
        INSTALL.call_once(|| {
            // Where no handler can be installed Ctrl-C keeps its usual meaning, which is no worse.
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

    /// Whether the user asked to stop.
    pub fn asked(&self) -> bool {
        STATE.load(Ordering::SeqCst) == STOP_ASKED
    }
}

/// Runs `write`, which takes moments, without letting Ctrl-C leave a temporary file behind.
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
