// The samples of JavaScript and HTML in all Markdown files run in Chromium, served by fvvserve under its content policy, with
// the bundles that js/player/README.md makes. tests/samples lists which samples those are.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { build } from "esbuild";

import { bundlePlayer } from "../../player/bundle.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { root, serveFolder, tool } from "../../testing/served.mjs";

const FOLDERS = ["docs", "spec", "js", "bindings", "conformance"];
const FENCE = /^[ \t]*```(js|html|sh)\n([\s\S]*?)^[ \t]*```$/gm;

/** All Markdown files of the project, by paths from its root. */
function pages() {
  const within = (folder) =>
    readdirSync(join(root, folder), { withFileTypes: true }).flatMap((entry) => {
      if (["node_modules", "dist"].includes(entry.name)) return [];
      const path = join(folder, entry.name);
      if (entry.isDirectory()) return within(path);
      return entry.name.endsWith(".md") ? [path] : [];
    });
  const top = readdirSync(root).filter((name) => name.endsWith(".md"));
  return [...top, ...FOLDERS.flatMap(within)].sort();
}

const samples = pages().flatMap((file) => {
  const text = readFileSync(join(root, file), "utf8");
  return [...text.matchAll(FENCE)].map((match) => ({
    name: `${file}:${text.slice(0, match.index).split("\n").length}`,
    language: match[1],
    text: match[2],
  }));
});

/** What a sample takes for granted: the reader's own names, and a decoder that an earlier sample made. */
function completed(text) {
  const lines = [];
  if (/\bcreateDecoder\b/.test(text) ? !/import .*createDecoder/.test(text) : /\bdecoder\./.test(text))
    lines.push('import { createDecoder } from "@fvv/decoder";');
  if (/\bsource\b[ ,]/.test(text) && !/source:/.test(text)) lines.push('const source = "players.fvv";');
  if (/\bdraw\(/.test(text))
    lines.push("const draw = (positions) => { if (!positions.length) throw Error('no mesh'); };");
  if (/\bdecoder\./.test(text) && !/const decoder/.test(text))
    lines.push('const decoder = await createDecoder({ source: "players.fvv" });');
  return [...lines, text, 'document.title = "done";'].join("\n");
}

describe("samples", { skip: missingBrowser("chromium") }, () => {
  let made, served, browser;
  before(async () => {
    made = mkdtempSync(join(tmpdir(), "fvv-samples-"));
    const stream = join(made, "players.fvv");
    tool(
      "fvvsynth",
      "-o",
      join(made, "capture"),
      "--rig",
      "small",
      "--cameras",
      "4",
      "--frames",
      "6",
      "--size",
      "160x96",
    );
    tool(
      "fvvmux",
      join(made, "capture"),
      "-o",
      stream,
      "--max-error",
      "0.5",
      "--ladder",
      "1,0.5",
      "--video-tracks",
      "2",
    );
    served = await serveFolder({ clip: stream });
    const at = (name) => join(served.folder, name);
    copyFileSync(stream, at("players.fvv"));
    copyFileSync(at("players.fvv"), at("scan.fvv"));
    copyFileSync(join(root, "js/site/src/marks/players.json"), at("play.json"));
    writeFileSync(at("favicon.ico"), "");
    // As the page of the player says; npx finds the packages in js.
    const { text } = samples.find(
      ({ language, text: command }) => language === "sh" && command.startsWith("npx esbuild"),
    );
    const command = text.trim().replace("npx esbuild", join(root, "js/node_modules/.bin/esbuild"));
    execFileSync("bash", ["-c", command.replace("--outdir=site", `--outdir=${served.folder} --log-level=error`)], {
      cwd: join(root, "js/player"),
    });
    await bundlePlayer(at("fvv-player.min.js"));
    browser = await openBrowser();
  });
  after(async () => {
    await browser?.close();
    served?.close();
    if (made) rmSync(made, { recursive: true, force: true });
  });

  test("there are samples", () => {
    assert.ok(samples.filter(({ language }) => language === "js").length >= 8);
    assert.ok(samples.filter(({ language }) => language === "html").length >= 3);
  });

  for (const [number, { name, language, text }] of samples.entries()) {
    if (language === "html")
      test(name, async () => {
        const page = `sample${number}.html`;
        writeFileSync(join(served.folder, page), /<!doctype/i.test(text) ? text : `<!doctype html>\n${text}`);
        const opened = await browser.newPage(`${served.url}${page}`, 480, 320);
        await opened.waitForFunction(() => document.querySelector("fvv-player")?.readyState >= 2, { timeout: 30000 });
        await opened.close();
        assert.deepEqual(
          browser.troubles.splice(0).filter((trouble) => !/worker/.test(trouble)),
          [],
        );
      });
    if (language === "js")
      test(name, async () => {
        const script = `sample${number}.js`;
        mkdirSync(join(served.folder, "samples"), { recursive: true });
        await build({
          stdin: { contents: completed(text), resolveDir: join(root, "js/three"), sourcefile: name },
          bundle: true,
          format: "esm",
          target: "es2022",
          // It is imported only where a browser lacks a codec, and is built separately.
          external: ["@fvv/video-fallback"],
          outfile: join(served.folder, script),
          logLevel: "error",
        });
        writeFileSync(
          join(served.folder, `sample${number}.html`),
          `<!doctype html><title>runs</title><script type="module" src="${script}"></script>`,
        );
        const opened = await browser.newPage(`${served.url}sample${number}.html`, 480, 320);
        const failed = () => browser.troubles.filter((trouble) => !/worker/.test(trouble));
        for (let waited = 0; waited < 300 && (await opened.title()) !== "done" && !failed().length; waited++)
          await new Promise((later) => setTimeout(later, 50));
        assert.deepEqual(failed(), []);
        assert.equal(await opened.title(), "done");
        browser.troubles.splice(0);
        await opened.close();
      });
  }
});
