//! Streams with very many channels: the work grows with their number.

use std::collections::BTreeMap;

use mcap::records::{Channel, MessageHeader, Record, SchemaHeader};
use twin_input::budget::CHANNELS;
use twin_input::work;

use super::shared::Shared;
use super::socket::{Advertised, Numbers, Said, Subscribed};

const POSE: &str = "geometry_msgs/msg/PoseStamped";
const DEFINITION: &str = "geometry_msgs/Pose pose\n===\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n===\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

/// Gives a stream `count` channels of poses, each with a message of its own.
fn stream(count: usize) {
    let shared = Shared::new("stream".to_owned(), None);
    for number in 1..=count as u16 {
        let header =
            SchemaHeader { id: number, name: POSE.to_owned(), encoding: "ros2msg".to_owned() };
        shared.take(Record::Schema { header, data: DEFINITION.as_bytes().into() });
        shared.take(Record::Channel(Channel {
            id: number,
            schema_id: number,
            topic: format!("/pose{number}"),
            message_encoding: "cdr".to_owned(),
            metadata: BTreeMap::new(),
        }));
        let header =
            MessageHeader { channel_id: number, sequence: 0, log_time: 1, publish_time: 1 };
        let data = [&[0, 1, 0, 0][..], &[0; 56]].concat();
        shared.take(Record::Message { header, data: data.into() });
    }
    let state = shared.state();
    // A pose gives a position and an attitude, each with one sample.
    let samples: usize = state.tracks().map(|track| track.samples.len()).sum();
    assert_eq!((state.tracks().count(), samples), (2 * count, 2 * count));
}

fn advertised(id: u64) -> Advertised {
    Advertised {
        id,
        topic: format!("/pose{id}"),
        encoding: "cdr".to_owned(),
        schema_name: POSE.to_owned(),
        schema: DEFINITION.to_owned(),
        schema_encoding: None,
    }
}

#[test]
fn the_work_of_channels_and_their_messages_grows_with_their_number() {
    let growth = work::growth(100, &mut stream);
    assert!(growth < work::LINEAR, "four times the channels took {growth:.1} times the steps");
}

#[test]
fn the_work_of_channels_that_a_server_advertises_one_by_one_grows_with_their_number() {
    let growth = work::growth(100, &mut |count| {
        let (shared, mut numbers) = (Shared::new("ws".to_owned(), None), Numbers::default());
        let mut subscribed = Subscribed::default();
        let mut answers = 0;
        for id in 0..count as u64 {
            let said = Said::Advertise { channels: vec![advertised(id)] };
            let answer = subscribed.hear(&shared, said, &mut numbers);
            answers += usize::from(answer.is_ok_and(|answer| answer.is_some()));
        }
        assert_eq!(answers, count);
    });
    assert!(growth < work::LINEAR, "four times the channels took {growth:.1} times the steps");
}

#[test]
fn a_server_that_offers_and_withdraws_channels_without_end_is_left() {
    let (shared, mut numbers) = (Shared::new("ws".to_owned(), None), Numbers::default());
    let mut subscribed = Subscribed::default();
    let mut hear = |said| subscribed.hear(&shared, said, &mut numbers);
    for round in 0..CHANNELS.most {
        assert!(hear(Said::Advertise { channels: vec![advertised(0)] }).is_ok(), "round {round}");
        assert_eq!(hear(Said::Unadvertise { channel_ids: vec![0] }), Ok(None));
    }
    let said = hear(Said::Advertise { channels: vec![advertised(0)] }).unwrap_err();
    assert!(said.contains("65536 channels") && said.contains("at most 65535"), "{said}");
}
