//! The port for Foxglove: accepts its clients by the rules of the console, and passes their messages on to Foxglove's own server.
//!
//! Foxglove's server asks nobody who he is, sets no limits, and stops accepting after the first error of the operating system. It therefore
//! listens on an address that only this program knows, and every client comes through here.

use std::hash::{BuildHasher as _, Hasher as _, RandomState};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::{Request, State};
use axum::http::header::{HOST, ORIGIN, SEC_WEBSOCKET_PROTOCOL};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use futures_util::{FutureExt, SinkExt, StreamExt};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::mpsc;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::protocol::WebSocketConfig;
use tokio_tungstenite::tungstenite::{Bytes, Error, Message};
use tokio_tungstenite::{WebSocketStream, client_async_with_config};

use crate::server::App;
use crate::server::admission::budget::{Budget, ONE_PER_S, Pace};
use crate::server::admission::refusals::Refusal;
use crate::server::http::{refusal, text};
use crate::server::origin::{AppOrigin, check_app, check_host};
use crate::server::outbox::CloseReason;
use crate::server::pace::now;
use crate::server::socket::{
    NoUpgrade, Upgrade, WebSocket, code, farewell, linger, say_farewell, try_later,
};

/// Size of the buffer between Foxglove's server and this one, bytes. It is small, so that a slow client gets new messages instead of old
/// ones.
const INSIDE_BUFFER: u32 = 64 * 1024;

/// Foxglove's server must answer within this time. It answers at once, unless it stopped accepting.
const INSIDE_PATIENCE: Duration = Duration::from_secs(2);

/// Length of the part of a message that sets one gain, bytes; so much of a long message costs as much as a frame.
const GAIN_BYTES: usize = 64;

/// Start of the names of the sub-protocols that Foxglove's server speaks.
const PROTOCOLS: &str = "foxglove.sdk.v1";

/// A connection to Foxglove's server.
type Inside = WebSocketStream<TcpStream>;

/// The state that the clients share.
#[derive(Clone)]
struct Front {
    app: Arc<App>,
    inside: SocketAddr,
    origins: Arc<[AppOrigin]>,
    /// Each client has a clone, so that the other end knows when the last one has left.
    open: mpsc::Sender<()>,
}

/// An address of the loopback interface for Foxglove's server. A page that tries ports cannot find it, because it would have to try
/// sixteen million addresses. A system that has one loopback address only gives that one.
pub(super) async fn inside_host() -> IpAddr {
    let [a, b, c, ..] = RandomState::new().build_hasher().finish().to_le_bytes();
    let hidden = IpAddr::V4(Ipv4Addr::new(127, a, b, c.clamp(2, 254)));
    let usable = TcpListener::bind((hidden, 0)).await.is_ok();
    if usable { hidden } else { IpAddr::V4(Ipv4Addr::LOCALHOST) }
}

/// The routes of the port for Foxglove: a WebSocket at every path.
pub(super) fn routes(
    app: Arc<App>,
    inside: SocketAddr,
    origins: Vec<AppOrigin>,
    open: mpsc::Sender<()>,
) -> Router {
    let front = Front { app, inside, origins: origins.into(), open };
    Router::new()
        .fallback(join)
        .layer(middleware::from_fn_with_state(front.clone(), guard))
        .with_state(front)
}

/// Refuses requests of foreign hosts, and of pages that are no known application.
async fn guard(State(front): State<Front>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let checked = check_host(text(headers, &HOST))
        .and_then(|()| check_app(text(headers, &ORIGIN), &front.origins));
    match checked {
        Ok(()) => next.run(request).await,
        Err(error) => refusal(&error, &front.app.admission),
    }
}

