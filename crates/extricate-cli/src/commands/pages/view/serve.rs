//! Serves one page over HTTP to browsers of this computer alone. It implements only the necessary
//! part of the protocol.

use std::io::{ErrorKind, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::Context;

/// Largest head of a request.
const MAX_HEAD_BYTES: usize = 8192;
/// Time within which a browser has to send its request.
const REQUEST_TIMEOUT: Duration = Duration::from_secs(5);
/// Time within which a browser has to receive the reply.
const REPLY_TIMEOUT: Duration = Duration::from_secs(30);
/// Largest number of connections at a time, each of which takes a thread; further ones are closed.
const MAX_CONNECTIONS: usize = 64;
/// Bytes that are written at once.
const PIECE_BYTES: usize = 1 << 16;

/// Header fields of every reply. They keep pages from elsewhere from embedding this one.
const REPLY_FIELDS: &str = "Content-Type: text/html; charset=utf-8\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
                      Content-Security-Policy: frame-ancestors 'none'\r\nX-Frame-Options: DENY\r\nConnection: close\r\n";

/// Serves `page` until the process ends; `begun` receives the address.
///
/// # Errors
/// Fails if the port is not available.
pub fn serve(page: &[u8], port: u16, begun: impl FnOnce(SocketAddr) -> anyhow::Result<()>) -> anyhow::Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    let listener = listener.with_context(|| format!("cannot listen at 127.0.0.1:{port}"))?;
    let address = listener.local_addr().context("cannot listen")?;
    begun(address)?;
    let answered = AtomicUsize::new(0);
    thread::scope(|scope| {
        for stream in listener.incoming().flatten() {
            if answered.fetch_add(1, Ordering::SeqCst) >= MAX_CONNECTIONS {
                answered.fetch_sub(1, Ordering::SeqCst);
                continue;
            }
            let answered = &answered;
            let answer = move || {
                // A browser that disconnects early must not affect the others.
                let _ = answer(stream, page, address.port());
                answered.fetch_sub(1, Ordering::SeqCst);
            };
            if thread::Builder::new().spawn_scoped(scope, answer).is_err() {
                answered.fetch_sub(1, Ordering::SeqCst);
            }
        }
    });
    Ok(())
}

fn answer(mut stream: TcpStream, page: &[u8], port: u16) -> std::io::Result<()> {
    let head = head_of(&mut stream, Instant::now() + REQUEST_TIMEOUT)?;
    let (status, body) = reply(&head, page, port);
    let fields = format!("HTTP/1.1 {status}\r\nContent-Length: {}\r\n{REPLY_FIELDS}\r\n", body.len());
    let body = if head.starts_with("HEAD ") { &[] } else { body };
    let end = Instant::now() + REPLY_TIMEOUT;
    for piece in [fields.as_bytes()].into_iter().chain(body.chunks(PIECE_BYTES)) {
        stream.set_write_timeout(Some(left_until(end)?))?;
        stream.write_all(piece)?;
    }
    stream.flush()
}

/// Reads the first lines of a request, up to the empty one.
///
/// # Errors
/// Fails if they have not arrived by `end`; the timeout of a stream would apply to each read alone.
fn head_of(stream: &mut TcpStream, end: Instant) -> std::io::Result<String> {
    let (mut head, mut piece) = (Vec::new(), [0; 1024]);
    while head.len() < MAX_HEAD_BYTES && !head.windows(4).any(|end| end == b"\r\n\r\n") {
        stream.set_read_timeout(Some(left_until(end)?))?;
        match stream.read(&mut piece)? {
            0 => break,
            read => head.extend_from_slice(&piece[..read]),
        }
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

fn left_until(end: Instant) -> std::io::Result<Duration> {
    let left = end.saturating_duration_since(Instant::now());
    if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(left) }
}

/// Chooses status and body for a request.
fn reply<'a>(head: &str, page: &'a [u8], port: u16) -> (&'static str, &'a [u8]) {
    let mut lines = head.lines();
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let lower = lines.map(str::to_ascii_lowercase);
    let hosts: Vec<String> =
        lower.filter_map(|line| line.strip_prefix("host:").map(|host| host.trim().to_string())).collect();
    // If a foreign name resolves to this computer, a foreign page could read this one under that
    // name.
    let is_own = |host: &String| [format!("127.0.0.1:{port}"), format!("localhost:{port}")].contains(host);
    match (method, target) {
        _ if hosts.len() > 1 => ("400 Bad Request", b"asked under several names"),
        _ if !hosts.first().is_some_and(is_own) => ("403 Forbidden", b"asked under another name"),
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
    fn a_request_has_one_host() {
        let own = "Host: localhost:8000\r\n";
        for second in [own, "host: elsewhere.example\r\n"] {
            let head = format!("GET / HTTP/1.1\r\n{own}{second}\r\n");
            assert_eq!(reply(&head, b"page", 8000).0, "400 Bad Request", "{head:?}");
        }
    }

    /// Both ends of a connection.
    fn connection() -> [TcpStream; 2] {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        [client, listener.accept().unwrap().0]
    }

    #[test]
    fn a_head_without_end_is_cut() {
        let later = Instant::now() + REPLY_TIMEOUT;
        let [mut client, mut server] = connection();
        let writing = thread::spawn(move || client.write_all(&[b'a'; 4 * MAX_HEAD_BYTES]).map(|()| client));
        assert!(head_of(&mut server, later).unwrap().len() <= MAX_HEAD_BYTES + 1024);
        drop(server);
        let _ = writing.join().unwrap();
        let [mut client, mut server] = connection();
        client.write_all(b"GET / HTTP/1.1\r\n\r\nrest").unwrap();
        assert_eq!(head_of(&mut server, later).unwrap(), "GET / HTTP/1.1\r\n\r\nrest");
    }

    #[test]
    fn a_head_that_comes_slowly_has_an_end() {
        let [mut client, mut server] = connection();
        let writing = thread::spawn(move || {
            let started = Instant::now();
            while started.elapsed() < REPLY_TIMEOUT && client.write_all(b"a").is_ok() {
                thread::sleep(Duration::from_millis(20));
            }
            started.elapsed()
        });
        assert!(head_of(&mut server, Instant::now() + Duration::from_millis(200)).is_err());
        drop(server);
        assert!(writing.join().unwrap() < REPLY_TIMEOUT / 2, "it was read for as long as it was written");
    }
}
