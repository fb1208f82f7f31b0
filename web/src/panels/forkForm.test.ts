import { describe, expect, it } from "vitest";
import { commandOf, keysOf, type ForkForm } from "./forkForm";

const NOTHING: ForkForm = { gains: [], predictor: "", adapter: null, payloadG: NaN, wind: [NaN, NaN, NaN] };

describe("the form of a fork", () => {
  it("asks for nothing where nothing is chosen", () => {
    expect(keysOf(NOTHING)).toEqual([]);
  });

  it("writes gains, predictor, adapter, payload and wind as keys of a scenario", () => {
    const gains = [
      { name: "leak", value: 2 },
      { name: "slope.theta", value: 1.25 },
    ];
    const form: ForkForm = { gains, predictor: "persistence", adapter: false, payloadG: 350, wind: [2, NaN, -0.5] };
    expect(keysOf(form)).toEqual([
      "gains.leak=2.0",
      "gains.slope.4=1.25",
      "predictor.kind=persistence",
      "gains.adapter_on=0.0",
      "payload.mass_kg=0.35",
      "wind.velocity_m_s=[2.0,0.0,-0.5]",
    ]);
  });

  it("gives a command that a shell takes as it is", () => {
    expect(commandOf("hover", 3, 12.5, ["gains.leak=2.0"])).toBe("twin fly scenarios/hover.toml --headless --seed 3 --fork-at 12.5 --set 'gains.leak=2.0'");
  });
});
