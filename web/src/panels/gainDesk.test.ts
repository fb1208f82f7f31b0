import { beforeEach, describe, expect, it } from "vitest";
import type { ClientMessage, GainInfo, Hello } from "../protocol";
import { GainDesk } from "./gainDesk";

const gain = (name: string, value: number): GainInfo => ({ name, label: name.toUpperCase(), group: "g", unit: "", help: "", min: 0, max: 10, step: 0.1, value, preset_value: value });

let desk: GainDesk;
let sent: ClientMessage[];
let now: number;

beforeEach(() => {
  sent = [];
  now = 0;
  desk = new GainDesk((message) => sent.push(message), () => now);
  desk.rebuild({ gains: [gain("a", 1), gain("b", 2)], preset: "tuned" } as unknown as Hello);
});

const echo = (name: string, value: number, tick = 7): boolean => desk.echo({ name, value, tick, preset: "custom" });

describe("GainDesk", () => {
  it("tells its own echoes from those of others", () => {
    desk.request("a", 5);
    expect(echo("a", 5)).toBe(true);
    expect(echo("a", 6)).toBe(false);
    expect(desk.last).toEqual({ text: "A = 6", tick: 7, own: false });
    now = 60_000;
    expect(echo("a", 5)).toBe(false);
  });

  it("keeps the tick at which each value took effect, for this flight alone", () => {
    desk.request("a", 5);
    echo("a", 5, 123);
    expect([desk.model.tickOf("a"), desk.model.tickOf("b")]).toEqual([123, undefined]);
    desk.rebuild({ gains: [gain("a", 5), gain("b", 2)], preset: "custom" } as unknown as Hello);
    expect(desk.model.tickOf("a")).toBeUndefined();
  });

  it("makes several gains one step of the history, with the tick of the last", () => {
    desk.apply([{ name: "a", value: 3 }, { name: "b", value: 4 }], "set A");
    expect(sent.length).toBe(2);
    echo("a", 3, 10);
    expect(desk.model.history()).toEqual([]);
    echo("b", 4, 11);
    expect(desk.model.history()).toEqual([{ text: "set A", tick: 11, undone: false }]);
    desk.undo();
    expect(sent.slice(2)).toEqual([{ type: "set_gain", name: "a", value: 1 }, { type: "set_gain", name: "b", value: 2 }]);
  });

  it("remembers what came through when the rest is refused or stays away", () => {
    desk.apply([{ name: "a", value: 3 }, { name: "b", value: 99 }]);
    echo("a", 3);
    desk.refused();
    expect(desk.model.history().map(({ text }) => text)).toEqual(["A 1 → 3"]);
    desk.apply([{ name: "b", value: 5 }]);
    now = 10_000;
    desk.overdue();
    expect(desk.model.history().length).toBe(1);
  });

  it("starts from what is on its way when several gains are asked for before the last answer", () => {
    desk.apply([{ name: "a", value: 3 }, { name: "b", value: 4 }], "set A");
    echo("a", 3);
    expect(desk.expected()).toEqual([{ name: "a", value: 3 }, { name: "b", value: 4 }]);
    desk.apply([{ name: "a", value: 1 }, { name: "b", value: 2 }], "set B");
    expect(sent.slice(2)).toEqual([{ type: "set_gain", name: "a", value: 1 }, { type: "set_gain", name: "b", value: 2 }]);
    echo("b", 4);
    echo("a", 1);
    echo("b", 2);
    expect(desk.model.history().map(({ text }) => text)).toEqual(["set A", "set B"]);
    expect(desk.expected().map(({ value }) => value)).toEqual([1, 2]);
  });

  it("asks for nothing that is in force already", () => {
    desk.apply([{ name: "a", value: 1 }]);
    expect(sent).toEqual([]);
  });

  it("makes a preset one step that is taken back as a preset", () => {
    desk.choosePreset("paper");
    expect(echo("a", 8)).toBe(true);
    desk.replace({ gains: [gain("a", 8), gain("b", 2)], preset: "paper", tick: 20 });
    expect(desk.model.history()).toEqual([{ text: "preset paper", tick: 20, undone: false }]);
    desk.undo();
    expect(sent.at(-1)).toEqual({ type: "preset", name: "tuned" });
    expect(echo("a", 1)).toBe(true);
  });

  it("goes to any step of the history and back", () => {
    for (const value of [3, 4, 5]) {
      desk.apply([{ name: "a", value }]);
      echo("a", value);
    }
    sent = [];
    desk.goTo(1);
    expect(sent.map((message) => (message.type === "set_gain" ? message.value : NaN))).toEqual([4, 3]);
    expect(desk.model.history().map(({ text, undone }) => [text, undone])).toEqual([["A 1 → 3", false], ["A 3 → 4", true], ["A 4 → 5", true]]);
    sent = [];
    desk.goTo(3);
    expect(sent.map((message) => (message.type === "set_gain" ? message.value : NaN))).toEqual([4, 5]);
  });
});
