// Which channels an operator means by a few letters.
import type { ChannelInfo } from "../protocol";
import { symbolOf } from "./spec";

/** Channels that have every word of `query` in their name, label, group, unit or symbol; all of them for no words. */
export function matching(channels: ChannelInfo[], query: string): ChannelInfo[] {
  const words = plain(query).split(/\s+/).filter((word) => word !== "");
  return channels.filter((channel) => {
    const { name, label, group, unit, row } = channel;
    const text = plain([name, label, group, unit, row === null ? "" : symbolOf(row)].join(" "));
    return words.every((word) => text.includes(word));
  });
}

/** Without case, and with digits for subscripts. */
function plain(text: string): string {
  return text.normalize("NFKC").toLowerCase();
}
