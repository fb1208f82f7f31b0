//! One connection: a task that reads and a task that writes; the client's outbox joins them. A [`Dialect`] encodes and decodes
//! the messages: the console's dialect stands here, those of the stock viewers in [`crate::server::viewers`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::TrySendError;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message as Frame, WebSocket, WebSocketUpgrade};
use axum::http::HeaderMap;
use axum::http::header::ORIGIN;
use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::Notify;

use crate::server::App;
use crate::server::command::{self, Request};
use crate::server::hub::Client;
use crate::server::mirrored;
use crate::server::outbox::{CloseReason, Message, OutboxContent, SharedMessage};
use crate::server::protocol::{ClientMessage, NoticeLevel, ServerMessage};
use crate::server::rate::{Admission, MESSAGES_PER_S, TokenBucket};

/// Longest message a client may send, bytes.
pub(super) const LONGEST_MESSAGE: usize = 64 * 1024;

/// Size of each connection's read buffer, bytes. It is small because clients send short messages.
const READ_BUFFER: usize = 8 * 1024;

/// Most rows in a frame. A connection never frees the memory that its largest frame took, so frames are kept small.
const PART_ROWS: usize = 128;

/// The least time between two batches to a page. No screen shows 200 pictures per second, so several ticks may share a batch.
const GAP: Duration = Duration::from_millis(5);

/// With more than fifty clients the least time between two batches is this time for each of them, so that all clients together
/// get no more batches per second than fifty clients do.
const SHARE: Duration = Duration::from_micros(100);

/// The server closes a connection whose client accepts no data for this long.
const SEND_TIMEOUT: Duration = Duration::from_secs(20);

/// The server waits this long for a client to receive the reason why its connection closes.
const LINGER: Duration = Duration::from_secs(2);

/// The protocol of one kind of client; the reading and the writing task share it.
pub(super) trait Dialect: Send + Sync + 'static {
    /// Whether the next batch waits until the client has received the last one.
    const ONE_IN_FLIGHT: bool;

    /// Encodes the content of the outbox as frames; `now_s` is the server's uptime, s.
    fn compose(&self, parcel: OutboxContent, client: &Client, now_s: f64) -> Vec<Frame>;

    /// Handles one frame of the client; the caller has handled control frames already.
    fn hear(&self, frame: &Frame, client: &Client, app: &App);
}

/// The receiver at the other end of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ReceiverKind {
    /// A page in a browser, which draws at most as often as its screen shows pictures.
    Page,
    /// A program, which may want every tick and gets the next batch as soon as it has read the last one.
    Program,
}

impl ReceiverKind {
    /// A browser sends the header `Origin` with the page that opens the socket; a program sends none.
    pub(super) fn of(headers: &HeaderMap) -> Self {
        if headers.contains_key(ORIGIN) { Self::Page } else { Self::Program }
    }

    /// The least time between two batches while `clients` clients are connected. A program that `answers` each batch sets the pace
    /// by its answers.
    fn gap(self, answers: bool, clients: u32) -> Duration {
        let least = if self == Self::Program && answers { Duration::ZERO } else { GAP };
        let share = SHARE * clients;
        if share > GAP { share } else { least }
    }
}

/// The browser console: JSON both ways and binary telemetry.
pub(super) struct Console;

impl Dialect for Console {
    const ONE_IN_FLIGHT: bool = false;

    fn compose(&self, parcel: OutboxContent, client: &Client, now_s: f64) -> Vec<Frame> {
        let texts = parcel.messages.into_iter().map(|message| match message {
            Message::Shared(told) => Frame::text(told.text.clone()),
            Message::Hello(published) => {
                Frame::text(SharedMessage::from(published.hello(client.id)).text)
            }
        });
        let rows = parcel.telemetry.map(|telemetry| Frame::binary(telemetry.encode(now_s)));
        texts.chain(rows).collect()
    }

    fn hear(&self, frame: &Frame, client: &Client, app: &App) {
        match frame {
            Frame::Text(text) => handle(text.as_str(), client, app),
            _ => client.notice(
                NoticeLevel::Warning,
                "binary messages are not understood here; send JSON text",
            ),
        }
    }
}

/// A notice quotes at most this many characters of a parser's error.
const SHOWN_CHARACTERS: usize = 300;

/// Tells whether the client has received the last batch: a ping follows the batch, and the client answers it with a pong.
#[derive(Default)]
struct Acknowledged {
    awaited: AtomicBool,
    arrived: Notify,
}

