// The pages of the site: what all have around their content, the page that embeds the player, and the specification.

import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";
import { fileURLToPath } from "node:url";
import { Marked, Renderer } from "marked";

const PAGES = [
  ["", "Player"],
  ["embed.html", "Embed"],
  ["three/", "three.js"],
  ["spec/fvv.html", "Specification"],
  ["docs/", "Docs"],
];

/** A whole page. page: address below the site's root, "" for the first; script: a module; content: HTML of main. */
export function frame({ title, page, script, content, kind = "" }) {
  const root = "../".repeat(page.split("/").length - 1) || "./";
  const links = PAGES.map(([address, name]) => {
    const current = address === page ? ' aria-current="page"' : "";
    return `        <a href="${root}${address}"${current}>${name}</a>`;
  });
  return `<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <meta name="viewport" content="width=device-width, initial-scale=1, viewport-fit=cover" />
    <meta name="color-scheme" content="light dark" />
    <title>${title}</title>
    <link rel="icon" href="${root}favicon.ico" />
    <link rel="stylesheet" href="${root}site.css" />
    <script type="module" src="${root}${script}"></script>
  </head>
  <body>
    <a class="skip" href="#content">Skip to content</a>
    <header class="top">
      <a class="brand" href="${root}">fvv</a>
      <nav aria-label="Pages">
${links.join("\n")}
      </nav>
      <button class="theme" type="button" data-theme-toggle aria-label="Dark or light">
        <svg viewBox="0 0 24 24" aria-hidden="true">
          <circle cx="12" cy="12" r="8.5" fill="none" stroke="currentColor" stroke-width="2" />
          <path d="M12 3.5a8.5 8.5 0 0 1 0 17z" fill="currentColor" />
        </svg>
      </button>
    </header>
    <main id="content" class="${kind}">
${content.trimEnd()}
    </main>
    <footer class="end">
      <p>
        fvv, a streaming file format for free-viewpoint video, under the Apache License 2.0.
        <a href="${root}embed.html">Five lines of HTML</a> put the player into a page; <a href="${root}spec/fvv.html">the specification</a>
        describes the format.
      </p>
    </footer>
  </body>
</html>
`;
}

/** The page that embeds the player, as short as possible; a formatter would make more lines of it. */
export const FIVE_LINES = `<!doctype html>
<html lang="en">
<title>My clip</title>
<script type="module" src="player.js"></script>
<fvv-player src="clips/players.fvv" controls autoplay loop></fvv-player>
`;

const folder = fileURLToPath(new URL("../../spec/", import.meta.url));

const slug = (text) =>
  text
    .toLowerCase()
    .replace(/[^\w\- ]/g, "")
    .replace(/ /g, "-");

/** pages: names of all pages. Links to other files of the repository become plain text. */
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
      // Wide tables and listings scroll separately, also by keyboard.
      table(token) {
        const table = Renderer.prototype.table.call(this, token);
        // Empty headings are not accessible.
        const cells = table.replace(/<th[^>]*><\/th>/g, "<td></td>");
        return `<div class="scroll" tabindex="0" role="group" aria-label="Table">${cells}</div>`;
      },
      code({ text }) {
        return `<pre tabindex="0"><code>${text.replace(/&/g, "&amp;").replace(/</g, "&lt;")}</code></pre>`;
      },
    },
  });
}

/** Writes the specification as pages, from its Markdown. frame(name, title, content): returns a whole page. */
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
