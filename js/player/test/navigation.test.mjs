// Navigation: rotations, journeys, views of cameras, and their text forms.

import assert from "node:assert/strict";
import { describe, test } from "node:test";

import { commandOf, MovementKeys, keepsKey, takesText } from "../src/navigation/keys.js";
import { Navigator } from "../src/navigation/navigator.js";
import {
  axesOf,
  between,
  directionsOf,
  extentOf,
  fromSpherical,
  homePose,
  orbit,
  poseOfCamera,
  toSpherical,
} from "../src/navigation/pose.js";
import {
  findInHash,
  formatBookmark,
  formatFieldOfView,
  formatOrbit,
  formatTarget,
  parseBookmark,
  parseFieldOfView,
  parseOrbit,
  parseTarget,
  putIntoHash,
} from "../src/navigation/view_text.js";
import { dot, length, subtract } from "@fvv/shading";
import { viewOf } from "../src/view.js";

function assertClose(found, wanted, tolerance = 1e-6) {
  found.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) < tolerance, `${found} is not ${wanted}`));
}

/** A camera 5 m in front of the middle, a little to the side and rolled, looking at the middle. */
const camera = {
  id: 7,
  calibrated: true,
  width: 640,
  height: 480,
  fx: 600,
  fy: 600,
  cx: 330,
  cy: 236,
  rotation: [0.8, 0.6, 0, 0.6, -0.8, 0, 0, 0, -1],
  translation: [0, 0, 5],
  centre: [0, 0, 5],
};
const upright = { ...camera, id: 1, rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1] };
const frame = {
  configuration: { upAxis: "y" },
  cameras: [upright, camera],
  mesh: { positions: Float32Array.of(-1, 0, -1, 1, 2, 1) },
};

function navigator() {
  const made = new Navigator();
  made.begin(frame);
  return made;
}
function settle(made, from = 0) {
  let now = from;
  while (made.step(now)) now += 16;
  return now;
}

describe("axes", () => {
  for (const name of ["x", "y", "z", "-x", "-y", "-z"])
    test(name, () => {
      const axes = axesOf(name, []);
      assert.equal(axes.up["xyz".indexOf(name.at(-1))], name[0] === "-" ? -1 : 1);
      for (const [a, b] of [
        ["up", "front"],
        ["up", "right"],
        ["front", "right"],
      ])
        assert.equal(dot(axes[a], axes[b]), 0);
      const offset = [1, 2, 3];
      assertClose(fromSpherical(axes, toSpherical(axes, offset)), offset);
    });
  test("unknown: cameras are upright", () => {
    const { up } = axesOf("unknown", [upright, camera]);
    assertClose(up, [-0.6 / Math.hypot(0.6, 1.8), 1.8 / Math.hypot(0.6, 1.8), 0]);
  });
});

test("the first view shows the whole scene from the direction of a camera", () => {
  const axes = axesOf("y", []);
  const extent = { centre: [0, 1, 0], radius: 2, low: [-2, 0, -1], high: [2, 2, 1] };
  for (const aspect of [16 / 9, 0.5]) {
    const pose = homePose(extent, upright, axes, aspect);
    const { forward } = directionsOf(pose);
    assert.ok(forward[2] < -0.9);
    const view = viewOf({ ...pose, width: 100 * aspect, height: 100 });
    for (let i = 0; i < 8; i++) {
      const [x, y, z] = [0, 1, 2].map((axis) => ((i >> axis) & 1 ? extent.high : extent.low)[axis]);
      const { rotation: r, translation: t, fx, cx, cy } = view;
      const at = [0, 3, 6].map((row, k) => r[row] * x + r[row + 1] * y + r[row + 2] * z + t[k]);
      const [u, v] = [cx + (fx * at[0]) / at[2], cy + (fx * at[1]) / at[2]];
      assert.ok(u > 0 && u < 100 * aspect && v > 0 && v < 90, `${u}, ${v} of ${100 * aspect} x 100`);
    }
  }
});

