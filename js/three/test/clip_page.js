// Clips in scenes, for tests: {kind} in every call is that of rendererOf.

import * as forWebGL from "@fvv/three";
import * as forWebGPU from "@fvv/three/webgpu";
import {
  AmbientLight,
  BoxGeometry,
  Color,
  DirectionalLight,
  Fog,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PerspectiveCamera,
  PlaneGeometry,
  Raycaster,
  Scene,
  Vector2,
  Vector3,
} from "three";

import { GaussianSplat } from "three/addons/objects/GaussianSplat.js";
import { createGaussianSplatGeometry } from "three/addons/utils/GaussianSplatUtils.js";

import { drawn, rendererOf } from "./renderers.js";

const size = { width: 320, height: 240 };
const worker = new URL("worker.js", import.meta.url);
const clips = [];

/** {renderer, scene, camera, clip}: a clip whose first frame is shown, seen from the front. */
async function stage(kind, src, options = {}) {
  const renderer = await rendererOf(kind, "standard");
  renderer.setSize(size.width, size.height, false);
  const scene = new Scene();
  scene.background = new Color(0x000000);
  const camera = new PerspectiveCamera(45, size.width / size.height, 0.05, 50);
  camera.position.set(0, 1.4, 3.4);
  camera.lookAt(0, 1, 0);
  const { FvvClip } = kind === "webgl" ? forWebGL : forWebGPU;
  const clip = new FvvClip({ src, renderer, decoderOptions: { worker }, ...options });
  clips.push(clip);
  scene.add(clip);
  await clip.ready;
  return { renderer, scene, camera, clip };
}

/** After a test: nothing goes on. */
window.end = () => {
  for (const clip of clips.splice(0)) clip.dispose();
};

/** What is drawn, in a picture of the screen of its own: three draws shadows once for each. */
async function picture({ renderer, scene, camera }) {
  await new Promise(requestAnimationFrame);
  return drawn(renderer, scene, camera, size);
}

