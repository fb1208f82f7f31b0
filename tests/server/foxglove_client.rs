//! A client for tests: JSON by hand, binary messages by the codec of Foxglove's own crate.

use std::collections::VecDeque;
use std::net::{SocketAddr, TcpStream};

use foxglove::Decode;
use foxglove::messages::FrameTransforms;
use foxglove::ws_protocol::BinaryMessage;
use foxglove::ws_protocol::server::fetch_asset_response::Payload;
use foxglove::ws_protocol::server::{PlaybackState, ServerMessage};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use crate::patience::{PATIENCE, Patience};

/// A message that arrives: JSON, or the data of a subscription.
pub(super) enum Said {
    Json(Value),
    Data { subscription: u32, log_time_ns: u64, payload: Vec<u8> },
    Other(Box<ServerMessage<'static>>),
}

pub(super) struct Foxglove {
    pub socket: WebSocket<TcpStream>,
    pub advertised: Vec<Value>,
    /// Telemetry rows that arrived during a wait for a state of playback; the order of the two is not defined.
    held: VecDeque<Said>,
}

impl Foxglove {
    pub(super) fn connect(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).expect("the server listens");
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut request = format!("ws://{address}").into_client_request().unwrap();
        let protocol = "foxglove.sdk.v1".parse().unwrap();
        request.headers_mut().insert("Sec-WebSocket-Protocol", protocol);
        let (socket, _) = tungstenite::client(request, stream).expect("a connection");
        Self { socket, advertised: Vec::new(), held: VecDeque::new() }
    }

    pub(super) fn send(&mut self, message: &Value) {
        self.socket.send(Message::text(message.to_string())).expect("the server reads");
    }

    pub(super) fn next(&mut self) -> Said {
        loop {
            match self.socket.read().expect("the connection stays open") {
                Message::Text(text) => {
                    let said: Value = serde_json::from_str(&text).expect("JSON");
                    if said["op"] == "advertise" {
                        self.advertised.extend(said["channels"].as_array().unwrap().clone());
                    }
                    return Said::Json(said);
                }
                Message::Binary(bytes) => {
                    let said = ServerMessage::parse_binary(&bytes).expect("a known opcode");
                    return match said.into_owned() {
                        ServerMessage::MessageData(data) => Said::Data {
                            subscription: data.subscription_id,
                            log_time_ns: data.log_time,
                            payload: data.data.into_owned(),
                        },
                        other => Said::Other(Box::new(other)),
                    };
                }
                _ => {}
            }
        }
    }

    pub(super) fn json(&mut self, fits: impl Fn(&Value) -> bool) -> Value {
        let patience = Patience::new();
        while patience.lasts() {
            match self.next() {
                Said::Json(said) if fits(&said) => return said,
                _ => {}
            }
        }
        panic!("not within {PATIENCE:?}");
    }

    pub(super) fn op(&mut self, op: &str) -> Value {
        self.json(|said| said["op"] == op)
    }

    /// Subscribes to a topic once it is advertised.
    pub(super) fn subscribe(&mut self, topic: &str, id: u32) {
        let channel = loop {
            let known = self.advertised.iter().find(|channel| channel["topic"] == topic);
            if let Some(channel) = known {
                break channel["id"].clone();
            }
            self.next();
        };
        let subscription = json!({ "id": id, "channelId": channel });
        self.send(&json!({ "op": "subscribe", "subscriptions": [subscription] }));
    }

    pub(super) fn data(&mut self, wanted: u32) -> (u64, Vec<u8>) {
        loop {
            let said = self.held.pop_front().unwrap_or_else(|| self.next());
            if let Said::Data { subscription, log_time_ns, payload } = said
                && subscription == wanted
            {
                return (log_time_ns, payload);
            }
        }
    }

    pub(super) fn transforms(&mut self, subscription: u32) -> (u64, FrameTransforms) {
        let (log_time_ns, payload) = self.data(subscription);
        (log_time_ns, FrameTransforms::decode(&payload[..]).expect("foxglove.FrameTransforms"))
    }

    /// Sends a message in the form that Foxglove's own crate gives it.
    pub(super) fn ask(&mut self, message: &impl for<'a> BinaryMessage<'a>) {
        self.socket.send(Message::binary(message.to_bytes())).expect("the server reads");
    }

    /// The next state of playback for which `fits` is true.
    pub(super) fn playback(&mut self, fits: impl Fn(&PlaybackState) -> bool) -> PlaybackState {
        let patience = Patience::new();
        let mut last = None;
        while patience.lasts() {
            match self.next() {
                row @ Said::Data { .. } => self.held.push_back(row),
                Said::Other(said) => {
                    if let ServerMessage::PlaybackState(state) = *said {
                        if fits(&state) {
                            return state;
                        }
                        last = Some(state);
                    }
                }
                Said::Json(_) => {}
            }
        }
        panic!("not within {PATIENCE:?}; the last was {last:?}");
    }

    /// Fetches an asset; returns its content, or the reason of the refusal.
    pub(super) fn fetch(&mut self, uri: &str, id: u32) -> Result<Vec<u8>, String> {
        self.send(&json!({ "op": "fetchAsset", "uri": uri, "requestId": id }));
        loop {
            if let Said::Other(said) = self.next()
                && let ServerMessage::FetchAssetResponse(answer) = *said
                && answer.request_id == id
            {
                return match answer.payload {
                    Payload::AssetData(data) => Ok(data.into_owned()),
                    Payload::ErrorMessage(why) => Err(why.into_owned()),
                };
            }
        }
    }
}
