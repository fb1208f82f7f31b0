import { afterEach, expect, it, vi } from "vitest";
import { Throttle } from "./throttle";

afterEach(() => vi.useRealTimers());

it("acts at once, then at most once a period, and always on the newest wish", () => {
  vi.useFakeTimers();
  const done: number[] = [];
  const throttle = new Throttle(100, (value) => done.push(value));
  for (let wish = 0; wish <= 20; wish += 1) {
    throttle.ask(wish);
    vi.advanceTimersByTime(20);
  }
  vi.advanceTimersByTime(200);
  expect(done).toEqual([0, 4, 9, 14, 19, 20]);
});
