// The example: one stream in a scene with a few controls. ?file=NAME.fvv selects the stream; default players.fvv.

import { createDecoder } from "@fvv/decoder";
import { FvvObject3D, lookThrough } from "@fvv/three";
import { Box3, Color, GridHelper, Matrix4, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

import { CameraFrusta } from "./frusta.js";
import { Playback } from "./playback.js";

const $ = (id) => document.getElementById(id);
const parameters = new URLSearchParams(location.search);
const file = parameters.get("file") ?? "players.fvv";
const shapes = { play: "M7 4.5v15l12-7.5z", pause: "M6 4.5h4v15H6zM14 4.5h4v15h-4z" };
const ups = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], "-x": [-1, 0, 0], "-y": [0, -1, 0], "-z": [0, 0, -1] };

const canvas = $("scene");
const renderer = new WebGLRenderer({ canvas, antialias: true });
const scene = new Scene();
const viewer = new PerspectiveCamera(45, 1, 0.02, 200);
const controls = new OrbitControls(viewer, canvas);
const object = new FvvObject3D({ renderer });
const frusta = new CameraFrusta(0x2f8fe8);
const box = new Box3();
let grid = null;
let playback = null;
let current = null; // number and cameras of the last frame, for the controls

controls.enableDamping = true;
scene.add(object, frusta);

function showMessage(text) {
  $("message").textContent = text;
}

function applyTheme(theme) {
  document.documentElement.dataset.theme = theme;
  scene.background = new Color(getComputedStyle(document.documentElement).getPropertyValue("--ground").trim());
  if (grid) grid.material.color.set(theme === "dark" ? 0x4a525c : 0xb4bac2);
}

function resize() {
  const { clientWidth, clientHeight } = canvas;
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.setSize(clientWidth, clientHeight, false);
  viewer.aspect = clientWidth / Math.max(1, clientHeight);
  viewer.updateProjectionMatrix();
}

/** Moves the viewer so that all of the first frame is in the picture, seen from the direction of the first camera. */
function frameScene(frame) {
  if (object.mesh.visible) box.copy(object.mesh.geometry.boundingBox).translate(object.mesh.position);
  else box.setFromCenterAndSize(new Vector3(), new Vector3(2, 2, 2));
  const centre = box.getCenter(new Vector3());
  const size = box.getSize(new Vector3()).length();
  const up = new Vector3(...(ups[frame.configuration.upAxis] ?? [0, 1, 0]));
  const eye = frame.cameras.length ? new Vector3(...frame.cameras[0].centre) : centre.clone().addScalar(size);
  const away = eye.sub(centre).normalize();
  const distance = size / (2 * Math.tan((viewer.fov * Math.PI) / 360)) / Math.min(1, viewer.aspect);
  viewer.up.copy(up);
  viewer.position.copy(centre).addScaledVector(away, 1.1 * distance);
  viewer.near = size / 250;
  viewer.far = 40 * size;
  controls.target.copy(centre);
  controls.update();
  grid = new GridHelper(2 * size, 20);
  grid.material.vertexColors = false;
  grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), up);
  const ground = Math.min(box.min.dot(up), box.max.dot(up));
  grid.position.copy(centre).addScaledVector(up, ground - centre.dot(up));
  scene.add(grid);
  applyTheme(document.documentElement.dataset.theme);
}

function listCameras(frame) {
  const option = (value, text) => new Option(text, value);
  $("view").replaceChildren(option("", "Free view"));
  for (const { id, name } of frame.cameras) $("view").append(option(id, name || `Camera ${id}`));
}

async function show(frame) {
  await object.show(frame);
  const { radius } = (object.mesh.visible && object.mesh.geometry.boundingSphere) || { radius: 2.5 };
  frusta.show(frame.cameras, 0.14 * radius, frame.configuration.localOrigin);
  const first = current === null;
  current = { number: frame.number, cameras: frame.cameras };
  if (first) {
    frameScene(frame);
    listCameras(frame);
    showMessage("");
  }
  $("frame").value = String(frame.number);
  $("number").value = `${frame.number}${Number($("frame").max) > 0 ? ` / ${$("frame").max}` : ""}`;
  const { mesh } = frame;
  $("facts").textContent = mesh
    ? `${mesh.faceCount.toLocaleString("en")} triangles, ${object.viewCount} cameras, ${frame.seconds.toFixed(2)} s`
    : "no mesh in this frame";
}

function draw(milliseconds) {
  playback?.tick(milliseconds / 1000);
  const id = $("view").value;
  const camera = id === "" ? null : current?.cameras.find((one) => one.id === Number(id) && one.calibrated);
  if (camera) {
    lookThrough(viewer, camera);
    // All of its picture, in a window of any shape.
    const shape = viewer.aspect / (camera.width / camera.height);
    viewer.projectionMatrix.premultiply(shapeMatrix(shape));
    viewer.projectionMatrixInverse.copy(viewer.projectionMatrix).invert();
  } else {
    controls.update();
  }
  renderer.render(scene, viewer);
  if (current) document.documentElement.dataset.drawn = String(current.number);
}

function shapeMatrix(shape) {
  return new Matrix4().makeScale(Math.min(1, 1 / shape), Math.min(1, shape), 1);
}

function setPlaying(playing) {
  playback.play(playing);
  $("play").setAttribute("aria-label", playing ? "Pause" : "Play");
  $("play-shape").setAttribute("d", playing ? shapes.pause : shapes.play);
}

function leaveCamera() {
  if ($("view").value === "") return;
  $("view").value = "";
  viewer.updateProjectionMatrix();
  controls.update();
}

function connectControls() {
  $("play").addEventListener("click", () => setPlaying(!playback.playing));
  $("frame").addEventListener("input", () => {
    setPlaying(false);
    playback.seek(Number($("frame").value));
  });
  $("frusta").addEventListener("change", () => (frusta.visible = $("frusta").checked));
  $("view").addEventListener("change", () => {
    if ($("view").value === "") viewer.updateProjectionMatrix();
  });
  $("theme").addEventListener("click", () =>
    applyTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"),
  );
  canvas.addEventListener("pointerdown", leaveCamera);
  canvas.addEventListener("wheel", leaveCamera, { passive: true });
  addEventListener("keydown", (event) => {
    if (event.key === " " && !["BUTTON", "SELECT"].includes(event.target.tagName)) setPlaying(!playback.playing);
  });
}

async function begin() {
  applyTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  new ResizeObserver(resize).observe(canvas);
  resize();
  $("title").textContent = file.replace(/^.*\//, "");
  const decoder = await createDecoder({
    source: file,
    worker: new URL("worker.js", import.meta.url),
  });
  decoder.addEventListener("warning", ({ detail }) => console.info(detail.message));
  playback = new Playback(decoder, show, (error) => showMessage(error.message));
  $("frame").max = String(Math.max(0, (decoder.frameCount ?? 1) - 1));
  $("frame").disabled = !decoder.seekable;
  $("play").disabled = false;
  connectControls();
  playback.seek(Number(parameters.get("frame") ?? 0));
  setPlaying(!parameters.has("frame"));
  renderer.setAnimationLoop(draw);
}

begin().catch((error) => {
  showMessage(error.message);
  console.error(error);
});
