import { describe, expect, it } from "vitest";
import type { Scene, SceneBody } from "../protocol";
import { handOf } from "./hand";

function body(name: string, group: SceneBody["group"], moving: boolean): SceneBody {
  return { name, group, moving, shapes: [], pose: { position: [0, 0, 0], quaternion_wxyz: [1, 0, 0, 0] } };
}

function scene(...bodies: SceneBody[]): Scene {
  return { bodies: [body("base", "vehicle", true), ...bodies], rotors: [], base_body: "base" };
}

describe("handOf", () => {
  it("prefers the grasp point to the palm, and either to a finger", () => {
    const [link, palm, finger] = [body("link1", "vehicle", true), body("palm", "vehicle", true), body("finger_left", "vehicle", true)];
    expect(handOf(scene(link, palm, body("tool", "vehicle", true), finger))).toBe("tool");
    expect(handOf(scene(link, palm, finger))).toBe("palm");
    expect(handOf(scene(link, finger))).toBe("finger_left");
  });

  it("finds none on a bare vehicle, whatever lies about", () => {
    expect(handOf(scene(body("tool box", "arena", false), body("payload", "payload", true)))).toBeUndefined();
  });
});
