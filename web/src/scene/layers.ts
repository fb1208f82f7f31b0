// What is drawn where: three.js cameras see layer 0 and the layers they ask for.

/** Trails and the ghost: they tell of the flight as a whole, and would be clutter in a close-up. */
export const MARKS_LAYER = 1;
