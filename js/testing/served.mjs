// Shared by tests: the tools of the native build, and a folder that fvvserve serves under its content policy.

import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

export const root = resolve(fileURLToPath(import.meta.url), "../../..");
export const build = resolve(process.env.FVV_BUILD ?? join(root, "build/default"));
export const toolPath = (name) => join(build, "tools", name, name);

/** Returns what the tool prints. */
export function tool(name, ...parameters) {
  const { status, stdout, stderr, error } = spawnSync(toolPath(name), parameters, { encoding: "utf8" });
  if (error) throw error;
  if (status !== 0) throw new Error(`${name} ${parameters.join(" ")}: ${status}\n${stderr}`);
  return stdout;
}

/** {folder, url, close}. live: files that are played in a loop at /live/NAME. */
export async function serveFolder(live = {}) {
  const folder = mkdtempSync(join(tmpdir(), "fvv-page-"));
  const streams = Object.entries(live).flatMap(([name, file]) => ["--live", `${name}=${file}`]);
  const server = spawn(toolPath("fvvserve"), ["--root", folder, "--port", "0", "--loop", ...streams], {
    stdio: ["ignore", "pipe", "inherit"],
  });
  const url = await new Promise((listening, failed) => {
    server.stdout.once("data", (line) => listening(String(line).split("\n")[0]));
    server.once("error", failed);
    server.once("exit", (code) => failed(new Error(`fvvserve ended with ${code}`)));
  });
  let closing = false;
  server.once("exit", (code, signal) => {
    if (!closing) console.error(`fvvserve ended by itself: ${signal ?? code}`);
  });
  const close = () => {
    closing = true;
    server.kill();
    rmSync(folder, { recursive: true, force: true });
  };
  return { folder, url, close };
}
