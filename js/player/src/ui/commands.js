// The commands of buttons and keys. navigation/keys.js assigns keys to them.

export const SPEEDS = [0.1, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 4];
export const MODES = [
  ["textured", "Textured"],
  ["weights", "Camera weights"],
  ["visibility", "Visibility"],
  ["wireframe", "Wireframe"],
  ["normals", "Normals"],
  ["depth", "Depth"],
];
/** Seconds. */
const JOURNEY = 0.7;

/** How cameras are shown in the scene, if it is not a contact sheet. Without a mesh there is nothing else. */
export const sceneOf = ({ onlyPictures }) => (onlyPictures ? "pictures" : "none");

/** panels: {toggle(name)}; player: the element. */
export function commandsOf(player, panels) {
  const seekable = () => (player.seekable.length ? [player.seekable.start(0), player.seekable.end(0)] : null);
  const seek = (seconds) => {
    const range = seekable();
    if (range) player.currentTime = Math.min(Math.max(seconds, range[0]), range[1]);
  };
  const look = (id) => player.snapToCamera(id, { duration: JOURNEY });

  return {
    togglePlay: () => (player.paused ? player.play() : player.pause()),
    toggleSound: () => (player.muted = !player.muted),
    step: (count) => player.step(count),
    skip: (seconds) => seek(player.currentTime + seconds),
    jump: (end) => seekable() && seek(end ? Infinity : -Infinity),
    changeSpeed: (by) => {
      const at = SPEEDS.findLastIndex((speed) => speed <= player.playbackRate + 1e-9);
      player.playbackRate = SPEEDS[Math.min(Math.max(at + by, 0), SPEEDS.length - 1)];
    },
    markLoop: (which) => {
      const range = seekable();
      if (!range) return;
      const { from, to } = { from: range[0], to: range[1], ...player.loopRange, [which]: player.currentTime };
      if (to > from) player.loopRange = { from, to };
      else player.loopRange = which === "from" ? { from, to: range[1] } : { from: range[0], to };
    },
    clearLoop: () => (player.loopRange = null),
    goLive: () => player.goLive(),
    nextCamera: (by) => {
      const ids = player.cameras.filter(({ calibrated }) => calibrated).map(({ id }) => id);
      if (!ids.length) return;
      const at = ids.indexOf(player.camera);
      look(ids[at < 0 ? (by > 0 ? 0 : ids.length - 1) : (at + by + ids.length) % ids.length]);
    },
    snapTo: (position) => {
      const camera = player.cameras.filter(({ calibrated }) => calibrated)[position];
      if (camera) look(camera.id);
    },
    goHome: () => player.resetView({ duration: JOURNEY }),
    toggleFlying: () => (player.navigation = player.navigation === "fly" ? "orbit" : "fly"),
    nextMode: () => {
      const names = MODES.map(([name]) => name);
      player.viewMode = names[(names.indexOf(player.viewMode) + 1) % names.length];
    },
    toggleSheet: () => (player.showCameras = player.showCameras === "sheet" ? sceneOf(player) : "sheet"),
    toggleCameras: () => panels.toggle("cameras"),
    toggleSettings: () => panels.toggle("settings"),
    toggleStats: () => panels.toggle("stats"),
    toggleHelp: () => panels.toggle("help"),
    toggleImmersive: (mode) => player.toggleImmersive(mode),
    toggleFullscreen: () => player.toggleFullscreen(),
  };
}
