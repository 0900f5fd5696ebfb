// What the tests share: tools of the native build, a folder that fvvserve serves, and a page of Chromium that looks at it.

import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

import puppeteer from "puppeteer-core";

const root = resolve(fileURLToPath(import.meta.url), "../../../..");
const build = resolve(process.env.FVV_BUILD ?? join(root, "build/default"));
const program = (name) => join(build, "tools", name, name);
const chromium = process.env.FVV_CHROMIUM ?? "chromium";

export const missingBrowser = spawnSync(chromium, ["--version"]).error ? `no ${chromium} here` : false;

export function tool(name, ...parameters) {
  const { status, stderr, error } = spawnSync(program(name), parameters, { encoding: "utf8" });
  if (error) throw error;
  if (status !== 0) throw new Error(`${name} ${parameters.join(" ")}: ${status}\n${stderr}`);
}

/** {folder, url, close} */
export async function serveFolder() {
  const folder = mkdtempSync(join(tmpdir(), "fvv-three-"));
  const server = spawn(program("fvvserve"), ["--root", folder, "--port", "0"], {
    stdio: ["ignore", "pipe", "inherit"],
  });
  const url = await new Promise((listening, failed) => {
    server.stdout.once("data", (line) => listening(String(line).trim()));
    server.once("error", failed);
    server.once("exit", (code) => failed(new Error(`fvvserve ended with ${code}`)));
  });
  const close = () => {
    server.kill();
    rmSync(folder, { recursive: true, force: true });
  };
  return { folder, url, close };
}

/** troubles: what the pages complain of, also of the content policy. */
export async function openBrowser() {
  const path = spawnSync("which", [chromium], { encoding: "utf8" }).stdout.trim();
  const browser = await puppeteer.launch({
    executablePath: path,
    args: [
      "--no-sandbox",
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--no-first-run",
    ],
  });
  const troubles = [];
  const newPage = async (url, width = 960, height = 600) => {
    const page = await browser.newPage();
    page.on("console", (message) => {
      if (["error", "warn"].includes(message.type())) troubles.push(message.text());
    });
    page.on("pageerror", (error) => troubles.push(error.message));
    page.on("requestfailed", (request) => {
      // A decoder that is closed leaves off in the middle.
      if (!request.url().endsWith(".fvv")) troubles.push(`${request.url()}: ${request.failure().errorText}`);
    });
    await page.setViewport({ width, height });
    await page.goto(url);
    return page;
  };
  return { newPage, troubles, close: () => browser.close() };
}
