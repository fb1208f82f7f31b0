"""Measures delivered ticks per second and latency at the socket, for this server and those of meshcat-python and viser.

All three show 12 poses a tick. The two other servers get 12 boxes, first 100 times a second and then as often as they accept
them. Our server flies in real time and then at `--speed max`. It flies a bare quadrotor with ten more links that are fixed to it,
because an arm is simulated more slowly than the server sends. One client reads: it takes bytes from its socket, answers
pings and notes the time of each frame. It decodes the frames afterwards. The client is the same for all servers, and it uses no
library, because a library would be slower than the servers. Rounds of the servers alternate, so that other load of the machine
affects all of them.

The latency of a tick is its time of arrival minus the time at which it was handed over, relative to the fastest tick of the run,
because our clock starts with the flight. Ours is given twice: from the time at which the tick was due, which includes the lag of
the flight, and from the time at which its frame was written. A tick is delivered when it has arrived. The console's protocol
carries every tick. The protocols of the stock viewers carry the newest poses, and so every tick for a program that reads as fast
as the vehicle flies.

Usage: viewers_bench.py TWIN [ROUNDS]        (needs: meshcat 0.3.2, viser 1.1.1)
Reports, asserts nothing. It wants a machine that does nothing else.
"""

import base64
import json
import os
import pathlib
import signal
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections import defaultdict

BODIES = 12
RATE_HZ = 100.0
MEASURED_S = 5.0
SETTLING_S = 1.5
PATIENCE_S = 60.0
ROOT = pathlib.Path(__file__).parents[2]
URDF = ROOT / "urdf" / "quadrotor.urdf"
SCENARIO = ROOT / "scenarios" / "quadrotor.toml"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def ticks(rate_hz):
    """Yields at each tick without end; a late feeder does not catch up."""
    due = time.perf_counter()
    while True:
        yield
        if rate_hz:
            due = max(due + 1.0 / rate_hz, time.perf_counter() - 1.0 / rate_hz)
            time.sleep(max(0.0, due - time.perf_counter()))


def feed_meshcat(rate_hz):
    import meshcat
    import meshcat.geometry as g
    import numpy as np

    viewer = meshcat.Visualizer()
    bodies = [viewer[f"body{k}"] for k in range(BODIES)]
    for body in bodies:
        body.set_object(g.Box([0.1, 0.1, 0.1]))
    print(viewer.url().split("/")[2], flush=True)
    matrix = np.eye(4)
    # The server of meshcat-python is a process in a session of its own; without this it would outlive the benchmark.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    try:
        for _ in ticks(rate_hz):
            matrix[0, 3] = time.time()
            for body in bodies:
                body.set_transform(matrix)
    finally:
        viewer.window.server_proc.kill()


def feed_viser(rate_hz):
    import viser

    server = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    bodies = [server.scene.add_box(f"/body{k}") for k in range(BODIES)]
    print(f"127.0.0.1:{server.get_port()}", flush=True)
    for tick, _ in enumerate(ticks(rate_hz)):
        # viser drops a pose close to the last one. So the time is a small number, and y and a sign distinguish the ticks.
        now = time.time() % 1000.0
        for body in bodies:
            body.position = (now, float(tick % 2), 0.0)
            body.wxyz = (0.6, 0.8, 0.0, 0.0) if tick % 2 else (0.8, 0.6, 0.0, 0.0)