async fn join(
    upgrade: Result<Upgrade, NoUpgrade>,
    State(front): State<Front>,
    headers: HeaderMap,
) -> Response {
    let upgrade = match upgrade {
        Ok(upgrade) => upgrade,
        Err(refused) => return refused.into_response(),
    };
    // Foxglove's server would refuse it, too, but with a line in the log for each refusal.
    let asked = headers.get(SEC_WEBSOCKET_PROTOCOL).and_then(|value| value.to_str().ok());
    let names = asked.unwrap_or_default().split(',').map(str::trim);
    let Some(usable) = names.into_iter().find(|name| name.starts_with(PROTOCOLS)) else {
        return (StatusCode::BAD_REQUEST, format!("expected the sub-protocol {PROTOCOLS}"))
            .into_response();
    };
    let admission = Arc::clone(&front.app.admission);
    let place = match admission.places.take(upgrade.visitor.clone()) {
        Ok(place) => place,
        Err(refusal) => {
            let address = upgrade.visitor.address;
            admission.refusals.note(refusal, &format_args!("{address}: too many clients"));
            return try_later(upgrade.protocol(usable));
        }
    };
    let entered = tokio::time::timeout(INSIDE_PATIENCE, enter(front.inside, asked)).await;
    match entered {
        Ok(Ok((inside, protocol))) => upgrade.protocol(&protocol).accept(async move |socket| {
            relay(socket, inside, &front.app).await;
            drop((place, front.open));
        }),
        Ok(Err(Error::Http(answer))) => {
            let why =
                String::from_utf8_lossy(answer.body().as_deref().unwrap_or_default()).into_owned();
            (answer.status(), why).into_response()
        }
        Ok(Err(error)) => absent(&front, &error.to_string()),
        Err(_) => absent(&front, "it does not answer"),
    }
}

fn absent(front: &Front, why: &str) -> Response {
    let what = format!("the server for Foxglove cannot be reached: {why}");
    front.app.admission.refusals.note(Refusal::System, &what);
    (StatusCode::SERVICE_UNAVAILABLE, what).into_response()
}

/// Connects to Foxglove's server; returns the sub-protocol that it chose, too.
async fn enter(inside: SocketAddr, asked: Option<&str>) -> Result<(Inside, String), Error> {
    let mut request = format!("ws://{inside}/").into_client_request()?;
    if let Some(value) = asked.and_then(|asked| asked.parse().ok()) {
        request.headers_mut().insert(SEC_WEBSOCKET_PROTOCOL, value);
    }
    let socket = TcpSocket::new_v4()?;
    socket.set_recv_buffer_size(INSIDE_BUFFER)?;
    // Foxglove's server stops for good if it finds no descriptor for the other end of this connection. So there must be one more.
    drop(TcpSocket::new_v4()?);
    let stream = socket.connect(inside).await?;
    stream.set_nodelay(true)?;
    // The files of a vehicle may be long; only clients are limited.
    let config = WebSocketConfig::default().max_message_size(None).max_frame_size(None);
    let (inside, answer) = client_async_with_config(request, stream, Some(config)).await?;
    let chosen = answer.headers().get(SEC_WEBSOCKET_PROTOCOL);
    let chosen = chosen.and_then(|value| value.to_str().ok()).unwrap_or_default().to_owned();
    Ok((inside, chosen))
}

/// Passes messages on in both directions until one side ends, then tells the client why.
async fn relay(socket: WebSocket, inside: Inside, app: &App) {
    let (mut to_client, mut from_client) = socket.split();
    let (mut to_inside, mut from_inside) = inside.split();
    let (doubt, mut doubted) = mpsc::channel(1);
    let why = {
        let outward = outward(&mut from_inside, &mut to_client, &mut doubted, app);
        let inward = inward(&mut from_client, &mut to_inside, &doubt, app);
        tokio::select! {
            why = outward => why,
            why = inward => why,
        }
    };
    if let Some(why) = why {
        say_farewell(&mut to_client, why).await;
    }
    // An error means that Foxglove's server has ended this connection already.
    let _ = tokio::time::timeout(INSIDE_PATIENCE, to_inside.close()).await;
    if let Ok(socket) = from_client.reunite(to_client) {
        linger(socket).await;
    }
}

