"""Reads the files of `twin export viser` and `twin export meshcat` with those projects' own Python code.

viser: the file has the structure that viser's serializer writes, every message fits viser's own class of that name and is one
that viser records, and the times ascend. MeshCat: every command of the page is a command of the stock viewer. In both files the
last pose of the vehicle is the one that the recording has on /tf.

Usage: exports_check.py FLIGHT.mcap FLIGHT.viser FLIGHT.html        (needs what viewers_check.py and mcap_check.py need)
"""

import base64
import re
import struct
import sys
from collections import Counter
from pathlib import Path

import msgspec
import umsgpack
import zstandard
from mcap_protobuf.decoder import DecoderFactory
from mcap.reader import make_reader
from viser import __version__

from viewers_check import ViserClient, check, check_meshcat, fill_buffers, take_buffers

# Poses are f32: at 10 m their error is 1e-6.
TOLERANCE = 1e-5
# Largest age of a picture relative to the last tick, s: there are 25 pictures a second.
PICTURE_S = 0.04


def told(path):
    """Name of the vehicle's root, and by time in s its pose on /tf as (x, y, z), (w, x, y, z)."""
    poses, names = {}, Counter()
    with open(path, "rb") as file:
        for _, _, message, said in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=["/tf"]):
            for transform in said.transforms:
                t, q = transform.translation, transform.rotation
                names[transform.child_frame_id] += 1
                poses[transform.child_frame_id, round(message.log_time * 1e-9, 3)] = (t.x, t.y, t.z), (q.w, q.x, q.y, q.z)
    return poses, names


def near(pose, name, poses, what):
    """Checks that the pose is that of `name` at one of the last ticks."""
    times = sorted(t for known, t in poses if known == name)
    for t in [t for t in times if t >= times[-1] - PICTURE_S - 1e-6]:
        position, turn = poses[name, t]
        if all(abs(a - b) < TOLERANCE for a, b in zip(pose, position + turn)):
            return
    sys.exit(f"exports_check: {what}: {name} ends at {pose}, the recording says {poses[name, times[-1]]}")


def check_viser(path, poses, names):
    data = Path(path).read_bytes()
    inner = zstandard.ZstdDecompressor().decompress(data[8:])
    check(len(inner) == struct.unpack_from("<Q", data)[0], "viser: another length than promised")
    size = struct.unpack_from("<Q", inner)[0]
    head = msgspec.msgpack.decode(inner[8 : 8 + size])
    check(
        set(head) == {"durationSeconds", "messages", "viserVersion", "binaryBufferLengths"}, f"viser: a head of {set(head)}"
    )
    check(head["viserVersion"] == __version__, f"viser: version {head['viserVersion']}")
    buffers = take_buffers(inner, 8 + size, head["binaryBufferLengths"])
    client, last, at = ViserClient(), {}, 0.0
    for t, fields in head["messages"]:
        check(t >= at, f"viser: {t} s after {at} s")
        at = t
        fields = fill_buffers(fields, buffers)
        kind = fields["type"]
        check(client.classes[kind].include_in_scene_serialization, f"viser: {kind} is not recorded")
        if kind in ("SetPositionMessage", "SetOrientationMessage"):
            last[fields["name"], kind] = tuple(fields["position" if kind == "SetPositionMessage" else "wxyz"])
        client.take_message(fields)
    check(at <= head["durationSeconds"], f"viser: {at} s of {head['durationSeconds']} s")
    for kind in ("FrameMessage", "LineSegmentsMessage", "LabelMessage", "SetPositionMessage", "SetOrientationMessage"):
        check(client.kinds[kind], f"viser: no {kind}")
    for name in names:
        near(last[f"/twin/{name}", "SetPositionMessage"] + last[f"/twin/{name}", "SetOrientationMessage"], name, poses, "viser")
    print(f"viser: {len(head['messages'])} messages of {head['durationSeconds']:.2f} s in {len(data)} bytes, all understood")


def check_page(path, poses, names):
    page = Path(path).read_text()
    commands = re.search(r"for \(const command of \[(.*?)\]\)", page, re.S).group(1)
    kinds, clips = Counter(), {}
    for text in commands.replace('"', "").split(","):
        frame = base64.b64decode(text, validate=True)
        check_meshcat(frame, kinds)
        command = umsgpack.unpackb(frame)
        if command["type"] == "set_animation":
            clips = {one["path"]: {t["name"]: t["keys"] for t in one["clip"]["tracks"]} for one in command["animations"]}
    for name in names:
        tracks = clips[f"/twin/{name}"]
        x, y, z, w = tracks[".quaternion"][-1]["value"]
        near(tuple(tracks[".position"][-1]["value"]) + (w, x, y, z), name, poses, "MeshCat")
        for keys in tracks.values():
            check(all(a["time"] < b["time"] for a, b in zip(keys, keys[1:])), f"MeshCat: keys of {name} out of order")
    print(f"MeshCat: {len(clips)} nodes move, {len(page)} bytes, all understood: {dict(kinds.most_common())}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    poses, names = told(sys.argv[1])
    check(names, "the recording has nothing on /tf")
    check_viser(sys.argv[2], poses, names)
    check_page(sys.argv[3], poses, names)
