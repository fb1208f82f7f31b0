// The forks tab: a form that asks for a fork of this moment, and each fork with what changed, how it ended, and how its metrics differ.
import type { Store } from "../data/store";
import type { ClientMessage, ForkInfo, ForkMetric, GainInfo } from "../protocol";
import { byId, element, option, setText } from "./dom";
import { commandOf, type ForkForm, keysOf } from "./forkForm";
import { notify } from "./notices";

/** Predictors that a fork may fly, by their words in a scenario. */
const PREDICTORS = ["fdt", "random_features", "persistence", "arx_rls", "bias", "gravity"];
/** Metrics shown before all others; the rest is behind "all metrics". */
const FIRST = ["position_rmse_m", "rms_error_e8", "residual_rmse_z", "resets", "tilt_peak_rad", "saturation_share", "grasp_slip_mm", "placement_error_mm"];
const ADAPTER: Record<string, boolean | null> = { "": null, on: true, off: false };

export class ForkPanel {
  private readonly gains = byId("fork-gains");
  private readonly predictor = byId<HTMLSelectElement>("fork-predictor");
  private readonly adapter = byId<HTMLSelectElement>("fork-adapter");
  private readonly payload = byId<HTMLInputElement>("fork-payload");
  private readonly wind = ["east", "north", "up"].map((axis) => byId<HTMLInputElement>(`fork-wind-${axis}`));
  private readonly name = byId<HTMLInputElement>("fork-name");
  private readonly button = byId<HTMLButtonElement>("fork-here");
  private list: ForkInfo[] = [];
  private all = false;

  /** `moment` is the time of the playhead, s; null while the page follows the flight. */
  constructor(
    private readonly store: Store,
    private readonly send: (message: ClientMessage) => void,
    private readonly moment: () => number | null,
    private readonly gainList: () => GainInfo[],
  ) {
    this.predictor.append(option("", "as it is"), ...PREDICTORS.map((word) => option(word, word.replaceAll("_", " "))));
    this.button.addEventListener("click", () => this.ask());
    byId("fork-add-gain").addEventListener("click", () => this.addGain());
    byId("fork-clear").addEventListener("click", () => this.clear());
  }

  /** Another flight, with other forks and perhaps without a vehicle that could be forked. */
  rebuild(): void {
    const mirrored = this.store.hello?.mirror !== null && this.store.hello?.mirror !== undefined;
    byId("fork-form").hidden = mirrored;
    byId("fork-none").hidden = !mirrored;
    this.update(this.store.hello?.forks ?? []);
  }

  update(list: ForkInfo[]): void {
    this.list = list;
    byId("forks").replaceChildren(...list.map((fork) => this.card(fork)));
    setText(byId("forks-state"), list.length === 0 ? "No fork yet. Choose what changes, or nothing, and press the button." : "");
  }

  /** Called a few times a second. */
  readings(): void {
    const at = this.moment();
    const now = Math.max(0, this.store.timeOf(this.store.lastTick));
    const text = at === null ? `Fork here, at ${now.toFixed(2)} s (now)` : `Fork at ${at.toFixed(2)} s (the playhead)`;
    setText(this.button, text);
  }

  private ask(): void {
    const at = this.moment();
    const tick = at === null ? null : Math.max(0, this.store.tickAt(at) + 1);
    this.send({ type: "fork", tick, set: keysOf(this.form()), name: this.name.value.trim() });
    this.name.value = "";
  }

  private form(): ForkForm {
    const gains = [...this.gains.querySelectorAll("li")].flatMap((line) => {
      const name = line.querySelector("select")?.value ?? "";
      const value = line.querySelector("input")?.valueAsNumber ?? NaN;
      return name !== "" && Number.isFinite(value) ? [{ name, value }] : [];
    });
    const [east = NaN, north = NaN, up = NaN] = this.wind.map((field) => field.valueAsNumber);
    return { gains, predictor: this.predictor.value, adapter: ADAPTER[this.adapter.value] ?? null, payloadG: this.payload.valueAsNumber, wind: [east, north, up] };
  }

  private clear(): void {
    this.gains.replaceChildren();
    this.predictor.value = "";
    this.adapter.value = "";
    [this.payload, ...this.wind].forEach((field) => (field.value = ""));
  }

  private addGain(): void {
    const known = this.gainList();
    const choice = element("select", { ariaLabel: "Gain of the fork" }, known.map(({ name, label }) => option(name, `${label} (${name})`)));
    const value = element("input", { type: "number", step: "any", ariaLabel: "Value of the gain in the fork" });
    const put = (): void => {
      const gain = known.find(({ name }) => name === choice.value);
      if (gain === undefined) return;
      [value.min, value.max, value.value] = [String(gain.min), String(gain.max), String(Number(gain.value.toPrecision(6)))];
      value.title = `${gain.help}; ${gain.min} to ${gain.max} ${gain.unit}`;
    };
    choice.addEventListener("change", put);
    put();
    const remove = element("button", { textContent: "×", title: "Leave this gain as it is", ariaLabel: "Leave this gain as it is" });
    const line = element("li", {}, [choice, value, remove]);
    remove.addEventListener("click", () => line.remove());
    this.gains.append(line);
    choice.focus();
  }