/// Passes the messages of Foxglove's server on to a client; returns the reason to close, or `None` if the client is gone.
async fn outward(
    from_inside: &mut (impl StreamExt<Item = Result<Message, Error>> + Unpin),
    to_client: &mut (impl SinkExt<Message> + Unpin),
    doubted: &mut mpsc::Receiver<()>,
    app: &App,
) -> Option<CloseReason> {
    let stalled = app.admission.limits.stalled;
    loop {
        let next = tokio::select! {
            next = from_inside.next() => next,
            Some(()) = doubted.recv() => Some(Ok(Message::Ping(Bytes::new()))),
        };
        let Some(Ok(first)) = next else { return Some(stops()) };
        let mut pending = Some(first);
        let mut ends = false;
        let sending = async {
            // All messages that wait are sent with one flush.
            while let Some(message) = pending.take() {
                if message.is_close() {
                    ends = true;
                    break;
                }
                if !message.is_pong() {
                    to_client.feed(message).await?;
                }
                pending = from_inside.next().now_or_never().flatten().and_then(Result::ok);
            }
            to_client.flush().await
        };
        match tokio::time::timeout(stalled, sending).await {
            Ok(Ok(())) if ends => return Some(stops()),
            Ok(Ok(())) => {}
            Ok(Err(_)) => return None,
            Err(_) => {
                let what =
                    format!("a Foxglove client took no data for {} s", stalled.as_secs_f64());
                app.admission.refusals.note(Refusal::Stalled, &what);
                return None;
            }
        }
    }
}

fn stops() -> CloseReason {
    CloseReason { code: code::GOING_AWAY, reason: "the server stops".to_owned() }
}

/// Passes the messages of a client on to Foxglove's server, as fast as its budget allows; returns the reason to close, or `None` if the
/// client is gone.
async fn inward(
    from_client: &mut (impl StreamExt<Item = Result<Message, Error>> + Unpin),
    to_inside: &mut (impl SinkExt<Message> + Unpin),
    doubt: &mpsc::Sender<()>,
    app: &App,
) -> Option<CloseReason> {
    let silent = app.admission.limits.silent;
    let refusals = &app.admission.refusals;
    let mut budget = Budget::new(now());
    let mut asked = false;
    loop {
        let message = match tokio::time::timeout(silent / 2, from_client.next()).await {
            Ok(Some(Ok(message))) => message,
            Ok(Some(Err(error))) => {
                let (why, refusal) = farewell(&error)?;
                refusals.note(refusal, &format_args!("a Foxglove client: {}", why.reason));
                return Some(why);
            }
            Ok(None) => return None,
            Err(_) if asked => {
                let reason = format!("no answer to a ping for {} s", (silent / 2).as_secs_f64());
                refusals.note(Refusal::Silent, &format_args!("a Foxglove client: {reason}"));
                return Some(CloseReason { code: code::POLICY, reason });
            }
            Err(_) => {
                asked = true;
                // A full channel means that a ping is under way already.
                let _ = doubt.try_send(());
                continue;
            }
        };
        asked = false;
        let all = app.admission.overall().debt(now());
        // A long message may set many gains.
        budget.charge((message.len() / GAIN_BYTES) as f64, now());
        match budget.frame(now(), all) {
            Pace::Go => {}
            Pace::Wait(wait) | Pace::Warn(wait) => tokio::time::sleep(wait).await,
            Pace::Close => {
                let reason = format!("more than {ONE_PER_S} messages per second");
                refusals.note(Refusal::Rate, &format_args!("a Foxglove client: {reason}"));
                return Some(CloseReason { code: code::POLICY, reason });
            }
        }
        match message {
            Message::Close(_) => {
                return Some(CloseReason { code: code::NORMAL, reason: "bye".to_owned() });
            }
            Message::Text(_) | Message::Binary(_) => to_inside.send(message).await.ok()?,
            _ => {}
        }
    }
}
