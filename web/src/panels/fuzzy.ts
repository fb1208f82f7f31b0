// How well a few typed letters fit a text: all of them in order, better at the beginnings of words and in a row.

const AT_START = 8;
const AT_WORD = 6;
const IN_A_ROW = 4;
const PLAIN = 1;
/** A gap costs little, so that a word further along still wins over scattered letters. */
const PER_GAP = 0.1;
/** A fit worse than this share of the best is letters strewn over a long text. */
const WORTH_SHOWING = 0.5;

/** Score of `query` in `text`, higher is better; null if it does not fit. Case and spaces in the query do not count. */
export function fuzzyScore(query: string, text: string): number | null {
  const letters = [...text.toLowerCase()];
  const wanted = [...query.toLowerCase()].filter((letter) => letter !== " ");
  if (wanted.length === 0) return 0;
  let scores: (number | null)[] | null = null;
  for (const letter of wanted) scores = following(letters, letter, scores);
  return (scores ?? []).reduce<number | null>(larger, null);
}

/** For every place of `letter`: the best score with it there, after letters that ended at `previous`. */
function following(letters: string[], letter: string, previous: (number | null)[] | null): (number | null)[] {
  let earlier: number | null = null;
  return letters.map((candidate, i) => {
    const worth = placeValue(letters, i);
    const justBefore = previous?.[i - 1] ?? null;
    const before = previous === null ? -PER_GAP * i : earlier;
    earlier = larger(earlier === null ? null : earlier - PER_GAP, justBefore);
    if (candidate !== letter) return null;
    return larger(before === null ? null : before - PER_GAP + worth, justBefore === null ? null : justBefore + Math.max(worth, IN_A_ROW));
  });
}

/** Items that fit about as well as the best, best first; equal ones keep their order. */
export function rank<T>(query: string, items: T[], textOf: (item: T) => string): T[] {
  const scored = items.flatMap((item) => {
    const score = fuzzyScore(query, textOf(item));
    return score === null ? [] : [{ item, score }];
  });
  const best = Math.max(...scored.map(({ score }) => score));
  return scored.filter(({ score }) => score >= WORTH_SHOWING * best).sort((a, b) => b.score - a.score).map(({ item }) => item);
}

function placeValue(letters: string[], i: number): number {
  if (i === 0) return AT_START;
  return /[\s._:(-]/.test(letters[i - 1] ?? "") ? AT_WORD : PLAIN;
}

function larger(a: number | null, b: number | null): number | null {
  if (a === null) return b;
  return b === null ? a : Math.max(a, b);
}
