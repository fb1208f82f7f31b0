//! A WebSocket server for Foxglove beside the console, on its own port.
//!
//! In: the messages and rows that the hub gives to every client; this server is one of the hub's clients. Out: the topics of a
//! recording (`/tf`, `/scene`, `/joint_states`, `/log`), the telemetry row as JSON (`/twin/telemetry`), simulated time, the
//! gains as parameters, the timeline of a mirrored recording ([`playback`]), and the vehicle's files ([`assets`]). A parameter
//! passes the same check and the same queue as a gain of the console. The flight never waits for this server: the server reads
//! from its own bounded outbox, and each Foxglove client has a bounded backlog that drops its oldest messages.
//!
//! Clients reach Foxglove's own server through [`front`], which decides who may connect, as the console does.

mod assets;
mod topics;
mod parameters;
mod playback;
mod front;

use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use foxglove::websocket::{
    Capability, ChannelView, Parameter, PlaybackControlRequest, PlaybackState, ServerListener,
    Status,
};
use foxglove::{Context, WebSocketServer, WebSocketServerHandle};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;

use crate::server::foxglove::assets::Assets;
use crate::server::foxglove::parameters::{Gains, parameters};
use crate::server::foxglove::playback::{PlaybackFilter, PlaybackRequests};
use crate::server::foxglove::topics::{Topics, nanoseconds};
use crate::server::hub::Client;
use crate::server::listen::Beside;
use crate::server::outbox::{Message, OutboxContent};
use crate::server::protocol::ServerMessage;
use crate::server::telemetry::Telemetry;
use crate::server::{App, accept, listen};

/// The least time between two batches.
const GAP: Duration = Duration::from_millis(5);

/// Most messages that wait for one Foxglove client: about two seconds of all topics.
const BACKLOG: usize = 1024;

/// Identifier of the one status line, so that a new refusal replaces the last.
const STATUS: &str = "twin";

/// Clients get this long to receive the last messages when the server stops.
const CLOSING: Duration = Duration::from_millis(500);

/// Takes the calls of Foxglove's own threads.
struct Listener {
    bridge: Arc<Client>,
    /// A client has subscribed, and the bodies that do not move have not been sent to it.
    waiting: AtomicBool,
    playback: Option<Arc<PlaybackRequests>>,
}

impl ServerListener for Listener {
    fn on_subscribe(&self, _: foxglove::websocket::Client, _: ChannelView) {
        self.waiting.store(true, Ordering::Relaxed);
        self.bridge.wake.notify_one();
    }

    fn on_playback_control_request(
        &self,
        request: PlaybackControlRequest,
    ) -> Option<PlaybackState> {
        self.playback.as_ref().map(|playback| playback.obey(&request))
    }
}

/// Listens on the port of `beside`; returns the address and the server's task, which ends when the hub closes all clients.
///
/// # Errors
/// A sentence if the server cannot listen on the port.
pub(super) async fn start(
    host: IpAddr,
    Beside { port, origins, vehicles, recorded_joints }: Beside,
    app: Arc<App>,
    stopped: watch::Receiver<bool>,
) -> Result<(SocketAddr, JoinHandle<()>), String> {
    let listener = listen::bind(SocketAddr::new(host, port)).map_err(|error| error.to_string())?;
    let address = listener.local_addr().map_err(|error| error.to_string())?;
    let bridge = app.hub.join();
    let playback = PlaybackRequests::new(&app, &bridge).map(Arc::new);
    let hearer = Arc::new(Listener {
        bridge: Arc::clone(&bridge),
        waiting: AtomicBool::new(false),
        playback: playback.clone(),
    });
    let vehicles = Arc::new(vehicles);
    let context = Context::new();
    let assets = Assets::new(Arc::clone(&app.hub), Arc::clone(&vehicles));
    let mut server = WebSocketServer::new()
        .name("twin")
        .context(&context)
        .capabilities([Capability::Time])
        .message_backlog_size(BACKLOG)
        .listener(Arc::clone(&hearer) as Arc<dyn ServerListener>)
        .fetch_asset_handler_blocking_fn(move |_, address: String| assets.read(&address))
        .parameter_handler(Arc::new(Gains::new(Arc::clone(&app), Arc::clone(&bridge))));
    if let Some(playback) = &playback {
        let (start, end) = playback.range();
        server = server.playback_time_range(start, end);
    }
    let inside = front::inside_host().await;
    let server = server.bind(inside.to_string(), 0).start().await.map_err(|error| {
        app.hub.leave(bridge.id);
        error.to_string()
    })?;
    let inside = SocketAddr::new(inside, server.port());
    let (open, closed) = mpsc::channel(1);
    let front = front::routes(Arc::clone(&app), inside, origins, open);
    tokio::spawn(accept::serve(listener, front, Arc::clone(&app.admission), stopped));
    let film = playback.map(PlaybackFilter::new);
    let topics = Topics::new(&context, vehicles, recorded_joints);
    let publisher = Publisher { server, topics, film, closed };
    Ok((address, tokio::spawn(publisher.run(hearer, app))))
}

