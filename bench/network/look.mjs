// Measures how a viewer who moves is served of a file with several tracks of video: node look.mjs FILE [X,Y,Z]. Plays the file
// from a host that supports Range over 8 Mbit/s and 40 ms, as the player does, for a viewer who walks around the target and one who jumps every
// second. Prints JSON: bytes relative to those of all tracks, requests for each second, cameras of a frame, and frames on
// screen whose cameras give less of the picture than the player accepts; the frame on screen at a jump is not counted.

import { createDecoder } from "../../js/decoder/dist/index.js";
import { serve } from "../../js/decoder/test/server.mjs";
import { shapedProxy } from "./shaped_proxy.mjs";
import { coverage, LEAST, ViewpointTracks } from "../../js/player/src/playback/viewpoint_tracks.js";

const target = (process.argv[3] ?? "0,1,0").split(",").map(Number);
/** Metres from the target, and metres per second. */
const DISTANCE = 5;
const SPEED = 1.4;
/** Radians, a golden section of a turn. */
const LEAP = 2.39996;

const at = (angle) => [target[0] + DISTANCE * Math.sin(angle), target[1] + 0.6, target[2] + DISTANCE * Math.cos(angle)];
const viewers = {
  walks: (seconds) => at((SPEED / DISTANCE) * seconds),
  jumps: (seconds) => at(LEAP * Math.floor(seconds + 0.5)),
};

const LINK = { bitsPerSecond: 8e6, roundTripMs: 40 };

const server = await serve({ clip: process.argv[2] });

/** viewer: undefined plays all tracks. */
async function play(viewer) {
  const before = server.requests.length;
  const proxy = await shapedProxy(Number(new URL(server.url).port), LINK);
  const decoder = await createDecoder({
    source: `http://127.0.0.1:${proxy.port}/range/clip`,
    video: "encoded",
    queue: 1,
  });
  const choice = new ViewpointTracks(decoder);
  const [cameras, worst] = [[], []];
  let [seconds, refetched, wrong] = [0, 0, 0];
  for (let frame = await decoder.next(); frame; frame = await decoder.next()) {
    frame.close();
    const eye = viewer?.(frame.seconds);
    const isAgain = viewer && (await choice.follow(frame, { eye, target }, 1000 * frame.seconds));
    const tiles = frame.configuration.videos.filter(({ track }) => frame.tracks?.includes(track) ?? true);
    if (isAgain) {
      refetched++;
      await decoder.seek({ frame: frame.number });
      continue;
    }
    seconds += frame.duration;
    cameras.push(tiles.reduce((sum, one) => sum + one.tiles.length, 0));
    const found = viewer ? coverage(frame, { eye, target }) : 1;
    worst.push(found);
    wrong += found < LEAST;
  }
  const { bytesRead: bytes } = await decoder.stats();
  decoder.close();
  proxy.close();
  const mean = cameras.reduce((sum, count) => sum + count, 0) / cameras.length;
  const rest = {
    frames: cameras.length,
    refetched,
    wrong,
    least: Math.min(...worst),
  };
  return {
    bytes,
    requestsPerSecond: (server.requests.length - before) / seconds,
    cameras: mean,
    ...rest,
  };
}

const all = await play();
const rows = { all };
for (const [name, viewer] of Object.entries(viewers)) rows[name] = await play(viewer);
for (const row of Object.values(rows)) row.bytesOverAll = row.bytes / all.bytes;
console.log(JSON.stringify(rows));
server.close();