function base64(bytes) {
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

/** Pixels that differ by more than 8 of 255. */
function different(a, b) {
  let count = 0;
  for (let i = 0; i < a.length; i += 4) count += [0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > 8);
  return count;
}
/** Pixels that are not black, and the mean of their components. */
function covered(data) {
  let [count, sum] = [0, 0];
  for (let i = 0; i < data.length; i += 4) {
    if (data[i] + data[i + 1] + data[i + 2] < 6) continue;
    count++;
    sum += data[i] + data[i + 1] + data[i + 2];
  }
  return { count, mean: sum / count / 3 };
}

const event = (target, type) => new Promise((done) => target.addEventListener(type, done));

/** Plays a clip to its end: the events, and the times of the frames that were shown. */
window.playClip = async (kind, src) => {
  const { clip } = await stage(kind, src, { muted: true });
  const log = [];
  const frames = [];
  for (const type of ["play", "playing", "pause", "ended", "seeking", "seeked"])
    clip.addEventListener(type, () => log.push(type));
  clip.addEventListener("framechange", () => frames.push(clip.currentFrame));
  const ended = event(clip, "ended");
  await clip.play();
  const wasPaused = clip.paused;
  await ended;
  const { duration, currentTime, frameCount } = clip;
  await clip.seek(0);
  return { log, frames, wasPaused, duration, currentTime, frameCount, back: clip.currentFrame, paused: clip.paused };
};

/** The number of times that a loop begins again within a second of a short clip, and whether setting another source works. */
window.loopClip = async (kind, src, other) => {
  const { clip } = await stage(kind, src, { muted: true, loop: true });
  let rounds = 0;
  let last = 0;
  clip.addEventListener("framechange", () => {
    rounds += clip.currentFrame < last;
    last = clip.currentFrame;
  });
  await clip.play();
  await new Promise((done) => setTimeout(done, 1200));
  clip.pause();
  const left = clip.seek(0.1).catch(({ name }) => name);
  clip.src = other;
  await clip.ready;
  const disposed = clip.seek(0.1).catch(({ name }) => name);
  const { paused, currentFrame: frame, loop } = clip;
  clip.dispose();
  return { rounds, paused, frame, loop, seeks: await Promise.all([left, disposed]) };
};

/** Whether three's Raycaster meets the surface where it is drawn, of the clip and of an instance. */
window.castRays = async (kind, src) => {
  const view = await stage(kind, src);
  const { scene, camera, clip } = view;
  const instance = clip.instance();
  instance.position.x = 1.2;
  instance.rotation.y = 0.7;
  clip.position.x = -0.7;
  scene.add(instance);
  scene.updateMatrixWorld();
  const data = await picture(view);
  const caster = new Raycaster();
  let [right, count, off] = [0, 0, 0];
  const objects = new Set();
  for (let y = 4; y < size.height; y += 7)
    for (let x = 4; x < size.width; x += 7) {
      const lit = (dx, dy) => {
        const i = 4 * ((y + dy) * size.width + x + dx);
        return data[i] + data[i + 1] + data[i + 2] > 5;
      };
      // Away from outlines.
      const around = [-2, 0, 2].flatMap((dy) => [-2, 0, 2].map((dx) => lit(dx, dy)));
      if (new Set(around).size > 1) continue;
      caster.setFromCamera(new Vector2((2 * (x + 0.5)) / size.width - 1, 1 - (2 * (y + 0.5)) / size.height), camera);
      const [hit] = caster.intersectObjects(scene.children, true);
      count++;
      right += Boolean(hit) === around[0];
      if (!hit) continue;
      objects.add(hit.object === clip.mesh ? "clip" : "instance");
      const seen = hit.point.clone().project(camera);
      off = Math.max(
        off,
        Math.hypot(((seen.x + 1) / 2) * size.width - x - 0.5, ((1 - seen.y) / 2) * size.height - y - 0.5),
      );
      if (!(Math.abs(hit.distance - hit.point.distanceTo(camera.position)) < 1e-4)) throw new Error("another distance");
    }
  return { right: right / count, count, off, objects: [...objects].sort(), ...covered(data) };
};

/** A floor under the clip and a lamp: how much darker the clip makes the floor, and something before the lamp the clip. */
window.castShadows = async (kind, src) => {
  const view = await stage(kind, src);
  const { renderer, scene, camera, clip } = view;
  renderer.shadowMap.enabled = true;
  const lamp = new DirectionalLight(0xffffff, 3);
  lamp.position.set(2, 4, 2);
  lamp.castShadow = true;
  Object.assign(lamp.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3, near: 0.1, far: 12 });
  lamp.shadow.mapSize.set(512, 512);
  lamp.shadow.bias = -0.004;
  const floor = new Mesh(new PlaneGeometry(6, 6), new MeshStandardMaterial({ color: 0xffffff }));
  floor.rotation.x = -Math.PI / 2;
  floor.receiveShadow = true;
  scene.add(lamp, floor, new AmbientLight(0xffffff, 0.3));
  camera.position.set(0, 2.6, 3.6);
  camera.lookAt(0, 0.6, 0);
  clip.mesh.receiveShadow = false;
  const draw = async (castShadow) => {
    clip.mesh.castShadow = castShadow;
    return picture(view);
  };
  const [withShadow, without] = [await draw(true), await draw(false)];
  const onFloor = different(withShadow, without);
  // A roof over the clip, which the camera does not see.
  const roof = new Mesh(new BoxGeometry(4, 0.05, 4), new MeshBasicMaterial({ color: 0 }));
  roof.position.set(0.9, 2.9, 0.9);
  roof.castShadow = true;
  scene.remove(floor);
  const bright = covered(await picture(view));
  clip.mesh.receiveShadow = true;
  clip.mesh.material.needsUpdate = true;
  const lit = covered(await picture(view));
  scene.add(roof);
  roof.layers.set(1);
  lamp.shadow.camera.layers.enable(1);
  const shaded = covered(await picture(view));
  renderer.shadowMap.enabled = false;
  return { onFloor, bright, lit, shaded, picture: base64(withShadow) };
};

/** The mean of the clip's pixels in fog of one colour, near and far away. */
window.drawFog = async (kind, src) => {
  const view = await stage(kind, src);
  const { scene, camera } = view;
  const clear = covered(await picture(view));
  scene.fog = new Fog(0xffffff, 3, 7);
  const near = covered(await picture(view));
  camera.position.z = 9;
  const far = covered(await picture(view));
  return { clear, near, far };
};

