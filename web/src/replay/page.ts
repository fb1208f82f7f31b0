// Makes the page of a recorded flight from the console's page. Parts that both pages show stand once, in index.html.

/** Words in a label of the console about an action that only a running flight allows. */
const LIVE_WORDS = ", Ctrl+drag to push the vehicle";

/**
 * `frame` (replay.html) with each `<!-- NAME of index.html -->` replaced by the text between `<!-- part: NAME -->` and
 * `<!-- end: NAME -->` of `index`, without what stands between `<!-- live -->` and `<!-- end: live -->`.
 *
 * Throws an error that names the part which `index` lacks.
 */
export function replayPage(frame: string, index: string): string {
  return frame.replace(/^[ \t]*<!-- (\w+) of index\.html -->\n/gm, (_, name: string) => part(index, name));
}

function part(index: string, name: string): string {
  const found = new RegExp(`<!-- part: ${name} -->\n([^]*?)^[ \\t]*<!-- end: ${name} -->`, "m").exec(index)?.[1];
  if (found === undefined) throw new Error(`index.html has no part "${name}" between <!-- part: ${name} --> and <!-- end: ${name} -->`);
  return found.replace(/^[ \t]*<!-- live -->\n[^]*?<!-- end: live -->\n/gm, "").replace(LIVE_WORDS, "");
}
