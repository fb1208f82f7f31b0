// Generated from twin/console/src/server/protocol.rs and twin/record/src/scene.rs; do not edit.
// Refresh: TWIN_UPDATE=1 cargo test --release protocol_ts

export const PROTOCOL_VERSION = 2;

/**
 * What the server says.
 */
export type ServerMessage = { "type": "hello" } & Hello | { "type": "state" } & StateInfo | { "type": "gain" } & GainEcho | { "type": "gains" } & GainList | { "type": "events", 
/**
 * In the order they happened.
 */
events: Array<EventInfo>, } | { "type": "forks", 
/**
 * In the order in which they were asked for.
 */
forks: Array<ForkInfo>, } | { "type": "notice" } & Notice | { "type": "pong", 
/**
 * The number sent.
 */
t: number, 
/**
 * Simulated time, s.
 */
t_s: number, } | { "type": "reset", };

/**
 * What a client may ask.
 */
export type ClientMessage = { "type": "set_gain", 
/**
 * Name of the gain.
 */
name: string, 
/**
 * New value, in the unit of the gain.
 */
value: number, } | { "type": "preset", 
/**
 * The preset; `custom` is refused.
 */
name: PresetName, } | { "type": "pause", 
/**
 * Stop or resume.
 */
paused: boolean, } | { "type": "step", 
/**
 * How many.
 */
ticks: number, } | { "type": "speed", 
/**
 * Factor.
 */
value: number | null, } | { "type": "restart", 
/**
 * Seed; `null` keeps the one in use.
 */
seed: number | null, 
/**
 * Name out of `hello.scenarios`; `null` keeps the one in use.
 */
scenario: string | null, } | { "type": "ping", 
/**
 * Any number; it comes back.
 */
t: number, } | { "type": "seek", 
/**
 * Time of the recording, s; beyond its ends the end is meant.
 */
t_s: number, } | { "type": "fork", 
/**
 * Tick before which the copy begins; `null` is the next tick of the flight.
 */
tick: number | null, 
/**
 * Keys that change, `key=value` each, as in a scenario; none leaves everything as it is.
 */
set: Array<string>, 
/**
 * For people; empty takes a number.
 */
name: string, } | { "type": "name_fork", 
/**
 * Its identifier.
 */
id: number, 
/**
 * For people.
 */
name: string, } | { "type": "drop_fork", 
/**
 * Its identifier.
 */
id: number, } | { "type": "disturb", 
/**
 * What to change.
 */
disturbance: Disturbance, };

/**
 * The form of a [`Disturbance`] for the generator of protocol.ts.
 */
export type Disturbance = { "kind": "payload_mass", 
/**
 * kg.
 */
kg: number, } | { "kind": "wind", 
/**
 * m/s.
 */
velocity_m_s: [number, number, number], } | { "kind": "push", 
/**
 * N, in the world.
 */
force_n: [number, number, number], 
/**
 * s.
 */
duration_s: number, } | { "kind": "drop_payload" } | { "kind": "effect", 
/**
 * Name of the effect.
 */
name: string, 
/**
 * In force or not.
 */
on: boolean, };

/**
 * Everything a client needs to start from nothing.
 */
export type Hello = { 
/**
 * [`PROTOCOL_VERSION`].
 */
protocol: number, 
/**
 * Which telemetry rows fit these channels and bodies; frames of another id are to be ignored.
 */
schema_id: number, 
/**
 * Number of this client.
 */
client_id: number, 
/**
 * Name of the scenario in flight.
 */
scenario: string, 
/**
 * Scenarios that `restart` accepts.
 */
scenarios: Array<ScenarioInfo>, 
/**
 * Period of a tick, s.
 */
tick_s: number, 
/**
 * How far the predictor looks into the future, ticks. The channels `fan_*` are known up to there.
 */
horizon_ticks: number, 
/**
 * Ranges of the numbers that messages carry; those of gains stand with the gains.
 */
quantities: Array<QuantityInfo>, 
/**
 * Effects that a disturbance of kind `effect` may switch.
 */
effects: Array<string>, 
/**
 * The recording that is mirrored; `null` if a simulated vehicle flies.
 */
mirror: MirrorInfo | null, 
/**
 * What to draw.
 */
scene: Scene, 
/**
 * Channels in the order of a telemetry row.
 */
channels: Array<ChannelInfo>, 
/**
 * Values that `set_gain` accepts.
 */
gains: Array<GainInfo>, 
/**
 * Preset in force.
 */
preset: PresetName, 
/**
 * How the flight stands.
 */
state: StateInfo, 
/**
 * The last events, oldest first.
 */
events: Array<EventInfo>, 
/**
 * The forks of the flight.
 */
forks: Array<ForkInfo>, };

