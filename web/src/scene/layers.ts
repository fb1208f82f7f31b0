// The layers of three.js that the cameras draw: each camera draws layer 0 and the layers that it enables.

/** Layer of trails and the ghost. They belong to the whole flight, and the close-up does not draw them. */
export const MARKS_LAYER = 1;