/** Two clips and a box in one scene: pixels of the box that the first clip hides, and of the clip that the box hides. */
window.drawTwo = async (kind, src, other) => {
  const view = await stage(kind, src);
  const { renderer, scene } = view;
  const alone = covered(await picture(view)).count;
  const { FvvClip } = kind === "webgl" ? forWebGL : forWebGPU;
  const second = new FvvClip({ src: other, renderer, decoderOptions: { worker } });
  clips.push(second);
  second.position.set(1.3, 0, -0.5);
  view.clip.position.x = -0.6;
  scene.add(second);
  await second.ready;
  const both = covered(await picture(view)).count;
  const box = new Mesh(new BoxGeometry(0.4, 3, 0.01), new MeshBasicMaterial({ color: 0xff00ff }));
  const magenta = async (z) => {
    box.position.set(-0.6, 1, z);
    const data = await picture(view);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) count += data[i] > 250 && data[i + 1] < 5 && data[i + 2] > 250;
    return count;
  };
  scene.add(box);
  return { alone, both, before: await magenta(1.5), behind: await magenta(-2) };
};

/**
 * A wall of three's splats across the view, before the clip and behind it: pixels of the wall's colour, and of the clip's, which are
 * neither that nor black.
 */
window.drawSplats = async (kind, src) => {
  const view = await stage(kind, src);
  const { scene } = view;
  const side = 40;
  const centers = new Float32Array(3 * side * side);
  const covariances = new Float32Array(6 * side * side);
  for (let i = 0; i < side * side; i++) {
    centers.set([((i % side) - side / 2) / 10, Math.floor(i / side) / 10 - 1, 0], 3 * i);
    covariances.set([0.01, 0, 0, 0.01, 0, 0.0001], 6 * i);
  }
  const colors = Uint8Array.from({ length: 4 * side * side }, (_, i) => (i % 4 === 1 ? 0 : 255));
  const splats = new GaussianSplat(createGaussianSplatGeometry(centers, covariances, colors));
  scene.add(splats);
  const counted = async (z) => {
    splats.position.z = z;
    let data;
    // Splats are sorted after they were drawn first.
    for (let i = 0; i < 3; i++) data = await picture(view);
    let [wall, clip] = [0, 0];
    for (let i = 0; i < data.length; i += 4) {
      const isWall = data[i] > 200 && data[i + 1] < 40 && data[i + 2] > 200;
      wall += isWall;
      clip += !isWall && data[i + 1] > 40;
    }
    return { wall, clip };
  };
  const [before, behind] = [await counted(1.5), await counted(-1.5)];
  return { before, behind };
};

/** The static environment: the number of its meshes, and the pixels that it covers. */
window.drawEnvironment = async (kind, src) => {
  const view = await stage(kind, src);
  const { clip } = view;
  for (let i = 0; i < 100 && !clip.environment.children.length; i++) await new Promise((done) => setTimeout(done, 50));
  const withIt = covered(await picture(view)).count;
  clip.environment.visible = false;
  return { meshes: clip.environment.children.length, withIt, without: covered(await picture(view)).count };
};

/** Sound: the loudness of what reaches the context, the objects' places, and that other than by volume nothing is changed. */
window.hear = async (kind, src) => {
  const view = await stage(kind, src, { loop: true });
  const { clip } = view;
  await clip.play();
  for (let i = 0; i < 100 && !clip.audio.length; i++) {
    await picture(view);
    await new Promise((done) => setTimeout(done, 50));
  }
  const [audio] = clip.audio;
  /** The largest sample of any track, in at most the given number of looks; the first that is loud ends it. */
  const loudness = async (looks) => {
    const meters = clip.audio.map(({ context, gain }) => {
      const meter = new AnalyserNode(context, { fftSize: 8192 });
      gain.connect(meter);
      return { gain, meter, samples: new Float32Array(meter.fftSize) };
    });
    let most = 0;
    for (let i = 0; i < looks && most < 0.02; i++) {
      await new Promise((done) => setTimeout(done, 50));
      await picture(view);
      for (const { meter, samples } of meters) {
        meter.getFloatTimeDomainData(samples);
        most = Math.max(most, ...samples.map(Math.abs));
      }
    }
    for (const { gain, meter } of meters) gain.disconnect(meter);
    return most;
  };
  const loud = await loudness(100);
  clip.volume = 0;
  await new Promise((done) => setTimeout(done, 300));
  const silent = await loudness(15);
  const sphere = clip.mesh.geometry.boundingSphere;
  const off = audio.getWorldPosition(new Vector3()).distanceTo(clip.mesh.localToWorld(sphere.center.clone()));
  return { loud, silent, off, type: audio.constructor.name, count: clip.audio.length, state: audio.context.state };
};

