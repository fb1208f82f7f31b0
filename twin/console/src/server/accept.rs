//! Accepts the connections of one port and serves HTTP on them.
//!
//! In: a listener and the routes. A connection needs a place, its requests must arrive in time, and it must accept the answers in time. An
//! error of the operating system never ends the loop, and never makes it spin.

use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::http::StatusCode;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

use crate::server::admission::Admission;
use crate::server::admission::connections::Ticket;
use crate::server::admission::refusals::Refusal;
use crate::server::stream::Guarded;

/// Longest head of a request, bytes.
const HEAD_BYTES: usize = 32 * 1024;

/// After an error of the operating system the loop waits, first this long, and twice as long after each further error.
const PAUSE: Duration = Duration::from_millis(20);

/// Longest pause after an error.
const LONGEST_PAUSE: Duration = Duration::from_secs(1);

/// The answer to a connection without a place.
const FULL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 2\r\nConnection: close\r\n\
    Content-Type: text/plain\r\nContent-Length: 58\r\n\r\ntoo many connections; close a console or viewer, try again";

/// The address of the other end of a request's connection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Peer(pub SocketAddr);

/// Serves `routes` on the connections of `listener` until `stopped` changes.
pub(super) async fn serve(
    listener: TcpListener,
    routes: Router,
    admission: Arc<Admission>,
    mut stopped: watch::Receiver<bool>,
) {
    let mut pause = PAUSE;
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            _ = stopped.changed() => return,
        };
        match accepted {
            Ok((stream, address)) => {
                pause = PAUSE;
                admit(stream, address, &routes, &admission, &stopped);
            }
            Err(error) if is_of_the_peer(&error) => {}
            Err(error) => {
                let what = format!("a connection cannot be accepted: {error}");
                admission.refusals.note(Refusal::System, &what);
                tokio::time::sleep(pause).await;
                pause = longer(pause);
            }
        }
    }
}

/// Whether the peer gave the connection up before it was accepted; the next one may be accepted at once.
fn is_of_the_peer(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(error.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

fn longer(pause: Duration) -> Duration {
    (pause * 2).min(LONGEST_PAUSE)
}

fn admit(
    stream: TcpStream,
    address: SocketAddr,
    routes: &Router,
    admission: &Arc<Admission>,
    stopped: &watch::Receiver<bool>,
) {
    // Disables Nagle's algorithm: otherwise a frame waits for the acknowledgement of the previous one, which the peer may delay by 40 ms.
    if let Err(error) = stream.set_nodelay(true) {
        tracing::debug!("a connection keeps small frames back: {error}");
    }
    match admission.connections.admit(address.ip()) {
        Ok(ticket) => {
            let talk = converse(
                stream,
                address,
                ticket,
                routes.clone(),
                Arc::clone(admission),
                stopped.clone(),
            );
            tokio::spawn(talk);
        }
        Err(refusal) => {
            admission
                .refusals
                .note(refusal, &format_args!("{address} refused: too many connections"));
            // The answer fits into the empty send buffer; a peer that takes no answer is refused without one.
            let told = stream.into_std().and_then(|mut stream| stream.write_all(FULL));
            if let Err(error) = told {
                tracing::debug!("{address} was refused without an answer: {error}");
            }
        }
    }
}

/// Serves one connection until it ends, becomes a WebSocket, or loses its place.
async fn converse(
    stream: TcpStream,
    address: SocketAddr,
    ticket: Ticket,
    routes: Router,
    admission: Arc<Admission>,
    mut stopped: watch::Receiver<bool>,
) {
    let limits = admission.limits;
    let connection = Arc::clone(&ticket.connection);
    let routes = TowerToHyperService::new(routes);
    let answer = {
        let connection = Arc::clone(&connection);
        service_fn(move |mut request: hyper::Request<Incoming>| {
            connection.begin();
            request.extensions_mut().insert(Peer(address));
            let (answered, connection) = (routes.call(request), Arc::clone(&connection));
            async move {
                let response = answered.await;
                let upgraded =
                    response.as_ref().is_ok_and(|r| r.status() == StatusCode::SWITCHING_PROTOCOLS);
                if !upgraded {
                    connection.end();
                }
                response
            }
        })
    };
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(limits.head).max_buf_size(HEAD_BYTES);
    let io = TokioIo::new(Guarded::new(stream, limits.stalled, ticket));
    let talk = http.serve_connection(io, answer).with_upgrades();
    let mut talk = std::pin::pin!(talk);
    let mut ending = false;
    loop {
        tokio::select! {
            ended = talk.as_mut() => {
                if let Err(error) = ended {
                    note(&error, address, &admission);
                }
                return;
            }
            () = connection.displaced() => return,
            _ = stopped.changed(), if !ending => {
                ending = true;
                talk.as_mut().graceful_shutdown();
            }
        }
    }
}

fn note(error: &hyper::Error, address: SocketAddr, admission: &Admission) {
    let refusals = &admission.refusals;
    if error.is_timeout() {
        let s = admission.limits.head.as_secs_f64();
        refusals.note(Refusal::Head, &format_args!("{address} closed: no request within {s} s"));
    } else if is_stalled(error) {
        let s = admission.limits.stalled.as_secs_f64();
        refusals
            .note(Refusal::Stalled, &format_args!("{address} closed: it took no data for {s} s"));
    } else {
        tracing::debug!("the connection of {address} failed: {error}");
    }
}

fn is_stalled(error: &hyper::Error) -> bool {
    let source = std::error::Error::source(error);
    let io = source.and_then(|source| source.downcast_ref::<io::Error>());
    io.is_some_and(|io| io.kind() == io::ErrorKind::TimedOut)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_after_errors_grow_to_a_second() {
        let pauses: Vec<u128> = std::iter::successors(Some(PAUSE), |pause| Some(longer(*pause)))
            .take(9)
            .map(|p| p.as_millis())
            .collect();
        assert_eq!(pauses, [20, 40, 80, 160, 320, 640, 1000, 1000, 1000]);
    }

    #[test]
    fn the_answer_to_a_connection_without_a_place_is_whole() {
        let text = std::str::from_utf8(FULL).unwrap();
        let (head, body) = text.split_once("\r\n\r\n").unwrap();
        assert!(head.ends_with(&format!("Content-Length: {}", body.len())), "{}", body.len());
    }
}
