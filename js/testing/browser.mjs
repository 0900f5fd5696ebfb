// Browsers for tests that draw WebGL 2 without a GPU: headless Chromium, and Firefox on a virtual screen, because it has no
// headless WebGL. FVV_CHROMIUM, FVV_FIREFOX: paths of programs, if not in PATH.

import { spawn, spawnSync } from "node:child_process";

import puppeteer from "puppeteer-core";

const kinds = {
  chromium: {
    program: process.env.FVV_CHROMIUM ?? "chromium",
    launch: {
      browser: "chrome",
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
    },
  },
  firefox: {
    program: process.env.FVV_FIREFOX ?? "firefox-esr",
    screen: true,
    launch: {
      browser: "firefox",
      headless: false,
      extraPrefsFirefox: { "webgl.force-enabled": true },
    },
  },
};
/** Hints for developers, and Firefox's messages about drivers. */
const harmless = [/WebGL warning: .*(performance|drivers?)/i, /WEBGL_debug_renderer_info is deprecated/];

const absent = (program, parameter) => spawnSync(program, [parameter]).error !== undefined;

/** The reason why a browser cannot be opened, or false. */
export function missingBrowser(name) {
  const { program, screen } = kinds[name];
  if (absent(program, "--version")) return `no ${program} installed`;
  return screen && absent("Xvfb", "-help") ? "no Xvfb installed" : false;
}

/** A virtual screen: {display, close}. */
async function openScreen() {
  const server = spawn("Xvfb", ["-displayfd", "3", "-screen", "0", "1600x1200x24", "-nolisten", "tcp"], {
    stdio: ["ignore", "ignore", "ignore", "pipe"],
  });
  const display = await new Promise((opened, failed) => {
    server.stdio[3].once("data", (number) => opened(`:${String(number).trim()}`));
    server.once("error", failed);
    server.once("exit", (code) => failed(new Error(`Xvfb ended with ${code}`)));
  });
  return { display, close: () => server.kill() };
}

/** {name, newPage, troubles, close}; troubles: errors and warnings of the pages, including violations of the content policy. */
export async function openBrowser(name = "chromium") {
  const { program, screen: wanted, launch } = kinds[name];
  const path = spawnSync("which", [program], { encoding: "utf8" }).stdout.trim();
  const screen = wanted ? await openScreen() : null;
  const env = screen ? { ...process.env, DISPLAY: screen.display, LIBGL_ALWAYS_SOFTWARE: "1" } : process.env;
  let browser;
  try {
    browser = await puppeteer.launch({ ...launch, executablePath: path, env });
  } catch (error) {
    screen?.close();
    throw error;
  }
  const troubles = [];
  const newPage = async (url, width = 960, height = 600) => {
    const page = await browser.newPage();
    page.on("console", (message) => {
      if (!["error", "warn"].includes(message.type())) return;
      if (!harmless.some((pattern) => pattern.test(message.text()))) troubles.push(message.text());
    });
    page.on("pageerror", (error) => troubles.push(error.message));
    page.on("requestfailed", (request) => {
      // A closed decoder aborts its requests.
      if (!new URL(request.url()).pathname.endsWith(".fvv"))
        troubles.push(`${request.url()}: ${request.failure()?.errorText}`);
    });
    await page.setViewport({ width, height });
    await page.goto(url);
    return page;
  };
  const close = async () => {
    await browser.close();
    screen?.close();
  };
  return { name, newPage, troubles, close };
}
