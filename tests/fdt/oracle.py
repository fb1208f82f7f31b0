"""The forward pass of the Factorized Dynamics Transformer in double precision, written from its equations.

Reads FOLDER/{case}.safetensors and FOLDER/{case}.input (f32, [channels, t_long]) for case in 0..N, and writes the results to
FOLDER/{case}.json: residual [(k + 1) * outputs], regime [d_k], attention [channels].
"""

import json
import math
import pathlib
import struct
import sys

import numpy as np

erf = np.vectorize(math.erf)


def read(path):
    data = path.read_bytes()
    (size,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + size])
    head = json.loads(header.pop("__metadata__")["twin"])
    tensors = {}
    for name, info in header.items():
        begin, end = info["data_offsets"]
        values = np.frombuffer(data[8 + size + begin : 8 + size + end], dtype="<f4")
        tensors[name] = values.reshape(info["shape"]).astype(np.float64)
    return head, tensors


def gelu(x):
    return 0.5 * x * (1.0 + erf(x / math.sqrt(2.0)))


def softmax(x):
    e = np.exp(x - x.max(axis=-1, keepdims=True))
    return e / e.sum(axis=-1, keepdims=True)


def layer_norm(x, t, stem):
    centred = x - x.mean(axis=-1, keepdims=True)
    variance = (centred**2).mean(axis=-1, keepdims=True)
    return centred / np.sqrt(variance + 1e-5) * t[stem + ".weight"] + t[stem + ".bias"]


def linear(x, t, stem):
    y = x @ t[stem + ".weight"].T
    return y + t[stem + ".bias"] if stem + ".bias" in t else y


def attend(x, t, stem, heads):
    q, k, v = np.split(linear(layer_norm(x, t, stem + ".norm"), t, stem + ".qkv"), 3, axis=-1)
    width = x.shape[1] // heads
    split = lambda m: m.reshape(len(m), heads, width).transpose(1, 0, 2)
    weights = softmax(split(q) @ split(k).transpose(0, 2, 1) / math.sqrt(width))
    mixed = (weights @ split(v)).transpose(1, 0, 2).reshape(x.shape)
    return x + linear(mixed, t, stem + ".out")


def forward(config, t, x):
    c, d = config["channels"], config["d_model"]
    tokens = np.zeros((0, d))
    if config["short_horizon"]:
        tokens = x[:, -config["t_short"] :] @ t["short.embed.weight"].T + t["short.identity"]
        if config["global_token"]:
            tokens = np.vstack([tokens, t["short.global"]])
        for layer in range(config["layers"]):
            tokens = attend(tokens, t, f"short.layer.{layer}", config["heads"])
        asks = tokens[c] if config["global_token"] else tokens.mean(axis=0)
    else:
        asks = t["short.global"]
    asks = layer_norm(asks, t, "cross.norm")
    attention = np.zeros(0)
    if config["long_memory"]:
        memory = linear(gelu(linear(x, t, "long.hidden")), t, "long.out") + t["long.identity"]
        scores = linear(memory, t, "cross.key") @ linear(asks, t, "cross.query")
        attention = softmax(scores / math.sqrt(config["d_k"]))
        regime = attention @ linear(memory, t, "cross.value")
    else:
        regime = linear(asks, t, "cross.value")
    encoded = np.vstack([tokens[:c], linear(regime, t, "cross.lift")])
    hidden = gelu(linear(layer_norm(encoded, t, "decoder.norm"), t, "decoder.ffn.hidden"))
    y = encoded + linear(hidden, t, "decoder.ffn.out")
    pooled = y[:-1].mean(axis=0) if len(y) > 1 else np.zeros(d)
    hidden = gelu(linear(np.concatenate([pooled, y[-1]]), t, "decoder.readout.hidden"))
    residual = linear(hidden, t, "decoder.readout.out")
    if config.get("t_skip", 0):
        residual = residual + linear(x[:, -config["t_skip"] :].reshape(-1), t, "skip")
    return residual, regime, attention


def main():
    folder, cases = pathlib.Path(sys.argv[1]), int(sys.argv[2])
    for case in range(cases):
        head, tensors = read(folder / f"{case}.safetensors")
        config = head["config"]
        x = np.frombuffer((folder / f"{case}.input").read_bytes(), dtype="<f4").astype(np.float64)
        x = x.reshape(config["channels"], config["t_long"])
        residual, regime, attention = forward(config, tensors, x)
        answer = {"residual": residual, "regime": regime, "attention": attention}
        text = json.dumps({name: values.tolist() for name, values in answer.items()})
        (folder / f"{case}.json").write_text(text)


if __name__ == "__main__":
    main()
