// Projects of users, with the packages as npm publishes them, and what their pages show.

import { execFileSync } from "node:child_process";
import { cpSync, mkdirSync, symlinkSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

import { PNG } from "pngjs";

const js = fileURLToPath(new URL("../..", import.meta.url));

/** Makes a project of the files in a folder: tarballs ({name: path}) as npm would install them, and others of js/node_modules. */
export function install(files, project, tarballs) {
  cpSync(files, project, { recursive: true });
  writeFileSync(join(project, "package.json"), JSON.stringify({ private: true, type: "module" }));
  for (const [name, tarball] of Object.entries(tarballs)) {
    const target = join(project, "node_modules/@fvv", name);
    mkdirSync(target, { recursive: true });
    execFileSync("tar", ["-xzf", tarball, "-C", target, "--strip-components=1"]);
  }
  for (const name of ["react", "react-dom", "three", "vite", "@types"])
    symlinkSync(join(js, "node_modules", name), join(project, "node_modules", name));
  return project;
}

/** The number of colours on the player's picture. */
export async function coloursOf(page) {
  const shown = () => page.evaluate(() => document.querySelector("fvv-player").readyState >= 2);
  for (let i = 0; i < 300 && !(await shown()); i++) await new Promise((later) => setTimeout(later, 100));
  const player = await page.$("fvv-player");
  let colours;
  for (let attempt = 0; attempt < 30; attempt++) {
    const { data } = PNG.sync.read(Buffer.from(await player.screenshot()));
    colours = new Set();
    for (let i = 0; i < data.length; i += 4 * 61) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    if (colours.size > 300) break;
    await new Promise((later) => setTimeout(later, 100));
  }
  return colours.size;
}
