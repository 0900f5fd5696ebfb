// The style sheets of the player: colours, layout, controls.

import { compact } from "./compact_style.js";

/** Pages can override each colour: fvv-player { --fvv-accent: crimson; }. */
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

const theme = `
:host {${light}}
:host([theme="dark"]) {${dark}}
@media (prefers-color-scheme: dark) {
  :host(:not([theme="light"])) {${dark}}
}
`;

/** Layout: the picture and what is over it. */
const layout = `
:host {
  display: block;
  position: relative;
  width: 100%;
  aspect-ratio: 16 / 9;
  max-height: 100svh;
  overflow: hidden;
  container-type: inline-size;
  background: var(--ground);
  color: var(--ink);
  border-radius: var(--fvv-radius, 0);
  font: 14px/1.4 var(--fvv-font, system-ui, -apple-system, "Segoe UI", Roboto, sans-serif);
  -webkit-tap-highlight-color: transparent;
}
/* Over the camera's picture of a phone. */
:host([immersive]) {
  background: none;
}
:host([immersive]) :is(.ground, .poster, .sheet) {
  display: none;
}
:host([hidden]) {
  display: none;
}
:host(:fullscreen) {
  aspect-ratio: auto;
  height: 100%;
  max-height: none;
  border-radius: 0;
}
*,
::before,
::after {
  box-sizing: border-box;
}
[hidden] {
  display: none !important;
}
/* The interface is in English, and its slider runs with time, on right-to-left pages too. */
.frame {
  direction: ltr;
  text-align: left;
}
.ground,
.surface,
canvas,
.poster {
  position: absolute;
  inset: 0;
  width: 100%;
  height: 100%;
}
.ground {
  background: var(--ground);
}
.line {
  position: absolute;
  width: 0;
  height: 0;
  background: var(--grid);
}
.sky {
  position: absolute;
  width: 0;
  height: 0;
  background: var(--fvv-sky, transparent);
}
.surface {
  touch-action: pan-y;
  cursor: grab;
  outline: none;
}
:host([touch-action="pan-x"]) .surface {
  touch-action: pan-x;
}
:host([touch-action="none"]) .surface,
:host(:fullscreen) .surface {
  touch-action: none;
}
.surface:active {
  cursor: grabbing;
}
.surface:focus-visible::after {
  content: "";
  position: absolute;
  inset: 3px;
  border: 2px solid var(--accent);
  border-radius: calc(var(--fvv-radius, 0px) + 3px);
  pointer-events: none;
}
canvas {
  display: block;
}
canvas.empty {
  visibility: hidden;
}
.poster {
  object-fit: cover;
  pointer-events: none;
}
/* The first frame crossfades with the poster, or with the empty scene, where one of them covers it for a while. */
.poster.gone {
  opacity: 0;
  visibility: hidden;
  transition: opacity 0.25s, visibility 0s 0.25s;
}
.surface canvas {
  transition: opacity 0.25s;
}
.surface.covered canvas {
  opacity: 0;
}
.middle {
  position: absolute;
  inset: 0;
  display: grid;
  place-items: center;
  pointer-events: none;
}
.spinner {
  width: 44px;
  height: 44px;
  border-radius: 50%;
  border: 3px solid var(--line);
  border-top-color: var(--accent);
  animation: turn 0.9s linear infinite;
}
.outage {
  margin-top: 96px;
  padding: 6px 12px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 8px;
}
@keyframes turn {
  to {
    transform: rotate(1turn);
  }
}
.message {
  max-width: min(90%, 34rem);
  padding: 12px 16px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 12px;
  pointer-events: auto;
  overflow-wrap: anywhere;
}
.message p {
  margin: 0 0 8px;
}
.notice {
  position: absolute;
  top: 12px;
  left: 50%;
  transform: translateX(-50%);
  padding: 6px 12px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 999px;
  pointer-events: none;
  white-space: nowrap;
}
.missing {
  position: absolute;
  top: 12px;
  left: 12px;
  right: 12px;
  display: flex;
  align-items: center;
  gap: 8px;
  width: fit-content;
  max-width: 46rem;
  margin-inline: auto;
  padding: 4px 4px 4px 16px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 12px;
}
.missing p {
  margin: 4px 0;
}
.sheet {
  position: absolute;
  inset: 0;
}
.sheet button {
  position: absolute;
  left: calc(var(--x) * 100%);
  top: calc(var(--y) * 100%);
  width: calc(var(--width) * 100%);
  height: calc(var(--height) * 100%);
  min-height: 0;
  padding: 0;
  border: 1px solid var(--line);
  border-radius: 4px;
}
.sheet button:hover:enabled {
  background: none;
  border-color: var(--accent);
  box-shadow: 0 0 0 1px var(--accent);
}
.sheet span {
  position: absolute;
  left: 4px;
  bottom: 4px;
  max-width: calc(100% - 8px);
  padding: 1px 6px;
  overflow: hidden;
  text-overflow: ellipsis;
  white-space: nowrap;
  background: var(--panel);
  border-radius: 5px;
  font-size: 12px;
}
.notice:empty {
  display: none;
}
.controls {
  position: absolute;
  inset: 0;
  display: flex;
  flex-direction: column;
  justify-content: flex-end;
  gap: 8px;
  padding: 12px;
  padding-bottom: max(12px, env(safe-area-inset-bottom));
  pointer-events: none;
  transition: opacity 0.25s;
}
.controls > * {
  pointer-events: auto;
}
.idle .controls:not(:has(:focus-visible)) {
  opacity: 0;
}
.idle .surface {
  cursor: none;
}
.panels {
  display: flex;
  flex: 1;
  min-height: 0;
  justify-content: flex-end;
  align-items: flex-end;
  pointer-events: none;
}
.panel {
  display: flex;
  flex-direction: column;
  width: min(340px, 100%);
  max-height: 100%;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 14px;
  backdrop-filter: blur(14px);
  pointer-events: auto;
}
.stats-box {
  position: absolute;
  top: 12px;
  left: 12px;
  pointer-events: none;
}
@media (prefers-reduced-motion: reduce) {
  .controls,
  .poster.gone,
  .surface canvas {
    transition: none;
  }
  .spinner {
    animation-duration: 4s;
  }
}
`;

