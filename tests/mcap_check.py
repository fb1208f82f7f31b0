"""Opens a recording with the reference MCAP reader and checks that other tools can use it unaided.

Usage: mcap_check.py FLIGHT.mcap        (needs: mcap, mcap-protobuf-support)
Exit code 0 and one line of summary if all checks hold, 1 with the first check that fails.
"""

import json
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

CHANNELS = {
    "/tf": ("foxglove.FrameTransforms", "protobuf", "protobuf"),
    "/scene": ("foxglove.SceneUpdate", "protobuf", "protobuf"),
    "/joint_states": ("foxglove.JointStates", "protobuf", "protobuf"),
    "/log": ("foxglove.Log", "protobuf", "protobuf"),
    "/twin/tick": ("twin.Tick", "jsonschema", "json"),
    "/twin/measurement": ("twin.Measurement", "jsonschema", "json"),
}
ATTACHMENTS = {"vehicle.urdf": b"<robot", "scenario.toml": b"seed"}
START = {"scenario", "seed", "gains", "version", "git", "kernel"}
END = {"state_hash", "verdict", "ticks", "dropped_ticks"}
# A recording that `twin recover` made has this record, and may lack the end.
RECOVERED = "twin.recovered"

# The norm of a unit quaternion in f64 is one up to a few roundings.
UNIT = 1e-9
NANOSECOND = 1e-9


def check(condition, text):
    if not condition:
        sys.exit(f"{sys.argv[1]}: {text}")


def check_channels(summary):
    found = {}
    for channel in summary.channels.values():
        schema = summary.schemas.get(channel.schema_id)
        check(schema is not None and schema.data, f"{channel.topic} has no schema")
        found[channel.topic] = (schema.name, schema.encoding, channel.message_encoding)
    # Channels without a message are left out of some summaries, so /log may be missing from an uneventful flight.
    check(set(CHANNELS) - {"/log"} <= set(found) <= set(CHANNELS), f"channels are {sorted(found)}")
    for topic, form in found.items():
        check(form == CHANNELS[topic], f"{topic} is {form}, expected {CHANNELS[topic]}")


def check_extras(reader):
    files = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
    for name, word in ATTACHMENTS.items():
        check(word in files.get(name, b""), f"attachment {name} is missing or does not hold {word!r}")
    records = {record.name: record.metadata for record in reader.iter_metadata()}
    check(START <= set(records.get("twin", {})), f"metadata 'twin' is {records.get('twin')}")
    json.loads(records["twin"]["gains"])
    if RECOVERED in records:
        return records
    check(END <= set(records.get("twin.end", {})), f"metadata 'twin.end' is {records.get('twin.end')}")
    int(records["twin.end"]["state_hash"], 16)
    return records


def check_transforms(message, frames):
    for transform in message.transforms:
        rotation = transform.rotation
        norm = rotation.x**2 + rotation.y**2 + rotation.z**2 + rotation.w**2
        check(abs(norm - 1) < UNIT, f"/tf: the rotation of {transform.child_frame_id} has the norm {norm}")
        check(transform.parent_frame_id == "world", f"/tf: {transform.child_frame_id} does not hang under world")
        frames.add(transform.child_frame_id)


def check_messages(reader, slack):
    counts = dict.fromkeys(CHANNELS, 0)
    frames, drawn = {"world"}, set()
    last_time, last_index, indices = -1, None, 0
    for _, channel, message, decoded in reader.iter_decoded_messages():
        counts[channel.topic] += 1
        check(message.log_time >= last_time, f"{channel.topic}: log time runs backwards at {message.log_time} ns")
        last_time = message.log_time
        if channel.topic == "/tf":
            check_transforms(decoded, frames)
        elif channel.topic == "/scene":
            drawn.update(entity.frame_id for entity in decoded.entities)
        elif channel.topic == "/twin/tick":
            check(last_index is None or decoded["index"] == last_index + 1, f"tick {decoded['index']} after {last_index}")
            last_index, indices = decoded["index"], indices + 1
            seconds = decoded["measurement"]["t_s"]
            check(abs(message.log_time * 1e-9 - seconds) < NANOSECOND, f"tick {last_index} is logged at another time")
    check(drawn <= frames, f"/scene draws in frames that /tf never gives: {sorted(drawn - frames)}")
    each = [counts["/tf"], counts["/twin/tick"], counts["/twin/measurement"], indices]
    check(max(each) - min(each) <= slack, f"counts differ: {counts}")
    check(counts["/scene"] > 0 and indices > 0, f"nothing was recorded: {counts}")
    return counts


class JsonDecoderFactory:
    """Decodes JSON; the library decodes protobuf."""

    def decoder_for(self, message_encoding, _schema):
        return json.loads if message_encoding == "json" else None


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with open(sys.argv[1], "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory(), JsonDecoderFactory()])
        header, summary = reader.get_header(), reader.get_summary()
        check(header.profile == "", f"profile is {header.profile!r}")
        check(summary is not None, "there is no summary: the recording was cut off")
        check_channels(summary)
        records = check_extras(reader)
        # A cut may leave a part of the last tick.
        counts = check_messages(reader, slack=1 if RECOVERED in records else 0)
    if RECOVERED in records:
        told = int(records[RECOVERED]["messages"])
        check(told == sum(counts.values()), f"metadata counts {told} messages, there are {counts}")
    else:
        check(int(records["twin.end"]["ticks"]) == counts["/twin/tick"], "metadata counts other ticks than there are")
    print(", ".join(f"{topic} {count}" for topic, count in counts.items()))


if __name__ == "__main__":
    main()
