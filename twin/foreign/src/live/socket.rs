//! A client of a Foxglove WebSocket server with sub-protocol `foxglove.sdk.v1` or `foxglove.websocket.v1`. The messages that it
//! needs are the same in both.
//!
//! It subscribes to the channels that the map asks for, and reconnects whenever the connection is lost.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mcap::records::{Channel, MessageHeader, Record, SchemaHeader};
use serde::Deserialize;
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Message, WebSocket};

use super::Shared;
use super::backoff::Backoff;
use twin_input::budget::{CHANNELS, STREAM_MESSAGE_BYTES};
use twin_input::work;

/// Sub-protocols in order of preference.
const PROTOCOLS: &str = "foxglove.sdk.v1, foxglove.websocket.v1";

/// Time-out of a connection attempt.
const CONNECT: Duration = Duration::from_secs(2);

/// Time-out of a read; after each the client checks whether it should stop.
const READ: Duration = Duration::from_millis(100);

/// Reads without data after which the client sends a ping.
const PING_READS: u32 = 20;

/// Reads without data, the answer to the ping included, after which the server counts as gone. A machine that was switched off
/// closes no connection.
const GONE_READS: u32 = 60;

/// Opcode of a message of a subscription, and the length of its head: opcode, subscription, time.
const MESSAGE_DATA: u8 = 0x01;
const DATA_HEAD_BYTES: usize = 1 + 4 + 8;

/// The JSON messages of a server that this client needs.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase")]
pub(super) enum Said {
    Advertise {
        channels: Vec<Advertised>,
    },
    #[serde(rename_all = "camelCase")]
    Unadvertise {
        channel_ids: Vec<u64>,
    },
    #[serde(other)]
    Else,
}

/// A channel that the server advertises.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Advertised {
    pub(super) id: u64,
    pub(super) topic: String,
    pub(super) encoding: String,
    #[serde(default)]
    pub(super) schema_name: String,
    #[serde(default)]
    pub(super) schema: String,
    pub(super) schema_encoding: Option<String>,
}

/// Connects, and reconnects, until it is told to stop.
pub(super) fn listen(shared: &Shared, url: &str) {
    let mut numbers = Numbers::default();
    let mut backoff = Backoff::default();
    while !shared.is_stopped() {
        let end = connect(url).and_then(|mut socket| {
            shared.is_connected();
            read(shared, &mut socket, &mut numbers, &mut backoff)
        });
        if let Err(why) = end {
            shared.is_lost(&why);
        }
        shared.pause(backoff.pause());
    }
}

fn connect(url: &str) -> Result<WebSocket<TcpStream>, String> {
    let mut request = url.into_client_request().map_err(|error| error.to_string())?;
    request.headers_mut().insert("Sec-WebSocket-Protocol", HeaderValue::from_static(PROTOCOLS));
    let (host, port) = (request.uri().host().unwrap_or_default(), request.uri().port_u16());
    let host = host.trim_matches(['[', ']']);
    let mut addresses =
        (host, port.unwrap_or(8765)).to_socket_addrs().map_err(|error| error.to_string())?;
    let address = addresses.next().ok_or("the name has no address")?;
    let stream = TcpStream::connect_timeout(&address, CONNECT).map_err(|e| e.to_string())?;
    let timed = stream.set_read_timeout(Some(CONNECT)).and_then(|()| stream.set_nodelay(true));
    timed.map_err(|error| error.to_string())?;
    let most = Some(STREAM_MESSAGE_BYTES.count());
    let budget = WebSocketConfig::default().max_message_size(most).max_frame_size(most);
    let (socket, _) = tungstenite::client::client_with_config(request, stream, Some(budget))
        .map_err(|error| error.to_string())?;
    socket.get_ref().set_read_timeout(Some(READ)).map_err(|error| error.to_string())?;
    Ok(socket)
}

/// Our channel numbers, which stay the same across connections.
#[derive(Default)]
pub(super) struct Numbers {
    by_name: BTreeMap<(String, String, String), u16>,
}

impl Numbers {
    fn of(&mut self, channel: &Advertised) -> Option<u16> {
        let next = u16::try_from(self.by_name.len() + 1).ok()?;
        let name = (channel.topic.clone(), channel.schema_name.clone(), channel.encoding.clone());
        Some(*self.by_name.entry(name).or_insert(next))
    }
}

/// The subscriptions of one connection.
#[derive(Default)]
pub(super) struct Subscribed {
    /// Our channel number by subscription.
    channels: BTreeMap<u32, u16>,
    /// Channels that are offered and not subscribed, with their schema, by the server's numbers.
    offered: BTreeMap<u64, (Channel, String)>,
    /// The server's numbers of the subscribed channels.
    known: BTreeSet<u64>,
    /// The server's numbers of the channels that no map was asked about yet.
    fresh: Vec<u64>,
    /// Number of maps that were chosen when the channels were asked about.
    maps: u64,
}

