//! A request that becomes a WebSocket, and the codes with which a WebSocket is closed.

use std::time::Duration;

use axum::body::Body;
use axum::extract::FromRequestParts;
use axum::http::header::{
    CONNECTION, ORIGIN, SEC_WEBSOCKET_ACCEPT, SEC_WEBSOCKET_KEY, SEC_WEBSOCKET_PROTOCOL,
    SEC_WEBSOCKET_VERSION, UPGRADE, USER_AGENT,
};
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::response::{IntoResponse, Response};
use futures_util::SinkExt;
use hyper::upgrade::{OnUpgrade, Upgraded};
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::error::ProtocolError;
use tokio_tungstenite::tungstenite::handshake::derive_accept_key;
use tokio_tungstenite::tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tokio_tungstenite::tungstenite::{Error, Message};

use crate::server::accept::Peer;
use crate::server::admission::places::Visitor;
use crate::server::admission::refusals::Refusal;
use crate::server::outbox::CloseReason;

/// A WebSocket of this server.
pub(super) type WebSocket = WebSocketStream<TokioIo<Upgraded>>;

/// Longest message a client may send, bytes.
pub(super) const LONGEST_MESSAGE: usize = 64 * 1024;

/// Size of each connection's read buffer, bytes. It is small because clients send short messages.
const READ_BUFFER: usize = 8 * 1024;

/// The server waits this long for a client to receive the reason why its connection closes.
pub(super) const LINGER: Duration = Duration::from_secs(2);

/// Most bytes that are thrown away of a client whose connection closes.
const LINGER_BYTES: usize = 16 * 1024 * 1024;

/// Close codes of RFC 6455, section 7.4.1.
pub(super) mod code {
    /// The connection has done its work.
    pub(in crate::server) const NORMAL: u16 = 1000;
    /// The server stops.
    pub(in crate::server) const GOING_AWAY: u16 = 1001;
    /// A frame breaks the protocol.
    pub(in crate::server) const PROTOCOL: u16 = 1002;
    /// Text where only binary messages are understood, or the reverse.
    pub(in crate::server) const UNSUPPORTED: u16 = 1003;
    /// A message whose content is not of its type, such as text that is no UTF-8.
    pub(in crate::server) const INVALID: u16 = 1007;
    /// A rule of this server, such as a rate.
    pub(in crate::server) const POLICY: u16 = 1008;
    /// A message that is too long.
    pub(in crate::server) const TOO_LONG: u16 = 1009;
    /// No place is free.
    pub(in crate::server) const TRY_LATER: u16 = 1013;
}

/// A request for a WebSocket.
pub(super) struct Upgrade {
    key: HeaderValue,
    pending: OnUpgrade,
    protocol: Option<HeaderValue>,
    /// The client that asks.
    pub visitor: Visitor,
}

/// Why a request does not become a WebSocket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NoUpgrade(&'static str);

impl IntoResponse for NoUpgrade {
    fn into_response(self) -> Response {
        let version = [(SEC_WEBSOCKET_VERSION, "13")];
        (StatusCode::UPGRADE_REQUIRED, version, self.0).into_response()
    }
}

impl<S: Send + Sync> FromRequestParts<S> for Upgrade {
    type Rejection = NoUpgrade;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, NoUpgrade> {
        let headers = &parts.headers;
        if parts.method != Method::GET {
            return Err(NoUpgrade("a WebSocket begins with GET"));
        }
        if !names(headers, &CONNECTION, "upgrade") || !names(headers, &UPGRADE, "websocket") {
            return Err(NoUpgrade("expected Connection: upgrade and Upgrade: websocket"));
        }
        if !names(headers, &SEC_WEBSOCKET_VERSION, "13") {
            return Err(NoUpgrade("expected Sec-WebSocket-Version: 13"));
        }
        let key = headers.get(SEC_WEBSOCKET_KEY).cloned();
        let key = key.ok_or(NoUpgrade("expected a Sec-WebSocket-Key"))?;
        let visitor = visitor(parts).ok_or(NoUpgrade("the connection has no address"))?;
        let pending = parts.extensions.remove::<OnUpgrade>();
        let pending = pending.ok_or(NoUpgrade("the connection cannot become a WebSocket"))?;
        Ok(Self { key, pending, protocol: None, visitor })
    }
}

/// Whether the header `name` lists `word`.
fn names(headers: &HeaderMap, name: &HeaderName, word: &str) -> bool {
    let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
    values.flat_map(|value| value.split(',')).any(|one| one.trim().eq_ignore_ascii_case(word))
}

fn visitor(parts: &Parts) -> Option<Visitor> {
    let Peer(address) = parts.extensions.get()?;
    let text = |name| {
        let value: Option<&HeaderValue> = parts.headers.get(name);
        value.map(|value| String::from_utf8_lossy(value.as_bytes()).into_owned())
    };
    Some(Visitor {
        address: address.ip(),
        path: parts.uri.path().to_owned(),
        origin: text(ORIGIN),
        agent: text(USER_AGENT),
    })
}

impl Upgrade {
    /// Accepts this sub-protocol, which must be one that the client asked for.
    pub(super) fn protocol(mut self, protocol: &str) -> Self {
        self.protocol = HeaderValue::from_str(protocol).ok();
        self
    }

