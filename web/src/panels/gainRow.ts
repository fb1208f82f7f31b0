// The line of one gain: slider with a mark at the preset's value, number, unit, tick of effect, and a button back to the preset.
import type { GainInfo } from "../protocol";
import { element, setText } from "./dom";
import { formatGain, positionOf, sliderSteps, valueAt } from "./scale";

/** The least time between two requests to the server during a drag, ms. */
const SEND_EVERY_MS = 80;
/** Without an answer for this long the line shows the server's value again, ms. */
const ANSWER_WITHIN_MS = 1500;
/** A change by another client is marked for this long, ms. */
const MARKED_MS = 2500;

/** Relative difference below which two values count as equal after their way through JSON. */
const SAME = 1e-9;

export interface GainRowHandlers {
  /** Requests `value` from the server without a step of the history. */
  send(name: string, value: number): void;
  /** Adds a step to the history when the requested value has taken effect; `from` is the value before. */
  commit(name: string, from: number, to: number): void;
  /** Tells that the operator looks at this gain. */
  point(name: string): void;
  /** Stars the gain, or takes the star away. */
  star(name: string): void;
}

export class GainRow {
  readonly root: HTMLElement;
  private readonly slider: HTMLInputElement;
  private readonly field: HTMLInputElement | null;
  private readonly revert: HTMLButtonElement;
  private readonly track: HTMLElement;
  private readonly starButton = element("button", { className: "star", textContent: "☆" });
  private readonly tick = element("span", { className: "tick" });
  private readonly unit: HTMLElement;
  private before: number | null = null;
  private sentAt = 0;
  private later = 0;
  private unanswered = 0;
  private marked = 0;
  private readonly steps: number;
  /** Requested change without an answer; it becomes a step of the history when it takes effect. */
  private asked: { from: number; to: number } | null = null;

  constructor(
    private readonly gain: () => GainInfo,
    private readonly handlers: GainRowHandlers,
  ) {
    const { name, label, unit, min, max, step, help } = gain();
    const id = `gain-${name}`;
    this.steps = sliderSteps(gain());
    const onOff = min === 0 && max === 1 && step === 1;
    this.slider = element("input", { id, type: onOff ? "checkbox" : "range", min: "0", max: String(this.steps), step: "1" });
    this.slider.ariaLabel = `${label}${unit === "" ? "" : `, ${unit}`}`;
    this.slider.setAttribute("aria-describedby", "gain-help");
    this.field = onOff ? null : element("input", { type: "number", min: String(min), max: String(max), step: "any", ariaLabel: `${label} as a number` });
    this.revert = element("button", { className: "default", textContent: "↺", ariaLabel: `Back to the preset's ${label}` });
    this.track = element("span", { className: onOff ? "on-off" : "track" }, onOff ? [this.slider] : [this.slider, element("i", { className: "baseline", ariaHidden: "true" })]);
    this.unit = element("span", { textContent: unit });
    this.root = element("div", { className: label.length > 5 ? "gain long" : "gain" }, [
      element("label", { htmlFor: id, textContent: label, title: help }),
      this.track,
      this.field ?? element("span"),
      element("span", { className: "unit" }, [this.unit, this.tick]),
      this.revert,
      this.starButton,
    ]);
    this.root.dataset["gain"] = name;
    this.listen(onOff);
    this.show(true);
  }

  /** Shows the value in force, unless the operator drags the slider or types a number. */
  show(force = false): void {
    const gain = this.gain();
    this.revert.title = `Back to ${formatGain(gain.preset_value)}`;
    this.track.style.setProperty("--preset-at", String(positionOf(gain.preset_value, gain)));
    if (!force && (this.before !== null || this.unanswered !== 0)) return;
    if (this.slider.type === "checkbox") this.slider.checked = gain.value >= 0.5;
    else this.slider.value = String(Math.round(positionOf(gain.value, gain) * this.steps));
    this.slider.ariaValueText = `${formatGain(gain.value)} ${gain.unit}`;
    this.fill();
    if (this.field !== null && (force || document.activeElement !== this.field)) this.field.value = formatGain(gain.value);
  }

  /** Takes note that a value of this gain took effect. */
  answered(): void {
    const { name, value } = this.gain();
    // The echo of an earlier position of the drag does not answer the request of the last position.
    if (this.asked !== null && Math.abs(value - this.asked.to) > SAME * Math.abs(value)) return;
    this.settle();
    if (this.asked !== null) this.handlers.commit(name, this.asked.from, value);
    this.asked = null;
    this.show(this.before === null);
  }

  /** Takes note that the server refused the request. The line shows the server's value, and there is no step to undo. */
  refused(): void {
    if (this.unanswered === 0) return;
    this.settle();
    this.asked = null;
    this.show(true);
  }