/**
 * A number that messages of a client carry, with what bounds it.
 */
export type QuantityInfo = { 
/**
 * Unique name, `payload_mass`.
 */
name: string, 
/**
 * Unit, empty if none.
 */
unit: string, 
/**
 * What it says, in a few words.
 */
help: string, 
/**
 * Smallest allowed value.
 */
min: number, 
/**
 * Largest allowed value.
 */
max: number, 
/**
 * Step of a slider.
 */
step: number, 
/**
 * The messages that carry it: type, kind of a disturbance, field.
 */
messages: Array<string>, };

/**
 * A real flight from a recording: the loop predicts and adapts beside it, and acts on nothing.
 */
export type MirrorInfo = { 
/**
 * Name of the file.
 */
file: string, 
/**
 * Name of the map that says which messages mean what.
 */
map: string, 
/**
 * Name of the vehicle.
 */
vehicle: string, 
/**
 * What is drawn instead of the vehicle's own shape, one sentence.
 */
stand_in: string, 
/**
 * What the ghost is, one sentence.
 */
ghost: string, 
/**
 * What predicts, one sentence.
 */
predictor: string, 
/**
 * Where the applied force comes from, one sentence.
 */
force: string, 
/**
 * Rows whose residual is never known; the channels of residual and estimates are NaN there.
 */
unknown_rows: Array<string>, 
/**
 * Ticks of the recording.
 */
ticks: number, 
/**
 * Time of the recording, s.
 */
duration_s: number, 
/**
 * It still goes on: ticks and time are those of now.
 */
live: boolean, 
/**
 * What was found wrong or left out, a sentence each.
 */
notes: Array<string>, 
/**
 * The mass is unknown, so that forces are per kilogram.
 */
per_kilogram: boolean, 
/**
 * The phases of the whole recording as events, oldest first; empty if they are not known before they are played.
 */
phases: Array<EventInfo>, };

/**
 * A scenario that can be flown.
 */
export type ScenarioInfo = { 
/**
 * Unique name.
 */
name: string, 
/**
 * For people.
 */
title: string, };

/**
 * One number of a telemetry row.
 */
export type ChannelInfo = { 
/**
 * Unique name, `residual.x`.
 */
name: string, 
/**
 * For people.
 */
label: string, 
/**
 * Group it is shown under.
 */
group: string, 
/**
 * Unit, empty if none.
 */
unit: string, 
/**
 * Coordinate it belongs to.
 */
row: string | null, 
/**
 * Smallest and largest value that the hardware allows, in the unit of the channel.
 */
limits: [number, number] | null, 
/**
 * Residuals divided by this are z-scores, in the unit of the channel.
 */
z_scale: number | null, 
/**
 * Known weight of the vehicle that is part of the value, in the unit of the channel; charts leave it out.
 */
weight: number | null, };

/**
 * One value an operator may change.
 */
export type GainInfo = { 
/**
 * Unique name, `slope.x`.
 */
name: string, 
/**
 * Symbol as in the paper.
 */
label: string, 
/**
 * Group it is shown under.
 */
group: string, 
/**
 * Unit, empty if none.
 */
unit: string, 
/**
 * What it does, one sentence.
 */
help: string, 
/**
 * Smallest allowed value.
 */
min: number, 
/**
 * Largest allowed value.
 */
max: number, 
/**
 * Step of a slider.
 */
step: number, 
/**
 * Value in force.
 */
value: number, 
/**
 * Value of the preset chosen last.
 */
preset_value: number, };

/**
 * A gain that took effect.
 */
export type GainEcho = { 
/**
 * Name of the gain.
 */
name: string, 
/**
 * Value in force.
 */
value: number, 
/**
 * First tick flown with it.
 */
tick: number, 
/**
 * Preset all values now agree with.
 */
preset: PresetName, };

/**
 * All gains.
 */
export type GainList = { 
/**
 * Every gain with its value in force.
 */
gains: Array<GainInfo>, 
/**
 * Preset all values agree with.
 */
preset: PresetName, 
/**
 * First tick flown with them.
 */
tick: number, };

/**
 * Name of a set of gains.
 */
export type PresetName = "literal" | "paper" | "tuned" | "custom";

/**
 * How the flight stands.
 */
