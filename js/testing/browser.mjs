// Browsers for tests that draw WebGL 2 without a GPU: headless Chromium, and Firefox on a virtual screen, because it has no
// headless WebGL. Chromium plays sound without a device; Firefox gets one that is silent. FVV_CHROMIUM, FVV_FIREFOX: paths
// of programs, if not in PATH. FVV_ANGLE: what ANGLE, Chromium's WebGL, draws with in place of the processor: vulkan, gl-egl,
// d3d11 or metal.

import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import puppeteer from "puppeteer-core";

const ANGLE = process.env.FVV_ANGLE ?? "swiftshader";
const drawing = {
  swiftshader: ["--enable-unsafe-swiftshader"],
  vulkan: ["--ignore-gpu-blocklist", "--enable-features=Vulkan", "--disable-vulkan-surface"],
};

const WEBGPU = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"];

const kinds = {
  chromium: {
    program: process.env.FVV_CHROMIUM ?? "chromium",
    launch: {
      browser: "chrome",
      args: [
        "--no-sandbox",
        "--use-gl=angle",
        `--use-angle=${ANGLE}`,
        ...(drawing[ANGLE] ?? ["--ignore-gpu-blocklist"]),
        // A busy machine draws so slowly that the watchdog ends the process that draws, and after a few times Chromium.
        "--disable-gpu-watchdog",
        "--disable-gpu-process-crash-limit",
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
    device: true,
    launch: {
      browser: "firefox",
      headless: false,
      extraPrefsFirefox: { "webgl.force-enabled": true },
    },
  },
};
/** Hints for developers, and Firefox's messages about drivers. */
const harmless = [
  /WebGL warning: .*(performance|drivers?)/i,
  /GL Driver Message \(OpenGL, Performance/,
  /WEBGL_debug_renderer_info is deprecated/,
];

const absent = (program, parameter) => spawnSync(program, [parameter]).error !== undefined;

/** The reason why a browser is not opened, or false. FVV_BROWSERS: the browsers to open, if not all. */
export function missingBrowser(name) {
  const { program, screen } = kinds[name];
  if (!(process.env.FVV_BROWSERS ?? name).split(" ").includes(name)) return `FVV_BROWSERS leaves out ${name}`;
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

/** The reason why a browser plays no sound, or false. */
export const missingSound = (name) =>
  kinds[name].device && absent("pulseaudio", "--version") ? "no pulseaudio installed" : false;

/** A silent sound device, with a server of its own: {env, close}. */
async function openDevice() {
  const folder = mkdtempSync(join(tmpdir(), "fvv-device-"));
  const socket = join(folder, "native");
  const modules = ["module-null-sink", `module-native-protocol-unix socket=${socket} auth-anonymous=1`];
  const modest = ["--use-pid-file=no", "--disable-shm=yes", "--realtime=no", "--high-priority=no"];
  const parameters = ["-n", "--daemonize=no", "--exit-idle-time=-1", ...modest, ...modules.map((text) => `-L${text}`)];
  const env = { HOME: folder, XDG_RUNTIME_DIR: folder };
  const server = spawn("pulseaudio", parameters, { stdio: "ignore", env: { ...process.env, ...env } });
  const close = () => {
    server.kill();
    rmSync(folder, { recursive: true, force: true });
  };
  for (let i = 0; i < 100 && !existsSync(socket); i++) {
    if (server.exitCode !== null) throw new Error(`pulseaudio ended with ${server.exitCode}`);
    await new Promise((done) => setTimeout(done, 50));
  }
  return { env: { PULSE_SERVER: `unix:${socket}` }, close };
}

/** Firefox crashes now and then at its start on a busy machine, before it has a page: it is started once more. */
async function start(options) {
  try {
    return await puppeteer.launch(options);
  } catch (error) {
    console.error(`${options.browser} did not start and is started once more: ${error.message.split("\n")[0]}`);
    return puppeteer.launch(options);
  }
}

/**
 * {name, newPage, troubles, close}; troubles: errors and warnings of the pages, including violations of the content policy.
 * sound: with a device, if missingSound finds nothing. webgpu: with WebGPU of Chromium, which draws on the processor.
 */
export async function openBrowser(name = "chromium", { sound = false, webgpu = false } = {}) {
  const { program, screen: wanted, device: needed, launch } = kinds[name];
  const path = spawnSync("which", [program], { encoding: "utf8" }).stdout.trim();
  const screen = wanted ? await openScreen() : null;
  const device = needed && sound && !missingSound(name) ? await openDevice() : null;
  const env = {
    ...process.env,
    ...(screen && { DISPLAY: screen.display, LIBGL_ALWAYS_SOFTWARE: "1" }),
    ...device?.env,
  };
  let browser;
  try {
    const args = [...(launch.args ?? []), ...(webgpu ? WEBGPU : [])];
    browser = await start({ ...launch, args, executablePath: path, env });
  } catch (error) {
    screen?.close();
    device?.close();
    throw error;
  }
  const troubles = [];
  let closing = false;
  let said = "";
  browser.process()?.stderr?.on("data", (text) => (said = `${said}${text}`.slice(-4000)));
  browser.on("disconnected", () => {
    if (!closing) console.error(`${name} ended by itself:\n${said}`);
  });
  const newPage = async (url, width = 960, height = 600) => {
    const page = await browser.newPage();
    // A busy machine takes longer than puppeteer's half minute.
    page.setDefaultNavigationTimeout(120000);
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
    closing = true;
    await browser.close();
    screen?.close();
    device?.close();
  };
  return { name, newPage, troubles, close };
}
