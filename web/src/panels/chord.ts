// Keys as one text, "Ctrl+Shift+Z": how they are registered, compared and shown.

/** What a chord is read from; a KeyboardEvent is one. */
export interface Pressed {
  key: string;
  code: string;
  ctrlKey: boolean;
  metaKey: boolean;
  shiftKey: boolean;
  altKey: boolean;
}

const CAPS: Record<string, string> = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓" };

/**
 * The chord of an event: modifiers in the order Ctrl, Alt, Shift, then the key. Cmd counts as Ctrl. A letter goes by
 * what is printed on it, and by its place where the layout has no Latin letters; a sign such as `?` carries no Shift,
 * because which signs need one differs from layout to layout.
 */
export function chordOf(pressed: Pressed): string {
  const letter = letterOf(pressed);
  const key = pressed.key === " " ? "Space" : letter ?? pressed.key;
  const shifted = pressed.shiftKey && (letter !== null || key.length > 1);
  return [...(pressed.ctrlKey || pressed.metaKey ? ["Ctrl"] : []), ...(pressed.altKey ? ["Alt"] : []), ...(shifted ? ["Shift"] : []), key].join("+");
}

/** The caps of a chord as they stand on a keyboard: `Ctrl+ArrowRight` is Ctrl and →. */
export function capsOf(chord: string): string[] {
  return chord.split(/\+(?=.)/).map((cap) => CAPS[cap] ?? cap);
}

function letterOf({ key, code }: Pressed): string | null {
  if (/^[a-z]$/i.test(key)) return key.toUpperCase();
  if (key.length === 1 && key.charCodeAt(0) > 0x7f && /^Key[A-Z]$/.test(code)) return code.slice(3);
  return null;
}
