// Payload, wind and effects over the flight, as the server's states told them. A past moment is shown with what was in force then.
import type { StateInfo } from "../protocol";

export type WorldState = Pick<StateInfo, "payload_kg" | "wind_m_s" | "effects_off">;

export class StateLog {
  private entries: { tick: number; state: WorldState; text: string }[] = [];

  clear(): void {
    this.entries = [];
  }

  /** Notes the world of `state` from its tick on, if it differs from the one before. */
  put({ tick, payload_kg, wind_m_s, effects_off }: StateInfo): void {
    const state = { payload_kg, wind_m_s, effects_off };
    const text = JSON.stringify(state);
    // After a jump back in a recording the later entries belong to a past that is flown anew.
    this.entries = this.entries.filter((entry) => entry.tick <= tick);
    if (this.entries.at(-1)?.text !== text) this.entries.push({ tick, state, text });
  }

  /** The world at `tick`; null before the first state that this page received. */
  at(tick: number): WorldState | null {
    return this.entries.filter((entry) => entry.tick <= tick).at(-1)?.state ?? null;
  }
}