/// Accepts the socket of a client that speaks `dialect`.
pub(super) fn connect(
    upgrade: WebSocketUpgrade,
    headers: &HeaderMap,
    app: Arc<App>,
    dialect: impl Dialect,
) -> Response {
    let taker = ReceiverKind::of(headers);
    upgrade
        .read_buffer_size(READ_BUFFER)
        .max_message_size(LONGEST_MESSAGE)
        .max_frame_size(LONGEST_MESSAGE)
        .on_upgrade(move |socket| serve(socket, app, dialect, taker))
}

/// Serves one connection until it ends.
pub(super) async fn serve<D: Dialect>(
    socket: WebSocket,
    app: Arc<App>,
    dialect: D,
    taker: ReceiverKind,
) {
    let (mut sink, mut stream) = socket.split();
    let Some(client) = app.hub.join() else {
        let farewell = CloseReason {
            code: 1013,
            reason: "too many clients; close another console and try again".to_owned(),
        };
        say_farewell(&mut sink, farewell).await;
        return;
    };
    let shared = Arc::new((dialect, Acknowledged::default()));
    let writing = write(sink, Arc::clone(&client), Arc::clone(&app), Arc::clone(&shared), taker);
    let mut writer = tokio::spawn(writing);
    tokio::select! {
        () = read(&mut stream, &client, &app, &shared) => {
            client.close(1000, "bye");
            shared.1.arrived.notify_one();
            // Closing a socket with unread input resets the connection, and the client would never see the reason.
            let drained = async { while let Some(Ok(_)) = stream.next().await {} };
            let _ = tokio::time::timeout(LINGER, async { tokio::join!(&mut writer, drained) }).await;
        }
        _ = &mut writer => {}
    }
    writer.abort();
    app.hub.leave(client.id);
}

async fn write<D: Dialect>(
    mut sink: SplitSink<WebSocket, Frame>,
    client: Arc<Client>,
    app: Arc<App>,
    shared: Arc<(D, Acknowledged)>,
    taker: ReceiverKind,
) {
    let (dialect, acknowledged) = &*shared;
    loop {
        client.wake.notified().await;
        let mut parcel = client.outbox().take();
        let farewell = parcel.farewell.take();
        let mut asked = false;
        let mut parts = parcel.parts(PART_ROWS).peekable();
        while let Some(part) = parts.next() {
            let mut frames = dialect.compose(part, &client, app.uptime_s());
            asked = D::ONE_IN_FLIGHT && parts.peek().is_none() && !frames.is_empty();
            if asked {
                frames.push(acknowledged.ask());
            }
            if !frames.is_empty() && !send(&mut sink, frames).await {
                return;
            }
        }
        if let Some(farewell) = farewell {
            say_farewell(&mut sink, farewell).await;
            return;
        }
        if asked && !acknowledged.wait(&mut sink).await {
            return;
        }
        let gap = taker.gap(D::ONE_IN_FLIGHT, app.hub.crowd());
        if !gap.is_zero() {
            tokio::time::sleep(gap).await;
        }
    }
}

impl Acknowledged {
    /// The ping that is sent together with a batch, as its last frame.
    fn ask(&self) -> Frame {
        self.awaited.store(true, Ordering::Relaxed);
        Frame::Ping(Bytes::new())
    }

    /// Waits for the pong; returns `false` after closing the connection if none arrives in time.
    async fn wait(&self, sink: &mut SplitSink<WebSocket, Frame>) -> bool {
        if tokio::time::timeout(SEND_TIMEOUT, self.arrived.notified()).await.is_ok() {
            return true;
        }
        let reason = format!("no answer for {} s", SEND_TIMEOUT.as_secs());
        say_farewell(sink, CloseReason { code: 1001, reason }).await;
        false
    }

    /// Notes a pong; returns `false` if no batch waits for one.
    fn note(&self) -> bool {
        let awaited = self.awaited.swap(false, Ordering::Relaxed);
        if awaited {
            self.arrived.notify_one();
        }
        awaited
    }
}

/// Sends frames with one flush, because each flush is a system call and a viewer gets many frames per tick.
async fn send(sink: &mut SplitSink<WebSocket, Frame>, frames: Vec<Frame>) -> bool {
    let sending = async {
        for frame in frames {
            sink.feed(frame).await?;
        }
        sink.flush().await
    };
    matches!(tokio::time::timeout(SEND_TIMEOUT, sending).await, Ok(Ok(())))
}

