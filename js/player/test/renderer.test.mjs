// The renderer in Chromium and in Firefox, compared with pictures of fvvrender of the same frames.

import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, describe, test } from "node:test";

import { missingBrowser } from "../../testing/browser.mjs";
import { moveCapture } from "../../testing/moved_capture.mjs";
import { tool } from "../../testing/served.mjs";
import { compareFile, distance } from "../conformance/compare.mjs";
import { posesOf, Session } from "../conformance/session.mjs";

/** dB away from outlines, and percent of cameras and pixels. */
const LEAST_PSNR = 40;
/** With one camera per point, or a strong colour for unseen surface, seams are as sharp as outlines. */
const LEAST_PSNR_SEAMS = 35;
const LEAST_AGREEMENT = 99.5;
const size = [480, 270];
const scales = [0.1, 1, 100];
/** To 0.8 mm and to 100 m. */
const sizes = { tiny: 0.0002, huge: 25 };
/** Metres to map coordinates. */
const BY = [4000000, -2500000.5, 4700000.25];

const folder = mkdtempSync(join(tmpdir(), "fvv-renderer-"));
const at = (name) => join(folder, name);

function makeStreams() {
  const synth = (name, ...more) => tool("fvvsynth", "-o", at(name), ...more);
  const fixed = ["--view-loss", "none"];
  const mux = (capture, name, ...more) => tool("fvvmux", at(capture), "-o", at(`${name}.fvv`), ...fixed, ...more);
  synth("studio", "--frames", "2", "--size", "320x180", "--environment");
  mux("studio", "studio", "--visibility", "weight", "--texture-inset", "30mm");
  synth("many", "--rig", "small", "--cameras", "40", "--frames", "1", "--size", "160x120");
  mux("many", "many", "--visibility", "weight", "--codec", "jpeg", "--quality", "90");
  // A thousand faces, so that all visibility weights fit into one row of their texture.
  synth("few", "--rig", "small", "--cameras", "4", "--frames", "1", "--size", "160x120");
  mux("few", "few", "--visibility", "weight", "--codec", "vp9");
  const texturing = ["--texture-best", "1", "--texture-threshold", "0.5", "--texture-unseen", "250,10,60"];
  mux("studio", "texturing", "--visibility", "weight", "--no-environment", "--frames", "0-0", ...texturing);
  synth("placed", "--rig", "small", "--cameras", "5", "--frames", "1", "--size", "320x240", "--environment");
  const places = { near: {}, far: { by: BY } };
  for (const [name, scale] of Object.entries(sizes)) places[name] = { scale };
  const plain = ["--visibility", "weight", "--texture-inset", "off"];
  for (const [name, place] of Object.entries(places))
    tool("fvvmux", moveCapture(at("placed"), name, place), "-o", at(`${name}.fvv`), ...fixed, ...plain);
  // The same scene, scaled so that its longest side has this length.
  const capture = JSON.parse(readFileSync(at("studio/capture.json"), "utf8"));
  delete capture.environment;
  for (const metres of scales) {
    const name = `scale${metres}`;
    writeFileSync(at(`studio/${name}.json`), JSON.stringify({ ...capture, units: metres / 4 }));
    mux(`studio/${name}.json`, name, "--visibility", "none", "--frames", "0-0");
  }
}

/** The number of pixels of a colour. */
function countOf([r, g, b], { data }) {
  let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i] === r && data[i + 1] === g && data[i + 2] === b;
  return count;
}

/** The mean brightness of a picture. */
function brightness({ data }) {
  let sum = 0;
  for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
  return sum / (0.75 * data.length);
}

async function assertSurvivesLoss(session, stream) {
  const facts = await session.show(at(`${stream}.fvv`), 0);
  const [pose] = posesOf(1, facts, size);
  const before = await session.draw(pose, size, {});
  assert.ok(brightness(before) > 2, "the picture is black");
  await session.page.evaluate(() => window.loseContext());
  const restored = await session.draw(pose, size, {});
  assert.ok(before.data.equals(restored.data));
}

before(makeStreams);
after(() => rmSync(folder, { recursive: true, force: true }));

