// The kinds of things that the 3-D view can show: names, keys and colours, in the order of the list and of the legend.
import type { ViewKind } from "../scene/settings";

export interface KindInfo {
  kind: ViewKind;
  /** Name in the list. */
  label: string;
  /** Name in the legend; a kind that needs no explanation has none. */
  brief?: string;
  /** Help that appears when the operator points at the name. */
  help: string;
  key?: string;
  /** CSS class of the line in the legend. */
  mark?: string;
}

export const ARROW_KINDS: KindInfo[] = [
  { kind: "contact", label: "Contact forces", brief: "contact", help: "Force at each contact point; its length grows with the root of the force.", key: "Shift+C", mark: "force" },
  { kind: "thrust", label: "Thrust of each rotor", brief: "rotor thrust", help: "Thrust at each hub, along the body's z axis.", key: "Shift+T", mark: "thrust" },
  { kind: "total_thrust", label: "Total thrust", brief: "thrust", help: "Sum of the thrusts of all rotors, along the body's z axis.", key: "Shift+Y", mark: "thrust" },
  { kind: "estimate", label: "Residual estimate r̂", brief: "r̂ with weight", help: "Force that the loop adds to the nominal model: x, y, z of the r̂ in force, in the world. It carries weight, so it points up even in still air.", key: "Shift+E", mark: "estimate" },
  { kind: "adapter", label: "Adapter’s share r̂ − base", brief: "r̂ − base", help: "Force that the online adapter adds to the network's forecast of the same tick. The constant weight drops out if the forecast contains it.", key: "Shift+S", mark: "adapter" },
  { kind: "wind", label: "Wind", brief: "wind", help: "True wind at the vehicle, if the simulation knows it. The arrows stand upwind.", key: "Shift+W", mark: "third" },
];

export const FRAME_KINDS: KindInfo[] = [
  { kind: "world", label: "World", help: "The origin of the world." },
  { kind: "body", label: "Body", help: "The vehicle's root: x forward, y left, z up." },
  { kind: "links", label: "Links", help: "Frames of the arm's links and the fingers." },
  { kind: "tool", label: "Tool", help: "The grasp point." },
  { kind: "payload", label: "Payload", help: "The cube's centre." },
];

export const MARK_KINDS: KindInfo[] = [
  { kind: "trail", label: "Flown path", brief: "flown", help: "Path of the vehicle's root; older parts are fainter.", key: "Shift+L", mark: "estimate" },
  { kind: "reference_trail", label: "Reference path", brief: "reference", help: "Path of the reference of the vehicle's root.", key: "Shift+D", mark: "setpoint dashed" },
  { kind: "ghost", label: "Ghost of the reference", help: "The vehicle's root at its reference. Telemetry has no reference of the arm.", key: "Shift+G" },
];
