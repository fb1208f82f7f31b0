// Messages of the `/ws` endpoint, protocol version 1. Text frames carry one of these as JSON; telemetry is binary
// (link/decode.ts). Lengths in m, angles in rad, times in s of simulated time, quaternions [w, x, y, z].

export type Vec3 = [number, number, number];
export type Quaternion = [number, number, number, number];

export type Shape =
  | { kind: "box"; size_m: Vec3 }
  | { kind: "cylinder"; radius_m: number; length_m: number }
  | { kind: "sphere"; radius_m: number }
  | { kind: "capsule"; radius_m: number; length_m: number }
  | { kind: "mesh"; vertices: Vec3[]; triangles: Vec3[] };

export interface PoseInfo {
  position: Vec3;
  quaternion_wxyz: Quaternion;
}

export interface ShapeInfo extends PoseInfo {
  shape: Shape;
  rgba: [number, number, number, number];
}

export interface SceneBody {
  name: string;
  moving: boolean;
  pose: PoseInfo;
  group: "vehicle" | "arena" | "payload";
  shapes: ShapeInfo[];
}

export interface RotorInfo {
  position_in_body: Vec3;
  radius_m: number;
  spin: number;
}

export interface SceneInfo {
  bodies: SceneBody[];
  rotors: RotorInfo[];
  base_body: string;
}

export interface ChannelInfo {
  name: string;
  label: string;
  group: string;
  unit: string;
  row: string | null;
}

export interface GainInfo {
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
}

export interface StateInfo {
  phase: "flying" | "paused" | "ended";
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
}

export interface EventInfo {
  tick: number;
  t_s: number;
  kind: string;
  text: string;
}

export interface ScenarioInfo {
  name: string;
  title: string;
}

export interface Hello {
  protocol: number;
  schema_id: number;
  client_id: number;
  scenario: string;
  scenarios: ScenarioInfo[];
  tick_s: number;
  scene: SceneInfo;
  channels: ChannelInfo[];
  gains: GainInfo[];
  preset: string;
  state: StateInfo;
  events: EventInfo[];
}

export type ServerMessage =
  | ({ type: "hello" } & Hello)
  | ({ type: "state" } & StateInfo)
  | { type: "gain"; name: string; value: number; tick: number; preset: string; preset_value?: number }
  | { type: "events"; events: EventInfo[] }
  | { type: "notice"; level: "info" | "warning" | "error"; text: string }
  | { type: "pong"; t: number; t_s: number }
  | { type: "reset" };

export type ClientMessage =
  | { type: "set_gain"; name: string; value: number }
  | { type: "preset"; name: string }
  | { type: "pause"; paused: boolean }
  | { type: "step"; ticks: number }
  | { type: "speed"; value: number | null }
  | { type: "restart"; seed: number | null; scenario: string | null }
  | { type: "ping"; t: number };
