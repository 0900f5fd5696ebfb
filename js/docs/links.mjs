// Links of Markdown files, as they are in the repository: what each points to, and whether that exists.

import { existsSync, readFileSync, statSync } from "node:fs";
import { dirname, join, posix } from "node:path";

import { root } from "./sources.mjs";

/** The identifier of a heading, by the rule of GitHub. */
export const slug = (text) =>
  text
    .toLowerCase()
    .replace(/[^\p{L}\p{N}_\- ]/gu, "")
    .replace(/ /g, "-");

/** A listing between fences. */
export const FENCE = /^([ \t]*)(`{3,}|~{3,})[^\n]*\n[\s\S]*?^\1\2[ \t]*$/gm;
const SPAN = /(`+)(?!`)[\s\S]*?[^`]\1(?!`)/g;
const hide = (text) => text.replace(/[^\n]/g, " ");

/** The text with code replaced by spaces, of the same length. */
export const withoutCode = (text) => text.replace(FENCE, hide).replace(SPAN, hide);

/** The identifiers of the headings of a Markdown file. */
export function anchorsOf(text) {
  const anchors = new Set();
  const prose = text.replace(FENCE, hide);
  for (const [, title] of prose.matchAll(/^#{1,6}\s+(.*?)\s*#*$/gm)) {
    const plain = title.replace(/\[([^\]]*)\]\([^)]*\)/g, "$1").replace(/[`*]/g, "");
    let name = slug(plain);
    for (let copy = 1; anchors.has(name); copy++) name = `${slug(plain)}-${copy}`;
    anchors.add(name);
  }
  for (const [, name] of prose.matchAll(/<\w+[^>]*\s(?:id|name)="([^"]+)"/g)) anchors.add(name);
  return anchors;
}

const LINK = /(!?\[(?:[^[\]]|\[[^\]]*\])*\]\()([^()\s]+)(\))|(\s(?:src|href)=")([^"]+)(")/g;

/** Calls change(address, isPicture) for each link of a Markdown text, and returns the text with what it returns. */
export function mapLinks(text, change) {
  const prose = withoutCode(text);
  let mapped = "";
  let end = 0;
  for (const match of prose.matchAll(LINK)) {
    const [before, after] = [match[1] ?? match[4], match[3] ?? match[6]];
    const from = match.index + before.length;
    const to = match.index + match[0].length - after.length;
    const isPicture = before.startsWith("!") || before.includes("src=");
    // The text of a link may have code in it, which prose hides.
    const changed = change(prose.slice(from, to), isPicture);
    mapped += text.slice(end, from) + (typeof changed === "string" ? changed : prose.slice(from, to));
    end = to;
  }
  return mapped + text.slice(end);
}

const anchors = new Map();
function anchorsIn(path) {
  if (!anchors.has(path)) anchors.set(path, anchorsOf(readFileSync(join(root, path), "utf8")));
  return anchors.get(path);
}

/** What an address in a file points to: {path, anchor} in the repository; null for one of another host. */
export function targetOf(source, address) {
  if (/^[a-z][a-z+.-]*:/i.test(address)) return null;
  const [path, anchor = ""] = decodeURI(address).split("#");
  return { path: path === "" ? source : posix.normalize(posix.join(dirname(source), path)).replace(/\/$/, ""), anchor };
}

/** Why a link of a file leads nowhere, or null. generated: paths of pages that are made when the site is built. */
export function deadBecause(source, address, generated = () => false) {
  const target = targetOf(source, address);
  if (target === null || generated(address)) return null;
  const { path, anchor } = target;
  if (path.startsWith("..")) return `${source}: ${address} is outside of the repository`;
  if (!existsSync(join(root, path))) return `${source}: ${address}: there is no ${path}`;
  if (!anchor) return null;
  const page = statSync(join(root, path)).isDirectory() ? `${path}/README.md` : path;
  if (!page.endsWith(".md")) return null;
  return anchorsIn(page).has(anchor) ? null : `${source}: ${address}: ${page} has no heading with this anchor`;
}