async fn say_farewell(sink: &mut SplitSink<WebSocket, Frame>, farewell: CloseReason) {
    let frame = CloseFrame { code: farewell.code, reason: farewell.reason.into() };
    // An error means that the client is gone already, so nobody is left to tell.
    let _ =
        tokio::time::timeout(Duration::from_secs(1), sink.send(Frame::Close(Some(frame)))).await;
}

async fn read<D: Dialect>(
    stream: &mut SplitStream<WebSocket>,
    client: &Client,
    app: &App,
    (dialect, acknowledged): &(D, Acknowledged),
) {
    let mut bucket = TokenBucket::new(app.uptime_s());
    while let Some(frame) = stream.next().await {
        let frame = match frame {
            Ok(frame) => frame,
            Err(error) => {
                let limit = LONGEST_MESSAGE / 1024;
                client.close(
                    1009,
                    format!(
                        "unreadable or longer than {limit} KiB: {}",
                        shown(&error.to_string(), 60)
                    ),
                );
                return;
            }
        };
        if matches!(frame, Frame::Pong(_)) && acknowledged.note() {
            continue;
        }
        match admit(&mut bucket, client, app) {
            Admission::Handle => {}
            Admission::Close => return,
            Admission::Warn | Admission::Drop => continue,
        }
        match frame {
            Frame::Close(_) => return,
            Frame::Ping(_) | Frame::Pong(_) => {}
            frame => dialect.hear(&frame, client, app),
        }
    }
}

/// Decides whether to handle a message that arrives now; tells the client if it sends too many.
fn admit(bucket: &mut TokenBucket, client: &Client, app: &App) -> Admission {
    let admission = bucket.admit(app.uptime_s());
    match admission {
        Admission::Handle | Admission::Drop => {}
        Admission::Warn => client.notice(
            NoticeLevel::Warning,
            format!(
                "more than {MESSAGES_PER_S} messages per second; the rest is ignored, slow down"
            ),
        ),
        Admission::Close => client.close(
            1008,
            format!("more than {MESSAGES_PER_S} messages per second in spite of a warning"),
        ),
    }
    admission
}

fn handle(text: &str, client: &Client, app: &App) {
    let message: ClientMessage = match serde_json::from_str(text) {
        Ok(message) => message,
        Err(error) => {
            let why = shown(&error.to_string(), SHOWN_CHARACTERS);
            client.notice(NoticeLevel::Warning, format!("message not understood: {why}"));
            return;
        }
    };
    if let ClientMessage::Ping { t } = message {
        client.say(ServerMessage::Pong { t, t_s: app.hub.simulated_s() });
        return;
    }
    app.obey(message, client);
}

/// The first `characters` characters of `text`, or all of it if it is shorter.
pub(super) fn shown(text: &str, characters: usize) -> String {
    text.chars().take(characters).collect()
}

impl App {
    /// Checks a request of a client and hands it to the flight; tells the client if the request is refused.
    pub(super) fn obey(&self, message: ClientMessage, client: &Client) {
        if let Some(why) = mirrored::refusal(&message, self.mirrored) {
            return client.notice(NoticeLevel::Warning, why);
        }
        match command::check(message, &self.scenarios, &self.tuning) {
            Ok(Some(command)) => {
                if let Err(why) = self.ask(Request { client: Some(client.id), command }) {
                    client.notice(NoticeLevel::Error, why);
                }
            }
            Ok(None) => {}
            Err(error) => client.notice(NoticeLevel::Warning, error.to_string()),
        }
    }

    /// Hands a request to the flight without waiting.
    ///
    /// # Errors
    /// A sentence for the operator if the queue of requests is full or the flight has stopped.
    pub(super) fn ask(&self, request: Request) -> Result<(), &'static str> {
        self.requests.try_send(request).map_err(|error| match error {
            TrySendError::Full(_) => "the flight is busy; nothing was changed, try again",
            TrySendError::Disconnected(_) => "the flight has stopped; start the server again",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_paced_a_program_paces_itself_and_a_crowd_shares() {
        let (ms, page) =
            (Duration::from_millis, HeaderMap::from_iter([(ORIGIN, "http://x".parse().unwrap())]));
        let (page, program) = (ReceiverKind::of(&page), ReceiverKind::of(&HeaderMap::new()));
        assert_eq!(
            [page.gap(true, 1), program.gap(true, 1), program.gap(true, 50)],
            [ms(5), ms(0), ms(0)]
        );
        // The console's rows collect in the outbox and are sent together, so the wait loses none.
        assert_eq!(program.gap(false, 1), ms(5));
        assert_eq!([page, program].map(|taker| taker.gap(true, 200)), [ms(20); 2]);
    }
}
