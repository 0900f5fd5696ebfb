// The reference of C and C++: each public header as a page. A block is a comment and the declarations after it, as the
// header has them; the comment becomes prose, with links to what it names.

import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { basename, dirname, join } from "node:path";

import { root } from "../sources.mjs";

const LIBRARIES = [
  ["fvv_mux", "The encoder: from a capture on disk, or from arrays in memory, to a stream."],
  ["fvv_view", "A frame of a stream drawn from anywhere."],
  ["fvv_compare", "Two sequences of meshes: distances, normals, motion."],
  ["fvv_cxx", "What the C++ libraries share: the exception type, meshes and pictures in memory."],
];
// Headers of C beside those of libfvv.
const IN_C = ["libfvv/mux/include/fvv"];

const NOISE =
  /^\s*(#\s*(ifndef \w+_H|define \w+_H$|include|pragma once|ifdef __cplusplus|endif)|extern "C"|namespace [\w:]+ \{|\} ?\/\/ namespace)/;

/** Comment lines as paragraphs of Markdown; indented lines stay as they are. */
function prose(lines, linked) {
  const parts = [];
  for (const line of lines) {
    const kind = line.trim() === "" ? "gap" : /^ {2,}\S/.test(line) ? "kept" : "text";
    if (kind !== "gap" && parts.at(-1)?.kind === kind) parts.at(-1).lines.push(line);
    else parts.push({ kind, lines: [line] });
  }
  const name = /\b(?:fvv_\w+|FVV_\w+|[a-z]\w*::\w+(?:::\w+)*)(?:\(\))?/g;
  const escaped = (text) =>
    text
      .replace(/&/g, "&amp;")
      .replace(/</g, "&lt;")
      .replace(/([*`[\]|{}])/g, "\\$1");
  const link = (text) => {
    const address = linked(text.replace("()", ""));
    return address ? `[\`${text}\`](${address})` : `\`${text}\``;
  };
  return parts
    .map(({ kind, lines }) => {
      if (kind === "gap") return "";
      if (kind === "kept") return ["```text", ...lines.map((line) => line.replace(/^ {2}/, "")), "```"].join("\n");
      const text = lines.join("\n");
      let out = "";
      let end = 0;
      for (const match of text.matchAll(name)) {
        // A prefix of names, such as FVV_UP_..., is none.
        const isPrefix = match[0].endsWith("_") || text.startsWith("...", match.index + match[0].length);
        out += escaped(text.slice(end, match.index)) + (isPrefix ? escaped(match[0]) : link(match[0]));
        end = match.index + match[0].length;
      }
      return out + escaped(text.slice(end));
    })
    .join("\n")
    .replace(/\n{3,}/g, "\n\n");
}

/** What a line is within the header: its text without the marks of a comment, if it is within one. */
function* read(text) {
  let inside = false;
  for (const line of text.split("\n")) {
    const begins = /^\/\*/.test(line);
    if (inside || begins) {
      const ends = line.includes("*/");
      yield { comment: line.replace(/^\/\* ?|^ \*(?!\/) ?/, "").replace(/\s*\*\/.*$/, "") };
      inside = !ends;
    } else if (/^\/\/ ?/.test(line)) yield { comment: line.replace(/^\/\/ ?/, "") };
    else yield { code: line };
  }
}

/** The names that declarations introduce. */
function namesOf(code) {
  const flat = code.replace(/\/\*[\s\S]*?\*\/|\/\/.*$/gm, "");
  let depth = 0;
  let outer = "";
  for (const character of flat) {
    if (character === "{") depth++;
    if (depth === 0) outer += character;
    if (character === "}") depth--;
  }
  const found = [
    ...[...outer.matchAll(/(?:\b(?:class|struct|enum(?: class)?) (\w+)(?=\s*(?::[^:][^;]*)?(?:$|[;\n{]|final)))/g)].map(
      ([, name]) => name,
    ),
    ...[...outer.matchAll(/^typedef (?:[\w ]+|[^;]*?)[ *](\w+)\s*;/gm)].map(([, name]) => name),
    ...[...outer.matchAll(/^typedef [^;(]*\(\*(\w+)\)/gm)].map(([, name]) => name),
    ...[...outer.matchAll(/^#define (\w+)/gm)].map(([, name]) => name),
    ...[...outer.matchAll(/^using (\w+) =/gm)].map(([, name]) => name),
    ...[...outer.matchAll(/^(?:inline )?constexpr [\w:<>, ]+ (\w+)\b/gm)].map(([, name]) => name),
    ...[...outer.matchAll(/^(?!typedef|#|using|constexpr|return|template)[\w:<>,*& ]+?[ *&](~?\w+)\s*\(/gm)].map(
      ([, name]) => name,
    ),
  ];
  return [...new Set(found)].filter((name) => !/^(?:defined|FVV_API|FVV_MUST_USE|__attribute__|operator)$/.test(name));
}

/** {intro, blocks: [{title} or {comment, code, names}]} of a header. */
export function parseHeader(text) {
  const blocks = [];
  let depth = 0;
  const last = () => blocks.at(-1);
  for (const { comment, code } of read(text)) {
    if (comment !== undefined && depth === 0) {
      const title = /^-{4} (.*?) -{4,}$/.exec(comment);
      if (title) blocks.push({ title: title[1] });
      else if (last()?.comment && !last().code.length && !last().closed) last().comment.push(comment);
      else blocks.push({ comment: [comment], code: [] });
      continue;
    }
    const line = comment === undefined ? code : `// ${comment}`;
    if (depth === 0 && (line.trim() === "" || NOISE.test(line))) {
      if (last()) last().closed = true;
      continue;
    }
    if (last()?.code === undefined || (last().closed && depth === 0)) blocks.push({ comment: [], code: [] });
    last().code.push(line);
    const bare = line.replace(/\/\/.*$|\/\*.*?\*\//g, "");
    depth += (bare.match(/\{/g) ?? []).length - (bare.match(/\}/g) ?? []).length;
  }
  const intro = blocks[0]?.comment && !blocks[0].code.length ? blocks.shift().comment : [];
  for (const block of blocks) if (block.code) block.names = namesOf(block.code.join("\n"));
  return { intro, blocks };
}

// Of C all; of C++ those that are installed.
function headersOf(library) {
  const short = library.replace(/^fvv_?/, "");
  const folders = library === "fvv" ? ["libfvv/include/fvv", ...IN_C] : [`libfvv/${short}/include/${library}`];
  const rules = library === "fvv" ? "" : readFileSync(join(root, "libfvv", short, "CMakeLists.txt"), "utf8");
  const installed = /fvv_library\([^)]*HEADERS ((?:\w+\.h\s*)+)/.exec(rules)?.[1].trim().split(/\s+/);
  return folders
    .flatMap((folder) => readdirSync(join(root, folder)).map((name) => ({ folder, name })))
    .filter(({ name }) => name.endsWith(".h") && (library === "fvv" || installed.includes(name)))
    .sort((a, b) => (a.name < b.name ? -1 : 1))
    .map(({ folder, name }) => ({
      path: `${library}/${name}`,
      ...parseHeader(readFileSync(join(root, folder, name), "utf8")),
    }));
}

/** What a header is for: the first sentence of its first comment. */
const purpose = ({ intro, path }) => {
  const text = intro.join(" ").replace(`${path}: `, "").replace(/\s+/g, " ");
  return (/^(.*?[.:])(?: |$)/.exec(text)?.[1] ?? text).replace(/:$/, ".").replace(/Spec: .*/, "");
};

function page(header, language, linked) {
  const { path, intro, blocks } = header;
  const begins = intro.join("\n").replace(`${path}: `, "");
  const lines = [`# ${path}`, "", prose(`${begins.charAt(0).toUpperCase()}${begins.slice(1)}`.split("\n"), linked)];
  const introduced = new Set();
  for (const { title, comment, code, names = [] } of blocks) {
    if (title) {
      lines.push("", `## ${title[0].toUpperCase()}${title.slice(1)}`);
      continue;
    }
    if (!code.length) {
      lines.push("", prose(comment, linked));
      continue;
    }
    // A type may be declared before it is defined.
    const [first, ...others] = names.filter((name) => !introduced.has(name));
    for (const name of names) introduced.add(name);
    if (first) lines.push("", `### ${first.replace(/_/g, "\\_")} {#${first}}`);
    if (others.length) lines.push("", others.map((name) => `<a id="${name}"></a>`).join(""));
    if (comment.length) lines.push("", prose(comment, linked));
    lines.push("", `\`\`\`${language}`, ...code, "```");
  }
  return lines.join("\n") + "\n";
}

/** Writes the pages below c/ and cpp/. Returns two references. */
export function headerReferences(out) {
  const c = { folder: "c", language: "c", libraries: [["fvv", ""]] };
  const cpp = { folder: "cpp", language: "cpp", libraries: LIBRARIES };
  const places = new Map();
  const pageOf = (folder, path) => (folder === "c" ? `c/${basename(path, ".h")}` : `cpp/${path.replace(".h", "")}`);
  for (const kind of [c, cpp]) {
    kind.headers = kind.libraries.map(([library]) => headersOf(library));
    for (const header of kind.headers.flat())
      for (const { names = [] } of header.blocks)
        for (const name of names)
          if (!places.has(name)) places.set(name, `/${pageOf(kind.folder, header.path)}#${name}`);
  }
  const linked = (name) => places.get(name) ?? places.get(name.split("::").at(-1));
  return [c, cpp].map(({ folder, language, libraries, headers }) => {
    const put = (name, text) => {
      mkdirSync(dirname(join(out, name)), { recursive: true });
      writeFileSync(join(out, name), text);
      return name;
    };
    const files = headers
      .flat()
      .map((header) => put(`${pageOf(folder, header.path)}.md`, page(header, language, linked)));
    const row = (header) => `| [${header.path}](/${pageOf(folder, header.path)}) | ${purpose(header)} |`;
    const table = (of) => ["| header | |", "|---|---|", ...of.map(row)].join("\n");
    const title = folder === "c" ? "C: libfvv" : "C++";
    const text =
      folder === "c"
        ? `The headers are C99. They say who owns what, which errors there are, and what a call costs.\n\n${table(headers[0])}\n`
        : libraries.map(([library, what], i) => `## ${library}\n\n${what}\n\n${table(headers[i])}`).join("\n\n");
    files.push(put(`${folder}/index.md`, `# ${title}\n\n${text}`));
    const items = headers.flat().map(({ path }) => ({ text: path, link: `/${pageOf(folder, path)}` }));
    return { title, folder, pages: [{ text: "All headers", link: `/${folder}/` }, ...items], files };
  });
}
