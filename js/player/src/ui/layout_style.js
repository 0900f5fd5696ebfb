// Where things stand: the picture, what lies over it, and what goes where there is little room.

export const layout = `
:host {
  display: block;
  position: relative;
  width: 100%;
  aspect-ratio: 16 / 9;
  overflow: hidden;
  container-type: inline-size;
  background: var(--ground);
  color: var(--ink);
  border-radius: var(--fvv-radius, 0);
  font: 14px/1.4 var(--fvv-font, system-ui, -apple-system, "Segoe UI", Roboto, sans-serif);
  -webkit-tap-highlight-color: transparent;
}
:host([hidden]) {
  display: none;
}
:host(:fullscreen) {
  aspect-ratio: auto;
  height: 100%;
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
.surface {
  touch-action: none;
  cursor: grab;
  outline: none;
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
.idle .controls:not(:focus-within) {
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
  .controls {
    transition: none;
  }
  .spinner {
    animation-duration: 4s;
  }
}
`;
