"""Watches a flight as MeshCat and viser do, and checks every frame with those projects' own Python code.

MeshCat: the MessagePack library of meshcat-python unpacks each frame and packs it to the same bytes, and the frame is a command
with exactly the fields that the stock viewer reads. viser: each frame has the structure that viser's client expects, and each
message is an instance of viser's own dataclass of that name, from exactly the fields received, of the annotated types.

Usage: viewers_check.py TWIN SCENARIO.toml        (needs: u-msgpack-python, viser 1.1.1 with what it brings)
Exit code 0 and one line of summary for each viewer if all checks hold, 1 with the first check that fails.
"""

import dataclasses
import json
import socket
import struct
import subprocess
import sys
import time
import typing
import urllib.request
from collections import Counter

import msgspec
import numpy as np
import typing_extensions
import umsgpack
import zstandard
from viser import _messages
from viser.infra import Message
from viser.infra._messages import get_type_hints_cached, wire_field_names
from websockets.sync.client import connect

# Long enough for trails, charts and status lines, s.
WATCHED_S = 6.0
# Long enough for a start on a loaded machine, s.
PATIENCE_S = 60.0

# Fields of each command besides its type, as the stock viewers read them; `notice` is our own command, which they ignore.
COMMANDS = {
    "set_object": [{"object", "path"}],
    "set_transform": [{"path", "matrix"}],
    "set_property": [{"path", "property", "value"}],
    "set_control": [{"name", "callback"}, {"name", "callback", "keycode1"}, {"name", "callback", "value", "min", "max", "step"},
                    # Drake's sliders with keys.
                    {"name", "callback", "value", "min", "max", "step", "keycode1", "keycode2"}],
    "set_control_value": [{"name", "value", "invoke_callback"}],
    "delete": [{"path"}],
    "set_target": [{"value"}],
    "set_animation": [{"animations", "options", "path"}],
    "notice": [{"text"}],
    "show_realtime_rate": [{"show"}],
    "realtime_rate": [{"rate"}],
}
# Bytes of an element of the typed arrays that the stock viewer knows.
TYPED_ARRAYS = {0x12: 1, 0x15: 4, 0x16: 4, 0x17: 4}

# Shapes of arrays, which the wire does not carry and viser's classes require.
SHAPES = {
    ("MeshProps", "vertices"): (-1, 3),
    ("MeshProps", "faces"): (-1, 3),
    ("LineSegmentsProps", "points"): (-1, 2, 3),
    ("LineSegmentsProps", "colors"): (-1, 2, 3),
    ("ArrowProps", "points"): (-1, 2, 3),
    ("BatchedAxesProps", "batched_wxyzs"): (-1, 4),
    ("BatchedAxesProps", "batched_positions"): (-1, 3),
}


def check(condition, text):
    if not condition:
        sys.exit(f"viewers_check: {text}")


def typed_arrays(value):
    if isinstance(value, umsgpack.Ext):
        yield value
    for inner in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from typed_arrays(inner)


def check_meshcat(frame, kinds):
    check(isinstance(frame, bytes), "MeshCat: a text frame")
    command = umsgpack.unpackb(frame)
    check(umsgpack.packb(command) == frame, f"MeshCat: packs to other bytes: {str(command)[:300]}")
    kind = command.pop("type")
    check(set(command) in COMMANDS.get(kind, []), f"MeshCat: {kind} with {sorted(command)}")
    for array in typed_arrays(command):
        size = TYPED_ARRAYS.get(array.type)
        check(size and len(array.data) % size == 0, f"MeshCat: {kind} with extension {array.type}")
    kinds[kind] += 1


def watch_meshcat(address):
    kinds, frames, size, ends = Counter(), 0, 0, time.monotonic() + WATCHED_S
    with connect(f"ws://{address}/", max_size=None) as socket_:
        while time.monotonic() < ends:
            frame = socket_.recv(timeout=PATIENCE_S)
            check_meshcat(frame, kinds)
            frames, size = frames + 1, size + len(frame)
    for kind in ("set_object", "set_transform", "set_control", "set_property", "delete"):
        check(kinds[kind], f"MeshCat: no {kind}")
    print(f"MeshCat: {frames} frames, {size} bytes, all understood: {dict(kinds.most_common())}")