export type StateInfo = { 
/**
 * Flying, paused or ended.
 */
phase: FlightPhase, 
/**
 * Simulated seconds per second that are asked for; `null` is as fast as the machine can.
 */
speed: number | null, 
/**
 * Name of the scenario.
 */
scenario: string, 
/**
 * Seed of the run.
 */
seed: number, 
/**
 * Ticks flown.
 */
tick: number, 
/**
 * Simulated time, s.
 */
t_s: number, 
/**
 * Phase of the task.
 */
task_phase: string, 
/**
 * Verdict of a flight that ended.
 */
verdict: string | null, 
/**
 * Its reason.
 */
reason: string | null, 
/**
 * Simulated seconds per second that are reached.
 */
real_time_factor: number, 
/**
 * Clients connected.
 */
clients: number, 
/**
 * Where the time of a tick goes.
 */
stages: Array<StageCost>, 
/**
 * Mass of the payload, kg; `null` without one.
 */
payload_kg: number | null, 
/**
 * Mean wind in the world, m/s.
 */
wind_m_s: [number, number, number], 
/**
 * Effects that are switched off.
 */
effects_off: Array<string>, 
/**
 * The twin that flew beside a mirrored recording until now; `null` if a simulated vehicle flies, and until the first tick after
 * a jump is flown.
 */
twin: TwinInfo | null, 
/**
 * How the newest recording stands; `null` if nothing is recorded.
 */
recording: RecordingStatus | null, };

/**
 * How far the twin is from a mirrored flight, having started from it some time ago under the commands that were recorded.
 */
export type TwinInfo = { 
/**
 * What flew, one sentence.
 */
says: string, 
/**
 * How long ago it started, s.
 */
horizon_s: number, 
/**
 * The worst axis; `null` where force or motion is unknown.
 */
light: Light | null, 
/**
 * Where the forecasts of the flight so far are better than persistence and than the mean, and where not, in words.
 */
gate: string, 
/**
 * Whether they are better at every step; `null` without a score.
 */
gate_passed: boolean | null, 
/**
 * Axes that are compared.
 */
axes: Array<TwinAxis>, };

/**
 * One axis of it, m or rad.
 */
export type TwinAxis = { 
/**
 * Name of the row.
 */
row: string, 
/**
 * Twin less flight.
 */
twin: number, 
/**
 * The same of the twin with the residual of the half second before it started.
 */
with_residual: number, 
/**
 * The same of what simply went on as it moved.
 */
coasting: number, };

/**
 * Verdict on the twin's prediction, relative to coasting and to the accuracy of the recording.
 */
export type Light = "valid" | "doubtful" | "invalid";

/**
 * What one stage of a tick costs.
 */
export type StageCost = { 
/**
 * Name of the stage.
 */
name: string, 
/**
 * Mean wall-clock time per tick since the state before, ms.
 */
ms: number, };

/**
 * Whether ticks are flown.
 */
export type FlightPhase = "flying" | "paused" | "ended";

/**
 * A fork of the flight.
 */
export type ForkInfo = { 
/**
 * Its identifier, which no other fork of this server has.
 */
id: number, 
/**
 * Its place among the colours, from 0; no other fork has it at the same time.
 */
slot: number, 
/**
 * For people.
 */
name: string, 
/**
 * Time of the flight before which it begins, s.
 */
at_s: number, 
/**
 * Keys that were to change, `key=value` each.
 */
set: Array<string>, 
/**
 * Keys that differ from the flight at that moment; empty until it flies.
 */
changed: Array<ForkChange>, 
/**
 * How far it is.
 */
state: ForkState, 
/**
 * Rows that `/api/forks/{id}/{from}` has.
 */
ticks: number, 
/**
 * Time up to which it has flown, s.
 */
flown_s: number, 
/**
 * How it ended; `null` until then, and for a fork that still flew after a minute.
 */
outcome: ForkOutcome | null, 
/**
 * Its metrics from the fork on, beside those of the flight as it would have gone on; empty until both are flown.
 */
metrics: Array<ForkMetric>, };

/**
 * How far a fork is.
 */
export type ForkState = "waiting" | "flying" | "flown" | "failed";

/**
 * The end of a fork.
 */
export type ForkOutcome = { 
/**
 * The verdict, one word.
 */
verdict: string, 
/**
 * Its reason, one sentence.
 */
reason: string, };

/**
 * A key that a fork changed.
 */
export type ForkChange = { 
/**
 * Dotted key.
 */
key: string, 
/**
 * Value before, as TOML.
 */
from: string, 
/**
 * Value of the fork, as TOML.
 */
to: string, };

