// The player as all pages of the site have it: a browser without a decoder of Opus loads one.

import { FvvPlayer } from "@fvv/player";

FvvPlayer.decoderOptions = { soundFallback: () => import("opus-decoder") };