def fits(value, annotation):
    """Whether a value from the wire has the annotated type; for an array, the type of its elements counts."""
    origin, args = typing.get_origin(annotation), typing.get_args(annotation)
    if annotation is typing.Any:
        return True
    if annotation is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    if annotation is int:
        return isinstance(value, int) and not isinstance(value, bool)
    if origin is typing.Annotated:
        return fits(value, args[0])
    if origin is typing.Literal:
        return value in args
    if origin is typing.Union:
        return any(fits(value, arg) for arg in args)
    if origin is tuple and isinstance(value, (list, tuple)):
        types = args[:1] * len(value) if args[1:] == (...,) else args
        return len(types) == len(value) and all(map(fits, value, types))
    if origin is np.ndarray:
        wanted = typing.get_args(args[1])[0]
        return isinstance(value, np.ndarray) and (wanted is typing.Any or value.dtype == np.dtype(wanted))
    if origin is dict:
        return isinstance(value, dict)
    if typing_extensions.is_typeddict(annotation):
        return (
            isinstance(value, dict)
            and set(annotation.__required_keys__) <= set(value) <= set(annotation.__annotations__)
        )
    return isinstance(value, origin or annotation)


def build(cls, fields):
    """An instance of one of viser's dataclasses from exactly these fields."""
    hints = get_type_hints_cached(cls)
    wanted = set(wire_field_names(cls))
    check(set(fields) == wanted, f"viser: {cls.__name__}: unknown {set(fields) - wanted}, missing {wanted - set(fields)}")
    values = {}
    for name, value in fields.items():
        hint = hints[name]
        if dataclasses.is_dataclass(hint):
            value = build(hint, value)
        check(fits(value, hint), f"viser: {cls.__name__}.{name} = {value!r:.200} is no {hint}")
        if (cls.__name__, name) in SHAPES:
            value = value.reshape(SHAPES[cls.__name__, name])
        values[name] = value
    made = cls(**{field.name: values.pop(field.name) for field in dataclasses.fields(cls) if field.init})
    for name, value in values.items():
        setattr(made, name, value)
    return made


def take_apart(frame):
    """Messages of one frame, with the buffers in their places."""
    check(isinstance(frame, bytes), "viser: a text frame")
    size, packed = struct.unpack_from("<QQ", frame)
    inner = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed])
    check(len(inner) == size, f"viser: {len(inner)} bytes of messages, {size} promised")
    frame_map = msgspec.msgpack.decode(inner)
    check(set(frame_map) == {"messages", "timestampSec", "binaryBufferLengths"}, f"viser: a frame of {set(frame_map)}")
    buffers = take_buffers(frame, 16 + packed, frame_map["binaryBufferLengths"])
    return [fill_buffers(message, buffers) for message in frame_map["messages"]]


