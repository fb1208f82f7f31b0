// What the column asks of anything it stacks: charts over time, and the bars of the spectrum.
import type { Frame } from "./frame";
import type { Bounds } from "./range";
import type { ChartSpec } from "./spec";

export interface SeriesReading {
  channel: string;
  label: string;
  value: number;
  /** Smallest and largest value drawn; null for none. */
  plotted: Bounds | null;
  /** Points at which the line is broken. */
  breaks: number;
}

/** What an exported picture shows of a panel. */
export interface Picture {
  title: string;
  entries: { label: string; text: string; color: string; dash: number[] }[];
  canvas: HTMLCanvasElement;
}

export interface Panel {
  readonly spec: ChartSpec;
  readonly root: HTMLElement;
  /** Where the pointer moves the shared cursor; null if it does not. */
  readonly over: HTMLElement | null;
  /** On the screen: worth drawing. */
  visible: boolean;
  /** Round it was drawn in last. */
  round: number;
  refresh(frame: Frame): void;
  /** Puts the cursor at `time`; null: none. */
  point(time: number | null): void;
  /** Writes the values at `time` into the heading, the newest for null. */
  write(time: number | null, now: number): void;
  select(part: [number, number] | null): void;
  /** What is drawn, and the values at `time`, the newest for null. */
  readings(time: number | null): SeriesReading[];
  sentence(time: number | null): string;
  picture(): Picture;
  destroy(): void;
}
