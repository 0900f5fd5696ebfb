// How buttons, the bar to scrub on, switches and lists look. Whatever is touched is at least 40 pixels high.

export const controls = `
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
.tip {
  position: absolute;
  bottom: 34px;
  left: calc(var(--at, 0) * 100%);
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
