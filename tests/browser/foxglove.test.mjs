// One flight seen through Foxglove's own client library: topics, telemetry tick by tick, a gain set as a parameter, and the URDF.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import path from "node:path";
import { after, before, test } from "node:test";
import foxglove from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { freePort, ROOT, startTwin, until } from "./harness.mjs";

const SCENARIO = "scenarios/hover.toml";
const SOON = 30_000;
const LIMIT = { timeout: 120_000 };
/** Nanoseconds between two ticks. */
const TICK_NS = 10_000_000n;

let twin;
let client;
const heard = { info: null, channels: [], messages: [], parameters: [], times: [], assets: new Map(), errors: [] };

before(async () => {
  const port = await freePort();
  twin = await startTwin(SCENARIO, await freePort(), ["--foxglove-port", String(port), "--set", "task.duration_s=3600", "--set", "time_limit_s=3600"]);
  // The library's messages fit the current protocol, whose name the test gives here.
  const ws = new WebSocket(`ws://127.0.0.1:${port}`, ["foxglove.sdk.v1"]);
  client = new foxglove.FoxgloveClient({ ws });
  client.on("serverInfo", (info) => (heard.info = info));
  client.on("advertise", (channels) => heard.channels.push(...channels));
  client.on("message", (message) => heard.messages.push(message));
  client.on("parameterValues", (values) => heard.parameters.push(values));
  client.on("time", ({ timestamp }) => heard.times.push(timestamp));
  client.on("fetchAssetResponse", (answer) => heard.assets.set(answer.requestId, answer));
  client.on("error", (error) => heard.errors.push(error.message));
  await until(() => heard.info && heard.channels.some(({ topic }) => topic === "/twin/telemetry"), SOON, () => `topics: ${heard.errors}`);
}, LIMIT);

after(async () => {
  client?.close();
  await twin?.stop();
});

test("telemetry arrives tick by tick with the flight's own time, as its schema says", LIMIT, async () => {
  for (const capability of ["parameters", "parametersSubscribe", "time", "assets"]) {
    assert.ok(heard.info.capabilities.includes(capability), `${heard.info.capabilities}`);
  }
  const channel = heard.channels.find(({ topic }) => topic === "/twin/telemetry");
  const subscription = client.subscribe(channel.id);
  await until(() => heard.messages.length > 100, SOON, "a second of telemetry");
  client.unsubscribe(subscription);
  const rows = heard.messages.filter(({ subscriptionId }) => subscriptionId === subscription);
  for (let k = 1; k < rows.length; k++) assert.equal(rows[k].timestamp - rows[k - 1].timestamp, TICK_NS);
  const { properties } = JSON.parse(channel.schema);
  const row = JSON.parse(new TextDecoder().decode(rows.at(-1).data));
  assert.deepEqual(Object.keys(row), Object.keys(properties));
  assert.ok(Math.abs(row.t_s * 1e9 - Number(rows.at(-1).timestamp)) < 1);
  assert.ok(heard.times.length > 10 && heard.times.every((time, k) => k === 0 || time > heard.times[k - 1]));
});

test("a gain set as a parameter is answered, in force, and told to who subscribed", LIMIT, async () => {
  client.subscribeParameterUpdates(["slope.x"]);
  client.setParameters([{ name: "slope.x", value: 1.5, type: "float64" }], "set");
  const of = (id) => heard.parameters.find((values) => values.id === id)?.parameters[0];
  const answer = await until(() => of("set"), SOON, "an answer");
  assert.deepEqual([answer.name, answer.value], ["slope.x", 1.5]);
  const { gains } = await until(async () => {
    const list = await (await fetch(`${twin.url}/api/gains`)).json();
    return list.gains.find(({ name }) => name === "slope.x").value === 1.5 && list;
  }, SOON, "the gain is in force");
  await until(() => heard.parameters.some(({ id, parameters }) => id === undefined && parameters.some(({ name, value }) => name === "slope.x" && value === 1.5)), SOON, "an echo without a request");
  client.getParameters([], "all");
  const all = await until(() => heard.parameters.find(({ id }) => id === "all"), SOON, "all gains");
  const values = (list) => list.map(({ name, value }) => [name, value]).sort();
  assert.deepEqual(values(all.parameters), values(gains));
});

test("the URDF is fetched byte for byte, and nothing else complained", LIMIT, async () => {
  client.fetchAsset("package://twin/vehicle.urdf", 11);
  const { data } = await until(() => heard.assets.get(11), SOON, "the file");
  const wanted = readFileSync(path.join(ROOT, "urdf", "aerial_manipulator.urdf"));
  assert.deepEqual(Buffer.from(data.buffer, data.byteOffset, data.byteLength), wanted);
  client.fetchAsset("package://twin/../Cargo.toml", 12);
  assert.match((await until(() => heard.assets.get(12), SOON, "a refusal")).error, /no asset/);
  assert.deepEqual(heard.errors, []);
});
