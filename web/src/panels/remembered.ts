// A value of the page that survives a reload, as JSON in the browser's storage. Without storage the value lasts as long as the page.

export interface Remembered<T> {
  get(): T;
  set(value: T): void;
}

export function remembered<T>(key: string, initial: T): Remembered<T> {
  let value = initial;
  try {
    const stored = localStorage.getItem(key);
    if (stored !== null) value = JSON.parse(stored) as T;
  } catch {
    // The stored value is unreadable or storage is forbidden; the initial value serves.
  }
  return {
    get: () => value,
    set: (next) => {
      value = next;
      try {
        localStorage.setItem(key, JSON.stringify(next));
      } catch {
        // The storage is full or forbidden; the value lasts as long as the page.
      }
    },
  };
}
