// <fvv-player> as a component of React. React 19 sets properties of custom elements and adds listeners for names in small
// letters, as "onframechange"; the component has the names that are usual in React.

import { createElement } from "react";

import "../index.js";

/** The events that React components usually name in camel case, by the name of the property. */
const EVENTS = Object.fromEntries(
  [
    ..."Abort CanPlay CanPlayThrough DurationChange Emptied Ended Error LoadedData LoadedMetadata LoadStart Pause Play".split(
      " ",
    ),
    ..."Playing Progress RateChange Seeked Seeking Stalled Suspend TimeUpdate VolumeChange Waiting".split(" "),
    ..."FrameChange OptionsChange RungChange Warning".split(" "),
  ].map((name) => [`on${name}`, `on${name.toLowerCase()}`]),
);
EVENTS.onCameraChange = "oncamera-change";

/** Properties: those of the element, listeners as onFrameChange, and ref for the element itself. */
export function FvvPlayer(properties) {
  const passed = Object.entries(properties).map(([name, value]) => [EVENTS[name] ?? name, value]);
  return createElement("fvv-player", Object.fromEntries(passed));
}
