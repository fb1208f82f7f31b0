"""Times the forward pass of the Factorized Dynamics Transformer in PyTorch and ONNX Runtime in turn with twin's, on one core.

    pip install numpy torch onnx onnxruntime          (in an environment of your own)
    python tests/bench/inference_export.py [ARITHMETIC ...]

All use the same random weights and history, from `cargo bench --bench inference -- --write`. Each round times some calls of one
runtime after the other, so that other load of the machine affects all of them. It prints the parity, then ms per call.
"""

import json
import math
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np
import onnxruntime
import torch
import torch.nn.functional as F

ROUNDS, CALLS = 40, 10
BENCH = ["cargo", "bench", "--quiet", "--bench", "inference", "--"]


def read(path):
    data = path.read_bytes()
    (size,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + size])
    head = json.loads(header.pop("__metadata__")["twin"])
    tensors = {}
    for name, info in header.items():
        begin, end = info["data_offsets"]
        values = np.frombuffer(data[8 + size + begin : 8 + size + end], dtype="<f4")
        tensors[name] = torch.from_numpy(values.reshape(info["shape"]).copy())
    return head["config"], tensors


class Fdt(torch.nn.Module):
    """The equations as the paper states them, for a batch of one."""

    def __init__(self, config, tensors):
        super().__init__()
        self.c = config
        for name, value in tensors.items():
            self.register_buffer(name.replace(".", "_"), value)

    def t(self, name):
        return getattr(self, name.replace(".", "_"))

    def linear(self, x, stem):
        bias = getattr(self, f"{stem}.bias".replace(".", "_"), None)
        return F.linear(x, self.t(f"{stem}.weight"), bias)

    def norm(self, x, stem):
        return F.layer_norm(x, x.shape[-1:], self.t(f"{stem}.weight"), self.t(f"{stem}.bias"))

    def forward(self, x):
        c, d, heads = self.c["channels"], self.c["d_model"], self.c["heads"]
        tokens = F.linear(x[:, -self.c["t_short"] :], self.t("short.embed.weight"))
        tokens = torch.cat([tokens + self.t("short.identity"), self.t("short.global")[None]])
        for layer in range(self.c["layers"]):
            stem = f"short.layer.{layer}"
            qkv = self.linear(self.norm(tokens, f"{stem}.norm"), f"{stem}.qkv")
            q, k, v = qkv.reshape(c + 1, 3, heads, d // heads).permute(1, 2, 0, 3)
            mixed = torch.softmax(q @ k.transpose(1, 2) / math.sqrt(d // heads), -1) @ v
            tokens = tokens + self.linear(mixed.permute(1, 0, 2).reshape(c + 1, d), f"{stem}.out")
        memory = self.linear(F.gelu(self.linear(x, "long.hidden")), "long.out")
        memory = memory + self.t("long.identity")
        q = self.linear(self.norm(tokens[c:], "cross.norm"), "cross.query")
        scores = q @ self.linear(memory, "cross.key").T / math.sqrt(self.c["d_k"])
        regime = torch.softmax(scores, -1) @ self.linear(memory, "cross.value")
        encoded = torch.cat([tokens[:c], self.linear(regime, "cross.lift")])
        hidden = F.gelu(self.linear(self.norm(encoded, "decoder.norm"), "decoder.ffn.hidden"))
        y = encoded + self.linear(hidden, "decoder.ffn.out")
        pooled = torch.cat([y[:c].mean(0), y[c]])
        hidden = F.gelu(self.linear(pooled, "decoder.readout.hidden"))
        residual = self.linear(hidden, "decoder.readout.out")
        if self.c.get("t_skip", 0):
            residual = residual + self.linear(x[:, -self.c["t_skip"] :].reshape(-1), "skip")
        return residual, regime[0]


def onnx_session(model, x, path):
    torch.onnx.export(
        model, (x,), str(path), input_names=["x"], output_names=["residual", "regime"],
        opset_version=20, dynamo=False,
    )
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.graph_optimization_level = onnxruntime.GraphOptimizationLevel.ORT_ENABLE_ALL
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


class Twin:
    def __init__(self, path, arithmetic):
        command = [*BENCH, "--serve", str(path), arithmetic]
        self.child = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def ask(self, line):
        self.child.stdin.write(line + "\n")
        self.child.stdin.flush()
        return json.loads(self.child.stdout.readline())

    def close(self):
        self.child.stdin.close()
        self.child.wait()


def timed(call):
    times = []
    for _ in range(CALLS):
        start = time.perf_counter()
        call()
        times.append((time.perf_counter() - start) * 1e3)
    return times


def compare(folder, size, arithmetics):
    path = folder / f"{size}.safetensors"
    config, tensors = read(path)
    x = np.frombuffer((folder / f"{size}.input").read_bytes(), dtype="<f4")
    x = x.reshape(config["channels"], config["t_long"]).copy()
    model, tensor = Fdt(config, tensors).eval(), torch.from_numpy(x)
    with torch.inference_mode():
        wanted = [part.numpy() for part in model(tensor)]
    session = onnx_session(model, tensor, folder / f"{size}.onnx")
    twins = {f"twin {name}": Twin(path, name) for name in arithmetics}

    def eager():
        with torch.inference_mode():
            model(tensor)

    runs = {"PyTorch eager": lambda: timed(eager)}
    runs["ONNX Runtime"] = lambda: timed(lambda: session.run(None, {"x": x}))
    runs |= {name: lambda twin=twin: twin.ask(f"run {CALLS}") for name, twin in twins.items()}
    answers = {"ONNX Runtime": session.run(None, {"x": x})}
    for name, twin in twins.items():
        answer = twin.ask("forward")
        answers[name] = [np.array(answer["residual"]), np.array(answer["regime"])]
    for name, parts in answers.items():
        worst = [np.abs(a - b).max() / np.abs(b).max() for a, b in zip(parts, wanted)]
        print(f"{size:6} {name:20} differs from PyTorch by {worst[0]:.1e} (r), {worst[1]:.1e} (g')")
    times = {name: [] for name in runs}
    for turn in range(ROUNDS + 2):
        for name, run in runs.items():
            measured = run()
            times[name] += measured if turn >= 2 else []
    base = np.median(times["ONNX Runtime"])
    for name, measured in times.items():
        p50, p99 = np.percentile(measured, [50, 99])
        print(
            f"{size:6} {name:20} min {min(measured):7.4f}  p50 {p50:7.4f}  p99 {p99:7.4f} ms"
            f"  ONNX Runtime / it {base / p50:5.2f}"
        )
    for twin in twins.values():
        twin.close()


def main():
    torch.set_num_threads(1)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})
    arithmetics = sys.argv[1:] or ["best"]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([*BENCH, "--write", str(folder)], check=True)
        for size in ("small", "paper"):
            compare(folder, size, arithmetics)


if __name__ == "__main__":
    main()
