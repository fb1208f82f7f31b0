//! One connection: a task that reads and a task that writes; the client's outbox joins them. A [`Dialect`] encodes and decodes
//! the messages: the console's dialect stands here, those of the stock viewers in [`crate::server::viewers`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::Notify;
use tokio_tungstenite::tungstenite::Bytes;
pub(super) use tokio_tungstenite::tungstenite::Message as Frame;

use crate::server::App;
use crate::server::admission::refusals::Refusal;
use crate::server::hub::Client;
use crate::server::outbox::{CloseReason, Message, OutboxContent, SharedMessage};
use crate::server::protocol::{ClientMessage, NoticeLevel, ServerMessage};
use crate::server::socket::{LINGER, Upgrade, WebSocket, code, linger, say_farewell, try_later};

/// Most rows in a frame. A connection never frees the memory that its largest frame took, so frames are kept small.
const PART_ROWS: usize = 128;

/// The least time between two batches to a page. No screen shows 200 pictures per second, so several ticks may share a batch.
const GAP: Duration = Duration::from_millis(5);

/// With more than fifty clients the least time between two batches is this time for each of them, so that all clients together
/// get no more batches per second than fifty clients do.
const SHARE: Duration = Duration::from_micros(100);

/// Content of a ping that asks whether the client is alive. The ping that follows a batch is empty.
const ALIVE: &[u8] = b"alive";

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
    /// A browser names the page that opens the socket; a program names none.
    pub(super) fn of(upgrade: &Upgrade) -> Self {
        if upgrade.visitor.origin.is_some() { Self::Page } else { Self::Program }
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
            _ => {
                refuse_data(code::UNSUPPORTED, "a binary message, expected JSON text", client, app);
            }
        }
    }
}

/// Closes the connection of a client whose message is not of the type that is understood here.
pub(super) fn refuse_data(code: u16, what: &str, client: &Client, app: &App) {
    app.admission.refusals.note(Refusal::Data, &format_args!("client {}: {what}", client.id));
    client.close(code, format!("message not understood: {what}"));
}

/// A notice quotes at most this many characters of a parser's error.
const SHOWN_CHARACTERS: usize = 300;

/// Tells whether the client has received the last batch: a ping follows the batch, and the client answers it with a pong.
#[derive(Default)]
struct Acknowledged {
    awaited: AtomicBool,
    arrived: Notify,
    /// The client was silent, and is to be asked whether it is alive.
    doubted: AtomicBool,
}

/// Accepts the socket of a client that speaks `dialect`, if a place is free.
pub(super) fn connect(upgrade: Upgrade, app: Arc<App>, dialect: impl Dialect) -> Response {
    let taker = ReceiverKind::of(&upgrade);
    match app.admission.places.take(upgrade.visitor.clone()) {
        Ok(place) => upgrade.accept(async move |socket| {
            serve(socket, app, dialect, taker).await;
            drop(place);
        }),
        Err(refusal) => {
            let address = upgrade.visitor.address;
            app.admission.refusals.note(refusal, &format_args!("{address}: too many clients"));
            try_later(upgrade)
        }
    }
}

/// Serves one connection until it ends.
async fn serve<D: Dialect>(socket: WebSocket, app: Arc<App>, dialect: D, taker: ReceiverKind) {
    let (sink, mut stream) = socket.split();
    let client = app.hub.join();
    let shared = Arc::new((dialect, Acknowledged::default()));
    let writing = write(sink, Arc::clone(&client), Arc::clone(&app), Arc::clone(&shared), taker);
    let mut writer = tokio::spawn(writing);
    let sink = tokio::select! {
        () = read(&mut stream, &client, &app, &shared) => {
            client.close(code::NORMAL, "bye");
            shared.1.arrived.notify_one();
            tokio::time::timeout(LINGER, &mut writer).await.ok()
        }
        sink = &mut writer => Some(sink),
    };
    app.hub.leave(client.id);
    match sink {
        Some(Ok(sink)) => {
            if let Ok(socket) = stream.reunite(sink) {
                linger(socket).await;
            }
        }
        // The client takes no data, so it would not take the reason either.
        _ => writer.abort(),
    }
}

