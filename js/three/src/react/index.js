// <Fvv> for @react-three/fiber: a clip as a component, which suspends until its first frame is there.

import { useThree } from "@react-three/fiber";
import { createElement, use, useEffect, useImperativeHandle, useState } from "react";

import { SharedClips } from "./shared_clips.js";

/** Events of a clip by the property of their listener. */
const EVENTS = {
  onEnded: "ended",
  onError: "error",
  onPause: "pause",
  onPlay: "play",
  onPlaying: "playing",
  onRungChange: "rungchange",
  onSeeked: "seeked",
  onTimeUpdate: "timeupdate",
  onWaiting: "waiting",
  onWarning: "warning",
};
/** Options that a clip has from the beginning. */
const FIXED = ["listener", "environment", "decoderOptions", "blend", "threshold", "best", "unseen"];
/** Properties of a clip that may change, with their values where a component does not have them. */
const CHANGING = { loop: false, muted: false, volume: 1, playbackRate: 1, rung: "auto" };

const shared = new SharedClips();

/** The clip of a component: components with the same src and id of one renderer share it. */
function useShared({ src, id, options }) {
  const renderer = useThree((state) => state.gl);
  const entry = shared.get(renderer, src, id, options);
  const clip = use(entry.clip);
  const [user] = useState(() => ({}));
  const [object, setObject] = useState(null);
  useEffect(() => {
    setObject(entry.join(user));
    return () => entry.leave(user);
  }, [entry, user]);
  return { clip, object };
}

function useListeners(clip, listeners) {
  const invalidate = useThree((state) => state.invalidate);
  useEffect(() => {
    const added = [];
    const listen = (type, listener) => {
      clip.addEventListener(type, listener);
      added.push([type, listener]);
    };
    for (const [property, type] of Object.entries(EVENTS)) if (listeners[property]) listen(type, listeners[property]);
    listen("framechange", () => {
      // For frameloop="demand".
      invalidate();
      if (clip.frame) listeners.onFrame?.({ ...clip.frame, target: clip });
    });
    return () => added.forEach(([type, listener]) => clip.removeEventListener(type, listener));
  });
}

/**
 * Properties: src, loop, autoPlay, muted, volume, playbackRate, rung, paused; onFrame and other listeners; those of a primitive
 * of fiber, as position; ref for the clip.
 */
export function Fvv({ src, id, autoPlay, paused, castShadow = true, receiveShadow = true, ref, children, ...given }) {
  const taken = (names) => Object.fromEntries(names.filter((name) => name in given).map((name) => [name, given[name]]));
  const options = { ...taken(FIXED), ...taken(Object.keys(CHANGING)) };
  const { clip, object } = useShared({ src, id, options });
  const listeners = taken([...Object.keys(EVENTS), "onFrame"]);
  useListeners(clip, listeners);
  useImperativeHandle(ref, () => clip, [clip]);
  for (const [name, initial] of Object.entries(CHANGING)) {
    const value = given[name] ?? initial;
    useEffect(() => {
      if (clip[name] !== value) clip[name] = value;
    }, [clip, name, value]);
  }
  useEffect(() => {
    if (paused === undefined ? autoPlay : !paused) clip.play().catch(() => {});
    else if (paused) clip.pause();
  }, [clip, autoPlay, paused]);
  useEffect(() => {
    if (object)
      object.traverse(
        (one) => one.isMesh && one.parent === object && Object.assign(one, { castShadow, receiveShadow }),
      );
  }, [object, castShadow, receiveShadow]);
  if (!object) return null;
  const others = Object.fromEntries(
    Object.entries(given).filter(([name]) => !(name in options) && !(name in listeners)),
  );
  // A clip is disposed of when no component uses it.
  return createElement("primitive", { ...others, object, dispose: null }, children);
}

/** Begins to load a clip before a component needs it. */
export function preload(renderer, src, { id, ...options } = {}) {
  return shared.get(renderer, src, id, options).clip;
}