def take_buffers(frame, at, lengths):
    """The aligned buffers after `at`; they must reach to the end of the data."""
    buffers = []
    for length in lengths:
        at = -(-at // 8) * 8
        buffers.append(frame[at : at + length])
        at += length
    check(at == len(frame), f"viser: {len(frame)} bytes, {at} promised")
    return buffers


def fill_buffers(value, buffers):
    """The value, with each reference to a buffer replaced by its array."""
    if isinstance(value, list):
        return [fill_buffers(inner, buffers) for inner in value]
    if not isinstance(value, dict):
        return value
    if "__binary_index" in value:
        return np.frombuffer(buffers[value["__binary_index"]], dtype=value["dtype"])
    return {key: fill_buffers(inner, buffers) for key, inner in value.items()}


# Nodes whose properties change.
CHANGING = ("LineSegmentsMessage", "ArrowMessage", "BatchedAxesMessage")


class ViserClient:
    def __init__(self):
        self.kinds = Counter()
        self.elements = {}
        self.classes = {cls.__name__: cls for cls in Message.get_subclasses()}

    def take(self, frame):
        for fields in take_apart(frame):
            self.take_message(fields)

    def take_message(self, fields):
        kind = fields.pop("type")
        check(kind in self.classes, f"viser: there is no message {kind}")
        message = build(self.classes[kind], fields)
        self.kinds[kind] += 1
        # Nodes whose properties change later.
        if hasattr(message, "props") and (hasattr(message, "uuid") or kind in CHANGING):
            self.elements[getattr(message, "uuid", None) or message.name] = message
        if hasattr(message, "updates"):
            self.update(getattr(message, "uuid", None) or message.name, message.updates)

    def update(self, name, updates):
        check(name in self.elements, f"viser: an update of {name}, which there is not")
        element = self.elements[name]
        for key, value in updates.items():
            owner = element if key == "value" else element.props
            hint = get_type_hints_cached(type(owner)).get(key)
            check(hint is not None and fits(value, hint), f"viser: update of {name}: {key} = {value!r:.200} is no {hint}")
            if (type(owner).__name__, key) in SHAPES:
                value = value.reshape(SHAPES[type(owner).__name__, key])
            setattr(owner, key, value)
        if isinstance(element, _messages.LineSegmentsMessage):
            points, colors = element.props.points, element.props.colors
            check(points.shape == colors.shape, f"viser: {name}: {points.shape} points, {colors.shape} colours")
        if isinstance(element, _messages.BatchedAxesMessage):
            turns, places = element.props.batched_wxyzs, element.props.batched_positions
            check(len(turns) == len(places) > 0, f"viser: {name}: {len(turns)} turns, {len(places)} places")
            check(np.allclose(np.linalg.norm(turns, axis=1), 1.0, atol=1e-6), f"viser: {name}: no unit quaternions")


def gains(address):
    with urllib.request.urlopen(f"http://{address}/api/gains", timeout=PATIENCE_S) as answer:
        return {gain["name"]: gain["value"] for gain in json.load(answer)["gains"]}


def watch_viser(address):
    client, frames, size, ends = ViserClient(), 0, 0, time.monotonic() + WATCHED_S
    with connect(f"ws://{address}/viser", subprotocols=["viser-v1.1.1"], max_size=None) as socket_:
        # The message that the client sends when a slider moves, packed by viser itself.
        moved = _messages.GuiUpdateMessage(uuid="gain.slope.x", updates={"value": 1.5})
        socket_.send(msgspec.msgpack.encode(moved.as_serializable_dict()))
        while time.monotonic() < ends:
            frame = socket_.recv(timeout=PATIENCE_S)
            client.take(frame)
            frames, size = frames + 1, size + len(frame)
    value = gains(address)["slope.x"]
    check(value == 1.5, f"viser: the slider's gain is {value}")
    wanted = ("FrameMessage", "LabelMessage", "SceneNodeUpdateMessage", "GuiUpdateMessage", "GuiUplotMessage")
    for kind in (*wanted, *CHANGING):
        check(client.kinds[kind], f"viser: no {kind}")
    marks = client.elements["/twin/trails/attitude"].props.batched_positions
    check(len(marks) > 2, f"viser: {len(marks)} marks of the way in {WATCHED_S} s")
    for name in ("residual", "estimate"):
        foot, tip = client.elements[f"/twin/forces/{name}"].props.points[0]
        # The weight of 3 kg or more, drawn with 12.5 mm per newton.
        check(0.3 < tip[2] - foot[2] < 0.6, f"viser: the arrow {name} reaches from {foot} to {tip}")
    print(f"viser: {frames} frames, {size} bytes, all understood: {dict(client.kinds.most_common())}")


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def main(twin, scenario):
    address = f"127.0.0.1:{free_port()}"
    flight = subprocess.Popen([twin, "fly", scenario, "--port", address.split(":")[1]], stderr=subprocess.DEVNULL)
    try:
        ends = time.monotonic() + PATIENCE_S
        while True:
            try:
                gains(address)
                break
            except OSError:
                check(time.monotonic() < ends and flight.poll() is None, f"{twin} does not fly {scenario}")
                time.sleep(0.1)
        watch_meshcat(address)
        watch_viser(address)
    finally:
        flight.terminate()
        flight.wait()


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