/// Passes on to Foxglove's clients what the hub gives to its clients.
struct Publisher {
    server: WebSocketServerHandle,
    topics: Topics,
    film: Option<PlaybackFilter>,
    /// Ends when no client is connected.
    closed: mpsc::Receiver<()>,
}

impl Publisher {
    /// Publishes the content of the outbox until the hub closes the outbox.
    async fn run(mut self, listener: Arc<Listener>, app: Arc<App>) {
        let bridge = &listener.bridge;
        loop {
            bridge.wake.notified().await;
            let mut parcel = bridge.outbox().take();
            let ends = parcel.farewell.take().is_some();
            self.tell(parcel);
            if listener.waiting.swap(false, Ordering::Relaxed) {
                self.topics.repeat();
            }
            if ends {
                break;
            }
            tokio::time::sleep(GAP).await;
        }
        app.hub.leave(bridge.id);
        // Clients that do not receive the end in time lose their connection when the runtime stops.
        let told = async {
            self.server.stop().wait().await;
            while self.closed.recv().await.is_some() {}
        };
        let _ = tokio::time::timeout(CLOSING, told).await;
    }

    fn tell(&mut self, parcel: OutboxContent) {
        for message in parcel.messages {
            match message {
                Message::Hello(published) => {
                    self.topics.begin(&published);
                    self.server.publish_parameter_values(parameters(&published.gains));
                }
                Message::Shared(told) => self.pass_on(&told.message),
            }
        }
        let telemetry = match (&mut self.film, parcel.telemetry) {
            (Some(film), Some(telemetry)) => film.cut(telemetry),
            (_, telemetry) => telemetry,
        };
        self.publish(telemetry);
    }

    fn pass_on(&mut self, message: &ServerMessage) {
        match message {
            ServerMessage::Gain(echo) => {
                let gain = Parameter::float64(&echo.name, echo.value);
                self.server.publish_parameter_values(vec![gain]);
            }
            ServerMessage::Gains(list) => {
                self.server.publish_parameter_values(parameters(&list.gains));
            }
            ServerMessage::Events { events } => {
                if !self.film.as_ref().is_some_and(PlaybackFilter::is_under_way) {
                    self.topics.log(events);
                }
            }
            ServerMessage::Notice(notice) => {
                self.server.publish_status(Status::warning(&notice.text).with_id(STATUS));
            }
            ServerMessage::Reset {} => match &mut self.film {
                Some(film) => film.reset(),
                // The time of a new flight starts at zero again; a new session makes clients forget the old messages.
                None => self.server.clear_session(None),
            },
            ServerMessage::State(state) => {
                if let Some(film) = &mut self.film {
                    let (news, reached) = film.follow(state);
                    if let Some(news) = news {
                        self.server.broadcast_playback_state(news);
                    }
                    self.publish(reached);
                }
            }
            ServerMessage::Hello(_) | ServerMessage::Forks { .. } | ServerMessage::Pong { .. } => {}
        }
    }

    fn publish(&mut self, telemetry: Option<Telemetry>) {
        if let Some(telemetry) = telemetry {
            self.server.broadcast_time(nanoseconds(telemetry.picture.t_s));
            self.topics.publish(&telemetry);
        }
    }
}
