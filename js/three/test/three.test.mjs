// The object as drawn by Chromium, compared with pictures of fvvrender of the same frames; and the example page. Both are
// served by fvvserve under its content policy.

import assert from "node:assert/strict";
import { cpSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { after, before, describe, test } from "node:test";

import { bundle, bundleExample } from "../bundle.mjs";
import { missingBrowser, openBrowser } from "../../testing/browser.mjs";
import { moveCapture } from "../../testing/moved_capture.mjs";
import { serveFolder, tool } from "../../testing/served.mjs";

/** dB over the foreground. A percent of its pixels, at edges, is of another surface. */
const LEAST_PSNR = 32;
/** Its edges are finer; its own conversion of colours would give 34 to 37. */
const LEAST_PSNR_FIREFOX = 40;
/** Where one camera alone colours a place, or a strong colour none, seams are as sharp as edges. */
const LEAST_PSNR_SEAMS = 30;

describe("three", { skip: missingBrowser("chromium") }, () => {
  let served, browser, page;
  const at = (name) => join(served.folder, name);

  function makeStreams() {
    const synth = (name, ...more) => tool("fvvsynth", "-o", at(name), ...more);
    const mux = (capture, name, ...more) =>
      tool("fvvmux", at(capture), "-o", at(`${name}.fvv`), "--group", "2", "--view-loss", "none", ...more);
    synth("small", "--rig", "small", "--frames", "4", "--size", "320x240");
    mux("small", "bits", "--visibility", "weight", "--texture-inset", "30mm");
    mux("small", "spread", "--video-tracks", "3");
    mux("small", "vp9", "--codec", "vp9");
    mux("small", "maps", "--visibility", "none", "--codec", "jpeg", "--quality", "90");
    const by = [4000000, -2500000.5, 4700000.25];
    moveCapture(at("small"), "far", { by });
    mux("small/far.json", "far", "--visibility", "none", "--frames", "0-0", "--codec", "jpeg", "--quality", "90");
    const plain = ["--visibility", "none", "--texture-inset", "off", "--codec", "jpeg", "--quality", "90"];
    for (const [name, scale] of Object.entries({ unit: 1, tiny: 0.0002 })) {
      moveCapture(at("small"), name, { scale });
      mux(`small/${name}.json`, name, "--frames", "0-0", ...plain);
    }
    const texturing = [
      "--texture-best",
      "1",
      "--texture-threshold",
      "0.5",
      "--texture-unseen",
      "250,10,60",
      "--texture-blend",
      "paper",
    ];
    mux("small", "texturing", "--visibility", "none", "--frames", "0-0", ...texturing);
    synth("studio", "--frames", "2", "--size", "480x270", "--meshes", "hull", "--hull-cells", "50");
    mux("studio", "studio");
    synth("many", "--rig", "small", "--cameras", "64", "--frames", "1", "--size", "320x200");
    mux("many", "many", "--visibility", "weight", "--codec", "jpeg", "--quality", "90");
    const mapped = ["--cameras", "3", "--atlas", "--atlas-size", "512"];
    synth("mapped", "--rig", "small", "--frames", "1", "--size", "320x240", ...mapped);
    mux("mapped", "mapped");
    // Colours are taken from wrong places, but from the same ones as in fvvrender.
    cpSync(at("small"), at("bent"), { recursive: true });
    const capture = JSON.parse(readFileSync(at("bent/capture.json"), "utf8"));
    for (const camera of capture.cameras)
      if (camera.id > 0) camera.lens = { model: "fisheye", coefficients: [0.05, -0.02, 0.01, -0.002] };
    writeFileSync(at("bent/capture.json"), JSON.stringify(capture));
    mux("bent", "bent", "--crop", "none", "--visibility", "none", "--keep-geometry");
  }

  before(async () => {
    served = await serveFolder();
    makeStreams();
    const here = (name) => fileURLToPath(new URL(name, import.meta.url));
    await bundle(here("compare.js"), [here("compare.html")], at("test"));
    await bundleExample(served.folder);
    browser = await openBrowser();
    page = await browser.newPage(`${served.url}test/compare.html`);
    await page.waitForSelector("[data-ready]");
  });
  after(async () => {
    await browser?.close();
    served?.close();
  });

  /** With fvvrender's pictures of the stream, or of another one that has to look the same. */
  async function compare(stream, number, cameras, { render = [], as = stream, on = { browser, page }, ...more } = {}) {
    const cases = cameras.map((camera) => {
      const [picture, mask] = ["picture", "mask"].map((kind) => `/${stream}-${number}-${camera}-${kind}.png`);
      const output = ["-o", at(picture), "--mask", at(mask), "--force"];
      tool("fvvrender", at(`${as}.fvv`), "--frame", `${number}`, "--camera", `${camera}`, ...render, ...output);
      return { camera, picture, mask };
    });
    const found = await on.page.evaluate((parameters) => window.compare(parameters), {
      file: `/${stream}.fvv`,
      number,
      cases,
      ...more,
    });
    assert.deepEqual(on.browser.troubles, []);
    return found;
  }

  function assertAlike({ results }, least = LEAST_PSNR) {
    for (const { camera, psnr, count, outside, grey } of results) {
      assert.ok(count > 1000, `camera ${camera}: ${count} pixels of foreground`);
      assert.ok(psnr > least, `camera ${camera}: ${psnr.toFixed(1)} dB`);
      assert.ok(outside < 0.01 * count, `camera ${camera}: ${outside} pixels beyond the outline`);
      assert.ok(grey < 0.05 * count, `camera ${camera}: ${grey} grey pixels`);
    }
  }

  const bits = { render: ["--visible-by", "bits"] };
  const maps = { render: ["--visible-by", "depth"] };

  test("cameras in several tracks, some of which are left out", async () => {
    const { tracks } = await compare("spread", 1, []);
    assert.equal(tracks.length, 3);
    const ids = ({ tiles }) => tiles.map(({ camera }) => camera);
    const [camera] = ids(tracks[0]);
    assertAlike(await compare("spread", 1, [camera], bits));
    const selected = tracks.slice(0, 2);
    const render = [...bits.render, "--sources", selected.flatMap(ids).join()];
    const found = await compare("spread", 1, [camera], { render, tracks: selected.map(({ track }) => track) });
    assert.equal(found.views, selected.flatMap(ids).length);
    assert.deepEqual(found.tracks[2].tiles, []);
    assertAlike(found);
  });

  test("H.264, visibility by weights", async () => {
    const found = await compare("bits", 1, [0, 2, 3], bits);
    assert.equal(found.hasVisibility, true);
    assert.equal(found.views, 7);
    assertAlike(found);
  });
  test("texturing parameters of the stream, and overrides", async () => {
    assertAlike(await compare("texturing", 0, [0, 2], maps), LEAST_PSNR_SEAMS);
    const own = { threshold: 0.3, best: 3, unseen: 0x0ac83c };
    const asked = ["--threshold", "0.3", "--best", "3", "--unseen", "10,200,60"];
    assertAlike(await compare("texturing", 0, [0, 2], { render: [...maps.render, ...asked], own }), LEAST_PSNR_SEAMS);
    for (const [name, value] of Object.entries({ threshold: 0.25, best: 3, unseen: 0x808080, blend: "viewer" })) {
      const { results } = await compare("texturing", 0, [0, 2], { ...maps, own: { [name]: value } });
      const worst = Math.min(...results.map(({ psnr }) => psnr));
      assert.ok(worst < LEAST_PSNR_SEAMS - 0.5, `${name} makes no difference: ${worst.toFixed(1)} dB`);
    }
  });
  test("VP9", async () => {
    assertAlike(await compare("vp9", 1, [0, 2]));
  });
  test("JPEG, visibility by depth maps", async () => {
    const found = await compare("maps", 0, [0, 2, 3], maps);
    assert.equal(found.hasVisibility, false);
    assertAlike(found);
  });
  test("a group with another layout of tiles", async () => {
    const [first, second] = [await compare("maps", 1, [0], maps), await compare("maps", 3, [0, 2, 3], maps)];
    assert.notDeepEqual(first.tiles, second.tiles);
    assertAlike(second);
  });
  test("cameras of several sizes that distort and move", async () =>
    assertAlike(await compare("studio", 1, [0, 6, 11], bits)));
  test("64 cameras", async () => {
    const found = await compare("many", 0, [0, 40], bits);
    assert.equal(found.views, 64);
    assertAlike(found);
  });
  test("several video tracks", async () => assertAlike(await compare("mapped", 0, [0, 1], bits)));
  test("map coordinates", async () => {
    assertAlike(await compare("far", 0, [0, 3], maps));
    assertAlike(await compare("far", 0, [0, 3], { ...maps, turned: true }));
  });
  test("a scene of a millimetre", async () => {
    assertAlike(await compare("tiny", 0, [0, 3], { ...maps, as: "unit", near: 1e-5 }));
  });
  test("fisheye lenses", async () => assertAlike(await compare("bent", 1, [0], maps)));
  test("an object that is rotated and scaled", async () => {
    assertAlike(await compare("maps", 0, [0, 3], { ...maps, turned: true }));
  });
  for (const stream of ["maps", "far"])
    test(`rays meet what is drawn: ${stream}`, async () => {
      for (const turned of [false, true]) {
        const { results } = await compare(stream, 0, [0, 3], { ...maps, turned, cast: true });
        for (const { rays } of results) {
          assert.ok(rays.hits >= 30 && rays.right > 0.99, JSON.stringify(rays));
          assert.ok(rays.off < 0.02, JSON.stringify(rays));
        }
      }
    });
  test("each camera gives its own colours", async () => {
    const greys = [];
    for (const only of [0, 2]) {
      const render = [...maps.render, "--sources", `${only}`, "--unseen", "128,128,128"];
      const found = await compare("maps", 0, [0], { render, only, own: { unseen: 0x808080 } });
      assert.equal(found.views, 1);
      assert.ok(found.results[0].psnr > LEAST_PSNR, `from camera ${only}: ${found.results[0].psnr.toFixed(1)} dB`);
      greys.push(found.results[0].grey);
    }
    assert.ok(greys[1] > 2 * greys[0], `grey pixels: ${greys}`);
  });
  for (const depth of ["reversed", "logarithmic"])
    test(`a renderer with a ${depth} depth buffer`, async () => {
      const found = await compare("maps", 0, [0, 2], { ...maps, depth, planes: [0.2, 50] });
      assertAlike(found);
      for (const { hidden } of found.results) {
        assert.equal(hidden[0], 1, "by a plane before the object");
        assert.ok(hidden[1] < 0.02, `${hidden[1]} of the object by a plane beyond it`);
      }
      assertAlike(await compare("bits", 1, [0], { ...bits, depth }));
    });
  test("nodes: other depth buffers, lenses and rules, far away, without pictures", async () => {
    const kind = "force-webgl";
    for (const depth of ["reversed", "logarithmic"]) {
      const found = await compare("maps", 0, [0], { ...maps, kind, depth, planes: [0.2, 50] });
      assertAlike(found);
      const [{ hidden }] = found.results;
      assert.ok(hidden[0] === 1 && hidden[1] < 0.02, `${depth}: ${hidden}`);
    }
    assertAlike(await compare("far", 0, [0], { ...maps, kind, turned: true }));
    assertAlike(await compare("bent", 1, [0], { ...maps, kind }));
    assertAlike(await compare("texturing", 0, [0], { ...maps, kind }), LEAST_PSNR_SEAMS);
    // The first picture from far away has no levels yet.
    const { results } = await compare("maps", 0, [0, 2], { ...maps, kind, shrink: 8 });
    assert.ok(results[1].psnr > 30, `from far away: ${results[1].psnr.toFixed(1)} dB`);
    const render = [...maps.render, "--no-pictures"];
    assertAlike(await compare("maps", 0, [0], { render, pictures: false, kind }));
  });
  test("after a loss of the context", async () => {
    const renewed = await browser.newPage(`${served.url}test/compare.html`);
    await renewed.waitForSelector("[data-ready]");
    const on = { browser: { troubles: [] }, page: renewed };
    assertAlike(await compare("maps", 0, [0, 2], { ...maps, lose: true, on }));
    assertAlike(await compare("bits", 1, [0], { ...bits, lose: true, on }));
    await renewed.close();
    // three.js frees objects of the former context.
    const others = browser.troubles.splice(0).filter((text) => !text.includes("does not belong to this context"));
    assert.deepEqual(others, []);
  });
  test("from far away, levels of the pictures", async () => {
    const { results } = await compare("maps", 0, [0, 2], { ...maps, shrink: 8 });
    for (const { camera, psnr } of results) assert.ok(psnr > 30, `camera ${camera}: ${psnr.toFixed(1)} dB`);
  });
  test("colours of vertices, shaded, where the pictures are lost", async () => {
    const render = [...maps.render, "--no-pictures"];
    for (const turned of [false, true]) {
      const found = await compare("maps", 0, [0, 3], { render, pictures: false, turned });
      assert.equal(found.views, 0);
      assertAlike(found);
    }
  });

  test("in Firefox", { skip: missingBrowser("firefox") }, async () => {
    const firefox = await openBrowser("firefox");
    try {
      const other = await firefox.newPage(`${served.url}test/compare.html`);
      await other.waitForSelector("[data-ready]");
      const on = { browser: firefox, page: other };
      assertAlike(await compare("bits", 1, [0], { ...bits, on }), LEAST_PSNR_FIREFOX);
      assertAlike(await compare("maps", 0, [0], { ...maps, on }), LEAST_PSNR_FIREFOX);
    } finally {
      await firefox.close();
    }
  });

  /** How many of the canvas's pixels are neither ground nor grid: coloured. */
  const colourful = (example) =>
    example.evaluate(
      () =>
        new Promise((resolve) =>
          requestAnimationFrame(() => {
            const canvas = document.getElementById("scene");
            const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
            copy.drawImage(canvas, 0, 0);
            const { data } = copy.getImageData(0, 0, canvas.width, canvas.height);
            let count = 0;
            for (let i = 0; i < data.length; i += 4)
              count += Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 40;
            resolve(count);
          }),
        ),
    );

  for (const [what, width, height] of [
    ["desk", 960, 600],
    ["telephone", 360, 640],
  ])
    test(`the example page on a ${what}`, async () => {
      const example = await browser.newPage(`${served.url}?file=bits.fvv&frame=2`, width, height);
      const drawn = (number) =>
        example.waitForFunction((wanted) => document.documentElement.dataset.drawn === wanted, {}, `${number}`);
      await drawn(2);
      assert.ok((await colourful(example)) > 500, "the scene is empty");
      assert.equal(await example.$eval("#message", (message) => message.textContent), "");
      assert.equal(await example.$eval("#frame", (slider) => `${slider.value} of ${slider.max}`), "2 of 3");
      assert.ok((await example.evaluate(() => document.documentElement.scrollWidth)) <= width);
      const theme = () => example.$eval("html", (html) => html.dataset.theme);
      const [former] = [await theme(), await example.click("#theme"), await example.click("#frusta")];
      assert.notEqual(await theme(), former);
      await example.focus("#frame");
      await example.keyboard.press("ArrowRight");
      await drawn(3);
      await example.select("#view", "3");
      await example.click("#play");
      await drawn(0); // starts again after the last frame
      await example.click("#play");
      assert.deepEqual(browser.troubles, []);
      await example.close();
    });
});
