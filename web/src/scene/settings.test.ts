import { describe, expect, it } from "vitest";
import { firstSettings, parseSettings, settingsText } from "./settings";

describe("view settings", () => {
  it("come back as they were stored", () => {
    const settings = firstSettings();
    settings.shown.thrust = !settings.shown.thrust;
    settings.shown.tool = true;
    settings.trailS = Infinity;
    expect(parseSettings(settingsText(settings))).toEqual(settings);
  });

  it.each([null, "", "{", "7", "null", '{"shown":3,"trail_s":-1}', '{"shown":{"thrust":"yes","other":true},"trail_s":7}'])("are those of the first visit for stored %s", (text) => {
    expect(parseSettings(text)).toEqual(firstSettings());
  });
});
