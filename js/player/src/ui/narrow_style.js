// What is left out, and moves closer, where there is little room. It comes last: it takes back what the others say.

export const narrow = `
@media (max-width: 560px) {
  :host {
    aspect-ratio: 1;
  }
}
@container (max-width: 760px) {
  .row [data-wide="3"] {
    display: none;
  }
}
@container (max-width: 560px) {
  .row [data-wide] {
    display: none;
  }
  .controls {
    padding: 8px;
    padding-bottom: max(8px, env(safe-area-inset-bottom));
  }
  .bar {
    padding: 2px;
  }
  .row {
    gap: 0;
  }
  .time {
    padding: 0 2px;
    font-size: 13px;
  }
  .total {
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
