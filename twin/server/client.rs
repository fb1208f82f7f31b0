//! One connection of `/ws`: a task that reads and a task that writes, joined by the client's outbox.

use std::sync::Arc;
use std::sync::mpsc::TrySendError;
use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message as Frame, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};

use crate::server::App;
use crate::server::command::{self, Request};
use crate::server::hub::{Client, json};
use crate::server::outbox::{Farewell, Message};
use crate::server::protocol::{ClientMessage, NoticeLevel, ServerMessage};
use crate::server::rate::{Admission, Bucket, MESSAGES_PER_S};

/// Longest message a client may send, bytes.
pub(super) const LONGEST_MESSAGE: usize = 64 * 1024;

/// A client that takes nothing for this long is gone.
const SEND_TIMEOUT: Duration = Duration::from_secs(20);

/// A connection that is to be closed may go on for this long to take its reason.
const LINGER: Duration = Duration::from_secs(2);

/// Frames are at least this far apart; ticks that fall between share one.
const FRAME_GAP: Duration = Duration::from_millis(5);

/// Most of a parser's sentence that a notice repeats, characters.
const SHOWN_CHARACTERS: usize = 300;

/// Serves one connection until it ends.
pub(super) async fn serve(socket: WebSocket, app: Arc<App>) {
    let (mut sink, mut stream) = socket.split();
    let Some(client) = app.hub.join() else {
        let farewell = Farewell {
            code: 1013,
            reason: "too many clients; close another console and try again".to_owned(),
        };
        say_farewell(&mut sink, farewell).await;
        return;
    };
    let mut writer = tokio::spawn(write(sink, Arc::clone(&client), Arc::clone(&app)));
    tokio::select! {
        () = read(&mut stream, &client, &app) => {
            client.close(1000, "bye");
            // Closing with unread input resets the connection, and the other side would never see the reason.
            let drained = async { while let Some(Ok(_)) = stream.next().await {} };
            let _ = tokio::time::timeout(LINGER, async { tokio::join!(&mut writer, drained) }).await;
        }
        _ = &mut writer => {}
    }
    writer.abort();
    app.hub.leave(client.id);
}

async fn write(mut sink: SplitSink<WebSocket, Frame>, client: Arc<Client>, app: Arc<App>) {
    loop {
        client.wake.notified().await;
        let parcel = client.outbox().take();
        for message in parcel.messages {
            let text = match message {
                Message::Json(text) => text,
                Message::Hello(published) => json(&published.hello(client.id)),
            };
            if !send(&mut sink, Frame::text(text.to_string())).await {
                return;
            }
        }
        if let Some(telemetry) = parcel.telemetry {
            let bytes = telemetry.encode(app.uptime_s());
            if !send(&mut sink, Frame::binary(bytes)).await {
                return;
            }
        }
        if let Some(farewell) = parcel.farewell {
            say_farewell(&mut sink, farewell).await;
            return;
        }
        tokio::time::sleep(FRAME_GAP).await;
    }
}

async fn send(sink: &mut SplitSink<WebSocket, Frame>, frame: Frame) -> bool {
    matches!(tokio::time::timeout(SEND_TIMEOUT, sink.send(frame)).await, Ok(Ok(())))
}

async fn say_farewell(sink: &mut SplitSink<WebSocket, Frame>, farewell: Farewell) {
    let frame = CloseFrame { code: farewell.code, reason: farewell.reason.into() };
    // The other side may be gone already; there is nobody left to tell.
    let _ =
        tokio::time::timeout(Duration::from_secs(1), sink.send(Frame::Close(Some(frame)))).await;
}

async fn read(stream: &mut SplitStream<WebSocket>, client: &Client, app: &App) {
    let mut bucket = Bucket::new(app.uptime_s());
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
        match bucket.admit(app.uptime_s()) {
            Admission::Handle => {}
            Admission::Drop => continue,
            Admission::Warn => {
                let text = format!(
                    "more than {MESSAGES_PER_S} messages per second; the rest is ignored, slow down"
                );
                client.notice(NoticeLevel::Warning, text);
                continue;
            }
            Admission::Close => {
                client.close(
                    1008,
                    format!("more than {MESSAGES_PER_S} messages per second in spite of a warning"),
                );
                return;
            }
        }
        match frame {
            Frame::Text(text) => handle(text.as_str(), client, app),
            Frame::Binary(_) => client
                .notice(NoticeLevel::Warning, "binary messages mean nothing here; send JSON text"),
            Frame::Close(_) => return,
            Frame::Ping(_) | Frame::Pong(_) => {}
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
        client.say(&ServerMessage::Pong { t, t_s: app.hub.simulated_s() });
        return;
    }
    match command::check(message, &app.scenarios, &app.tuning) {
        Ok(Some(command)) => {
            if let Err(why) = app.ask(Request { client: Some(client.id), command }) {
                client.notice(NoticeLevel::Error, why);
            }
        }
        Ok(None) => {}
        Err(error) => client.notice(NoticeLevel::Warning, error.to_string()),
    }
}

/// The start of a sentence, at most so many characters.
fn shown(text: &str, characters: usize) -> String {
    text.chars().take(characters).collect()
}

impl App {
    /// Hands a request to the flight without waiting.
    ///
    /// # Errors
    /// A sentence for the operator if the flight takes no requests.
    pub(super) fn ask(&self, request: Request) -> Result<(), &'static str> {
        self.requests.try_send(request).map_err(|error| match error {
            TrySendError::Full(_) => "the flight is busy; nothing was changed, try again",
            TrySendError::Disconnected(_) => "the flight has stopped; start the server again",
        })
    }
}
