//! What the live page asks its WebAssembly, asked of the library as it is: one request a line of
//! standard input, one reply a line. The arguments are a file with the bytes that the page opens,
//! and one with those of the scene that it enters, where there is one.
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
