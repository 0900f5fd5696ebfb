// Numbers as people read them.

/** 83.5 -> "1:23.50"; whole: without hundredths. */
export function clockTime(seconds, whole = false) {
  if (!Number.isFinite(seconds)) return "0:00";
  const hundredths = Math.floor(Math.max(0, seconds) * 100 + 1e-6);
  const all = Math.floor(hundredths / 100);
  const pad = (n) => String(n).padStart(2, "0");
  const [hours, minutes] = [Math.floor(all / 3600), Math.floor(all / 60) % 60];
  const text = hours ? `${hours}:${pad(minutes)}:${pad(all % 60)}` : `${minutes}:${pad(all % 60)}`;
  return whole ? text : `${text}.${pad(hundredths % 100)}`;
}

/** For who listens: "1 minute 23.5 seconds". */
export function spokenTime(seconds) {
  const minutes = Math.floor(seconds / 60);
  const rest = Number((seconds - 60 * minutes).toFixed(2));
  const part = `${rest} ${rest === 1 ? "second" : "seconds"}`;
  return minutes ? `${minutes} ${minutes === 1 ? "minute" : "minutes"} ${part}` : part;
}

export const megabytes = (bytes) => `${(bytes / 2 ** 20).toFixed(0)} MiB`;
export const bitrateText = (bits) =>
  bits >= 1e6 ? `${(bits / 1e6).toFixed(2)} Mbit/s` : `${(bits / 1e3).toFixed(0)} kbit/s`;
export const rateText = (rate) => `${rate}\u00d7`;
