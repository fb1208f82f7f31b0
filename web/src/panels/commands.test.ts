import { describe, expect, it } from "vitest";
import { capsOf, chordOf, type Pressed } from "./chord";
import { type Command, Commands } from "./commands";

const pressed = (key: string, more: Partial<Pressed> = {}): Pressed => ({ key, code: "", ctrlKey: false, metaKey: false, shiftKey: false, altKey: false, ...more });
const command = (id: string, keys: string[], more: Partial<Command> = {}): Command => ({ id, group: "g", description: id, keys, action: () => {}, ...more });

describe("chordOf", () => {
  it("names modifiers in one order and letters as printed", () => {
    expect(chordOf(pressed(" "))).toBe("Space");
    expect(chordOf(pressed("z", { ctrlKey: true, code: "KeyY" }))).toBe("Ctrl+Z");
    expect(chordOf(pressed("Z", { ctrlKey: true, shiftKey: true }))).toBe("Ctrl+Shift+Z");
    expect(chordOf(pressed("k", { metaKey: true }))).toBe("Ctrl+K");
    expect(chordOf(pressed("ArrowRight", { ctrlKey: true }))).toBe("Ctrl+ArrowRight");
  });

  it("gives a sign no Shift, and a letter without Latin print its place", () => {
    expect(chordOf(pressed("?", { shiftKey: true }))).toBe("?");
    expect(chordOf(pressed("м", { code: "KeyV" }))).toBe("V");
  });

  it("shows caps", () => {
    expect(capsOf("Ctrl+ArrowRight")).toEqual(["Ctrl", "→"]);
    expect(capsOf("?")).toEqual(["?"]);
    expect(capsOf("+")).toEqual(["+"]);
  });
});

describe("Commands", () => {
  it("finds the newest command that applies, and falls back to the older one", () => {
    const list = new Commands();
    let inspecting = true;
    list.register(command("step", ["ArrowRight"]));
    list.register(command("seek", ["ArrowRight"], { when: () => inspecting }));
    expect(list.find("ArrowRight")?.id).toBe("seek");
    inspecting = false;
    expect(list.find("ArrowRight")?.id).toBe("step");
    expect(list.find("ArrowLeft")).toBeUndefined();
  });

  it("forgets what was taken away, and replaces by id", () => {
    const list = new Commands();
    const away = list.register(command("a", ["A"]), command("b", ["B"]));
    list.register(command("a", ["X"]));
    expect(list.list().map(({ id, keys }) => `${id}${keys.join("")}`)).toEqual(["aX", "bB"]);
    away();
    expect(list.list()).toEqual([]);
  });

  it("groups under headings in order of registration", () => {
    const list = new Commands();
    list.register(command("a", [], { group: "Flight" }), command("b", [], { group: "Page" }), command("c", [], { group: "Flight" }));
    expect([...list.groups()].map(([group, all]) => [group, ...all.map(({ id }) => id)])).toEqual([["Flight", "a", "c"], ["Page", "b"]]);
  });
});