  private card(fork: ForkInfo): HTMLElement {
    const name = element("input", { type: "text", value: fork.name, ariaLabel: `Name of ${fork.name}`, maxLength: 64 });
    name.addEventListener("change", () => this.send({ type: "name_fork", id: fork.id, name: name.value }));
    const drop = element("button", { textContent: "Drop", title: `Forget ${fork.name}` });
    drop.addEventListener("click", () => this.send({ type: "drop_fork", id: fork.id }));
    const copy = element("button", { textContent: "Copy command", title: "The command that repeats this fork without the console; what operators did before the fork is not in it" });
    copy.addEventListener("click", () => void this.copy(fork));
    const swatch = element("i", { className: "line dashed", ariaHidden: "true" });
    swatch.style.color = `var(--fork-${fork.slot + 1})`;
    const card = element("article", { className: "fork", ariaLabel: fork.name }, [
      element("header", { className: "line" }, [swatch, name, drop]),
      element("p", { textContent: `at ${fork.at_s.toFixed(2)} s: ${changes(fork)}` }),
      element("p", { className: "muted", textContent: state(fork) }),
    ]);
    card.dataset["fork"] = String(fork.id);
    if (fork.metrics.length > 0) card.append(this.table(fork), element("p", { className: "line" }, [copy, this.more()]));
    return card;
  }

  /** Metrics from the fork on: of the fork, of the flight as it would have gone on, and the difference. */
  private table({ metrics }: ForkInfo): HTMLElement {
    const shown = this.all ? metrics : FIRST.flatMap((name) => metrics.filter(({ metric }) => metric === name));
    const head = ["metric", "fork", "flight", "Δ", ""].map((text) => element("th", { scope: "col", textContent: text }));
    return element("table", { className: "numbers fork-metrics" }, [
      element("thead", {}, [element("tr", {}, head)]),
      element("tbody", {}, shown.map(row)),
    ]);
  }

  private more(): HTMLButtonElement {
    const button = element("button", { textContent: this.all ? "Fewer metrics" : "All metrics" });
    button.addEventListener("click", () => {
      this.all = !this.all;
      this.update(this.list);
    });
    return button;
  }

  private async copy(fork: ForkInfo): Promise<void> {
    const { hello, state: now } = this.store;
    if (hello === null || now === null) return;
    const command = commandOf(hello.scenario, now.seed, fork.at_s, fork.changed.map(({ key, to }) => `${key}=${to}`));
    await navigator.clipboard.writeText(command).then(() => notify("info", `copied: ${command}`), () => notify("info", command));
  }
}

function changes(fork: ForkInfo): string {
  if (fork.changed.length > 0) return fork.changed.map(({ key, from, to }) => `${key} ${from} → ${to}`).join(", ");
  return fork.set.length === 0 ? "nothing changed" : fork.set.join(", ");
}

function state(fork: ForkInfo): string {
  const outcome = fork.outcome === null ? "still flying after a minute" : `${fork.outcome.verdict}: ${fork.outcome.reason}`;
  switch (fork.state) {
    case "waiting":
      return "waits for the forks before it";
    case "flying":
      return `flies, ${(fork.flown_s - fork.at_s).toFixed(1)} s ahead of the fork`;
    case "failed":
      return fork.outcome?.reason ?? "refused";
    case "flown":
      return outcome;
  }
}

function row({ metric, value, parent, difference, judgement }: ForkMetric): HTMLElement {
  const text = (number: number | null): string => (number === null ? "–" : four(number));
  const sign = difference !== null && difference > 0 ? "+" : "";
  const word = judgement === "better" ? "▲ better" : judgement === "worse" ? "▼ worse" : judgement;
  const made = element("tr", {}, [
    element("th", { scope: "row", textContent: metric }),
    element("td", { textContent: text(value) }),
    element("td", { textContent: text(parent) }),
    element("td", { textContent: difference === null ? "–" : `${sign}${two(difference)}` }),
    element("td", { textContent: word }),
  ]);
  made.dataset["judgement"] = judgement;
  made.dataset["metric"] = metric;
  return made;
}

function two(value: number): string {
  return String(Number(value.toPrecision(2))).replace("-", "−");
}

function four(value: number): string {
  return String(Number(value.toPrecision(4))).replace("-", "−");
}
