// Colours, dark and light. Pages set any of them from outside: fvv-player { --fvv-accent: crimson; }.

const dark = `
  --ground: var(--fvv-background, #14171b);
  --panel: var(--fvv-panel, rgb(27 31 37 / 0.92));
  --ink: var(--fvv-ink, #f0f3f6);
  --faint: var(--fvv-faint, #aab4bf);
  --line: var(--fvv-line, rgb(255 255 255 / 0.16));
  --hover: var(--fvv-hover, rgb(255 255 255 / 0.12));
  --accent: var(--fvv-accent, #5fb0ff);
  --on-accent: var(--fvv-on-accent, #08131f);
  --grid: var(--fvv-grid, #343b44);
  color-scheme: dark;
`;
const light = `
  --ground: var(--fvv-background, #eef0f3);
  --panel: var(--fvv-panel, rgb(255 255 255 / 0.94));
  --ink: var(--fvv-ink, #14181d);
  --faint: var(--fvv-faint, #545d67);
  --line: var(--fvv-line, rgb(20 25 30 / 0.16));
  --hover: var(--fvv-hover, rgb(20 25 30 / 0.08));
  --accent: var(--fvv-accent, #0a63c4);
  --on-accent: var(--fvv-on-accent, #ffffff);
  --grid: var(--fvv-grid, #c3c9d0);
  color-scheme: light;
`;

export const theme = `
:host {${light}}
:host([theme="dark"]) {${dark}}
@media (prefers-color-scheme: dark) {
  :host(:not([theme="light"])) {${dark}}
}
`;
