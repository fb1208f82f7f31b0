import { describe, expect, it } from "vitest";
import index from "../../index.html?raw";
import frame from "../../replay.html?raw";
import { replayPage } from "./page";

const page = replayPage(frame, index);
const ids = (text: string): string[] => [...text.matchAll(/ id="([^"]+)"/g)].map(([, id]) => id ?? "");

describe("the page of a recorded flight", () => {
  it("holds what both pages show, each once, and its own places for style, flight and script", () => {
    for (const id of ["scene", "hand", "view", "charts", "timeline", "events", "notices", "picker", "help-keys", "theme", "lanes", "at", "sections"]) expect(ids(page)).toContain(id);
    expect(new Set(ids(page)).size).toBe(ids(page).length);
    for (const place of ["<title>twin</title>", "/*replay.css*/", "/*flight*/", "/*replay.js*/"]) expect(page.split(place).length, place).toBe(2);
  });

  it("lacks what only a flight in progress has", () => {
    expect(ids(index)).toContain("link-banner");
    expect(ids(page)).not.toContain("link-banner");
    expect(index).toContain("to push the vehicle");
    expect(page).not.toMatch(/push the vehicle|<h2>Marks|index\.html -->|<!-- (live|part|end)/);
  });

  it("refuses to be built without a part", () => {
    expect(() => replayPage("<!-- desk of index.html -->\n", index)).toThrow('no part "desk"');
  });
});
