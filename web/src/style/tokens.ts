// The theme's colours as values for drawing on canvases and in WebGL; CSS has them as custom properties.

/** Reads tokens of the current theme by their names without the dashes. */
export function tokenReader(): (name: string) => string {
  const style = getComputedStyle(document.documentElement);
  return (name) => style.getPropertyValue(`--${name}`).trim();
}