/**
 * A metric of a fork and of the flight.
 */
export type ForkMetric = { 
/**
 * Name with its unit.
 */
metric: string, 
/**
 * Value of the fork.
 */
value: number | null, 
/**
 * Value of the flight.
 */
parent: number | null, 
/**
 * Fork minus flight.
 */
difference: number | null, 
/**
 * `better`, `worse`, `equal`, `in one only`, or empty if neither more nor less of it is better.
 */
judgement: string, };

/**
 * Something that happened.
 */
export type EventInfo = { 
/**
 * At which tick.
 */
tick: number, 
/**
 * At which simulated time, s.
 */
t_s: number, 
/**
 * What kind of thing.
 */
kind: string, 
/**
 * One sentence.
 */
text: string, };

/**
 * A word to one client.
 */
export type Notice = { 
/**
 * How serious.
 */
level: NoticeLevel, 
/**
 * One sentence.
 */
text: string, };

/**
 * How serious a notice is.
 */
export type NoticeLevel = "info" | "warning" | "error";

/**
 * How a recording stands.
 */
export type RecordingStatus = { 
/**
 * Path of the file.
 */
file: string, 
/**
 * Whether it goes on.
 */
state: RecordingState, 
/**
 * Bytes written.
 */
bytes: number, 
/**
 * Ticks that are safe in the file.
 */
ticks: number, 
/**
 * Ticks that are not, and never will be in the file.
 */
dropped_ticks: number, 
/**
 * Why it failed, and what to do; one sentence.
 */
error: string | null, 
/**
 * Why it may fail before the flight ends; one sentence.
 */
warning: string | null, };

/**
 * Whether a recording goes on.
 */
export type RecordingState = "recording" | "finished" | "failed";

/**
 * Everything there is to draw.
 */
export type Scene = { 
/**
 * Bodies; the moving ones are in the order of [`twin_core::tick::Truth::poses`].
 */
bodies: Array<SceneBody>, 
/**
 * Rotor discs of the vehicle, in rotor order.
 */
rotors: Array<SceneRotor>, 
/**
 * Name of the body that is the vehicle's root.
 */
base_body: string, };

/**
 * One body.
 */
export type SceneBody = { 
/**
 * Unique name.
 */
name: string, 
/**
 * Its pose changes from tick to tick.
 */
moving: boolean, 
/**
 * World pose at the start, and for good if it does not move, m.
 */
pose: ScenePose, 
/**
 * What the body belongs to.
 */
group: SceneGroup, 
/**
 * Shapes in the body's frame.
 */
shapes: Array<ShapeInfo>, };

/**
 * The form of a pose in the browser's protocol, m and `[w x y z]`.
 */
export type ScenePose = { position: [number, number, number], quaternion_wxyz: [number, number, number, number], };

/**
 * What a body belongs to.
 */
export type SceneGroup = "vehicle" | "arena" | "payload";

/**
 * One shape of a body.
 */
export type ShapeInfo = { 
/**
 * Form and size.
 */
shape: SceneShape, 
/**
 * Origin in the body's frame, m.
 */
position: [number, number, number], 
/**
 * Body-from-shape quaternion, `[w x y z]`.
 */
quaternion_wxyz: [number, number, number, number], 
/**
 * Colour and opacity, 0 to 1.
 */
rgba: [number, number, number, number], };

/**
 * A solid. Cylinders and capsules lie along z. All shapes but meshes are centred on their origin.
 */
export type SceneShape = { "kind": "box", 
/**
 * Full edge lengths along x, y, z, m.
 */
size_m: [number, number, number], } | { "kind": "cylinder", 
/**
 * Radius, m.
 */
radius_m: number, 
/**
 * Full length along z, m.
 */
length_m: number, } | { "kind": "sphere", 
/**
 * Radius, m.
 */
radius_m: number, } | { "kind": "capsule", 
/**
 * Radius, m.
 */
radius_m: number, 
/**
 * Length of the cylindrical part along z, m.
 */
length_m: number, } | { "kind": "mesh", 
/**
 * Corners, m.
 */
vertices: Array<[number, number, number]>, 
/**
 * Indices into `vertices`, counter-clockwise from outside.
 */
triangles: Array<[number, number, number]>, };

/**
 * One rotor disc.
 */
export type SceneRotor = { 
/**
 * Hub in the frame of the vehicle's root, m.
 */
position_in_body: [number, number, number], 
/**
 * Radius, m.
 */
radius_m: number, 
/**
 * 1: counter-clockwise seen from above, -1: clockwise.
 */
spin: number, };
