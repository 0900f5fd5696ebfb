// Errors and warnings. Codes are the names of fvv_status in types.h, and a few of this package.

const codes = new Map([
  [-1, "argument"],
  [-2, "memory"],
  [-4, "io"],
  [-5, "state"],
  [-6, "input"],
  [-100, "damaged"],
  [-101, "truncated"],
  [-102, "invalid"],
  [-103, "unsupported"],
  [-104, "limit"],
  [-200, "bug"],
]);

export const IO = -4;

export class FvvError extends Error {
  /** code: "damaged", "limit", ...; issue: n of FVV-n in spec/issues.md, 0 if no rule is violated. */
  constructor({ code, message, issue = 0, fatal = true, severity = "error", cause, ...place }) {
    super(issue ? `${message} [FVV-${String(issue).padStart(4, "0")}]` : message, cause ? { cause } : undefined);
    this.name = "FvvError";
    const { chunk = "", offset = null, frame = null, from = null, to = null } = place;
    Object.assign(this, { code, issue, fatal, severity, chunk, offset, frame, from, to });
  }

  static warning(code, message, cause) {
    return new FvvError({ code, message, severity: "warning", fatal: false, cause });
  }

  /** Frames between two times are missing because of cause. */
  static gap(cause, { from, to }) {
    const { issue, chunk, offset, severity } = cause;
    const message = `frames are missing: ${cause.message}`;
    const gap = new FvvError({ code: "gap", message, severity, fatal: false, chunk, offset, from, to, cause });
    gap.issue = issue; // the message of the cause names it
    return gap;
  }

  static fromDiagnostic(diagnostic, { fatal = true } = {}) {
    const code = codes.get(diagnostic.status) ?? "unknown";
    return new FvvError({ ...diagnostic, code, message: diagnostic.message || code, fatal });
  }

  /** Structured clones of errors lose their class and fields. */
  toPlain() {
    const { code, issue, fatal, severity, chunk, offset, frame, from, to, message } = this;
    const cause = this.cause instanceof FvvError ? { cause: this.cause.toPlain() } : null;
    return { code, issue, fatal, severity, chunk, offset, frame, from, to, message, ...cause };
  }

  static fromPlain(plain) {
    const cause = plain.cause && FvvError.fromPlain(plain.cause);
    const error = new FvvError({ ...plain, issue: 0, cause });
    error.issue = plain.issue;
    return error;
  }

  static from(error, code = "io") {
    if (error instanceof FvvError) return error;
    return new FvvError({ code, message: String(error?.message ?? error), cause: error });
  }
}
