// Which Markdown file of the repository becomes which page of the documentation.

import { existsSync, readdirSync } from "node:fs";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

export const root = resolve(fileURLToPath(import.meta.url), "../../..");

const list = (folder, ends) =>
  readdirSync(join(root, folder))
    .filter((name) => name.endsWith(ends))
    .sort();

/** Map from the path in the repository to the path of the page, both with .md. */
export function pagesOf() {
  const pages = new Map([
    ["README.md", "overview.md"],
    ["CHANGELOG.md", "changelog.md"],
    ["CONTRIBUTING.md", "contributing.md"],
    ["SECURITY.md", "security.md"],
    ["docs/evidence/charts/README.md", "evidence/charts.md"],
    ["bindings/python/README.md", "python/index.md"],
    ["conformance/README.md", "conformance/vectors.md"],
    ["conformance/PROTOCOL.md", "conformance/protocol.md"],
    ["conformance/reference/listings/README.md", "conformance/listings.md"],
    ["packaging/README.md", "packaging.md"],
    ["tests/real/README.md", "real-captures.md"],
    ["js/player/conformance/README.md", "js/player-conformance.md"],
  ]);
  for (const name of list("js/docs/pages", ".md")) pages.set(`js/docs/pages/${name}`, name);
  for (const folder of ["guide", "tools", "encoding", "format", "evidence", "project"])
    for (const name of list(`docs/${folder}`, ".md")) pages.set(`docs/${folder}/${name}`, `${folder}/${name}`);
  for (const name of list("spec", ".md")) pages.set(`spec/${name}`, `spec/${name === "README.md" ? "index.md" : name}`);
  for (const folder of ["js", "conformance"])
    for (const name of readdirSync(join(root, folder)).sort())
      if (existsSync(join(root, folder, name, "README.md")))
        pages.set(`${folder}/${name}/README.md`, `${folder}/${name}.md`);
  for (const source of pages.keys())
    if (!existsSync(join(root, source))) throw new Error(`${source} is a page of the documentation and is not there`);
  return pages;
}
