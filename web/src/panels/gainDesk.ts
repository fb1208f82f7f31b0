// Stands between the panel and the server: it keeps the requests of this page, decides whether an echo answers one of them, and
// joins changes to steps of the history. It touches no element of the page.
import type { ClientMessage, GainEcho, GainList, Hello, PresetName } from "../protocol";
import { GainModel, type Requests, same, type Setting, type Snapshot } from "./gainModel";
import { formatGain } from "./scale";

/** An echo that comes later than this after the request belongs to another client, ms. */
const ANSWER_WITHIN_MS = 2000;

export interface LastChange {
  text: string;
  tick: number;
  /** Whether this page asked for the change. */
  own: boolean;
}

/** Several gains that were requested together and become one step of the history. */
interface Batch {
  before: Snapshot;
  waiting: Map<string, number>;
  title: string | undefined;
  until: number;
}

export class GainDesk {
  readonly model = new GainModel();
  last: LastChange | null = null;
  private sent: { name: string; value: number; at: number }[] = [];
  private batch: Batch | null = null;
  private beforePreset: Snapshot | null = null;
  /** Until this time echoes belong to a preset that undo or redo has requested, ms. Its step of the history exists already. */
  private presetAgainUntil = -Infinity;

  constructor(
    private readonly send: (message: ClientMessage) => void,
    private readonly now: () => number = () => performance.now(),
  ) {}

  rebuild(hello: Hello): void {
    this.model.load(hello.gains, hello.preset);
    this.model.forgetTicks();
    this.last = null;
    this.batch = null;
    this.beforePreset = null;
  }

  /** Requests one value; the caller adds the step to the history. */
  request(name: string, value: number): void {
    const now = this.now();
    this.sent = [...this.sent.filter(({ at }) => now - at < ANSWER_WITHIN_MS), { name, value, at: now }];
    this.send({ type: "set_gain", name, value });
  }

  /** The values in force, with requested values in place of those not yet answered. A further request starts from these. */
  expected(): Setting[] {
    return this.model.snapshot().settings.map(({ name, value }) => ({ name, value: this.batch?.waiting.get(name) ?? value }));
  }

  /** Requests several values as one step of the history. */
  apply(settings: Setting[], title?: string): void {
    const before = { ...this.model.snapshot(), settings: this.expected() };
    this.closeBatch();
    const from = new Map(before.settings.map(({ name, value }) => [name, value]));
    const known = settings.filter(({ name, value }) => !same(from.get(name) ?? value, value));
    if (known.length === 0) return;
    this.batch = { before, waiting: new Map(known.map(({ name, value }) => [name, value])), title, until: this.now() + ANSWER_WITHIN_MS };
    known.forEach(({ name, value }) => this.request(name, value));
  }

  choosePreset(name: PresetName): void {
    this.closeBatch();
    this.beforePreset ??= this.model.snapshot();
    this.send({ type: "preset", name });
  }

  undo(): void {
    this.closeBatch();
    this.ask(this.model.undo());
  }

  redo(): void {
    this.closeBatch();
    this.ask(this.model.redo());
  }

  /** Goes to the state after the first `count` steps of the history. */
  goTo(count: number): void {
    this.closeBatch();
    this.model.goTo(count).forEach((requests) => this.ask(requests));
  }

  /** Takes the echo of a gain that took effect; returns whether this page requested it. */
  echo({ name, value, preset, tick }: GainEcho): boolean {
    const own = this.beforePreset !== null || this.now() < this.presetAgainUntil || this.asked(name, value);
    this.model.echo(name, value, preset, tick);
    this.last = { text: `${this.model.get(name)?.label ?? name} = ${formatGain(value)}`, tick, own };
    if (this.batch !== null && same(this.batch.waiting.get(name) ?? NaN, value)) {
      this.batch.waiting.delete(name);
      if (this.batch.waiting.size === 0) this.closeBatch(tick);
    }
    return own;
  }

  /** Takes the gains of a preset that took effect. */
  replace({ gains, preset, tick }: GainList): void {
    const own = this.beforePreset !== null || this.now() < this.presetAgainUntil;
    this.presetAgainUntil = -Infinity;
    this.model.load(gains, preset);
    this.last = { text: preset === "custom" ? "several gains" : `preset ${preset}`, tick, own };
    if (this.beforePreset !== null) this.model.commitSince(this.beforePreset, { presets: { from: this.beforePreset.preset, to: preset }, tick });
    this.beforePreset = null;
  }

  /** Whether this page requested a preset and waits for its echoes and its list of gains. */
  get presetPending(): boolean {
    return this.beforePreset !== null;
  }

  /** Notes that the server refused a request. The values of the same batch that took effect stay. */
  refused(): void {
    this.beforePreset = null;
    this.batch?.waiting.clear();
    this.closeBatch();
  }

  /** Closes a batch whose answers are overdue, with the answers that came; called regularly. */
  overdue(): void {
    if (this.batch === null || this.now() <= this.batch.until) return;
    this.batch.waiting.clear();
    this.closeBatch();
  }

  private ask({ settings, preset }: Requests): void {
    if (preset !== null) {
      this.presetAgainUntil = this.now() + ANSWER_WITHIN_MS;
      this.send({ type: "preset", name: preset });
    }
    settings.forEach(({ name, value }) => this.request(name, value));
  }

  private asked(name: string, value: number): boolean {
    const since = this.now() - ANSWER_WITHIN_MS;
    return this.sent.some((request) => request.name === name && request.at >= since && same(request.value, value));
  }

  /** Adds the batch to the history as one step, with the values that took effect and those still to be answered. */
  private closeBatch(tick?: number): void {
    if (this.batch === null) return;
    const { before, title } = this.batch;
    const after = this.expected();
    this.batch = null;
    this.model.commitBetween(before.settings, after, { ...(title === undefined ? {} : { title }), ...(tick === undefined ? {} : { tick }) });
  }
}
