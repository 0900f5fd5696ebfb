// The style of controls in narrow players and on low screens, such as telephones: what is most needed, in one row, over at most an
// eighth of the picture.

/** Buttons are still 40 pixels high; the scrubber is between them. */
const oneRow = `
  .controls {
    padding: 8px;
    padding-bottom: max(8px, env(safe-area-inset-bottom));
  }
  .bar {
    display: flex;
    align-items: center;
    padding: 0;
    border-width: 0;
  }
  .row {
    display: contents;
  }
  .row > * {
    order: 2;
  }
  .row > :is([part~="play"], [part~="step-back"], [part~="step-forward"], .time, .live) {
    order: 0;
  }
  .row > .spring {
    display: none;
  }
  .scrubber {
    order: 1;
    flex: 1;
    min-width: 40px;
    margin: 0 10px;
  }
  .scrubber[hidden] {
    display: block;
    visibility: hidden;
  }
  .total {
    display: none;
  }
`;

export const compact = `
@media (max-width: 560px) {
  :host {
    aspect-ratio: 1;
  }
}
@media (max-height: 480px) {
${oneRow}
}
@container (max-width: 760px) {
  .row [data-wide="3"] {
    display: none;
  }
}
@container (max-width: 560px) {
${oneRow}
  .row :is([data-wide], [part~="step-back"], [part~="step-forward"]) {
    display: none;
  }
  .time {
    padding: 0 2px;
    font-size: 13px;
  }
  /* There is no room for another button and the time. */
  .row:has(:is([part~="sound"], [part~="vr"], [part~="ar"]):not([hidden])) .time {
    display: none;
  }
  .panels {
    position: absolute;
    inset: 8px;
    z-index: 1;
  }
  .panel {
    width: 100%;
  }
}
`;