    /// Answers the request, and hands the WebSocket to `serve` once the client has the answer.
    pub(super) fn accept<F>(self, serve: impl FnOnce(WebSocket) -> F + Send + 'static) -> Response
    where
        F: Future<Output = ()> + Send + 'static,
    {
        let config = WebSocketConfig::default()
            .read_buffer_size(READ_BUFFER)
            .max_message_size(Some(LONGEST_MESSAGE))
            .max_frame_size(Some(LONGEST_MESSAGE));
        tokio::spawn(async move {
            match self.pending.await {
                Ok(upgraded) => {
                    let io = TokioIo::new(upgraded);
                    serve(WebSocketStream::from_raw_socket(io, Role::Server, Some(config)).await)
                        .await;
                }
                Err(error) => tracing::debug!("a client left during its handshake: {error}"),
            }
        });
        let mut response = Response::new(Body::empty());
        *response.status_mut() = StatusCode::SWITCHING_PROTOCOLS;
        let headers = response.headers_mut();
        headers.insert(CONNECTION, HeaderValue::from_static("upgrade"));
        headers.insert(UPGRADE, HeaderValue::from_static("websocket"));
        let accepted = HeaderValue::from_str(&derive_accept_key(self.key.as_bytes()));
        headers.extend(accepted.ok().map(|accepted| (SEC_WEBSOCKET_ACCEPT, accepted)));
        headers.extend(self.protocol.map(|protocol| (SEC_WEBSOCKET_PROTOCOL, protocol)));
        response
    }
}

/// The reason with which to close a WebSocket after `error`, and the refusal to count; `None` if the client is gone.
pub(super) fn farewell(error: &Error) -> Option<(CloseReason, Refusal)> {
    let (code, reason, refusal) = match error {
        Error::Capacity(_) => {
            let limit = LONGEST_MESSAGE / 1024;
            (code::TOO_LONG, format!("a message is longer than {limit} KiB"), Refusal::Length)
        }
        Error::Utf8(_) => (code::INVALID, "a text message is no UTF-8".to_owned(), Refusal::Data),
        Error::Protocol(ProtocolError::ResetWithoutClosingHandshake) => return None,
        Error::Protocol(error) => (code::PROTOCOL, error.to_string(), Refusal::Protocol),
        _ => return None,
    };
    Some((CloseReason { code, reason }, refusal))
}

/// Sends the reason; an error means that the client is gone already, so nobody is left to tell.
pub(super) async fn say_farewell(
    sink: &mut (impl futures_util::Sink<Message> + Unpin),
    farewell: CloseReason,
) {
    // The reason of a close frame has at most 123 bytes.
    let reason: String = farewell.reason.chars().filter(char::is_ascii).take(120).collect();
    let frame = CloseFrame { code: farewell.code.into(), reason: reason.into() };
    let sent = sink.send(Message::Close(Some(frame)));
    let _ = tokio::time::timeout(Duration::from_secs(1), sent).await;
}

/// Ends a WebSocket after its farewell. Closing it with unread input would reset the connection, and the client would never see the
/// reason; so what the client still sends is thrown away until it closes its side, for a limited time.
pub(super) async fn linger(mut socket: WebSocket) {
    let io = socket.get_mut();
    let drained = async {
        io.shutdown().await?;
        let mut buffer = [0; 4096];
        let mut left = LINGER_BYTES;
        while left > 0 {
            match io.read(&mut buffer).await? {
                0 => break,
                read => left = left.saturating_sub(read),
            }
        }
        std::io::Result::Ok(())
    };
    let _ = tokio::time::timeout(LINGER, drained).await;
}

/// Accepts a client only to tell it that no place is free: a page sees the code of a WebSocket, but not the status of a request.
pub(super) fn try_later(upgrade: Upgrade) -> Response {
    upgrade.accept(|mut socket| async move {
        let reason = "too many clients; close another console and try again".to_owned();
        say_farewell(&mut socket, CloseReason { code: code::TRY_LATER, reason }).await;
        linger(socket).await;
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio_tungstenite::tungstenite::error::CapacityError;

    #[test]
    fn each_kind_of_error_has_its_code() {
        let too_long = CapacityError::MessageTooLong { size: 9, max_size: 8 };
        for (error, wanted) in [
            (Error::Capacity(too_long), Some(1009)),
            (Error::Protocol(ProtocolError::UnmaskedFrameFromClient), Some(1002)),
            (Error::Protocol(ProtocolError::NonZeroReservedBits), Some(1002)),
            (Error::Utf8("at 3".to_owned()), Some(1007)),
            (Error::Protocol(ProtocolError::ResetWithoutClosingHandshake), None),
            (Error::ConnectionClosed, None),
            (Error::Io(std::io::ErrorKind::BrokenPipe.into()), None),
        ] {
            let found = farewell(&error).map(|(reason, _)| reason.code);
            assert_eq!(found, wanted, "{error}");
        }
    }

    #[test]
    fn a_header_lists_words() {
        let mut headers = HeaderMap::new();
        headers.insert(CONNECTION, HeaderValue::from_static("keep-alive, Upgrade"));
        assert!(names(&headers, &CONNECTION, "upgrade"));
        assert!(!names(&headers, &CONNECTION, "up") && !names(&headers, &UPGRADE, "websocket"));
    }
}
