// Measurements as text, with no more digits than their uncertainty justifies.

/** Two digits of the uncertainty, or one if that begins with 3 or more. */
function digitsFor(uncertainty) {
  if (!(uncertainty > 0)) return 3;
  const power = Math.floor(Math.log10(uncertainty));
  const first = uncertainty / 10 ** power;
  return Math.min(6, Math.max(0, (first < 3 ? 1 : 0) - power));
}

/** How a kind of figure is shown: [unit, the word for screen readers, factor] of each choice. */
const UNITS = {
  length: { m: ["m", "metres", 1] },
  unscaled: { units: ["units", "units of the stream", 1] },
  speed: { "m/s": ["m/s", "metres per second", 1], "km/h": ["km/h", "kilometres per hour", 3.6] },
  unscaledSpeed: { "units/s": ["units/s", "units per second", 1] },
};

/** {text, spoken, unit, factor} of {value, uncertainty}. quantity: of UNITS; unit: one of its choices, by default the first. */
export function figure({ value, uncertainty }, quantity, unit) {
  const choices = UNITS[quantity];
  const [short, word, factor] = choices[unit] ?? Object.values(choices)[0];
  const digits = digitsFor(factor * uncertainty);
  const [number, around] = [value, uncertainty].map((x) => (factor * x).toFixed(digits));
  return {
    text: `${number} ± ${around} ${short}`,
    spoken: `${number} ${word}, plus or minus ${around}`,
    unit: short,
    factor,
  };
}
