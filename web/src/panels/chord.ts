// Chords of keys as one text such as "Ctrl+Shift+Z". Commands are registered, compared and shown with this text.

/** The parts of a KeyboardEvent from which a chord is read. */
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
 * The chord of an event: modifiers in the order Ctrl, Alt, Shift, then the key. Cmd counts as Ctrl. A letter key has the name of
 * its printed letter; in a layout without Latin letters its position gives the name. A sign such as `?` has no Shift, because
 * layouts differ in which signs need Shift.
 */
export function chordOf(pressed: Pressed): string {
  const letter = letterOf(pressed);
  const key = pressed.key === " " ? "Space" : letter ?? pressed.key;
  const shifted = pressed.shiftKey && (letter !== null || key.length > 1);
  return [...(pressed.ctrlKey || pressed.metaKey ? ["Ctrl"] : []), ...(pressed.altKey ? ["Alt"] : []), ...(shifted ? ["Shift"] : []), key].join("+");
}

/** The captions of a chord's keys as on a keyboard: `Ctrl+ArrowRight` gives Ctrl and →. */
export function capsOf(chord: string): string[] {
  return chord.split(/\+(?=.)/).map((cap) => CAPS[cap] ?? cap);
}

function letterOf({ key, code }: Pressed): string | null {
  if (/^[a-z]$/i.test(key)) return key.toUpperCase();
  if (key.length === 1 && key.charCodeAt(0) > 0x7f && /^Key[A-Z]$/.test(code)) return code.slice(3);
  return null;
}