test("the first view is no further away than its camera, as far as the scene then fits into the picture", () => {
  const axes = axesOf("y", []);
  const extent = { centre: [0, 1, 0], radius: 2, low: [-2, 0, -1], high: [2, 2, 1] };
  const at = (z) => ({ ...upright, centre: [0, 1, z] });
  const distance = ({ eye, target }) => Math.hypot(...[0, 1, 2].map((axis) => eye[axis] - target[axis]));
  const far = homePose(extent, at(9), axes, 16 / 9);
  assert.equal(far.fov, Math.PI / 4);
  assert.ok(distance(far) < 9);
  const near = homePose(extent, at(3.5), axes, 16 / 9);
  assert.ok(near.fov > Math.PI / 4);
  assert.ok(Math.abs(distance(near) - 3.5) < 1e-9);
  // Among the action, or on a narrow screen, the picture would be stretched.
  for (const [z, aspect] of [
    [1.2, 16 / 9],
    [3.5, 0.5],
  ]) {
    const pose = homePose(extent, at(z), axes, aspect);
    assert.ok(Math.abs(pose.fov - (70 * Math.PI) / 180) < 1e-12);
    assert.ok(distance(pose) > z);
  }
});

test("the stream says from which camera the first view is", () => {
  const cameras = [upright, { ...upright, id: 9, centre: [4, 1, 0] }];
  const begun = (...metadata) => {
    const made = new Navigator();
    made.begin({ ...frame, configuration: { ...frame.configuration, metadata }, cameras });
    return directionsOf(made.pose).forward;
  };
  const chosen = begun(JSON.stringify({ view: { camera: 9 } }));
  assert.ok(chosen[0] < -0.9);
  // Ancillary: what is not understood is as if it were not there.
  for (const text of ["", "{", "null", "[]", '{"view":9}', '{"view":{"camera":"9"}}', '{"view":{"camera":77}}'])
    assert.deepEqual(begun(text), begun(), text);
  assert.deepEqual(begun("{", JSON.stringify({ view: { camera: 9 } })), chosen);
});

test("a scene of a millimetre is walked through as smoothly as one of metres", () => {
  const steps = (scale) => {
    const made = new Navigator();
    made.begin({ ...frame, mesh: { positions: Float32Array.of(-1, 0, -1, 1, 2, 1).map((x) => scale * x) } });
    made.moveBy(0.5 * scale, 0, 0);
    let count = 0;
    for (let now = 0; made.step(now); now += 16) count++;
    return count;
  };
  assert.ok(steps(1) > 10);
  assert.equal(steps(0.001), steps(1));
});

test("the extent of a scene in map coordinates is exact", () => {
  const origin = [4000000, -2500000, 4700000];
  const localPositions = Float32Array.of(-1, 0.125, -1, 1, 2, 1.5);
  const positions = localPositions.map((x, i) => x + origin[i % 3]);
  const { low, high, centre } = extentOf({ ...frame, mesh: { positions, localPositions, origin } });
  assert.deepEqual(low, [3999999, -2499999.875, 4699999]);
  assert.deepEqual(high, [4000001, -2499998, 4700001.5]);
  assert.deepEqual(centre, [4000000, -2499998.9375, 4700000.25]);
});

test("orbits keep their distance, stay level and avoid the poles", () => {
  const axes = axesOf("z", []);
  const pose = { eye: [0, -4, 1], target: [0, 0, 1], up: [0, 0, 1], fov: 0.8 };
  const turned = orbit(pose, { theta: Math.PI / 2, phi: 0 }, axes);
  assertClose(turned.eye, [4, 0, 1]);
  const above = orbit(pose, { theta: 0, phi: -10 }, axes);
  assert.ok(above.eye[2] > 4.99);
  assert.ok(length(subtract([above.eye[0], above.eye[1], 0], [0, 0, 0])) > 0.05);
});

test("journeys go around the target, the short way", () => {
  const axes = axesOf("y", []);
  const at = (degrees) => {
    const angle = (degrees * Math.PI) / 180;
    return { eye: [4 * Math.sin(angle), 0, 4 * Math.cos(angle)], target: [0, 0, 0], up: [0, 1, 0], fov: 1 };
  };
  for (const [from, to, middle] of [
    [0, 170, 85],
    [170, -170, 180],
    [350, 20, 5],
  ])
    assertClose(between(at(from), at(to), 0.5, axes).eye, at(middle).eye);
  assert.equal(between(at(0), at(10), 1, axes).fov, 1);
});