class Wire:
    """A WebSocket client that only reads."""

    def __init__(self, address, path, subprotocol=None):
        host, port = address.split(":")
        self.socket = socket.create_connection((host, int(port)), PATIENCE_S)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        key = base64.b64encode(os.urandom(16)).decode()
        asked = [f"GET {path} HTTP/1.1", f"Host: {address}", "Upgrade: websocket", "Connection: Upgrade"]
        asked += [f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13"]
        asked += [f"Sec-WebSocket-Protocol: {subprotocol}"] if subprotocol else []
        self.socket.sendall("\r\n".join([*asked, "", ""]).encode())
        said = b""
        while b"\r\n\r\n" not in said:
            said += self.socket.recv(65536)
        head, rest = said.split(b"\r\n\r\n", 1)
        self.waiting = bytearray(rest)
        if b" 101 " not in head:
            sys.exit(f"viewers_bench: {address}{path} answers {head[:80]}")

    def read(self, seconds):
        """Frames with their times of arrival."""
        frames, ends = [], time.time() + seconds
        while True:
            at = time.time()
            del self.waiting[: self.take(at, frames)]
            if at >= ends:
                return frames
            self.waiting += self.socket.recv(1 << 20)

    def take(self, at, frames):
        """Moves all whole frames to the result; returns the number of their bytes."""
        waiting, here, have = self.waiting, 0, len(self.waiting)
        while here + 2 <= have:
            kind, length, start = waiting[here], waiting[here + 1], here + 2
            if length >= 126:
                size = 2 if length == 126 else 8
                if start + size > have:
                    break
                length = int.from_bytes(waiting[start : start + size])
                start += size
            if start + length > have:
                break
            payload = bytes(waiting[start : start + length])
            here = start + length
            if kind == 0x89:
                # The mask is zero.
                self.socket.sendall(bytes([0x8A, 0x80 | length, 0, 0, 0, 0]) + payload)
            elif kind == 0x82:
                frames.append((at, payload))
        return here


def read(address, path, subprotocol=None):
    """Binary frames with their times of arrival, after some time to settle."""
    frames = Wire(address, path, subprotocol).read(SETTLING_S + MEASURED_S)
    starts = frames[-1][0] - MEASURED_S
    return [(at, frame) for at, frame in frames if at >= starts]


def commands(frames):
    import umsgpack

    for at, frame in frames:
        # The test before unpacking saves the time to unpack frames that are not used.
        if b"set_transform" in frame:
            yield at, umsgpack.unpackb(frame)


def arrivals_meshcat(frames):
    return [(at, one["matrix"][12]) for at, one in commands(frames) if one["path"].endswith("body0")]


def batches(frames):
    import msgspec
    import zstandard

    for at, frame in frames:
        packed = struct.unpack_from("<QQ", frame)[1]
        inner = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed])
        yield at, msgspec.msgpack.decode(inner)


def arrivals_viser(frames):
    for at, inner in batches(frames):
        for message in inner["messages"]:
            if message["type"] == "SetPositionMessage" and message["name"] == "/body0":
                yield at, at - (at - message["position"][0]) % 1000.0


def arrivals_ours(frames, since_due):
    for at, frame in frames:
        first, rows = struct.unpack_from("<IH", frame, 4)
        written = struct.unpack_from("<d", frame, 32)[0]
        for tick in range(first, first + rows):
            yield at, tick / RATE_HZ if since_due else written


def arrivals_ours_meshcat(frames):
    return [(at, at) for at, one in commands(frames) if one["path"] == "/twin/base_link"]


def arrivals_ours_viser(frames):
    for at, inner in batches(frames):
        if any(one["type"] == "SetPositionMessage" and one["name"] == "/twin/base_link" for one in inner["messages"]):
            yield at, inner["timestampSec"]


class Results:
    """Ticks per second, and latencies in ms, of each kind of run over all rounds."""

    def __init__(self):
        self.rates, self.lags, self.sizes = defaultdict(list), defaultdict(list), defaultdict(list)

    def add(self, name, arrivals, frames, timed=True):
        arrivals = list(arrivals)
        self.rates[name].append(len(arrivals) / MEASURED_S)
        self.sizes[name].append(sum(len(frame) for _, frame in frames) / MEASURED_S / 1000)
        lags = [1000 * (at - sent) for at, sent in arrivals] if timed else []
        self.lags[name] += [lag - min(lags) for lag in lags]

    def report(self):
        for name, rates in self.rates.items():
            line = f"{name:44} {statistics.median(rates):8.1f} ticks/s ({min(rates):.0f} to {max(rates):.0f})"
            line += f" {statistics.median(self.sizes[name]):9.1f} kB/s"
            if len(self.lags[name]) > 1:
                cuts = statistics.quantiles(self.lags[name], n=20)
                line += f"   p50 {cuts[9]:6.2f} ms   p95 {cuts[18]:6.2f} ms"
            print(line, flush=True)


def measure_theirs(kind, rate_hz, results):
    command = [sys.executable, __file__, f"feed-{kind}", str(rate_hz)]
    feeder = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, start_new_session=True
    )
    try:
        address = next(line.split()[-1] for line in feeder.stdout if "127.0.0.1:" in line and "/" not in line)
        frames = read(address, "/", "viser-v1.1.1" if kind == "viser" else None)
        arrivals = {"meshcat": arrivals_meshcat, "viser": arrivals_viser}[kind](frames)
        package = {"meshcat": "meshcat-python", "viser": "viser"}[kind]
        how = f"{rate_hz:.0f} Hz" if rate_hz else "as fast as it takes"
        results.add(f"{package}, {how}", arrivals, frames, bool(rate_hz))
    finally:
        os.killpg(feeder.pid, 15)
        feeder.wait()


