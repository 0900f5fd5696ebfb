// The specification as pages of the site, out of its Markdown.

import { mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";

import { Marked, Renderer } from "marked";

const folder = fileURLToPath(new URL("../../spec/", import.meta.url));

const slug = (text) =>
  text
    .toLowerCase()
    .replace(/[^\w\- ]/g, "")
    .replace(/ /g, "-");

/** pages: names of those that there are. Links to other files of the repository become plain text. */
function converter(pages) {
  return new Marked({
    renderer: {
      heading({ tokens, depth, text }) {
        return `<h${depth} id="${slug(text)}">${this.parser.parseInline(tokens)}</h${depth}>\n`;
      },
      link({ href, tokens }) {
        const text = this.parser.parseInline(tokens);
        const [, page, anchor = ""] = /^([\w-]+)\.md(#.*)?$/.exec(href) ?? [];
        if (pages.includes(page)) return `<a href="${page}.html${anchor}">${text}</a>`;
        return /^(#|https?:)/.test(href) ? `<a href="${href}">${text}</a>` : text;
      },
      // Wide tables and listings scroll by themselves, also by keyboard.
      table(token) {
        const table = Renderer.prototype.table.call(this, token);
        // A heading without words is none.
        const cells = table.replace(/<th[^>]*><\/th>/g, "<td></td>");
        return `<div class="scroll" tabindex="0" role="group" aria-label="Table">${cells}</div>`;
      },
      code({ text }) {
        return `<pre tabindex="0"><code>${text.replace(/&/g, "&amp;").replace(/</g, "&lt;")}</code></pre>`;
      },
    },
  });
}

/** frame(name, title, content): the page around it. */
export function writeSpecification(out, frame) {
  const pages = readdirSync(folder)
    .filter((name) => name.endsWith(".md") && name !== "README.md")
    .map((name) => basename(name, ".md"));
  const marked = converter(pages);
  mkdirSync(out, { recursive: true });
  for (const page of pages) {
    const text = readFileSync(join(folder, `${page}.md`), "utf8");
    const title = /^# (.*)/m.exec(text)?.[1] ?? page;
    writeFileSync(join(out, `${page}.html`), frame(page, title.replace(/[`<&]/g, ""), marked.parse(text)));
  }
}
