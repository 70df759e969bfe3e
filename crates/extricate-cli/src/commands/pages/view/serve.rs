//! One page over HTTP, to browsers of this computer alone: what is needed of the protocol and no
//! more.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::time::Duration;

use anyhow::Context;

/// Longest head of a request \[bytes\].
const LONGEST_HEAD: usize = 8192;
/// How long a browser may take to ask, and to take what it is given.
const PATIENCE: Duration = Duration::from_secs(5);

/// Answers requests for `page`, until the process ends; `begun` hears the address.
///
/// # Errors
/// Where the port cannot be had.
pub fn serve(page: &[u8], port: u16, begun: impl FnOnce(SocketAddr) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let listener = listener.with_context(|| format!("cannot listen at 127.0.0.1:{port}"))?;
    let address = listener.local_addr().context("cannot listen")?;
    begun(address)?;
    for stream in listener.incoming().flatten() {
        // A browser that goes away in the middle is no fault of the others.
        let _ = answer(stream, page, address.port());
    }
    Ok(())
}

fn answer(mut stream: TcpStream, page: &[u8], port: u16) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = head_of(&mut stream)?;
    let (status, body) = reply(&head, page, port);
    let fields = format!(
        "HTTP/1.1 {status}\r\nContent-Type: text/html; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(fields.as_bytes())?;
    if !head.starts_with("HEAD ") {
        stream.write_all(body)?;
    }
    stream.flush()
}

/// The first lines of a request, up to the empty one.
fn head_of(stream: &mut impl Read) -> std::io::Result<String> {
    let (mut head, mut piece) = (Vec::new(), [0; 1024]);
    while head.len() < LONGEST_HEAD && !head.windows(4).any(|end| end == b"\r\n\r\n") {
        match stream.read(&mut piece)? {
            0 => break,
            read => head.extend_from_slice(&piece[..read]),
        }
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

/// Status and body for a request.
fn reply<'a>(head: &str, page: &'a [u8], port: u16) -> (&'static str, &'a [u8]) {
    let mut lines = head.lines();
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let host =
        lines.find_map(|line| line.to_ascii_lowercase().strip_prefix("host:").map(|host| host.trim().to_string()));
    // A name of elsewhere that leads here would let a page of elsewhere read this one.
    let is_own = |host: String| [format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(&host);
    match (method, target) {
        _ if !host.is_some_and(is_own) => ("403 Forbidden", b"asked under another name"),
        ("GET" | "HEAD", "/") => ("200 OK", page),
        ("GET" | "HEAD", _) => ("404 Not Found", b"there is one page, at /"),
        _ => ("405 Method Not Allowed", b"expected GET"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_page_is_given_under_its_own_name_alone() {
        let status = |head: &str| reply(head, b"page", 8000).0;
        assert_eq!(reply("GET / HTTP/1.1\r\nHost: 127.0.0.1:8000\r\n\r\n", b"page", 8000), ("200 OK", &b"page"[..]));
        assert_eq!(status("HEAD / HTTP/1.1\r\nhost: LOCALHOST:8000\r\n\r\n"), "200 OK");
        assert_eq!(status("GET /etc HTTP/1.1\r\nHost: localhost:8000\r\n\r\n"), "404 Not Found");
        assert_eq!(status("POST / HTTP/1.1\r\nHost: localhost:8000\r\n\r\n"), "405 Method Not Allowed");
        for head in ["GET / HTTP/1.1\r\nHost: elsewhere.example:8000\r\n\r\n", "GET / HTTP/1.1\r\n\r\n", "", "\r\n"] {
            assert_eq!(status(head), "403 Forbidden", "{head:?}");
        }
    }

    #[test]
    fn a_head_without_end_is_cut() {
        assert!(head_of(&mut std::io::repeat(b'a')).unwrap().len() <= LONGEST_HEAD + 1024);
        assert_eq!(head_of(&mut &b"GET / HTTP/1.1\r\n\r\nrest"[..]).unwrap(), "GET / HTTP/1.1\r\n\r\nrest");
    }
}
