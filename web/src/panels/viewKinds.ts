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
  { kind: "thrust", label: "Thrust of each rotor", brief: "rotor thrust", help: "Along the body's z axis at each hub.", key: "Shift+T", mark: "thrust" },
  { kind: "total_thrust", label: "Total thrust", brief: "thrust", help: "Sum of the rotors, along the body's z axis.", key: "Shift+Y", mark: "thrust" },
  { kind: "estimate", label: "Residual estimate r̂", brief: "r̂ with weight", help: "Force the loop adds because the nominal model lacks it: x, y, z of r̂ in force, in the world. It holds the weight up, so it points up even in still air.", key: "Shift+E", mark: "estimate" },
  { kind: "adapter", label: "Adapter’s share r̂ − base", brief: "r̂ − base", help: "What the online adapter adds to the network's forecast: both as of this tick, so the constant weight drops out where the forecast holds it.", key: "Shift+S", mark: "adapter" },
  { kind: "wind", label: "Wind", brief: "wind", help: "True wind at the vehicle, where the simulation knows it; the arrows stand upwind.", key: "Shift+W", mark: "third" },
];

export const FRAME_KINDS: KindInfo[] = [
  { kind: "world", label: "World", help: "Origin of the world." },
  { kind: "body", label: "Body", help: "The vehicle's root: x forward, y left, z up." },
  { kind: "links", label: "Links", help: "Frames of the arm's links and the fingers." },
  { kind: "tool", label: "Tool", help: "The grasp point." },
  { kind: "payload", label: "Payload", help: "The cube's centre." },
];

export const MARK_KINDS: KindInfo[] = [
  { kind: "trail", label: "Way flown", brief: "flown", help: "Way of the vehicle's root; older is fainter.", key: "Shift+L", mark: "estimate" },
  { kind: "reference_trail", label: "Way of the reference", brief: "reference", help: "Where the vehicle's root was meant to be.", key: "Shift+D", mark: "setpoint dashed" },
  { kind: "ghost", label: "Ghost of the reference", help: "The root of the vehicle where it is meant to be now; the reference of the arm is not sent.", key: "Shift+G" },
];
