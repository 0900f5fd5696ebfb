// Elements, icons and texts of the interface.

/**
 * An element with its properties and children. No inline styles or markup, which strict content policies and trusted types
 * forbid. properties: "on..." are listeners; class, role, part, for and names with a hyphen are attributes.
 */
export function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (value === undefined || value === null) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key === "class" || key === "role" || key === "part" || key === "for" || key.includes("-"))
      made.setAttribute(key, value);
    else made[key] = value;
  }
  made.append(...children.filter((child) => child !== null));
  return made;
}

const SVG = "http://www.w3.org/2000/svg";
function icon(path) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const shape = document.createElementNS(SVG, "path");
  shape.setAttribute("d", path);
  svg.append(shape);
  return svg;
}
/** solid: filled. */
export function setIcon(button, path, solid = false) {
  const svg = button.querySelector("svg");
  svg.querySelector("path").setAttribute("d", path);
  svg.classList.toggle("solid", solid);
}

export function iconButton(label, path, click, properties = {}) {
  return element(
    "button",
    { type: "button", class: "icon", "aria-label": label, title: label, onclick: click, ...properties },
    icon(path),
  );
}

/** A checkbox that looks like a switch, with its label. */
export function toggle(label, checked, changed, properties = {}) {
  const input = element("input", { type: "checkbox", role: "switch", checked, ...properties });
  input.addEventListener("change", () => changed(input.checked));
  return { input, row: element("label", { class: "switch" }, element("span", {}, label), input) };
}

/** choices: [value, text]. */
export function select(label, choices, value, changed, properties = {}) {
  const input = element("select", { "aria-label": label, title: label, ...properties });
  for (const [one, text] of choices) input.append(element("option", { value: one }, text));
  input.value = value;
  input.addEventListener("change", () => changed(input.value));
  return input;
}

/** Whether the attribute controlslist leaves a control out. */
export const leavesOut = ({ controlsList }, name) => controlsList.toLowerCase().split(/\s+/).includes(name);

/** Paths of icons in a box of 24 by 24, drawn as lines. */
export const icons = {
  play: "M8 5.6v12.8L18.5 12z",
  pause: "M8.5 6v12M15.5 6v12",
  replay: "M5 12a7 7 0 1 0 2.4-5.3L5 9M5 4.5V9h4.5",
  back: "M16 6.5v11L8.5 12zM6.5 6.5v11",
  forward: "M8 6.5v11l7.5-5.5zM17.5 6.5v11",
  loop: "M6 14V8.5h11M14.5 5.5l3 3-3 3M18 10v5.5H7M9.5 18.5l-3-3 3-3",
  sound: "M4 9.5h3.5L12 5.5v13l-4.5-4H4zM15 9a4 4 0 0 1 0 6M17.5 6.5a8 8 0 0 1 0 11",
  silence: "M4 9.5h3.5L12 5.5v13l-4.5-4H4zM15.5 9.5l5 5M20.5 9.5l-5 5",
  cameras: "M4 8h10.5v9H4zM14.5 11.2 20 8.5v8l-5.5-2.7M7 5.2h4.5",
  settings: "M4 7.5h8M16 7.5h4M4 16.5h4M12 16.5h8M14 5.3v4.4M10 14.3v4.4",
  stats: "M5 19V12M10 19V6M15 19v-5M20 19V9",
  fullscreen: "M5 9.5V5h4.5M14.5 5H19v4.5M19 14.5V19h-4.5M9.5 19H5v-4.5",
  leaveFullscreen: "M9.5 5v4.5H5M19 9.5h-4.5V5M14.5 19v-4.5H19M5 14.5h4.5V19",
  vr: "M4 8.5h16v7.5h-5l-1.6-2.4h-2.8L9 16H4zM8 11.8h.1M15.9 11.8h.1",
  ar: "M4 8V4.5h3.5M16.5 4.5H20V8M20 16v3.5h-3.5M7.5 19.5H4V16M12 8l4 2.2v4.2L12 16.6l-4-2.2v-4.2zM8 10.2l4 2.2 4-2.2M12 12.4v4.2",
  close: "M6.5 6.5l11 11M17.5 6.5l-11 11",
  look: "M3.5 12s3.2-5.5 8.5-5.5 8.5 5.5 8.5 5.5-3.2 5.5-8.5 5.5S3.5 12 3.5 12zM12 9.6a2.4 2.4 0 1 0 0 4.8 2.4 2.4 0 0 0 0-4.8",
  home: "M5 9.5V5h4.5M14.5 5H19v4.5M19 14.5V19h-4.5M9.5 19H5v-4.5M12 9.2a2.8 2.8 0 1 0 0 5.6 2.8 2.8 0 0 0 0-5.6",
  link: "M10 14a3.5 3.5 0 0 0 5 0l3-3a3.5 3.5 0 0 0-5-5l-1 1M14 10a3.5 3.5 0 0 0-5 0l-3 3a3.5 3.5 0 0 0 5 5l1-1",
  keys: "M4 7h16v10H4zM7 10.2h.1M10.3 10.2h.1M13.7 10.2h.1M17 10.2h.1M8 13.8h8",
};

/** 83.5 -> "1:23.50"; whole: without hundredths. */
export function clockTime(seconds, whole = false) {
  if (!Number.isFinite(seconds)) return "0:00";
  const hundredths = Math.floor(Math.max(0, seconds) * 100 + 1e-6);
  const all = Math.floor(hundredths / 100);
  const pad = (n) => String(n).padStart(2, "0");
  const [hours, minutes] = [Math.floor(all / 3600), Math.floor(all / 60) % 60];
  const text = hours ? `${hours}:${pad(minutes)}:${pad(all % 60)}` : `${minutes}:${pad(all % 60)}`;
  return whole ? text : `${text}.${pad(hundredths % 100)}`;
}

/** For screen readers: "1 minute 23.5 seconds". */
export function spokenTime(seconds) {
  const minutes = Math.floor(seconds / 60);
  const rest = Number((seconds - 60 * minutes).toFixed(2));
  const part = `${rest} ${rest === 1 ? "second" : "seconds"}`;
  return minutes ? `${minutes} ${minutes === 1 ? "minute" : "minutes"} ${part}` : part;
}

export const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(0)} MiB`;
export const bitrateText = (bits) =>
  bits >= 1e6 ? `${(bits / 1e6).toFixed(2)} Mbit/s` : `${(bits / 1e3).toFixed(0)} kbit/s`;
export const rateText = (rate) => `${rate}\u00d7`;
