// A moment and a view of it as a part of a URL's fragment: #fvv=t:1.28;eye:1.2,1.6,3;at:0,1,0;up:0,1,0;fov:45. Other parts
// of the fragment are left as they are.

import { isPose } from "./pose.js";

const short = (x) => String(Number(x.toFixed(3)));
const list = (vector) => vector.map(short).join(",");

/** camera: identifier of the one that is looked through, or null. */
export function formatBookmark({ seconds, pose, camera }) {
  const view =
    camera !== null
      ? `camera:${camera}`
      : `eye:${list(pose.eye)};at:${list(pose.target)};up:${list(pose.up)};fov:${short((pose.fov * 180) / Math.PI)}`;
  return `t:${short(seconds)};${view}`;
}

/** {seconds, pose, camera}, each null where it is not said or makes no sense. */
export function parseBookmark(text) {
  const fields = Object.fromEntries(text.split(";").map((field) => field.split(":")));
  const numbers = (name) => (fields[name] ?? "").split(",").map((word) => (word === "" ? NaN : Number(word)));
  const [seconds] = numbers("t");
  const [camera] = numbers("camera");
  const pose = {
    eye: numbers("eye"),
    target: numbers("at"),
    up: numbers("up"),
    fov: (numbers("fov")[0] * Math.PI) / 180,
  };
  return {
    seconds: Number.isFinite(seconds) ? seconds : null,
    camera: Number.isInteger(camera) ? camera : null,
    pose: isPose(pose) ? pose : null,
  };
}

/** What a fragment says under a name; null: nothing. */
export function findInHash(hash, name) {
  const part = hash
    .replace(/^#/, "")
    .split("&")
    .find((one) => one.startsWith(`${name}=`));
  if (part === undefined) return null;
  try {
    return decodeURIComponent(part.slice(name.length + 1));
  } catch {
    return null;
  }
}

export function putIntoHash(hash, name, text) {
  const others = hash
    .replace(/^#/, "")
    .split("&")
    .filter((one) => one && !one.startsWith(`${name}=`));
  return `#${[...others, `${name}=${text}`].join("&")}`;
}
