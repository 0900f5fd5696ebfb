// Headless browsers, and the results that their pages post. FVV_CHROMIUM, FVV_FIREFOX: paths of programs, if not in PATH.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const browsers = {
  chromium: {
    program: process.env.FVV_CHROMIUM ?? "chromium",
    parameters: (profile, url) => [
      "--headless=new",
      "--no-sandbox",
      "--disable-gpu",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--no-first-run",
      `--user-data-dir=${profile}`,
      url,
    ],
  },
  firefox: {
    program: process.env.FVV_FIREFOX ?? "firefox-esr",
    parameters: (profile, url) => ["--headless", "--no-remote", "--profile", profile, url],
  },
};

/** Opens a page with a profile of its own. Returns a function that ends the browser. */
export function visit({ program, parameters }, url) {
  const profile = mkdtempSync(join(tmpdir(), "fvv-browser-"));
  const browser = spawn(program, parameters(profile, url), { stdio: "ignore", detached: true });
  const gone = new Promise((resolve) => browser.once("exit", resolve));
  return async () => {
    process.kill(-browser.pid);
    await gone;
    rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
  };
}

/** {result, post}: a promise that post fulfils, and that is rejected after a while. */
export function awaitPost(seconds) {
  let post;
  const result = new Promise((resolve, reject) => {
    post = resolve;
    setTimeout(() => reject(new Error("the page does not respond")), 1000 * seconds).unref();
  });
  return { result, post };
}