describe("navigator", () => {
  test("movements by the user are smooth and complete", () => {
    const made = navigator();
    const before = toSpherical(made.axes, subtract(made.pose.eye, made.pose.target));
    made.orbitBy(0.5, 0.1);
    made.step(0);
    const part = toSpherical(made.axes, subtract(made.pose.eye, made.pose.target));
    assert.ok(part.theta > before.theta && part.theta < before.theta + 0.3);
    settle(made, 16);
    const after = toSpherical(made.axes, subtract(made.pose.eye, made.pose.target));
    assertClose([after.theta, after.phi, after.radius], [before.theta + 0.5, before.phi + 0.1, before.radius]);
    assert.equal(made.source, "user");
  });
  test("at once with reduced motion", () => {
    const made = navigator();
    made.calm = true;
    made.orbitBy(0.5, 0);
    assert.equal(made.step(0), false);
    const before = made.pose;
    assert.equal(made.step(16), false);
    assert.equal(made.pose, before);
    made.goTo({ ...before, eye: [0, 1, 9] }, 3);
    assert.equal(made.step(32), false);
    assertClose(made.pose.eye, [0, 1, 9]);
  });
  test("zoom within limits", () => {
    const made = navigator();
    made.dollyBy(-100);
    settle(made);
    assert.ok(length(subtract(made.pose.eye, made.pose.target)) >= made.limits.nearest * 0.999);
    made.dollyBy(200);
    settle(made);
    assert.ok(length(subtract(made.pose.eye, made.pose.target)) <= made.limits.farthest * 1.001);
  });
  test("a journey has a duration, and ends when the user moves", async () => {
    const made = navigator();
    const goal = { eye: [5, 1, 0], target: [0, 1, 0], up: [0, 1, 0], fov: 1 };
    const arrived = made.goTo(goal, 1);
    made.step(0);
    assert.equal(made.step(500), true);
    assert.equal(made.step(1000), false);
    assert.deepEqual(made.pose, goal);
    assert.equal(await arrived, true);
    const left = made.goHome(1);
    made.step(2000);
    made.step(2300);
    made.panBy(0.1, 0);
    assert.equal(await left, false);
  });
  test("the view of a camera is exact, and becomes level after it", async () => {
    const made = navigator();
    made.lookThrough(camera, 0.5);
    assert.equal(made.camera, 7);
    settle(made);
    const view = made.view(640, 480);
    assertClose(view.rotation, camera.rotation, 1e-9);
    assertClose([view.fx, view.fy, view.cx, view.cy], [600, 600, 330, 236], 1e-9);
    made.orbitBy(0.2, 0);
    assert.equal(made.camera, null);
    settle(made, 1000);
    made.orbitBy(0.2, 0);
    settle(made, 9000);
    const free = made.view(640, 480);
    assertClose([free.cx, free.cy], [320, 240], 1e-9);
    assert.ok(Math.abs(free.rotation[1]) < 0.05, `rolled: ${free.rotation}`);
  });
  test("the view follows a moving camera", () => {
    const made = navigator();
    made.lookThrough(camera, 0);
    settle(made);
    made.follow([{ ...camera, centre: [1, 0, 5], translation: [-0.8, -0.6, 5], fx: 700 }]);
    const view = made.view(640, 480);
    assertClose(view.translation, [-0.8, -0.6, 5]);
    assert.equal(view.fx, 700);
  });
  test("another scene begins with its own first view", async () => {
    const made = navigator();
    made.lookThrough(camera, 0);
    settle(made);
    const left = made.goTo({ ...made.pose, fov: 0.3 }, 5);
    made.orbitBy(0.5, 0);
    made.begin({ ...frame, cameras: [upright] });
    assert.equal(await left, false);
    settle(made);
    assert.equal(made.camera, null);
    assert.deepEqual(made.pose, made.home);
    const { fx, cx } = made.view(640, 480);
    assertClose([fx, cx], [240 / Math.tan(made.home.fov / 2), 320]);
  });
  test("a camera's pose looks along its axis", () => {
    const pose = poseOfCamera(camera, [0, 0, 0]);
    assertClose(pose.target, [0, 0, 0]);
    assertClose([pose.fov], [2 * Math.atan(0.4)]);
  });
});

