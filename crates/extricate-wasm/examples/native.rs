//! Answers the requests of the live page with the native library: one request per line of standard
//! input, one reply per line. The arguments are a file with the bytes that the page opens and, if
//! it enters another scene, a file with those.
#![allow(clippy::print_stdout)]

use std::io::BufRead;

use extricate_wasm::Session;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("expected a file")?;
    let mut session = Session::open(&std::fs::read(path)?)?;
    if let Some(path) = std::env::args().nth(2) {
        session.enter(&std::fs::read(path)?)?;
    }
    for line in std::io::stdin().lock().lines() {
        println!("{}", session.call(line?.as_bytes())?);
    }
    Ok(())
}
