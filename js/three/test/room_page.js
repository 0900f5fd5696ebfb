// The example with @react-three/xr, with an emulated headset, which draws both eyes beside each other.

import { metaQuest3, XRDevice } from "iwer";

window.device = new XRDevice(metaQuest3, { stereoEnabled: true });
// Chromium has a runtime of its own, without devices.
window.device.installRuntime({ forceInstall: true });
document.getElementById("root").style.height = "360px";
await import("../example/room.jsx");
document.documentElement.dataset.ready = "";
