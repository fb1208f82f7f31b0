"""Delivered ticks per second and latency at the socket: this server against meshcat-python's and viser's own.

Each of the two servers is fed 12 bodies, first 100 times a second and then as often as it takes them; ours flies a scenario
in real time and then at `--speed max`. One client reads everything; what it read is taken apart afterwards. A tick's
latency is how much later it arrived than it was handed over, above that of the fastest tick of the run, because our clock
starts with the flight. Ours is given twice: since the tick was due, which also counts a flight that lags, and since its
frame was written. A tick counts as delivered when it arrived. The console's protocol carries every tick; those of the stock
viewers carry the newest poses, which is every tick for a client that takes them as fast as they are flown.

Usage: viewers_bench.py TWIN SCENARIO.toml        (needs: meshcat 0.3.2, viser 1.1.1)
Reports, asserts nothing. It wants a machine that does nothing else.
"""

import os
import socket
import statistics
import struct
import subprocess
import sys
import time

BODIES = 12
RATE_HZ = 100.0
MEASURED_S = 8.0
SETTLING_S = 2.0
PATIENCE_S = 60.0


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def ticks(rate_hz):
    """Yields at each tick, for ever; a late feeder does not catch up."""
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
    for _ in ticks(rate_hz):
        matrix[0, 3] = time.time()
        for body in bodies:
            body.set_transform(matrix)


def feed_viser(rate_hz):
    import viser

    server = viser.ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    bodies = [server.scene.add_box(f"/body{k}") for k in range(BODIES)]
    print(f"127.0.0.1:{server.get_port()}", flush=True)
    for tick, _ in enumerate(ticks(rate_hz)):
        # viser sends no position that is close to the last; so the time is a small number, and y tells ticks apart.
        now = time.time() % 1000.0
        for body in bodies:
            body.position = (now, float(tick % 2), 0.0)


def read(url, subprotocols=None):
    """Frames with the time each arrived at, after some time to settle."""
    from websockets.sync.client import connect

    frames, ends = [], time.time() + SETTLING_S + MEASURED_S
    with connect(url, subprotocols=subprotocols, max_size=None, open_timeout=PATIENCE_S) as wire:
        while time.time() < ends:
            frame = wire.recv(timeout=PATIENCE_S)
            frames.append((time.time(), frame))
    starts = frames[0][0] + SETTLING_S
    return [(at, frame) for at, frame in frames if at >= starts]


def arrivals_meshcat(frames):
    import umsgpack

    for at, frame in frames:
        command = umsgpack.unpackb(frame)
        if command["type"] == "set_transform" and command["path"].endswith("body0"):
            yield at, command["matrix"][12]


def arrivals_viser(frames):
    import msgspec
    import zstandard

    for at, frame in frames:
        packed = struct.unpack_from("<QQ", frame)[1]
        inner = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed]))
        for message in inner["messages"]:
            if message["type"] == "SetPositionMessage" and message["name"] == "/body0":
                yield at, at - (at - message["position"][0]) % 1000.0


def arrivals_ours(frames, since_due):
    for at, frame in frames:
        if isinstance(frame, bytes):
            first, rows = struct.unpack_from("<IH", frame, 4)
            written = struct.unpack_from("<d", frame, 32)[0]
            for tick in range(first, first + rows):
                yield at, tick / RATE_HZ if since_due else written


def arrivals_ours_meshcat(frames):
    import umsgpack

    for at, frame in frames:
        command = umsgpack.unpackb(frame)
        if command["type"] == "set_transform" and command["path"] == "/twin/base_link":
            yield at, at


def arrivals_ours_viser(frames):
    import msgspec
    import zstandard

    for at, frame in frames:
        packed = struct.unpack_from("<QQ", frame)[1]
        inner = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed]))
        if any(one["type"] == "SetPositionMessage" and one["name"] == "/twin/base_link" for one in inner["messages"]):
            yield at, inner["timestampSec"]


