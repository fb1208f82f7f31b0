// The dialog with the gains in force as text for a scenario file. It shows the text, copies it, and saves it as a file.
import { byId, element, setText } from "./dom";
import { notify } from "./notices";

const ADDRESS = "/api/override.toml";

/** Wires the dialog; returns a function that fetches the text, saves it as a file and shows it. */
export function overrideDialog(scenario: () => string): () => Promise<void> {
  const dialog = byId<HTMLDialogElement>("override");
  const text = byId<HTMLTextAreaElement>("override-text");
  const save = (): void => download(text.value, `${scenario()}.override.toml`);
  byId("override-close").addEventListener("click", () => dialog.close());
  byId("override-save").addEventListener("click", save);
  byId("override-copy").addEventListener("click", () => void copy(text));
  return async () => {
    const answer = await fetch(ADDRESS).catch(() => null);
    if (answer === null || !answer.ok) {
      notify("error", `no override from the server (${answer === null ? "no connection" : `${answer.status} ${answer.statusText}`}); nothing was saved`);
      return;
    }
    text.value = await answer.text();
    text.rows = Math.min(16, text.value.split("\n").length + 1);
    setText(byId("override-state"), `Saved as ${scenario()}.override.toml.`);
    save();
    if (!dialog.open) dialog.showModal();
  };
}

function download(text: string, name: string): void {
  const href = URL.createObjectURL(new Blob([text], { type: "application/toml" }));
  element("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 10_000);
}

/** Copies the text. Without a secure page there is no clipboard; then the text is selected, and the operator presses Ctrl+C. */
async function copy(text: HTMLTextAreaElement): Promise<void> {
  text.select();
  try {
    await navigator.clipboard.writeText(text.value);
    setText(byId("override-state"), "Copied.");
  } catch {
    setText(byId("override-state"), "The text is selected: press Ctrl+C to copy it.");
  }
}
