// A player in a page with an emulated headset, which draws both eyes beside each other.

import { metaQuest3, XRDevice } from "iwer";

window.device = new XRDevice(metaQuest3, { stereoEnabled: true });
// Chromium has a runtime of its own, without devices.
window.device.installRuntime({ forceInstall: true });
// The player looks for WebXR when it is defined.
await import("@fvv/player");
window.player = document.querySelector("fvv-player");
