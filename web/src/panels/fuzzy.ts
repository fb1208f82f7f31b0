// Scores how well a few typed letters fit a text. The text must contain all letters in order. Letters at the beginnings of words
// and letters that follow each other score higher.

const AT_START = 8;
const AT_WORD = 6;
const IN_A_ROW = 4;
const PLAIN = 1;
/** Cost of a gap. It is small, so that letters in one word far along the text still beat scattered letters. */
const PER_GAP = 0.1;
/** Items that score less than this share of the best score are dropped: their letters are scattered over a long text. */
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

/** The best score for each position of `letter` in the text; `previous` has the best scores of the letters before it. */
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

/** Items that fit about as well as the best one, best first; items with equal scores keep their order. */
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
