// The tools over the picture, in Chromium: loaded when they are wanted, and used by mouse, by touch and by keys alone. Screenshots are
// kept in FVV_ARTEFACTS (build/screens).

import assert from "node:assert/strict";
import { copyFileSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { root, tool } from "../../testing/served.mjs";
import { toolsBytes } from "../sizes.mjs";
import { figure } from "../src/tools/figures.js";
import { documentOf, packMarks, readMarks, unpackMarks } from "../src/tools/marks_document.js";
import { Marks } from "../src/tools/marks.js";
import { onPlane, project, projectLine } from "../src/tools/projection.js";
import { drivePage, openPage } from "./page_driver.mjs";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));
const screens = resolve(process.env.FVV_ARTEFACTS ?? here("../../../build/screens"));
const FRAMES = 24;

test("what the attribute loads is 40 kB with brotli at most", async () => {
  const { brotli, scripts } = await toolsBytes();
  assert.ok(scripts.length > 0 && brotli > 2000, "there are tools");
  assert.ok(brotli <= 40000, `${brotli} bytes`);
});

test("figures have no more digits than their uncertainty justifies", () => {
  const text = (value, uncertainty, ...more) => figure({ value, uncertainty }, "length", ...more).text;
  assert.equal(text(2.41379, 0.0123), "2.414 ± 0.012 m");
  assert.equal(text(2.41379, 0.054), "2.41 ± 0.05 m");
  assert.equal(text(241.379, 12), "241 ± 12 m");
  const speed = figure({ value: 10, uncertainty: 0.1 }, "speed", "km/h");
  assert.deepEqual([speed.text, speed.spoken], ["36.0 ± 0.4 km/h", "36.0 kilometres per hour, plus or minus 0.4"]);
});

test("places in the picture, lines that pass the eye, and places on a plane", () => {
  const view = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 5e6], fx: 100, fy: 100, cx: 50, cy: 40 };
  const at = (x, y, z) => [x, y, z - 5e6];
  assert.deepEqual(project(view, at(1, 2, 2), 1), [100, 140]);
  assert.equal(project(view, at(1, 2, -2), 1), null);
  assert.deepEqual(projectLine(view, [at(0, 0, -1), at(0, 0, -2)], 1), []);
  const [run, ...others] = projectLine(view, [at(0, 0, 2), at(0, 1, 1), at(0, 3, -1)], 1);
  assert.deepEqual(
    [run.slice(0, 2), run.length, others.length],
    [
      [
        [50, 40],
        [50, 140],
      ],
      3,
      0,
    ],
  );
  assert.ok(run[2][1] > 1e4, "cut where it passes the eye");
  const floor = { up: [0, 1, 0], level: -1 };
  assert.deepEqual(onPlane({ origin: [0, 1, 0], direction: [0.5, -1, 0] }, floor), [1, -1, 0]);
  assert.equal(onPlane({ origin: [0, 1, 0], direction: [1, 1, 0] }, floor), null);
});

describe("documents of marks", () => {
  const cases = JSON.parse(readFileSync(join(root, "tests/analysis/marks.json"), "utf8"));
  test("are read as their schema says", async () => {
    for (const document of cases.valid) {
      const marks = readMarks(document);
      assert.deepEqual(marks, document.marks);
      assert.deepEqual(await unpackMarks(await packMarks(marks)), marks);
      assert.deepEqual(readMarks(documentOf(marks)), marks);
    }
    for (const { where, document } of cases.refused)
      assert.throws(
        () => readMarks(document),
        (error) => error instanceof TypeError && error.message.startsWith(`marks: ${where}: expected `),
        JSON.stringify(document),
      );
  });
  test("in links are bounded", async () => {
    const bomb = Array.from({ length: 1000 }, () => ({
      kind: "freehand",
      points: Array.from({ length: 1000 }, () => [0.123456789, 0, 0]),
    }));
    await assert.rejects(unpackMarks(await packMarks(bomb)), /the link has more than 1048576 bytes/);
    await assert.rejects(unpackMarks("AAAA"));
  });
  test("are undone and redone", () => {
    const marks = new Marks();
    const kinds = () => marks.list.map(({ text }) => text).join("");
    const add = (text) => marks.add({ kind: "text", points: [[0, 0, 0]], text });
    let changes = 0;
    marks.addEventListener("change", () => changes++);
    for (const text of "abc") add(text);
    marks.undo();
    marks.undo();
    assert.deepEqual([kinds(), marks.canRedo], ["a", true]);
    marks.redo();
    add("d");
    assert.deepEqual([kinds(), marks.canRedo, changes], ["abd", false, 7]);
    marks.remove(marks.list[1]);
    assert.equal(kinds(), "ad");
    for (let i = 0; i < 9; i++) marks.undo();
    assert.deepEqual([kinds(), marks.canUndo], ["", false]);
  });
});

