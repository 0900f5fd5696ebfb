// Numbers and names of the format as newcomers read them.

const number = new Intl.NumberFormat("en");
export const count = (n) => number.format(Math.round(n));
export const percent = (share) => `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;

/** 1923408 -> "1.92 MB" */
export function bytes(n) {
  if (n >= 1e6) return `${(n / 1e6).toFixed(n < 1e7 ? 2 : 1)} MB`;
  return n >= 1e3 ? `${(n / 1e3).toFixed(n < 1e4 ? 1 : 0)} kB` : `${Math.round(n)} bytes`;
}
export const bitrate = (bits) =>
  bits >= 1e6 ? `${(bits / 1e6).toFixed(1)} Mbit/s` : `${(bits / 1e3).toFixed(0)} kbit/s`;
export const seconds = (s) => (s < 0.095 ? `${Math.round(1000 * s)} ms` : `${s.toFixed(2)} s`);

const codecs = { avc1: "H.264", hvc1: "HEVC", vp09: "VP9", av01: "AV1", jpeg: "JPEG", oexr: "OpenEXR" };
export const codecName = (codec) => codecs[codec] ?? codec;

const profiles = {
  draco: "Draco key frames",
  delta: "motion between them",
  fast: "fast meshes",
  raw: "raw meshes",
  field: "fields",
};
export const profileName = (profile) => profiles[profile] ?? profile;