/// Sends the content of the outbox until the connection closes; returns the sink for the end of the connection.
async fn write<D: Dialect>(
    mut sink: SplitSink<WebSocket, Frame>,
    client: Arc<Client>,
    app: Arc<App>,
    shared: Arc<(D, Acknowledged)>,
    taker: ReceiverKind,
) -> SplitSink<WebSocket, Frame> {
    let (dialect, acknowledged) = &*shared;
    let stalled = app.admission.limits.stalled;
    loop {
        client.wake.notified().await;
        if acknowledged.doubted.swap(false, Ordering::Relaxed)
            && !send(&mut sink, vec![Frame::Ping(Bytes::from_static(ALIVE))], &client, &app).await
        {
            return sink;
        }
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
            if !frames.is_empty() && !send(&mut sink, frames, &client, &app).await {
                return sink;
            }
        }
        if let Some(farewell) = farewell {
            say_farewell(&mut sink, farewell).await;
            return sink;
        }
        if asked && !acknowledged.wait(stalled).await {
            app.note_stalled(&client);
            let reason = format!("a batch was not read for {} s", stalled.as_secs_f64());
            say_farewell(&mut sink, CloseReason { code: code::POLICY, reason }).await;
            return sink;
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

    /// Waits for the pong; returns `false` if none arrives within `stalled`.
    async fn wait(&self, stalled: Duration) -> bool {
        tokio::time::timeout(stalled, self.arrived.notified()).await.is_ok()
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

/// Sends frames with one flush, because each flush is a system call and a viewer gets many frames per tick. Returns `false` if the client
/// is gone, or has not taken them in time.
async fn send(
    sink: &mut SplitSink<WebSocket, Frame>,
    frames: Vec<Frame>,
    client: &Client,
    app: &App,
) -> bool {
    let sending = async {
        for frame in frames {
            sink.feed(frame).await?;
        }
        sink.flush().await
    };
    let sent = tokio::time::timeout(app.admission.limits.stalled, sending).await;
    if sent.is_err() {
        app.note_stalled(client);
    }
    matches!(sent, Ok(Ok(())))
}

/// Reads until the connection ends; a client that is silent is asked whether it is alive.
async fn read<D: Dialect>(
    stream: &mut SplitStream<WebSocket>,
    client: &Client,
    app: &App,
    (dialect, acknowledged): &(D, Acknowledged),
) {
    let silent = app.admission.limits.silent;
    let mut asked = false;
    loop {
        let frame = match tokio::time::timeout(silent / 2, stream.next()).await {
            Ok(Some(Ok(frame))) => frame,
            Ok(None) => return,
            Ok(Some(Err(error))) => return app.dismiss(&error, client),
            Err(_) if asked => {
                let reason = format!("no answer to a ping for {} s", (silent / 2).as_secs_f64());
                app.admission
                    .refusals
                    .note(Refusal::Silent, &format_args!("client {}: {reason}", client.id));
                return client.close(code::POLICY, reason);
            }
            Err(_) => {
                asked = true;
                acknowledged.doubted.store(true, Ordering::Relaxed);
                client.wake.notify_one();
                continue;
            }
        };
        asked = false;
        match frame {
            Frame::Pong(content) if content.is_empty() && acknowledged.note() => {}
            Frame::Close(_) => return,
            _ if !app.paced(client).await => return,
            Frame::Ping(_) | Frame::Pong(_) => {}
            frame => dialect.hear(&frame, client, app),
        }
        // The writing task may wait for an answer to its last batch; the end of this task wakes it.
        if client.outbox().is_closing() {
            return;
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_paced_a_program_paces_itself_and_a_crowd_shares() {
        let ms = Duration::from_millis;
        let (page, program) = (ReceiverKind::Page, ReceiverKind::Program);
        assert_eq!(
            [page.gap(true, 1), program.gap(true, 1), program.gap(true, 50)],
            [ms(5), ms(0), ms(0)]
        );
        // The console's rows collect in the outbox and are sent together, so the wait loses none.
        assert_eq!(program.gap(false, 1), ms(5));
        assert_eq!([page, program].map(|taker| taker.gap(true, 200)), [ms(20); 2]);
    }
}
