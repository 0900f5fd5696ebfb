import type { DetailedHTMLProps, HTMLAttributes, ReactElement } from "react";

import type { FvvPlayer as FvvPlayerElement, FvvPlayerEventMap } from "../index.js";

/** Properties of the element that a page may set. */
type Settable =
  | "src"
  | "srcObject"
  | "poster"
  | "autoplay"
  | "loop"
  | "controls"
  | "volume"
  | "playbackRate"
  | "loopRange"
  | "currentTime"
  | "cameraOrbit"
  | "cameraTarget"
  | "fieldOfView"
  | "navigation"
  | "touchAction"
  | "viewMode"
  | "pixelRatio"
  | "rung"
  | "tools"
  | "marks"
  | "visibleBy"
  | "blend"
  | "unseen"
  | "shadows"
  | "environment"
  | "grid"
  | "colourCameras"
  | "showCameras"
  | "selectedCamera"
  | "worker"
  | "decoderOptions"
  | "controlsList";

/** The element dispatches its events itself. */
type Handler<Name extends keyof FvvPlayerEventMap> = (
  event: FvvPlayerEventMap[Name] & { readonly target: FvvPlayerElement },
) => void;

interface Listeners {
  onAbort?: Handler<"abort">;
  onCameraChange?: Handler<"camera-change">;
  onCanPlay?: Handler<"canplay">;
  onCanPlayThrough?: Handler<"canplaythrough">;
  onDurationChange?: Handler<"durationchange">;
  onEmptied?: Handler<"emptied">;
  onEnded?: Handler<"ended">;
  onError?: Handler<"error">;
  onFrameChange?: Handler<"framechange">;
  onLoadedData?: Handler<"loadeddata">;
  onLoadedMetadata?: Handler<"loadedmetadata">;
  onLoadStart?: Handler<"loadstart">;
  onOptionsChange?: Handler<"optionschange">;
  onPause?: Handler<"pause">;
  onPlay?: Handler<"play">;
  onPlaying?: Handler<"playing">;
  onProgress?: Handler<"progress">;
  onRateChange?: Handler<"ratechange">;
  onRungChange?: Handler<"rungchange">;
  onSeeked?: Handler<"seeked">;
  onSeeking?: Handler<"seeking">;
  onStalled?: Handler<"stalled">;
  onSuspend?: Handler<"suspend">;
  onTimeUpdate?: Handler<"timeupdate">;
  onVolumeChange?: Handler<"volumechange">;
  onWaiting?: Handler<"waiting">;
  onWarning?: Handler<"warning">;
}

type Inherited = Omit<DetailedHTMLProps<HTMLAttributes<FvvPlayerElement>, FvvPlayerElement>, keyof Listeners>;
type Own = Partial<Pick<FvvPlayerElement, Settable>> & {
  muted?: boolean;
  live?: boolean;
  theme?: "light" | "dark";
  bookmarks?: boolean;
};

export type FvvPlayerProps = Inherited & Own & Listeners;

/** `<fvv-player>`: properties of the element, listeners as onFrameChange (the events of the DOM, not React's), and ref. */
export function FvvPlayer(properties: FvvPlayerProps): ReactElement;

declare module "react" {
  namespace JSX {
    interface IntrinsicElements {
      /** Its listeners have the names of the events: onframechange, oncamera-change. */
      "fvv-player": Inherited & Own & { [Name in keyof FvvPlayerEventMap as `on${Name}`]?: Handler<Name> };
    }
  }
}
