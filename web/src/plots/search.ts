// Finds channels by words that an operator types.
import type { ChannelInfo } from "../protocol";
import { symbolOf } from "./spec";

/** Channels with every word of `query` in their name, label, group, unit or symbol; all channels if there are no words. */
export function matching(channels: ChannelInfo[], query: string): ChannelInfo[] {
  const words = plain(query).split(/\s+/).filter((word) => word !== "");
  return channels.filter((channel) => {
    const { name, label, group, unit, row } = channel;
    const text = plain([name, label, group, unit, row === null ? "" : symbolOf(row)].join(" "));
    return words.every((word) => text.includes(word));
  });
}

/** The text in lower case, and with digits in place of subscripts. */
function plain(text: string): string {
  return text.normalize("NFKC").toLowerCase();
}