/// Reads until the connection ends; returns `Ok` if it was told to stop.
fn read(
    shared: &Shared,
    socket: &mut WebSocket<TcpStream>,
    numbers: &mut Numbers,
    backoff: &mut Backoff,
) -> Result<(), String> {
    let mut subscribed = Subscribed::default();
    let mut quiet = 0;
    while !shared.is_stopped() {
        shared.judge_again();
        match socket.read() {
            Ok(Message::Text(text)) => {
                // A message that cannot be parsed is none that this client needs.
                if let Ok(said) = serde_json::from_str::<Said>(&text)
                    && let Some(answer) = subscribed.hear(shared, said, numbers)?
                {
                    socket.send(Message::text(answer)).map_err(|error| error.to_string())?;
                }
            }
            Ok(Message::Binary(bytes)) => {
                if subscribed.data(shared, &bytes) {
                    backoff.reset();
                }
            }
            Ok(Message::Close(frame)) => {
                let why = frame.map_or_else(String::new, |frame| frame.reason.to_string());
                return Err(format!("the server closed the connection {why}"));
            }
            Ok(_) => {}
            // A read with a time-out ends with each signal of the process; the loop asks whether it was told to stop.
            Err(tungstenite::Error::Io(error)) if error.kind() == ErrorKind::Interrupted => {
                continue;
            }
            Err(tungstenite::Error::Io(error)) if is_timeout(&error) => {
                quiet += 1;
                if quiet >= GONE_READS {
                    return Err(format!(
                        "no answer for {:.0} s",
                        f64::from(quiet) * READ.as_secs_f64()
                    ));
                }
                if quiet % PING_READS == 0 {
                    let ping = socket.send(Message::Ping(Vec::new().into()));
                    ping.map_err(|error| error.to_string())?;
                }
                continue;
            }
            Err(error) => return Err(error.to_string()),
        }
        quiet = 0;
    }
    Ok(())
}

fn is_timeout(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut)
}

impl Subscribed {
    /// Takes a JSON message; returns the answer, if it needs one. More channels than the budget allows end the connection.
    pub(super) fn hear(
        &mut self,
        shared: &Shared,
        said: Said,
        numbers: &mut Numbers,
    ) -> Result<Option<String>, String> {
        match said {
            Said::Advertise { channels } => {
                for channel in channels {
                    self.offer(shared, channel, numbers);
                }
                let all = self.offered.len() + self.channels.len();
                CHANNELS.check_count(all).map_err(|excess| excess.to_string())?;
                Ok(self.wanted(shared))
            }
            Said::Unadvertise { channel_ids } => {
                for id in channel_ids {
                    self.offered.remove(&id);
                    self.known.remove(&id);
                }
                Ok(None)
            }
            Said::Else => Ok(None),
        }
    }

    fn offer(&mut self, shared: &Shared, offered: Advertised, numbers: &mut Numbers) {
        let Some(number) = numbers.of(&offered) else { return };
        let encoding = offered.schema_encoding.clone().unwrap_or_else(|| {
            let usual = match offered.encoding.as_str() {
                "cdr" => "ros2msg",
                "ros1" => "ros1msg",
                "json" => "jsonschema",
                other => other,
            };
            usual.to_owned()
        });
        // A binary schema is sent as base64.
        let text = match encoding.as_str() {
            "protobuf" | "flatbuffer" => STANDARD.decode(&offered.schema).unwrap_or_default(),
            _ => offered.schema.into_bytes(),
        };
        let header = SchemaHeader { id: number, name: offered.schema_name.clone(), encoding };
        shared.take(Record::Schema { header, data: text.into() });
        let channel = Channel {
            id: number,
            schema_id: number,
            topic: offered.topic,
            message_encoding: offered.encoding,
            metadata: BTreeMap::new(),
        };
        shared.take(Record::Channel(channel.clone()));
        self.offered.insert(offered.id, (channel, offered.schema_name));
        self.fresh.push(offered.id);
    }

    /// A subscription request for all channels that the map asks for and that are not yet subscribed.
    fn wanted(&mut self, shared: &Shared) -> Option<String> {
        let mut fresh = std::mem::take(&mut self.fresh);
        let maps = shared.maps();
        if maps != self.maps {
            // Another map may ask for channels that were offered before.
            fresh = self.offered.keys().copied().collect();
            self.maps = maps;
        }
        let mut subscriptions = Vec::new();
        for id in fresh {
            work::steps(1);
            let wanted = |(channel, schema): &(Channel, String)| shared.wants(channel, schema);
            if !self.known.contains(&id) && self.offered.get(&id).is_some_and(wanted) {
                let Some((channel, _)) = self.offered.remove(&id) else { continue };
                let subscription = self.channels.len() as u32 + 1;
                self.channels.insert(subscription, channel.id);
                self.known.insert(id);
                subscriptions.push(serde_json::json!({ "id": subscription, "channelId": id }));
            }
        }
        let some = !subscriptions.is_empty();
        some.then(|| {
            serde_json::json!({ "op": "subscribe", "subscriptions": subscriptions }).to_string()
        })
    }

    /// Takes a binary message; returns whether it was data of a subscription.
    fn data(&self, shared: &Shared, bytes: &[u8]) -> bool {
        let Some((head, data)) = bytes.split_at_checked(DATA_HEAD_BYTES) else { return false };
        let (Some(subscription), Some(time)) =
            (head[1..].first_chunk::<4>(), head[5..].first_chunk::<8>())
        else {
            return false;
        };
        let channel = self.channels.get(&u32::from_le_bytes(*subscription));
        let (MESSAGE_DATA, Some(channel_id)) = (head[0], channel) else { return false };
        let log_time = u64::from_le_bytes(*time);
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        shared.take(Record::Message { header, data: data.into() });
        true
    }
}