describe("written", () => {
  const auto = { theta: 1, phi: 1.5, radius: 4 };
  test("attributes", () => {
    assert.deepEqual(parseOrbit("90deg auto 150%", auto), { theta: Math.PI / 2, phi: 1.5, radius: 6 });
    assert.deepEqual(parseOrbit("0.5rad 1rad 250cm", auto), { theta: 0.5, phi: 1, radius: 2.5 });
    assert.deepEqual(parseTarget("0m 1.2m auto", [1, 2, 3]), [0, 1.2, 3]);
    for (const bad of ["", "1 2", "1deg 2deg 3deg", "x 2rad 3m", "1rad 1rad -3m"])
      assert.equal(parseOrbit(bad, auto), null);
    assert.equal(parseFieldOfView("200deg", 1), null);
    assert.ok(Math.abs(parseFieldOfView(formatFieldOfView(0.7), 1) - 0.7) < 1e-4);
    const again = parseOrbit(formatOrbit(auto), auto);
    assertClose([again.theta, again.phi, again.radius], [1, 1.5, 4], 1e-4);
    assert.deepEqual(parseTarget(formatTarget([0.12, -3, 4]), [0, 0, 0]), [0.12, -3, 4]);
  });
  test("of a scene of a millimetre", () => {
    const size = 0.001;
    const orbit = { theta: 1, phi: 1.5, radius: 0.0024 };
    assert.equal(formatOrbit(orbit), "57.3deg 85.94deg 0.0024m");
    assert.equal(formatTarget([0.0001234, 0, -2e-7], size), "0.000123m 0m 0m");
    const pose = { eye: [0.0024, 0.0005, 0.0012], target: [1e-5, 0, 0], up: [0, 1, 0], fov: 45 };
    const found = parseBookmark(formatBookmark({ seconds: 0, pose, camera: null })).pose;
    for (const name of ["eye", "target"]) assertClose(found[name], pose[name], 1e-6);
  });
  test("bookmarks", () => {
    const pose = { eye: [1.23456, 2, -3], target: [0, 1, 0], up: [0, 1, 0], fov: 45 };
    const text = formatBookmark({ seconds: 1.28, pose, camera: null });
    const found = parseBookmark(text);
    assert.equal(found.seconds, 1.28);
    assert.equal(found.camera, null);
    assertClose(found.pose.eye, [1.235, 2, -3]);
    assert.equal(found.pose.fov, 45);
    assert.equal(parseBookmark(formatBookmark({ seconds: 0, pose, camera: 3 })).camera, 3);
    assert.deepEqual(parseBookmark("t:x;eye:1,2;fov:9"), { seconds: null, camera: null, pose: null });
    const hash = putIntoHash("#chapter=2&fvv=old", "fvv", text);
    assert.equal(hash, `#chapter=2&fvv=${text}`);
    assert.equal(findInHash(hash, "fvv"), text);
    assert.equal(findInHash("#fvv=%", "fvv"), null);
    assert.equal(findInHash("#other", "fvv"), null);
  });
});

describe("keys", () => {
  test("commands, but not with Control, Alt or Command", () => {
    assert.deepEqual(commandOf({ key: "." }), { command: "step", value: 1 });
    assert.deepEqual(commandOf({ key: "K" }), { command: "togglePlay", value: undefined });
    assert.equal(commandOf({ key: "f", ctrlKey: true }), null);
    assert.equal(commandOf({ key: "z" }), null);
  });
  test("typed keys stay in text inputs", () => {
    for (const type of ["text", "search", "number", "email"]) assert.ok(takesText({ tagName: "INPUT", type }));
    assert.ok(takesText({ tagName: "TEXTAREA" }));
    assert.ok(takesText({ tagName: "DIV", isContentEditable: true }));
    assert.ok(!takesText({ tagName: "INPUT", type: "range" }));
    assert.ok(keepsKey({ tagName: "INPUT", type: "text" }, "k"));
    assert.ok(keepsKey({ tagName: "SELECT" }, "v"));
    assert.ok(keepsKey({ tagName: "BUTTON" }, " "));
    assert.ok(!keepsKey({ tagName: "BUTTON" }, "k"));
    assert.ok(keepsKey({ tagName: "INPUT", type: "range" }, "arrowleft"));
    assert.ok(!keepsKey({ tagName: "DIV" }, "arrowleft"));
  });
  test("a tap moves a little, holding moves until the key is released", (t) => {
    t.mock.timers.enable({ apis: ["setTimeout"] });
    const made = navigator();
    const keys = new MovementKeys(made);
    const theta = () => toSpherical(made.axes, subtract(made.pose.eye, made.pose.target)).theta;
    const key = { code: "ArrowRight", key: "ArrowRight" };
    const before = theta();
    assert.ok(keys.press(key));
    keys.release(key);
    let now = settle(made);
    const touched = theta();
    assert.ok(touched > before && touched < before + 0.1);
    keys.press(key);
    t.mock.timers.tick(200);
    for (let i = 0; i < 60; i++) assert.equal(made.step((now += 16)), true);
    assert.ok(theta() > touched + 1);
    keys.release(key);
    settle(made, now);
    assert.equal(keys.press({ code: "KeyK", key: "k" }), false);
  });
});
