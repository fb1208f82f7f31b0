// Messages of the `/ws` endpoint. Text frames carry one of these as JSON; telemetry is binary (link/decode.ts).
// Lengths in m, angles in rad, times in s of simulated time, quaternions [w, x, y, z].

export const PROTOCOL_VERSION = 1;

export type ServerMessage =
  | ({ type: "hello" } & Hello)
  | ({ type: "state" } & StateInfo)
  | ({ type: "gain" } & GainEcho)
  | ({ type: "gains" } & GainList)
  | { type: "events"; events: Array<EventInfo> }
  | ({ type: "notice" } & Notice)
  | { type: "pong"; t: number; t_s: number }
  | { type: "reset" };

export type ClientMessage =
  | { type: "set_gain"; name: string; value: number }
  | { type: "preset"; name: PresetName }
  | { type: "pause"; paused: boolean }
  | { type: "step"; ticks: number }
  | { type: "speed"; value: number | null }
  | { type: "restart"; seed: number | null; scenario: string | null }
  | { type: "ping"; t: number };

export type Hello = {
  protocol: number;
  schema_id: number;
  client_id: number;
  scenario: string;
  scenarios: Array<ScenarioInfo>;
  tick_s: number;
  scene: Scene;
  channels: Array<ChannelInfo>;
  gains: Array<GainInfo>;
  preset: PresetName;
  state: StateInfo;
  events: Array<EventInfo>;
};

export type ScenarioInfo = { name: string; title: string };

export type ChannelInfo = { name: string; label: string; group: string; unit: string; row: string | null };

export type GainInfo = {
  name: string;
  label: string;
  group: string;
  unit: string;
  help: string;
  min: number;
  max: number;
  step: number;
  value: number;
  preset_value: number;
};

export type GainEcho = { name: string; value: number; tick: number; preset: PresetName };

export type GainList = { gains: Array<GainInfo>; preset: PresetName; tick: number };

export type PresetName = "literal" | "paper" | "tuned" | "custom";

export type StateInfo = {
  phase: FlightPhase;
  speed: number | null;
  scenario: string;
  seed: number;
  tick: number;
  t_s: number;
  task_phase: string;
  verdict: string | null;
  reason: string | null;
  real_time_factor: number;
  clients: number;
};

export type FlightPhase = "flying" | "paused" | "ended";

export type EventInfo = { tick: number; t_s: number; kind: string; text: string };

export type Notice = { level: NoticeLevel; text: string };

export type NoticeLevel = "info" | "warning" | "error";

export type Scene = { bodies: Array<SceneBody>; rotors: Array<SceneRotor>; base_body: string };

export type SceneBody = { name: string; moving: boolean; pose: ScenePose; group: SceneGroup; shapes: Array<ShapeInfo> };

export type ScenePose = { position: [number, number, number]; quaternion_wxyz: [number, number, number, number] };

export type SceneGroup = "vehicle" | "arena" | "payload";

export type ShapeInfo = {
  shape: SceneShape;
  position: [number, number, number];
  quaternion_wxyz: [number, number, number, number];
  rgba: [number, number, number, number];
};

export type SceneShape =
  | { kind: "box"; size_m: [number, number, number] }
  | { kind: "cylinder"; radius_m: number; length_m: number }
  | { kind: "sphere"; radius_m: number }
  | { kind: "capsule"; radius_m: number; length_m: number }
  | { kind: "mesh"; vertices: Array<[number, number, number]>; triangles: Array<[number, number, number]> };

export type SceneRotor = { position_in_body: [number, number, number]; radius_m: number; spin: number };