def state(address):
    with urllib.request.urlopen(f"http://{address}/api/state", timeout=PATIENCE_S) as answer:
        return json.load(answer)


def flown(address):
    """Ticks per second that are flown without a client."""
    before, start = state(address)["tick"], time.perf_counter()
    time.sleep(MEASURED_S / 2)
    return (state(address)["tick"] - before) / (time.perf_counter() - start)


def measure_ours(twin, urdf, speed, watch, results):
    address = f"127.0.0.1:{free_port()}"
    command = [twin, "fly", str(SCENARIO), "--port", address.split(":")[1], "--speed", speed]
    changed = ("time_limit_s=3600", "task.kind=hover", "task.duration_s=3600", f'vehicle.urdf="{urdf}"')
    command += [word for change in changed for word in ("--set", change)]
    flight = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        ends = time.time() + PATIENCE_S
        while time.time() < ends and flight.poll() is None:
            try:
                state(address)
                break
            except OSError:
                time.sleep(0.2)
        else:
            sys.exit(f"viewers_bench: {twin} does not fly")
        watch(address, speed != "max", results)
        if state(address)["phase"] != "flying":
            sys.exit("viewers_bench: the flight ended before it was measured")
    finally:
        flight.terminate()
        flight.wait()


def how(paced):
    return "100 Hz" if paced else "--speed max"


def watch_nothing(address, paced, results):
    if not paced:
        name = f"twin flies at {how(paced)}, nobody watching"
        results.rates[name].append(flown(address))
        results.sizes[name].append(0.0)


def watch_console(address, paced, results):
    frames = read(address, "/ws")
    channels, bodies = struct.unpack_from("<HH", frames[0][1], 10)
    if bodies + 1 != BODIES:
        sys.exit(f"viewers_bench: {bodies} bodies and the reference, {BODIES} poses expected")
    if paced:
        results.add(f"twin, /ws with {channels} channels, {how(paced)}, since due", arrivals_ours(frames, True), frames)
    results.add(f"twin, /ws with {channels} channels, {how(paced)}", arrivals_ours(frames, False), frames, paced)


def watch_meshcat(address, paced, results):
    frames = read(address, "/")
    results.add(f"twin, MeshCat's protocol, {how(paced)}", arrivals_ours_meshcat(frames), frames, False)


def watch_viser(address, paced, results):
    frames = read(address, "/viser", "viser-v1.1.1")
    results.add(f"twin, viser's protocol, {how(paced)}", arrivals_ours_viser(frames), frames, paced)


def with_more_links(folder):
    """Adds massless links to the vehicle until it has 12 poses with the reference; returns the path of its file."""
    text, links = URDF.read_text(), ""
    for k in range(BODIES - 1 - text.count("<link ")):
        links += f'<link name="more{k}"/><joint name="more{k}_joint" type="fixed"><parent link="base_link"/>'
        links += f'<child link="more{k}"/><origin xyz="0 0 0.1"/></joint>\n'
    path = pathlib.Path(folder) / "twelve.urdf"
    path.write_text(text.replace("</robot>", f"{links}</robot>"))
    return path


def main(twin, rounds="3"):
    results = Results()
    with tempfile.TemporaryDirectory() as folder:
        urdf = with_more_links(folder)
        for _ in range(int(rounds)):
            for rate_hz, speed in ((RATE_HZ, "1"), (0.0, "max")):
                for kind in ("meshcat", "viser"):
                    measure_theirs(kind, rate_hz, results)
                for watch in (watch_nothing, watch_console, watch_meshcat, watch_viser):
                    measure_ours(twin, urdf, speed, watch, results)
    print(f"{BODIES} poses a tick, one client; median of {rounds} rounds and their range", flush=True)
    results.report()


if __name__ == "__main__":
    if sys.argv[1:2] == ["feed-meshcat"]:
        feed_meshcat(float(sys.argv[2]))
    elif sys.argv[1:2] == ["feed-viser"]:
        feed_viser(float(sys.argv[2]))
    elif len(sys.argv) in (2, 3):
        main(*sys.argv[1:])
    else:
        sys.exit(__doc__)
