// The interface of the panels in the column: charts over time, and the bars of the spectrum.
import type { Frame } from "./frame";
import type { Bounds } from "./range";
import type { ChartSpec } from "./spec";

export interface SeriesReading {
  channel: string;
  label: string;
  value: number;
  /** Smallest and largest value drawn; null if there is none. */
  plotted: Bounds | null;
  /** Number of points at which the line is broken. */
  breaks: number;
}

/** The parts of a panel that an exported picture shows. */
export interface Picture {
  title: string;
  entries: { label: string; text: string; color: string; dash: number[] }[];
  canvas: HTMLCanvasElement;
}

export interface Panel {
  readonly spec: ChartSpec;
  readonly root: HTMLElement;
  /** The element over which the pointer moves the shared cursor; null if the panel has no time axis. */
  readonly over: HTMLElement | null;
  /** Whether the panel is on the screen, so that it must be drawn. */
  visible: boolean;
  /** The last round in which the panel was drawn. */
  round: number;
  refresh(frame: Frame): void;
  /** Puts the cursor at `time`; null hides it. */
  point(time: number | null): void;
  /** Writes the values at `time` into the heading; for null the newest values. */
  write(time: number | null, now: number): void;
  select(part: [number, number] | null): void;
  /** The lines as drawn, and their values at `time`; for null the newest values. */
  readings(time: number | null): SeriesReading[];
  sentence(time: number | null): string;
  picture(): Picture;
  destroy(): void;
}
