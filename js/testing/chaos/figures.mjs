// What viewers measure while networks fail, in simulated time.

/** Milliseconds without a frame after the end of a fault that count as a hang: three times what any retry or time-out takes. */
export const HANG_MS = 45000;
/** After the event "online", and after the time that Retry-After names. */
export const PROMPT_MS = 3000;

function percentile95(recoveries) {
  const sorted = recoveries.map(({ milliseconds }) => milliseconds).sort((a, b) => a - b);
  return (sorted[Math.ceil(0.95 * sorted.length) - 1] ?? 0) / 1000;
}

export class Figures {
  frames = 0;
  hangs = 0;
  wrong = 0;
  lost = 0; // positions that were not kept
  errors = [];
  details = []; // of what is wrong or lost
  sessions = 0;
  refused = 0; // openings that failed while a fault lasted
  faults = {};
  recoveries = []; // {kind, milliseconds}

  note(fault) {
    const name = fault.kind === "status" ? `status${fault.retryAfter ? " with Retry-After" : ""}` : fault.kind;
    this.faults[name] = (this.faults[name] ?? 0) + 1;
  }
  recovered(fault, milliseconds) {
    this.recoveries.push({
      kind: fault.kind,
      isPrompt: fault.kind === "offline" || Boolean(fault.retryAfter),
      milliseconds,
    });
  }
  get late() {
    return this.recoveries.filter(({ isPrompt, milliseconds }) => isPrompt && milliseconds > PROMPT_MS);
  }
  /** The 95th of a hundred recoveries after a moment that a viewer knows: the event "online", or the time of Retry-After. In seconds. */
  get p95() {
    return percentile95(this.recoveries.filter(({ isPrompt }) => isPrompt));
  }
  /** The same of all: a host that is back says so only to who asks. */
  get returnP95() {
    return percentile95(this.recoveries);
  }
  /** The longest recovery of each kind, in seconds. */
  get #slowest() {
    const found = {};
    for (const { kind, milliseconds } of this.recoveries) found[kind] = Math.max(found[kind] ?? 0, milliseconds / 1000);
    return found;
  }
  toJSON() {
    const { frames, hangs, wrong, lost, errors, details, sessions, refused, faults, late, p95, returnP95 } = this;
    return {
      frames,
      sessions,
      refused,
      hangs,
      wrong,
      lost,
      errors,
      details,
      late,
      recoveries: this.recoveries.length,
      p95,
      returnP95,
      slowest: this.#slowest,
      faults,
    };
  }
}

/** What is wrong, as text; empty: nothing is. */
export const faultsOf = ({ hangs, wrong, lost, errors, late }) =>
  [
    hangs && `${hangs} hangs`,
    wrong && `${wrong} wrong frames`,
    lost && `${lost} positions lost`,
    ...errors,
    ...late.map(({ kind, milliseconds }) => `${kind}: playing again after ${Math.round(milliseconds)} ms`),
  ].filter(Boolean);
