// What plays a stream without an element: its clock, its frames and its sound. index.d.ts documents the types.

export { Media, MEDIA_EVENTS } from "./media.js";
export { Sound } from "./sound.js";
