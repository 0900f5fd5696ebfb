// Browsers that draw WebGL 2 without a GPU and that tests drive: Chromium without a window, Firefox, which has WebGL in a
// window only, on a screen in memory. FVV_CHROMIUM, FVV_FIREFOX: other programs than those of PATH.

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
/** What pages say for the sake of their developers; Firefox speaks of drivers. */
const harmless = [/WebGL warning: .*(performance|drivers?)/i, /WEBGL_debug_renderer_info is deprecated/];

const absent = (program, parameter) => spawnSync(program, [parameter]).error !== undefined;

/** Why a browser can't be opened here, or false. */
export function missingBrowser(name) {
  const { program, screen } = kinds[name];
  if (absent(program, "--version")) return `no ${program} here`;
  return screen && absent("Xvfb", "-help") ? "no Xvfb here" : false;
}

/** A screen in memory: {display, close}. */
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

/** {name, newPage, troubles, close}; troubles: what the pages complain of, also of the content policy. */
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
      // A decoder that is closed leaves off in the middle.
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