describe("renderer", { skip: missingBrowser("chromium") }, () => {
  let session;
  before(async () => (session = await Session.open("chromium")));
  after(() => session?.close());

  const drawOnly = (pose, options) =>
    session.page.evaluate((where, what) => window.drawOnly(where, what), pose, options);
  /** Arguments of viewFromPose, from an angle around the scene. */
  const around = (angle) => ({
    eye: [5 * Math.sin(angle), 1.6, 5 * Math.cos(angle)],
    target: [0, 0.9, 0],
    up: [0, 1, 0],
    fov: 34.4,
    width: size[0],
    height: size[1],
  });

  function assertAlike(lines, ways, least = LEAST_PSNR) {
    assert.deepEqual(
      lines.map(({ visibleBy }) => visibleBy),
      ways,
    );
    for (const { visibleBy, minPsnr, each } of lines) {
      for (const { pose, inner } of each) assert.ok(inner.pixels > 500, `${pose}: ${inner.pixels} pixels`);
      assert.ok(minPsnr > least, `${visibleBy}: ${minPsnr.toFixed(1)} dB`);
    }
    assert.deepEqual(session.browser.troubles, []);
  }

  test("draws the same as fvvrender, by bits and by depth maps", async () =>
    assertAlike(await compareFile(session, at("studio.fvv"), { frame: 1, poses: 4, size }), ["bits", "depth"]));

  test("draws the same directly as in a layer, which is the default in software", async () => {
    const facts = await session.show(at("studio.fvv"), 1);
    for (const pose of posesOf(3, facts, size))
      for (const visibleBy of ["bits", "depth"]) {
        const direct = await session.draw(pose, size, { visibleBy, surfaceScale: null });
        const layered = await session.draw(pose, size, { visibleBy });
        assert.ok(!direct.data.equals(layered.data), "there is one way only");
        const { psnr, large } = distance(direct.data, layered.data, new Uint8Array(size[0] * size[1]).fill(1));
        assert.ok(psnr > 50 && large < 1e-3, `${pose.name}: ${psnr.toFixed(1)} dB, ${large}`);
      }
    await assert.rejects(session.draw(posesOf(1, facts, size)[0], size, { surfaceScale: 2 }), /surfaceScale: expected/);
  });

  test("a surface of fewer pixels keeps its outline, and leaves all around it as it is", async () => {
    const facts = await session.show(at("studio.fvv"), 1);
    for (const pose of posesOf(3, facts, size)) {
      const { depth } = session.reference(pose, size, "bits");
      const surface = depth.map((z) => (Number.isFinite(z) ? 1 : 0));
      const full = await session.draw(pose, size, { environment: true });
      const coarse = await session.draw(pose, size, { environment: true, surfaceScale: 0.4 });
      const around = distance(
        coarse.data,
        full.data,
        surface.map((is) => 1 - is),
      );
      // Two rasterisers differ in pixels of the outline.
      assert.ok(around.large < 2e-3, `${pose.name}: ${around.large} of what is around`);
      const on = distance(coarse.data, full.data, surface);
      assert.ok(on.psnr > 24 && on.psnr < 45, `${pose.name}: ${on.psnr.toFixed(1)} dB`);
    }
  });

  test("what hides the surface from the viewer fades, and a floor is seen from below", async () => {
    await session.show(at("studio.fvv"), 1);
    const [red, green] = [[1, 0, 0], [0, 1, 0]]; // prettier-ignore
    const wall = [[-3, 0, 2.5], [3, 0, 2.5], [3, 4, 2.5], [-3, 4, 2.5]]; // prettier-ignore
    const floor = [[-9, 0, 9], [9, 0, 9], [9, 0, -9], [-9, 0, -9]]; // prettier-ignore
    await session.page.evaluate(
      (quads) => window.surround(quads),
      [
        { corners: wall, colour: red, doubleSided: true },
        { corners: floor, colour: green, doubleSided: false },
      ],
    );
    const draw = (pose, options) =>
      session.page.evaluate((pose, options) => window.draw(pose, options), pose, { shadows: false, ...options });
    const picture = async (pose, options) => ({ data: Buffer.from((await draw(pose, options)).data, "base64") });
    const [pure, earth] = [[255, 0, 0], [0, 255, 0]]; // prettier-ignore
    const front = around(0);
    const hidden = await picture(front, { fade: false });
    const through = await picture(front, {});
    const alone = await picture(front, { environment: false });
    const surface = new Uint8Array(size[0] * size[1]).map(
      (_, i) => Math.max(...alone.data.subarray(4 * i, 4 * i + 3)) > 0,
    );
    const share = (one) => distance(one.data, hidden.data, surface);
    assert.ok(share(alone).psnr < 12, "the wall hides the surface");
    assert.ok(share(through).psnr < 14, "it is seen through the wall");
    const like = distance(through.data, alone.data, surface).psnr;
    assert.ok(like > 12, `${like.toFixed(1)} dB: little is left of the wall`);
    // The wall has the same colour where nothing is behind it.
    const [before, after] = [hidden, through].map((one) => countOf(pure, one));
    assert.ok(after > 0.2 * before && after < 0.9 * before, `${after} of ${before} pixels are all wall`);
    // From behind, the wall is beyond the surface, and the floor before it stays.
    const back = around(Math.PI);
    assert.deepEqual(await picture(back, {}), await picture(back, { fade: false }));
    const below = { ...front, eye: [0, -3, 4] };
    assert.equal(countOf(earth, await picture(below, { fade: false })), 0);
    const seen = await picture(below, { clearColour: [0, 0, 0, 1] });
    let greenish = 0;
    for (let i = 0; i < seen.data.length; i += 4) greenish += seen.data[i + 1] > 60 && seen.data[i] < 30;
    assert.ok(greenish > 0.1 * surface.length, `${greenish} pixels of the floor`);
    assert.deepEqual(session.browser.troubles, []);
  });

  test("draws the same as fvvrender for few faces", async () =>
    assertAlike(await compareFile(session, at("few.fvv"), { poses: 2, size }), ["bits", "depth"]));

  test("draws colours of vertices where there are no pictures, shaded as fvvrender does", async () => {
    const [line] = await compareFile(session, at("studio.fvv"), { frame: 1, poses: 3, size, bare: true });
    assert.equal(line.views, 0);
    assertAlike([line], ["depth"]);
    // With pictures they are where no camera shows the surface, unless a colour is chosen.
    const facts = await session.show(at("studio.fvv"), 1);
    const [pose] = posesOf(1, facts, size);
    const hidden = { cameras: [], environment: false };
    const coloured = await session.draw(pose, size, hidden);
    const grey = await session.draw(pose, size, { ...hidden, unseen: 0x808080 });
    const surface = countOf([128, 128, 128], grey);
    assert.ok(surface > 1000);
    assert.ok(countOf([128, 128, 128], coloured) < surface / 100);
  });

  test("from far away, averages of pictures rather than single texels", async () => {
    const far = [96, 54];
    const facts = await session.show(at("studio.fvv"), 1);
    for (const pose of posesOf(3, facts, far)) {
      const { picture, depth } = session.reference(pose, far, "bits", { samples: 7 });
      const drawn = await session.draw(pose, far, { shadows: false, environment: false });
      const isInside = (k) => [0, 1, -1, far[0], -far[0]].every((step) => Number.isFinite(depth[k + step]));
      const { psnr, pixels } = distance(
        drawn.data,
        picture.data,
        depth.map((_, k) => isInside(k)),
      );
      assert.ok(psnr > 26, `${pose.name}: ${psnr.toFixed(1)} dB over ${pixels} pixels`);
    }
  });

  test("texturing parameters of the stream, and overrides", async () => {
    const lines = await compareFile(session, at("texturing.fvv"), { poses: 3, size });
    assertAlike(lines, ["bits", "depth"], LEAST_PSNR_SEAMS);
    const facts = await session.show(at("texturing.fvv"), 0);
    const [pose] = posesOf(1, facts, size);
    const explicit = await session.draw(pose, size, { best: 1, threshold: 0.5 });
    assert.ok(explicit.data.equals((await session.draw(pose, size, {})).data));
    for (const own of [{ best: 3 }, { threshold: 0.25 }])
      assert.ok(!explicit.data.equals((await session.draw(pose, size, own)).data), JSON.stringify(own));
    for (const mode of ["textured", "weights"]) {
      const hidden = { mode, cameras: [] };
      const [theirs, own] = [
        await session.draw(pose, size, hidden),
        await session.draw(pose, size, { ...hidden, unseen: 0x0ac83c }),
      ];
      assert.ok(countOf([250, 10, 60], theirs) > 1000);
      assert.equal(countOf([10, 200, 60], own), countOf([250, 10, 60], theirs));
    }
  });

  for (const metres of scales)
    test(`visibility agrees with ray casting, in a scene of ${metres} m`, async () => {
      const lines = await compareFile(session, at(`scale${metres}.fvv`), { poses: 2, size, rays: true });
      assertAlike(lines, ["depth"]);
      const [{ agreementPercent }] = lines;
      assert.ok(agreementPercent > LEAST_AGREEMENT, `${agreementPercent.toFixed(2)} % as rays`);
    });

  test("draws a scene in map coordinates as the same scene near 0", async () => {
    const facts = await session.show(at("near.fvv"), 0);
    const poses = posesOf(1, facts, size);
    const grid = { centre: [0, 0, 0], extent: 4, step: 0.5 };
    const ways = [
      {},
      { visibleBy: "depth" },
      { environment: false, grid, frusta: { selected: 0, picturePlanes: true } },
    ];
    const near = [];
    for (const pose of poses) for (const options of ways) near.push(await session.draw(pose, size, options));
    const found = await session.show(at("far.fvv"), 0);
    found.bounds.min.forEach((x, k) => assert.ok(Math.abs(x - BY[k] - facts.bounds.min[k]) < 1e-5));
    const moved = (point) => point.map((x, k) => x + BY[k]);
    for (const [i, pose] of poses.entries())
      for (const [k, options] of ways.entries()) {
        const there = { ...pose, eye: moved(pose.eye), target: moved(pose.target) };
        const own = options.grid ? { ...options, grid: { ...grid, centre: moved(grid.centre) } } : options;
        const { data } = await session.draw(there, size, own);
        const wanted = near[ways.length * i + k].data;
        assert.ok(brightness({ data: wanted }) > 2);
        const { psnr, large } = distance(data, wanted, new Uint8Array(size[0] * size[1]).fill(1));
        assert.ok(psnr > 45 && large < 1e-3, `pose ${i}, way ${k}: ${psnr.toFixed(1)} dB, ${large}`);
      }
    assert.deepEqual(session.browser.troubles, []);
  });

  for (const [name, scale] of Object.entries(sizes))
    test(`draws a scene ${scale} times as large as the scene itself`, async () => {
      const environment = false;
      const overlays = { frusta: { selected: 0, picturePlanes: true }, grid: { centre: [0, 0, 0] } };
      const ways = [{}, { visibleBy: "depth" }, { visibleBy: "depth", ...overlays }];
      const scaled = (point) => point.map((x) => scale * x);
      const facts = await session.show(at("near.fvv"), 0);
      const poses = posesOf(1, facts, size);
      // Close to the surface, where a plane of 1 cm would cut it off.
      const { eye, target } = poses[0];
      poses.push({ ...poses[0], eye: eye.map((x, k) => target[k] + 0.3 * (x - target[k])) });
      const wanted = [];
      for (const pose of poses)
        for (const way of ways) wanted.push(await session.draw(pose, size, { environment, ...way }));
      await session.show(at(`${name}.fvv`), 0);
      for (const [i, pose] of poses.entries())
        for (const [k, way] of ways.entries()) {
          const there = { ...pose, eye: scaled(pose.eye), target: scaled(pose.target) };
          const { data } = await session.draw(there, size, { environment, ...way });
          const reference = wanted[ways.length * i + k];
          assert.ok(brightness(reference) > 1);
          const { psnr, large } = distance(data, reference.data, new Uint8Array(size[0] * size[1]).fill(1));
          assert.ok(psnr > 38 && large < 5e-3, `pose ${i}, way ${k}: ${psnr.toFixed(1)} dB, ${large}`);
        }
      assert.deepEqual(session.browser.troubles, []);
    });

  test("draws depth and shadow maps once per frame, and no picture twice", async () => {
    await session.show(at("studio.fvv"), 0);
    const first = await drawOnly(around(0), { visibleBy: "depth" });
    const { views } = await session.show(at("studio.fvv"), 0);
    const again = await drawOnly(around(0), { visibleBy: "depth" });
    assert.equal(again.depthPasses - first.depthPasses, views);
    assert.equal(again.shadowPasses - first.shadowPasses, 2, "one for each lamp");
    assert.ok(again.bytesUploadedPerContentFrame > 1e5);
    for (const angle of [1, 2, 3]) {
      const moved = await drawOnly(around(angle), { visibleBy: "depth" });
      assert.equal(moved.drew, true);
      assert.equal(moved.bytesUploadedPerDrawnFrame, 0);
      assert.equal(moved.depthPasses, again.depthPasses);
      assert.equal(moved.shadowPasses, again.shadowPasses);
    }
    const same = await drawOnly(around(3), { visibleBy: "depth" });
    assert.equal(same.drew, false);
    // Switching off a camera updates the table but no maps.
    const without = await drawOnly(around(3), { visibleBy: "depth", cameras: [1, 2] });
    assert.equal(without.drew, true);
    assert.equal(without.depthPasses, again.depthPasses);
  });

  test("has the same number of samplers for 40 cameras as for 12", async () => {
    await session.show(at("studio.fvv"), 0);
    const few = await drawOnly(around(0), { visibleBy: "both" });
    const { views } = await session.show(at("many.fvv"), 0);
    assert.equal(views, 40);
    const many = await drawOnly(around(0), { visibleBy: "both" });
    assert.equal(many.samplers, few.samplers);
    assert.equal(many.drawCalls, few.drawCalls - 2, "its environment");
  });

  test("shows the last of several frames", async () => {
    await session.show(at("studio.fvv"), 0);
    const { shown, number, wanted } = await session.page.evaluate(() => window.showTwo());
    assert.deepEqual(shown, [false, true]);
    assert.equal(number, wanted);
  });

  for (const stream of ["studio", "many"])
    test(`draws the same after the loss of a context: ${stream}`, async () => {
      await assertSurvivesLoss(session, stream);
      session.browser.troubles.splice(0); // Chromium reports the loss
    });

  test("computes RGB from replicated chroma as browsers do", async () => {
    for (const matrix of ["bt709", "smpte170m", "bt470bg", "bt2020-ncl"])
      for (const fullRange of [false, true]) {
        const share = await session.page.evaluate((...colours) => window.replicate(...colours), matrix, fullRange);
        assert.equal(share, 1, `${matrix}, ${fullRange ? "full" : "limited"} range`);
      }
  });

  test("draws each mode, shadows and blend", async () => {
    const facts = await session.show(at("studio.fvv"), 0);
    const [pose] = posesOf(1, facts, size);
    const environment = false;
    const pictures = [];
    for (const options of [
      ...["textured", "weights", "visibility", "wireframe", "normals", "depth"].map((mode) => ({ mode, environment })),
      { blend: "paper", environment },
      { best: 1, environment },
      { threshold: 0.8, environment },
      { cameras: [0], environment },
      { grid: { centre: [0, 0, 0] }, environment },
      { frusta: { selected: 0, picturePlanes: true }, environment },
    ])
      pictures.push(await session.draw(pose, size, options));
    pictures.forEach((picture, i) => {
      assert.ok(brightness(picture) > 1, `picture ${i} is black`);
      for (const other of pictures.slice(0, i))
        assert.ok(!picture.data.equals(other.data), `picture ${i} equals another one`);
    });
    const [lit, shadowed] = [false, true].map((shadows) => session.draw(pose, size, { shadows }));
    const loss = brightness(await lit) - brightness(await shadowed);
    assert.ok(loss > 0.05 && loss < 10, `shadows take ${loss}`);
    await assert.rejects(session.draw(pose, size, { mode: "pretty" }), /mode: expected one of/);
    await assert.rejects(session.draw(pose, size, { best: 9 }), /best: expected .* 1 to 8/);
    await assert.rejects(session.draw(pose, size, { unseen: 2 ** 24 }), /unseen: expected a colour from 0 to 0xffffff/);
    assert.deepEqual(session.browser.troubles, []);
  });
});

describe("renderer in Firefox", { skip: missingBrowser("firefox") }, () => {
  let session;
  before(async () => (session = await Session.open("firefox")));
  after(() => session?.close());

  // Firefox converts video to RGB, which has to be undone; JPEG it decodes as fvvrender does.
  for (const [stream, frame] of Object.entries({ studio: 1, few: 0, many: 0 }))
    test(`draws the same as fvvrender: ${stream}`, async () => {
      const lines = await compareFile(session, at(`${stream}.fvv`), { frame, poses: 2, size });
      assert.equal(lines.length, 2);
      for (const { visibleBy, minPsnr } of lines)
        assert.ok(minPsnr > LEAST_PSNR, `${visibleBy}: ${minPsnr.toFixed(1)} dB`);
      assert.deepEqual(session.browser.troubles, []);
    });

  test("draws the same after the loss of a context", async () => {
    await assertSurvivesLoss(session, "studio");
    session.browser.troubles.splice(0);
  });
});
