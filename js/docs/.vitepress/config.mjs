// VitePress: the pages that ../build.mjs put together, under the content security policy of fvvserve (no inline scripts or
// styles). FVV_DOCS: JSON of {pages, references, base}, from ../build.mjs.

import { createHash } from "node:crypto";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

import { transformerStyleToClass } from "@shikijs/transformers";
import { defineConfig } from "vitepress";

import { icon } from "../../site/icon.mjs";
import { FENCE, slug } from "../links.mjs";
import { navigation, sidebar } from "./navigation.mjs";

const { pages, references, base } = JSON.parse(process.env.FVV_DOCS);
const installed = createRequire(import.meta.url).resolve;
const colours = transformerStyleToClass({ classPrefix: "c-" });
const scripts = new Map();

/** The page with its scripts beside it in place of inside of it, and without styles of elements (those are in style.css). */
function outside(html) {
  return (
    html
      // The theme's first page has no main region; theme/index.js keeps this right when another page opens.
      .replace('<div class="VPContent is-home"', '<div role="main" class="VPContent is-home"')
      .replace(/ style="(?:position:relative;|--vp-vh:0px;|)"/g, "")
      .replace(/<script(?![^>]*\ssrc=)([^>]*)>([\s\S]+?)<\/script>/g, (_, attributes, code) => {
        const name = `assets/inline.${createHash("sha256").update(code).digest("hex").slice(0, 8)}.js`;
        scripts.set(name, code);
        return `<script${attributes} src="${base}${name}"></script>`;
      })
  );
}

/** The alignment of cells as classes, and headings of tables that are empty as cells. */
function plainTables(markdown) {
  for (const kind of ["th_open", "td_open"]) {
    markdown.renderer.rules[kind] = (tokens, index, options, _, renderer) => {
      const token = tokens[index];
      const style = token.attrGet("style");
      if (style) {
        token.attrs = token.attrs.filter(([name]) => name !== "style");
        token.attrJoin("class", style.replace("text-align:", "to-the-"));
      }
      if (kind === "th_open" && tokens[index + 1].content === "") {
        token.tag = "td";
        tokens[index + 2].tag = "td";
      }
      return renderer.renderToken(tokens, index, options);
    };
  }
  // Indented code looks like fenced code.
  markdown.renderer.rules.code_block = (tokens, index, ...rest) => {
    Object.assign(tokens[index], { type: "fence", info: "text" });
    return markdown.renderer.rules.fence(tokens, index, ...rest);
  };
  // Wide tables scroll, also by keyboard.
  markdown.renderer.rules.table_open = () =>
    '<div class="scroll" tabindex="0" role="group" aria-label="Table"><table>\n';
  markdown.renderer.rules.table_close = () => "</table></div>\n";
}

/** What the search looks at: prose, not listings, whose colours take long. */
function searched(text, env, markdown) {
  const html = markdown.render(text.replace(FENCE, ""), env);
  return env.frontmatter?.search === false ? "" : html;
}

export default defineConfig({
  title: "fvv",
  titleTemplate: ":title - fvv",
  description: "A streaming file format for free-viewpoint video",
  lang: "en",
  base,
  srcDir: pages,
  cacheDir: join(pages, "../cache"),
  // The theme would write a style element while it changes colours.
  appearance: { disableTransition: false },
  head: [
    ["link", { rel: "icon", href: `${base}favicon.ico` }],
    ["link", { rel: "stylesheet", href: `${base}assets/code.css` }],
  ],
  metaChunk: true,
  markdown: {
    anchor: { slugify: slug },
    codeTransformers: [colours],
    theme: { light: "github-light-high-contrast", dark: "github-dark-high-contrast" },
    languageAlias: { ksy: "yaml" },
    config: plainTables,
  },
  // build.mjs finds dead links first, and says in which file of the repository they are.
  ignoreDeadLinks: false,
  themeConfig: {
    nav: navigation,
    sidebar: sidebar(references),
    outline: [2, 3],
    search: { provider: "local", options: { detailedView: false, _render: searched } },
    docFooter: { prev: "Before", next: "Next" },
    footer: { message: "Apache License 2.0" },
  },
  transformHtml: (html) => outside(html),
  buildEnd({ outDir }) {
    mkdirSync(join(outDir, "assets"), { recursive: true });
    writeFileSync(join(outDir, "assets/code.css"), colours.getCSS());
    writeFileSync(join(outDir, "favicon.ico"), icon());
    for (const [name, code] of scripts) if (!existsSync(join(outDir, name))) writeFileSync(join(outDir, name), code);
  },
  vite: {
    build: { chunkSizeWarningLimit: 8000 },
    logLevel: "warn",
    // Pages are in build/, from where Node's rules do not lead to js/node_modules.
    resolve: {
      alias: [
        { find: /^vue$/, replacement: installed("vue/dist/vue.runtime.esm-bundler.js") },
        { find: /^vue\/server-renderer$/, replacement: installed("vue/server-renderer") },
      ],
    },
  },
});
