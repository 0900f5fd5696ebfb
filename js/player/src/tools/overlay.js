// What is drawn over the picture, as SVG: lines, dots and texts at places of the scene.

import { project, projectLine } from "./projection.js";

const SVG = "http://www.w3.org/2000/svg";
/** Pixels. */
const DOT = 4;
const HEAD = 13;

/** An element of SVG. Attributes are no inline styles, which content policies forbid. */
export function svg(name, attributes = {}, ...children) {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) if (value !== null) node.setAttribute(key, value);
  node.append(...children);
  return node;
}

export const pathText = (runs, closed = false) =>
  runs
    .map((run) => `M${run.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}${closed ? "Z" : ""}`)
    .join("");

export class Overlay {
  node = svg("svg", { class: "scene-marks", "aria-hidden": "true" });

  /**
   * Draws shapes for a view, in place of the former: {kind: "line", points, arrow, closed, fill}, {kind: "dot", at}, {kind: "text", at, text},
   * each with colour, and faint: whether it is not sure. Places are of the scene, or with flat of the picture.
   */
  draw(view, size, shapes) {
    this.node.setAttribute("viewBox", `0 0 ${view.width} ${view.height}`);
    this.node.replaceChildren(...shapes.flatMap((shape) => this.#nodes(view, size, shape)));
  }
  clear() {
    this.node.replaceChildren();
  }

  #nodes(view, size, shape) {
    const { kind, colour, width = 3, faint = false, flat = false } = shape;
    const common = { class: faint ? "faint" : null };
    if (kind === "line") {
      const runs = flat ? [shape.points] : projectLine(view, shape.points, size);
      if (!runs.length) return [];
      const text = pathText(runs, shape.closed && runs.length === 1);
      const line = { d: text, fill: shape.fill ? colour : "none", "fill-opacity": 0.18, "stroke-width": width };
      const nodes = [
        svg("path", { ...common, ...line, class: "halo", fill: "none", "stroke-width": width + 2 }),
        svg("path", { ...common, ...line, stroke: colour }),
      ];
      return shape.arrow ? [...nodes, ...this.#head(runs.at(-1), colour, width)] : nodes;
    }
    const at = flat ? shape.at : project(view, shape.at, size);
    if (!at) return [];
    const [x, y] = at.map((value) => value.toFixed(1));
    if (kind === "dot") return [svg("circle", { ...common, cx: x, cy: y, r: DOT, fill: colour })];
    const [dx, dy] = shape.offset ?? [0, 0];
    return [svg("text", { ...common, x: Number(x) + dx, y: Number(y) + dy, fill: colour }, shape.text)];
  }

  /** The head of an arrow at the end of a line on the screen. */
  #head(run, colour, width) {
    const [x, y] = run.at(-1);
    // The direction of the last few pixels: neighbours of a drawn line may be in one pixel.
    const from = run.findLast(([a, b]) => Math.hypot(x - a, y - b) > HEAD / 2) ?? run[0];
    const size = Math.hypot(x - from[0], y - from[1]);
    if (!(size > 0)) return [];
    const [ux, uy] = [(x - from[0]) / size, (y - from[1]) / size];
    const reach = HEAD + width;
    const corner = (side) => [x - reach * ux + (side * reach * uy) / 2, y - reach * uy - (side * reach * ux) / 2];
    const tip = [x + 2 * ux, y + 2 * uy];
    return [svg("path", { class: "head", d: pathText([[tip, corner(1), corner(-1)]], true), fill: colour })];
  }
}
