// The style of the tools, beside those of the player.

/** Of measurements and marks, on any background: they have a dark edge. */
export const COLOURS = ["#ffd84d", "#7fd8ff", "#ff9ecb", "#9df59a", "#ffb066", "#d3b8ff"];

const keys = COLOURS.map((colour, i) => `.key.k${i} { background: ${colour}; }`).join("\n");

export const style = `
.scene-marks {
  position: absolute;
  inset: 0;
  width: 100%;
  height: 100%;
  pointer-events: none;
  overflow: hidden;
}
.scene-marks path {
  fill-rule: evenodd;
}
.scene-marks .halo {
  stroke: rgb(0 0 0 / 0.55);
}
.scene-marks circle,
.scene-marks .head {
  stroke: rgb(0 0 0 / 0.7);
  stroke-width: 1.5;
}
.scene-marks text {
  stroke: rgb(0 0 0 / 0.8);
  stroke-width: 3.5;
  paint-order: stroke;
  font-size: 14px;
  font-weight: 600;
}
.scene-marks .faint {
  opacity: 0.55;
}
.cross-hair {
  position: absolute;
  left: calc(var(--x) - 20px);
  top: calc(var(--y) - 20px);
  width: 40px;
  height: 40px;
  pointer-events: none;
  stroke: #fff;
  stroke-width: 1.8;
}
.cross-hair[hidden] {
  display: none;
}
.cross-hair .halo {
  stroke: rgb(0 0 0 / 0.7);
  stroke-width: 4;
}
.surface.pointing {
  cursor: crosshair;
}
.surface.drawing {
  touch-action: none;
}
.tools {
  position: absolute;
  top: 12px;
  right: 12px;
  max-width: min(280px, calc(100% - 24px));
  max-height: calc(100% - 110px);
  display: flex;
  flex-direction: column;
  align-items: flex-end;
  gap: 6px;
  pointer-events: none;
}
.tools > * {
  pointer-events: auto;
}
.tool-bar {
  display: flex;
  flex-wrap: wrap;
  justify-content: flex-end;
  flex: none;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 12px;
}
.hint {
  padding: 4px 10px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 8px;
  font-size: 13px;
}
.hint:empty {
  display: none;
}
.tool-list {
  width: 272px;
  max-width: 100%;
  min-height: 0;
  overflow: auto;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 12px;
}
.tool-list ul {
  list-style: none;
  margin: 0;
  padding: 0 10px;
}
.tool-list li + li {
  border-top: 1px solid var(--line);
}
.line-of {
  display: flex;
  align-items: center;
}
.line-of .name {
  flex: 1;
  overflow: hidden;
  text-overflow: ellipsis;
}
.tool-list .value {
  display: block;
  font-weight: 600;
  font-variant-numeric: tabular-nums;
}
.tool-list button.name {
  flex: 1;
  min-width: 0;
  padding: 0;
  text-align: left;
}
.tool-list button.name:disabled {
  opacity: 1;
}
.tool-list .objects {
  display: flex;
  flex-wrap: wrap;
  gap: 4px;
  padding: 6px;
}
.objects button {
  min-height: 32px;
  padding: 0 8px;
}
.tool-list .objects li {
  border: 0;
}
.actions {
  flex-wrap: wrap;
  padding: 0 4px;
}
.actions button {
  padding: 0 7px;
}
.tool-options input[type="text"] {
  font: inherit;
  width: 9rem;
  min-height: 32px;
  color: inherit;
  background: none;
  border: 1px solid var(--line);
  border-radius: 6px;
}
.key {
  display: inline-block;
  width: 10px;
  height: 10px;
  margin-right: 6px;
  border-radius: 3px;
  border: 1px solid rgb(0 0 0 / 0.5);
}
${keys}
.graph {
  display: block;
  width: 100%;
  height: 72px;
  margin: 4px 0 8px;
  cursor: pointer;
  background: var(--hover);
  border-radius: 6px;
}
.graph text {
  fill: var(--ink);
  stroke: none;
  font-size: 11px;
}
.graph .band {
  fill: var(--accent);
  stroke: none;
  opacity: 0.3;
}
.graph .curve {
  fill: none;
  stroke: var(--accent);
  stroke-width: 1.8;
}
.graph .playhead {
  stroke: var(--ink);
  stroke-width: 1.2;
}
.tool-options {
  display: flex;
  flex-wrap: wrap;
  align-items: center;
  gap: 2px 8px;
  padding: 0 10px;
  background: var(--panel);
  border: 1px solid var(--line);
  border-radius: 12px;
}
`;
