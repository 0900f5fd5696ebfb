// Elements in one expression. No styles and no markup in strings: strict content policies forbid the ones, and
// trusted types the others.

/** properties: "on..." are listeners, "class" and those with a hyphen and role are attributes, others are properties. */
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
export function icon(path) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const shape = document.createElementNS(SVG, "path");
  shape.setAttribute("d", path);
  svg.append(shape);
  return svg;
}
/** solid: filled, as play is everywhere. */
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