/** What is left after dispose. */
window.disposeClip = async (kind, src) => {
  const renderer = await rendererOf(kind, "standard");
  const countOf = ({ geometries, textures }) => ({ geometries, textures });
  // Empty textures are shared by all clips, and stay.
  const first = await stage(kind, src);
  await picture(first);
  window.end();
  const before = countOf(renderer.info.memory);
  const view = await stage(kind, src, { muted: true, loop: true });
  const { clip } = view;
  await picture(view);
  const meanwhile = countOf(renderer.info.memory);
  await clip.play();
  clip.removeFromParent();
  clip.dispose();
  await new Promise((done) => setTimeout(done, 300));
  const pending = new (kind === "webgl" ? forWebGL : forWebGPU).FvvClip({ src, renderer, decoderOptions: { worker } });
  pending.dispose();
  const ready = await pending.ready.then(
    () => "resolved",
    (error) => error.name,
  );
  return { before, meanwhile, after: countOf(renderer.info.memory), audio: clip.audio.length, ready };
};

/** The error of a source that is not there. */
window.failClip = async (kind) => {
  const renderer = await rendererOf(kind, "standard");
  const { FvvClip } = kind === "webgl" ? forWebGL : forWebGPU;
  const clip = new FvvClip({ renderer, decoderOptions: { worker } });
  const failed = event(clip, "error");
  clip.src = "/missing.fvv";
  const [{ error }, reason] = await Promise.all([failed, clip.ready.catch((cause) => cause)]);
  return { message: error.message, isSame: error === reason, code: clip.error.code };
};
/** The picture of docs/guide/three.md: a clip on a floor, with its shadow, among a box and splats, in fog. */
window.drawPicture = async (kind, src) => {
  const whole = { width: 960, height: 540 };
  const { renderer, scene, camera, clip } = await stage(kind, src);
  renderer.setSize(whole.width, whole.height, false);
  camera.aspect = whole.width / whole.height;
  camera.fov = 38;
  camera.position.set(1.2, 1.9, 4.6);
  camera.lookAt(0.1, 0.75, 0);
  camera.updateProjectionMatrix();
  scene.background = new Color(0xcfd8e3);
  scene.fog = new Fog(0xcfd8e3, 6, 14);
  renderer.shadowMap.enabled = true;
  const lamp = new DirectionalLight(0xfff4e0, 3);
  lamp.position.set(3, 5, 2.5);
  lamp.castShadow = true;
  Object.assign(lamp.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3, near: 0.1, far: 14 });
  lamp.shadow.mapSize.set(2048, 2048);
  lamp.shadow.bias = -0.002;
  const floor = new Mesh(new PlaneGeometry(40, 40), new MeshStandardMaterial({ color: 0x9aa7b5 }));
  floor.rotation.x = -Math.PI / 2;
  const box = new Mesh(new BoxGeometry(0.7, 0.7, 0.7), new MeshStandardMaterial({ color: 0xd9822b }));
  box.position.set(0, 0.35, -0.7);
  box.rotation.y = 0.6;
  floor.receiveShadow = box.receiveShadow = box.castShadow = true;
  scene.add(lamp, new AmbientLight(0xffffff, 0.9), floor, box);
  // A ball of splats behind the second player.
  const count = 3000;
  const centers = new Float32Array(3 * count);
  const covariances = new Float32Array(6 * count);
  const colors = new Uint8Array(4 * count);
  for (let i = 0; i < count; i++) {
    const rise = 1 - (2 * (i + 0.5)) / count;
    const around = 2.399963 * i;
    const level = Math.sqrt(1 - rise * rise);
    centers.set([0.45 * level * Math.cos(around), 0.45 * rise, 0.45 * level * Math.sin(around)], 3 * i);
    covariances.set([0.0003, 0, 0, 0.0003, 0, 0.0003], 6 * i);
    colors.set([90 + 80 * rise, 120 + 60 * Math.cos(around), 200, 235], 4 * i);
  }
  const ball = new GaussianSplat(createGaussianSplatGeometry(centers, covariances, colors));
  ball.position.set(1.55, 0.9, -0.5);
  scene.add(ball);
  const again = clip.instance();
  again.position.set(-1.2, 0, -4);
  again.rotation.y = 0.9;
  for (const mesh of again.children) mesh.castShadow = true;
  scene.add(again);
  let data;
  for (let i = 0; i < 3; i++) {
    await new Promise(requestAnimationFrame);
    data = await drawn(renderer, scene, camera, whole);
  }
  renderer.shadowMap.enabled = false;
  renderer.setSize(size.width, size.height, false);
  return { ...whole, data: base64(data) };
};

window.backendOf = async (kind) => ((await rendererOf(kind, "standard")).backend?.isWebGPUBackend ? "webgpu" : "webgl");
document.documentElement.dataset.ready = "";
