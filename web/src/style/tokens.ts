// The theme's colours as values: canvas and WebGL draw with them, and CSS has them as custom properties.

/** Reads tokens of the theme in force by their name without the dashes. */
export function tokenReader(): (name: string) => string {
  const style = getComputedStyle(document.documentElement);
  return (name) => style.getPropertyValue(`--${name}`).trim();
}