  mark(modified: boolean, tick: number | undefined): void {
    this.root.classList.toggle("modified", modified);
    this.revert.tabIndex = modified ? 0 : -1;
    setText(this.tick, tick === undefined ? "" : `@${tick}`);
    this.tick.title = tick === undefined ? "" : `in force from tick ${tick}`;
  }

  showStar(on: boolean): void {
    const { label } = this.gain();
    setText(this.starButton, on ? "★" : "☆");
    this.starButton.ariaPressed = String(on);
    this.starButton.ariaLabel = `${label} starred`;
    this.starButton.title = on ? "Starred: the layout fly lists it" : "Star: the layout fly lists it";
  }

  /** Shows beside a gain without a unit what it amounts to. */
  note(text: string): void {
    setText(this.unit, text);
  }

  /** Marks the line for a moment after another client has changed the gain. */
  changedElsewhere(): void {
    this.root.classList.add("elsewhere");
    window.clearTimeout(this.marked);
    this.marked = window.setTimeout(() => this.root.classList.remove("elsewhere"), MARKED_MS);
  }

  focus(): void {
    this.slider.focus();
    this.root.scrollIntoView({ block: "nearest" });
  }

  private listen(onOff: boolean): void {
    this.root.addEventListener("pointerenter", () => this.handlers.point(this.gain().name));
    this.root.addEventListener("focusin", () => this.handlers.point(this.gain().name));
    this.starButton.addEventListener("click", () => this.handlers.star(this.gain().name));
    this.revert.addEventListener("click", () => this.finish(this.gain().preset_value));
    if (onOff) {
      this.slider.addEventListener("change", () => this.finish(this.slider.checked ? 1 : 0));
      return;
    }
    this.slider.addEventListener("input", () => this.drag(this.sliderValue()));
    this.slider.addEventListener("change", () => this.finish(this.sliderValue()));
    this.field?.addEventListener("input", () => this.typing(true));
    this.field?.addEventListener("blur", () => this.typing(false));
    this.field?.addEventListener("change", () => this.typed());
    this.field?.addEventListener("keydown", (event) => this.fieldKey(event));
  }

  private sliderValue(): number {
    return valueAt(Number(this.slider.value) / this.steps, this.gain());
  }

  private fill(): void {
    this.track.style.setProperty("--at", String(Number(this.slider.value) / this.steps));
  }

  /** Marks the field while its text is not yet a request, so that Ctrl+Z undoes typing and not a gain. */
  private typing(yes: boolean): void {
    if (this.field !== null) this.field.dataset["typing"] = String(yes);
  }

  /** Requests the typed number as it is; the server refuses an unusable number and says why. */
  private typed(): void {
    const value = this.field?.valueAsNumber ?? NaN;
    this.typing(false);
    if (Number.isNaN(value)) this.show(true);
    else this.finish(value);
  }

  private fieldKey(event: KeyboardEvent): void {
    if (event.key === "Enter") this.typed();
    if (event.key === "Escape") {
      this.typing(false);
      this.show(true);
    }
    const by = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (by === 0) return;
    event.preventDefault();
    const { value, step, min, max } = this.gain();
    this.finish(Math.min(max, Math.max(min, Number((value + by * step * (event.shiftKey ? 10 : 1)).toPrecision(9)))));
  }

  private drag(value: number): void {
    this.before ??= this.gain().value;
    this.fill();
    if (this.field !== null) this.field.value = formatGain(value);
    window.clearTimeout(this.later);
    const wait = this.sentAt + SEND_EVERY_MS - performance.now();
    if (wait <= 0) this.send(value);
    else this.later = window.setTimeout(() => this.send(value), wait);
  }

  private finish(value: number): void {
    window.clearTimeout(this.later);
    const from = this.before ?? this.gain().value;
    this.before = null;
    if (value === this.gain().value) {
      // The last position of the drag has taken effect already.
      this.handlers.commit(this.gain().name, from, value);
      return this.show(true);
    }
    this.asked = { from: this.asked?.from ?? from, to: value };
    this.send(value);
    if (this.field !== null) this.field.value = formatGain(value);
  }

  private send(value: number): void {
    this.sentAt = performance.now();
    this.handlers.send(this.gain().name, value);
    this.root.classList.add("pending");
    window.clearTimeout(this.unanswered);
    this.unanswered = window.setTimeout(() => {
      this.settle();
      this.asked = null;
      this.show(true);
    }, ANSWER_WITHIN_MS);
  }

  private settle(): void {
    window.clearTimeout(this.unanswered);
    this.unanswered = 0;
    this.root.classList.remove("pending");
  }
}