describe("tools", { skip: missingBrowser("chromium") }, () => {
  let folder, opened, browser, page;

  before(async () => {
    mkdirSync(screens, { recursive: true });
    folder = mkdtempSync(join(tmpdir(), "fvv-tools-"));
    const capture = join(folder, "capture");
    const clip = join(folder, "players.fvv");
    tool("fvvsynth", "-o", capture, "--rig", "small", "--cameras", "4", "--frames", `${FRAMES}`, "--size", "240x160");
    tool("fvvmux", capture, "-o", clip, "--group", "8", "--quality", "30", "--objects", "auto");
    opened = await openPage("chromium", clip);
    ({ browser, page } = opened);
    copyFileSync(here("../../node_modules/axe-core/axe.min.js"), join(opened.served.folder, "axe.js"));
    await until(() => window.player.readyState === 4);
    await until(() => window.player.stats.drawnFrames > 0);
  });
  after(async () => {
    assert.deepEqual(browser?.troubles ?? [], []);
    await opened?.close();
    rmSync(folder, { recursive: true, force: true });
  });

  const { ask, until, screen, click, press, still, seekTo, accessibility } = drivePage(() => page, screens, "tools");
  const scripts = () =>
    ask(() => performance.getEntriesByType("resource").filter(({ name }) => name.endsWith(".js")).length);
  const part = (name) => `.tools [part~="${name}"]`;
  /** Begins a tool, also where it is in use. */
  const choose = async (name) => {
    const isPressed = (selector) => window.player.shadowRoot.querySelector(selector).ariaPressed === "true";
    if (await ask(isPressed, part(name))) await page.keyboard.press("Escape");
    await until((selector) => window.player.shadowRoot.querySelector(selector).ariaPressed === "false", part(name));
    await click(part(name));
    await until(isPressed, part(name));
  };
  const measurements = () => ask(() => window.player.measurements);
  const hint = () => ask(() => window.player.shadowRoot.querySelector(".hint").textContent);
  const overlayText = () =>
    ask(() => Array.from(window.player.shadowRoot.querySelectorAll(".scene-marks text"), (node) => node.textContent));
  const removeAll = () =>
    ask(() => {
      for (const button of window.player.shadowRoot.querySelectorAll(".measurements button.icon")) button.click();
    });
  /** Where objects are seen: [{object, x, y, position}], one place each, in pixels of the window. */
  const seen = () =>
    ask(async () => {
      const { player } = window;
      const { left, top } = player.getBoundingClientRect();
      const found = new Map();
      for (let y = 0.06; y < 0.8; y += 0.02)
        for (let x = 0.05; x < 0.6; x += 0.02) {
          const [px, py] = [x * player.clientWidth, y * player.clientHeight];
          const hit = await player.pick(px, py);
          if (hit?.object == null || hit.facing < 0.5) continue;
          const { object, position } = hit;
          found.set(object, [...(found.get(object) ?? []), { object, position, x: left + px, y: top + py }]);
        }
      return Array.from(found.values(), (places) => places[places.length >> 1]);
    });
  const near = (value, expected, within) =>
    assert.ok(Math.abs(value - expected) <= within, `${value}, not ${expected}`);
  const apart = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));

  test("nothing is loaded without the attribute, and one click measures nothing", async () => {
    const former = await scripts();
    assert.equal(await ask(() => window.player.shadowRoot.querySelector(".tools")), null);
    await ask(() => (window.player.tools = "nothing of this"));
    await still();
    assert.equal(await scripts(), former);
    await ask(() => (window.player.tools = "measure"));
    await until(() => window.player.shadowRoot.querySelector(".tools") !== null);
    assert.ok((await scripts()) > former);
    assert.deepEqual(await measurements(), []);
  });

  test("by mouse: the distance of two places, with a label, its uncertainty and a text for screen readers", async () => {
    await seekTo(4);
    await still();
    const [a, b] = await seen();
    assert.ok(b, "two objects are seen");
    await choose("distance");
    await ask(() => window.player.shadowRoot.querySelector(".tool-options label:not([hidden]) input").click()); // places, not centres
    assert.match(await hint(), /first of two places/);
    await page.mouse.click(a.x, a.y);
    assert.match(await hint(), /second place/);
    await page.mouse.move(b.x - 4, b.y);
    await page.mouse.click(b.x, b.y);
    const [{ kind, names, value }] = await measurements();
    assert.deepEqual([kind, names], ["distance", ["place", "place"]]);
    near(value.value, apart(a.position, b.position), 0.02);
    assert.ok(value.uncertainty > 0 && value.uncertainty < 0.2, `${value.uncertainty} m`);
    assert.match(await hint(), /^Distance \d+\.\d+ metres, plus or minus \d/);
    assert.match((await overlayText())[0], /^\d+\.\d+ ± \d+\.\d+ m$/);
    assert.equal(await ask(() => window.player.paused), true, "a click with a tool does not play");
    await screen("distance");
    // The group has the same faces in all frames: places move with the surface. Another group may have others.
    await seekTo(6);
    const [{ value: later, samples }] = await measurements();
    assert.ok(later && later.value > 0 && samples.length === 2);
    await removeAll();
    assert.deepEqual(await measurements(), []);
  });

  test("by touch: two objects over the whole stream, and the graph seeks", async () => {
    await ask(() => window.player.shadowRoot.querySelector(".tool-options label:not([hidden]) input").click());
    await choose("distance");
    await seekTo(10);
    await still();
    const [a, b] = await seen();
    for (const [i, { x, y }] of [a, b].entries()) {
      const former = await hint();
      await page.touchscreen.tap(x, y);
      if (i === 0) assert.match(former, /first of two/);
      await until((former) => window.player.shadowRoot.querySelector(".hint").textContent !== former, former);
    }
    const [{ names, value, samples }] = await measurements();
    assert.ok(names.every((name) => name.startsWith("object ")) && names[0] !== names[1], `${names}`);
    assert.equal(samples.length, FRAMES);
    const now = await ask(() => window.player.currentTime);
    const same = samples.reduce((best, one) =>
      Math.abs(one.seconds - now) < Math.abs(best.seconds - now) ? one : best,
    );
    // What is on screen is of the decoded mesh, and the path of the one before.
    near(value.value, same.value.value, value.uncertainty + same.value.uncertainty);
    await screen("objects");
    const { x, y, width, height } = await ask(() => {
      const { x, y, width, height } = window.player.shadowRoot.querySelector(".graph").getBoundingClientRect();
      return { x, y, width, height };
    });
    await page.mouse.click(x + width * 0.25, y + height / 2);
    await until(() => !window.player.seeking);
    near(await ask(() => window.player.currentFrame), 0.25 * (FRAMES - 1), 1.1);
    await removeAll();
  });

  test("by keys alone: the speed of an object and a height by the cross-hair", async () => {
    await seekTo(12);
    await still();
    const [a] = await seen();
    const box = await ask(() => {
      const { left, top, width, height } = window.player.shadowRoot.querySelector(".surface").getBoundingClientRect();
      return { x: left + width / 2, y: top + height / 2 };
    });
    for (const name of ["speed", "height"]) {
      await ask((name) => window.player.shadowRoot.querySelector(`.tools [part~="${name}"]`).focus(), name);
      await page.keyboard.press("Enter");
      // The cross-hair stays where it was.
      for (const [key, way] of name === "height"
        ? []
        : [
            [a.x < box.x ? "ArrowLeft" : "ArrowRight", Math.abs(a.x - box.x)],
            [a.y < box.y ? "ArrowUp" : "ArrowDown", Math.abs(a.y - box.y)],
          ]) {
        for (let i = 0; i < Math.floor(way / 12); i++) await page.keyboard.press(key);
        await page.keyboard.down("Shift");
        for (let i = 0; i < Math.round(way % 12); i++) await page.keyboard.press(key);
        await page.keyboard.up("Shift");
      }
      if (name === "speed") await screen("keys");
      await page.keyboard.press("Enter");
      assert.match(await hint(), name === "speed" ? /^Speed .* metres per second/ : /^Height .* metres/);
    }
    const [speed, height] = await measurements();
    assert.ok(speed.value.value >= 0 && speed.value.value < 12 && speed.value.uncertainty > 0);
    assert.ok(height.value.value > 0 && height.value.value < 3, `${height.value.value} m`);
    await page.keyboard.press("Escape");
    assert.equal(
      await ask(() => window.player.shadowRoot.querySelector(".tools [aria-pressed=true]")),
      null,
      "Escape ends the tool",
    );
    const orbit = () => ask(() => window.player.cameraOrbit && window.player.getCameraAttributes().cameraOrbit);
    const former = await orbit();
    await press("ArrowLeft");
    await still();
    assert.notEqual(await orbit(), former, "arrows move the viewer again");
  });

  test("has no violations of axe-core, and saves values as CSV", async () => {
    await choose("speed");
    assert.deepEqual(await accessibility(), []);
    const text = await ask(async () => {
      const made = new Promise((done) => {
        const { createObjectURL } = URL;
        URL.createObjectURL = (blob) => {
          URL.createObjectURL = createObjectURL;
          done(blob.text());
          return "data:,";
        };
      });
      window.player.shadowRoot.querySelector(".measurements button.text").click();
      return made;
    });
    const [head, ...rows] = text.trim().split("\r\n");
    assert.equal(head, "seconds,speed,speed uncertainty");
    assert.equal(rows.length, FRAMES);
    await screen("list");
  });

  const marks = () => ask(() => window.player.getMarks().marks);
  const drag = async (from, to, steps = 6) => {
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move(...to, { steps });
    await page.mouse.up();
  };

  test("marks are drawn by mouse and by keys, stay with their object, and are undone", async () => {
    await removeAll();
    await ask(() => (window.player.tools = "measure mark follow"));
    await seekTo(4);
    await still();
    const orbit = () => ask(() => window.player.getCameraAttributes().cameraOrbit);
    const former = await orbit();
    const [a, b] = await seen();
    await choose("ellipse");
    await drag([a.x - 60, 350], [a.x + 60, 380]);
    await choose("freehand");
    await drag([a.x + 40, 300], [a.x + 100, 330], 12);
    await choose("trail");
    await page.mouse.click(b.x, b.y);
    await ask(() => {
      const [where] = window.player.shadowRoot.querySelectorAll('.tool-options select[aria-label^="Where"]');
      where.value = "surface";
      where.dispatchEvent(new Event("change"));
    });
    await choose("arrow");
    await page.mouse.click(a.x, a.y);
    await page.mouse.click(a.x + 40, a.y - 60);
    assert.equal(await orbit(), former, "drawing does not turn the scene");
    const list = await marks();
    assert.deepEqual(
      list.map(({ kind }) => kind),
      ["ellipse", "freehand", "trail", "arrow"],
    );
    readMarks({ fvv_marks: 1, marks: list });
    const [round, free, trail, arrow] = list;
    const level = await ask(() => window.player._stage.place.floor);
    for (const point of [...round.points, ...free.points]) near(point[1], level, 1e-6);
    assert.ok(free.points.length > 5);
    assert.equal(trail.object, b.object);
    assert.equal(arrow.object, a.object, "by its identifier, as it has no name");
    assert.ok(Math.hypot(...arrow.points[0]) < 1.2, "from the centre of the object");
    assert.equal(await ask(() => document.activeElement === window.player), true);
    const lines = () =>
      ask(() =>
        Array.from(window.player.shadowRoot.querySelectorAll(".scene-marks path[stroke]"), (n) => n.getAttribute("d")),
      );
    const before = await lines();
    assert.equal(before.length, 4);
    await seekTo(16);
    await screen("marks");
    const later = await lines();
    assert.deepEqual([later[0] === before[0], later[1] === before[1]], [true, true], "the floor stays");
    assert.notEqual(later.at(-1), before.at(-1), "the arrow goes with its object");
    await page.keyboard.down("Control");
    await page.keyboard.press("z");
    await page.keyboard.press("z");
    await page.keyboard.press("y");
    await page.keyboard.up("Control");
    assert.equal((await marks()).length, 3);
    // By keys: two places of the cross-hair.
    await choose("line");
    await page.keyboard.press("Enter");
    for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Enter");
    const line = (await marks()).at(-1);
    assert.ok(line.kind === "line" && apart(...line.points) > 0.05);
    await page.keyboard.press("Escape");
    assert.deepEqual(await accessibility(), []);
  });

  test("a link has time, view and marks, and a document has marks", async () => {
    const list = await marks();
    const address = await ask(async () => {
      await window.player.copyBookmark();
      return location.href;
    });
    assert.match(address, /fvv-marks=[\w-]+/);
    const { pathname } = new URL(address);
    writeFileSync(join(opened.served.folder, "play.json"), JSON.stringify({ fvv_marks: 1, marks: list.slice(0, 2) }));
    const time = await ask(() => window.player.currentTime);
    await page.goto("about:blank");
    await page.goto(address);
    await until(() => window.player?.readyState === 4);
    await ask(() => (window.player.tools = "mark"));
    await until((count) => window.player.getMarks().marks.length === count, list.length);
    assert.deepEqual(await marks(), list);
    near(await ask(() => window.player.currentTime), time, 0.041);
    await page.goto("about:blank");
    await page.goto(new URL(pathname, address).href);
    await until(() => window.player?.readyState === 4);
    // The page wants something else before the script is there.
    await ask(() => {
      window.player.tools = "measure";
      window.player.marks = "play.json";
      window.player.tools = "";
    });
    await until(() => window.player.getMarks().marks.length === 2);
    assert.equal(await ask(() => window.player.shadowRoot.querySelector(".tools").clientHeight), 0, "no tools");
    const wrong = await ask(() => window.player.setMarks({ fvv_marks: 3, marks: [] }).catch((error) => error.message));
    assert.equal(wrong, "marks: fvv_marks: expected 1, found 3");
  });

  test("the view follows an object, and the viewer moves around it", async () => {
    await ask(() => (window.player.tools = "follow"));
    await seekTo(2);
    await still();
    const objects = await ask(() =>
      Array.from(window.player.shadowRoot.querySelectorAll(".tools button[aria-pressed]"), (node) => node.textContent),
    );
    assert.ok(objects.length >= 3 && objects[0].startsWith("Follow object"), `${objects}`);
    await ask(() => window.player.shadowRoot.querySelector(".tools li:nth-child(3) button").click());
    await still();
    const spot = () =>
      ask(async () => {
        const { eye, target } = window.player.getPose();
        return { eye, target };
      });
    const first = await spot();
    await seekTo(14);
    await still();
    const then = await spot();
    const moved = apart(first.target, then.target);
    assert.ok(moved > 0.05, `the object moved, by ${moved} m`);
    near(apart(first.eye, first.target), apart(then.eye, then.target), 1e-6);
    await press("ArrowLeft");
    await still();
    const around = await spot();
    assert.deepEqual(around.target, then.target);
    assert.ok(apart(around.eye, then.eye) > 0.02);
    await screen("follow");
    await ask(() => window.player.follow(null));
    await seekTo(2);
    assert.deepEqual((await spot()).target, around.target);
    const wrong = await ask(() => window.player.follow("umpire").catch(({ message }) => message));
    assert.equal(wrong, "the stream names no object umpire");
  });

  test("waiting for a first frame ends with the tools", async () => {
    const reason = await ask(async () => {
      const player = document.createElement("fvv-player");
      player.setAttribute("tools", "follow");
      document.body.append(player);
      const failed = player.follow("ball").catch(({ name }) => name);
      while (!player.shadowRoot.querySelector(".tools")) await new Promise(requestAnimationFrame);
      player.removeAttribute("tools");
      const name = await failed;
      player.remove();
      return name;
    });
    assert.equal(reason, "AbortError");
  });

  test("without the attribute all is gone, and clicks play again", async () => {
    await ask(() => {
      window.player.removeAttribute("marks");
      window.player.removeAttribute("tools");
    });
    assert.equal(await ask(() => window.player.shadowRoot.querySelector(".tools, .scene-marks, .cross-hair")), null);
    assert.deepEqual(await measurements(), []);
    await page.mouse.click(200, 200);
    await until(() => !window.player.paused);
    await ask(() => window.player.pause());
  });
});