/** Buttons, slider, switches and lists. Controls are at least 40 pixels high. */
const controls = `
.bar {
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 14px;
  backdrop-filter: blur(14px);
  padding: 2px 6px 4px;
}
.row {
  display: flex;
  align-items: center;
  gap: 2px;
}
.spring {
  flex: 1;
}
button,
select {
  font: inherit;
  color: inherit;
  cursor: pointer;
}
button {
  min-height: 40px;
  padding: 0 12px;
  background: none;
  border: 0;
  border-radius: 10px;
}
button.icon {
  display: grid;
  place-items: center;
  flex: none;
  width: 40px;
  height: 40px;
  padding: 0;
}
svg {
  width: 24px;
  height: 24px;
  fill: none;
  stroke: currentColor;
  stroke-width: 1.8;
  stroke-linecap: round;
  stroke-linejoin: round;
}
button.big {
  width: 76px;
  height: 76px;
  border: 1px solid var(--line);
  border-radius: 50%;
  background: var(--panel);
  pointer-events: auto;
}
button.big:hover:enabled {
  background: var(--panel);
  border-color: var(--accent);
  color: var(--accent);
}
.big svg {
  width: 38px;
  height: 38px;
}
svg.solid,
.big svg {
  fill: currentColor;
}
button:hover:enabled,
select:hover {
  background: var(--hover);
}
button:disabled,
select:disabled,
input:disabled {
  opacity: 0.4;
  cursor: default;
}
[aria-pressed="true"],
[aria-expanded="true"] {
  color: var(--accent);
}
:is(button, select, .body):focus-visible,
.scrubber input:focus-visible + *,
.switch input:focus-visible {
  outline: 2px solid var(--accent);
  outline-offset: -2px;
}
.body:focus-visible {
  border-radius: 0 0 14px 14px;
}
button.text {
  border: 1px solid var(--line);
}
.time {
  padding: 0 6px;
  font-variant-numeric: tabular-nums;
  white-space: pre;
}
.live::before {
  content: "";
  display: inline-block;
  width: 9px;
  height: 9px;
  margin-right: 7px;
  border-radius: 50%;
  background: #e5484d;
}
.live {
  font-weight: 600;
  white-space: nowrap;
}
.live[data-late="true"]::before {
  background: var(--faint);
}
.choice {
  height: 40px;
  padding: 0 8px;
  background: none;
  border: 0;
  border-radius: 10px;
}
.choice option {
  background: var(--ground);
  color: var(--ink);
}
.scrubber {
  position: relative;
  height: 40px;
  margin: 0 8px -6px;
}
.track {
  position: absolute;
  inset: 17px 0 auto;
  height: 6px;
  border-radius: 3px;
  background: var(--line);
  overflow: hidden;
}
.track > div {
  position: absolute;
  inset: 0;
  left: calc(var(--from, 0) * 100%);
  right: calc(100% - var(--to, 0) * 100%);
}
.buffered {
  background: var(--faint);
  opacity: 0.5;
}
.played {
  background: var(--accent);
}
.looped {
  border: solid var(--ink);
  border-width: 0 2px;
  background: color-mix(in srgb, var(--accent) 35%, transparent);
}
.scrubber input {
  position: absolute;
  inset: 0 -8px;
  width: calc(100% + 16px);
  height: 40px;
  margin: 0;
  background: none;
  appearance: none;
  -webkit-appearance: none;
  cursor: pointer;
  outline: none;
}
.scrubber input::-webkit-slider-runnable-track {
  height: 40px;
  background: none;
}
.scrubber input::-webkit-slider-thumb {
  -webkit-appearance: none;
  width: 16px;
  height: 16px;
  margin-top: 12px;
  border-radius: 50%;
  background: var(--accent);
  border: 2px solid var(--ground);
}
.scrubber input::-moz-range-track {
  background: none;
}
.scrubber input::-moz-range-thumb {
  width: 16px;
  height: 16px;
  border-radius: 50%;
  background: var(--accent);
  border: 2px solid var(--ground);
  box-sizing: border-box;
}
.scrubber input:focus-visible::-webkit-slider-thumb {
  box-shadow: 0 0 0 3px var(--ground), 0 0 0 5px var(--accent);
}
.scrubber input:focus-visible::-moz-range-thumb {
  box-shadow: 0 0 0 3px var(--ground), 0 0 0 5px var(--accent);
}
.scrubber input:disabled::-webkit-slider-thumb {
  visibility: hidden;
}
.track .marks {
  left: 0;
  right: 0;
}
.marks i {
  position: absolute;
  top: 0;
  bottom: 0;
  left: calc(var(--at) * 100%);
  width: 1px;
  background: var(--ground);
}
.preview canvas {
  position: static;
  display: block;
  width: 144px;
  height: auto;
  margin: 3px -4px 2px;
  border-radius: 4px;
}
.tip {
  position: absolute;
  bottom: 34px;
  left: clamp(74px, var(--at, 0) * 100%, 100% - 74px);
  transform: translateX(-50%);
  padding: 2px 8px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 7px;
  font-size: 12px;
  font-variant-numeric: tabular-nums;
  pointer-events: none;
}
.panel header {
  display: flex;
  align-items: center;
  justify-content: space-between;
  padding: 6px 6px 2px 16px;
}
.panel h2 {
  margin: 0;
  font-size: 15px;
  font-weight: 650;
}
.body {
  padding: 2px 16px 14px;
  overflow: auto;
  overscroll-behavior: contain;
}
.body p {
  margin: 0 0 10px;
  color: var(--faint);
}
@media (pointer: coarse) {
  .by-mouse {
    display: none;
  }
}
@media not (pointer: coarse) {
  .by-finger {
    display: none;
  }
}
.switch,
.field {
  display: flex;
  align-items: center;
  justify-content: space-between;
  gap: 12px;
  min-height: 40px;
}
.switch {
  cursor: pointer;
}
.field .choice {
  border: 1px solid var(--line);
}
.switch input {
  appearance: none;
  flex: none;
  position: relative;
  width: 40px;
  height: 24px;
  margin: 8px 0;
  border-radius: 12px;
  background: var(--faint);
  cursor: inherit;
}
.switch input::before {
  content: "";
  position: absolute;
  top: 3px;
  left: 3px;
  width: 18px;
  height: 18px;
  border-radius: 50%;
  background: var(--ground);
}
.switch input:checked {
  background: var(--accent);
}
.switch input:checked::before {
  left: 19px;
}
.switch input:focus-visible {
  outline-offset: 2px;
}
.actions {
  display: flex;
  flex-wrap: wrap;
  gap: 8px;
  padding: 6px 0 8px;
}
.chips {
  display: grid;
  grid-template-columns: 1fr 1fr;
  gap: 6px;
  margin: 0 0 6px;
  padding: 0;
  border: 0;
}
.chips legend {
  padding: 4px 0 6px;
}
.chip {
  position: relative;
  display: grid;
}
.chip input {
  position: absolute;
  inset: 0;
  margin: 0;
  opacity: 0;
  cursor: pointer;
}
.chip span {
  display: grid;
  place-items: center;
  min-height: 40px;
  border: 1px solid var(--line);
  border-radius: 10px;
}
.chip:hover span {
  background: var(--hover);
}
.chip input:checked + span {
  background: var(--accent);
  border-color: var(--accent);
  color: var(--on-accent);
}
.chip input:focus-visible + span {
  outline: 2px solid var(--accent);
  outline-offset: 2px;
}
.cameras {
  margin: 0;
  padding: 0;
  list-style: none;
}
.cameras li {
  display: flex;
  align-items: center;
  gap: 8px;
  border-top: 1px solid var(--line);
}
.cameras .name {
  flex: 1;
  min-width: 0;
  overflow: hidden;
  text-overflow: ellipsis;
  white-space: nowrap;
}
.swatch {
  flex: none;
  width: 12px;
  height: 12px;
  border-radius: 4px;
  background: var(--swatch);
}
.keys,
.stats {
  display: grid;
  grid-template-columns: auto 1fr;
  gap: 6px 14px;
  margin: 0;
}
.keys dd,
.stats dd {
  margin: 0;
}
kbd {
  display: inline-block;
  min-width: 24px;
  margin-right: 4px;
  padding: 1px 6px;
  border: 1px solid var(--line);
  border-radius: 6px;
  background: var(--hover);
  font: inherit;
  font-size: 12px;
  text-align: center;
}
.stats-box {
  padding: 8px 12px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 10px;
  font-size: 12px;
  font-variant-numeric: tabular-nums;
}
.stats {
  gap: 2px 14px;
}
.stats dt {
  color: var(--faint);
}
.stats dd {
  text-align: right;
}
`;

const made = new WeakMap(); // window -> sheets

/** Constructed style sheets, shared by all players of a window, as content policies may forbid inline styles. */
export function styleSheets(view) {
  if (!made.has(view)) {
    // Narrow and low pages override other rules.
    const sheets = [theme, layout, controls, compact].map((text) => {
      const sheet = new view.CSSStyleSheet();
      sheet.replaceSync(text);
      return sheet;
    });
    made.set(view, sheets);
  }
  return made.get(view);
}