def report(name, arrivals, frames, timed=True):
    arrivals = list(arrivals)
    rate = len(arrivals) / MEASURED_S
    size = sum(len(frame) for _, frame in frames) / MEASURED_S / 1000
    line = f"{name:34} {rate:8.1f} ticks/s {size:9.1f} kB/s"
    if timed and len(arrivals) > 1:
        lags = [1000 * (at - sent) for at, sent in arrivals]
        best = min(lags)
        cuts = statistics.quantiles([lag - best for lag in lags], n=20)
        line += f"   p50 {cuts[9]:6.2f} ms   p95 {cuts[18]:6.2f} ms"
    print(line, flush=True)


def fed(kind, rate_hz):
    return subprocess.Popen(
        [sys.executable, __file__, f"feed-{kind}", str(rate_hz)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        start_new_session=True,
    )


def measure_theirs(kind, rate_hz):
    feeder = fed(kind, rate_hz)
    try:
        address = next(line.split()[-1] for line in feeder.stdout if "127.0.0.1:" in line and "/" not in line)
        sub = ["viser-v1.1.1"] if kind == "viser" else None
        frames = read(f"ws://{address}/", sub)
        arrivals = {"meshcat": arrivals_meshcat, "viser": arrivals_viser}[kind](frames)
        package = {"meshcat": "meshcat-python", "viser": "viser"}[kind]
        report(f"{package}, {f'{rate_hz:.0f} Hz' if rate_hz else 'as fast as it takes'}", arrivals, frames, bool(rate_hz))
    finally:
        os.killpg(feeder.pid, 15)
        feeder.wait()


def measure_ours(twin, scenario, speed):
    port = free_port()
    command = [twin, "fly", scenario, "--port", str(port), "--speed", speed]
    command += ["--set", "time_limit_s=3600", "--set", "task.duration_s=3600"]
    flight = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        ends = time.time() + PATIENCE_S
        while time.time() < ends and flight.poll() is None:
            try:
                socket.create_connection(("127.0.0.1", port), 1.0).close()
                break
            except OSError:
                time.sleep(0.2)
        else:
            sys.exit(f"viewers_bench: {twin} does not fly {scenario}")
        report_ours(f"ws://127.0.0.1:{port}", speed != "max")
    finally:
        flight.terminate()
        flight.wait()


def report_ours(url, paced):
    how = "100 Hz" if paced else "--speed max"
    frames = read(f"{url}/ws")
    if paced:
        channels, bodies = next(struct.unpack_from("<HH", frame, 10) for _, frame in frames if isinstance(frame, bytes))
        print(f"twin sends {bodies + 1} poses, the reference among them, and on /ws {channels} channels a tick", flush=True)
        report(f"twin, /ws, {how}, since due", arrivals_ours(frames, True), frames)
        report(f"twin, /ws, {how}, since written", arrivals_ours(frames, False), frames)
    else:
        report(f"twin, /ws, {how}", arrivals_ours(frames, False), frames, False)
    frames = read(f"{url}/")
    report(f"twin, MeshCat's protocol, {how}", arrivals_ours_meshcat(frames), frames, False)
    frames = read(f"{url}/viser", ["viser-v1.1.1"])
    report(f"twin, viser's protocol, {how}", arrivals_ours_viser(frames), frames, paced)


def main(twin, scenario):
    for kind in ("meshcat", "viser"):
        measure_theirs(kind, RATE_HZ)
        measure_theirs(kind, 0.0)
    measure_ours(twin, scenario, "1")
    measure_ours(twin, scenario, "max")


if __name__ == "__main__":
    if sys.argv[1:2] == ["feed-meshcat"]:
        feed_meshcat(float(sys.argv[2]))
    elif sys.argv[1:2] == ["feed-viser"]:
        feed_viser(float(sys.argv[2]))
    elif len(sys.argv) == 3:
        main(*sys.argv[1:])
    else:
        sys.exit(__doc__)
