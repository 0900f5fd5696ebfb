// Copies the Markdown files of the repository, as pages, into a folder that VitePress reads: links to files become links to
// pages, pictures move along, and a source file that a page links to becomes a page.

import { copyFileSync, existsSync, mkdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { basename, dirname, extname, join, posix } from "node:path";

import { deadBecause, mapLinks, targetOf } from "./links.mjs";
import { pagesOf, root } from "./sources.mjs";

const PICTURES = new Set([".png", ".jpg", ".webp", ".svg"]);
const LANGUAGES = { ".h": "c", ".mjs": "js", ".md": "markdown", ".txt": "text", ".patch": "diff" };
const LONGEST_SOURCE = 200_000; // bytes
const LONGEST_COLOURED = 15_000; // characters; colours of long tables of figures cost seconds

/** An address that begins with reference: leads to a page that is made from sources: reference:c/stream.md. */
const REFERENCE = "reference:";

const relative = (from, to) => {
  const path = posix.relative(posix.dirname(from), to);
  return path.startsWith(".") ? path : `./${path}`;
};

function put(out, page, text) {
  const path = join(out, page);
  mkdirSync(dirname(path), { recursive: true });
  writeFileSync(path, text);
}

/** A page that shows a source file. */
function sourcePage(path) {
  const text = readFileSync(join(root, path), "utf8").trimEnd();
  const fence = "`".repeat(Math.max(3, ...[...text.matchAll(/`+/g)].map(([run]) => run.length + 1)));
  const plain = text.length > LONGEST_COLOURED && path.endsWith(".json");
  const language = plain ? "text" : (LANGUAGES[extname(path)] ?? (extname(path).slice(1) || "text"));
  const matter = "---\nsearch: false\noutline: false\neditLink: false\n---\n\n";
  return `${matter}# ${basename(path)}\n\n\`${path}\` of the repository.\n\n${fence}${language}\n${text}\n${fence}\n`;
}

/** Whether a file can be shown as a page. */
const isTextual = (path) =>
  !/\.(draco|drc|fvv|bin|gz|zip)$/.test(path) && statSync(join(root, path)).size < LONGEST_SOURCE;

/**
 * Writes all pages into the folder. references: the pages that are made from sources, with .md. Throws an Error that lists
 * all dead links.
 */
export function copyPages(out, references) {
  const pages = pagesOf();
  const sources = new Set();
  const dead = [];
  for (const [source, page] of pages) {
    const change = (address, isPicture) => {
      if (address.startsWith(REFERENCE)) {
        const [wanted, anchor] = address.slice(REFERENCE.length).split("#");
        if (!references.has(wanted)) dead.push(`${source}: ${address}: there is no such reference`);
        return relative(page, wanted) + (anchor ? `#${anchor}` : "");
      }
      const why = deadBecause(source, address);
      if (why) dead.push(why);
      const target = targetOf(source, address);
      if (target === null || why) return address;
      const { path, anchor } = target;
      const hash = anchor ? `#${anchor}` : "";
      const withReadme = existsSync(join(root, path, "README.md")) ? posix.join(path, "README.md") : path;
      if (pages.has(withReadme)) return relative(page, pages.get(withReadme)) + hash;
      if (PICTURES.has(extname(path))) {
        mkdirSync(join(out, "pictures"), { recursive: true });
        copyFileSync(join(root, path), join(out, "pictures", basename(path)));
        return relative(page, `pictures/${basename(path)}`) + (isPicture ? "" : "?picture");
      }
      if (statSync(join(root, path)).isDirectory() || !isTextual(path)) return "#in-the-repository";
      const header = /include\/(fvv|fvv_\w+)\/(\w+)\.h$/.exec(path);
      const described = header && (header[1] === "fvv" ? `c/${header[2]}.md` : `cpp/${header[1]}/${header[2]}.md`);
      if (references.has(described)) return relative(page, described);
      sources.add(path);
      return relative(page, `source/${path}.md`);
    };
    const text = mapLinks(readFileSync(join(root, source), "utf8"), change)
      // What is only in the repository is no link.
      .replace(/\[((?:[^[\]]|\[[^\]]*\])*)\]\(#in-the-repository\)/g, "$1");
    put(out, page, text);
  }
  if (dead.length) throw new Error(`links that lead nowhere:\n${dead.join("\n")}`);
  // The first page names its picture by its address.
  mkdirSync(join(out, "public"), { recursive: true });
  copyFileSync(join(root, "docs/pictures/walk.webp"), join(out, "public/walk.webp"));
  for (const path of sources) put(out, `source/${path}.md`, sourcePage(path));
}
