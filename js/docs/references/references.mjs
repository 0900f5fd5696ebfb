// The references that are made from sources: of the command line, C, C++, Python and JavaScript.

import { execFileSync } from "node:child_process";
import { join } from "node:path";

import { root } from "../sources.mjs";
import { cliReference } from "./cli.mjs";
import { headerReferences } from "./headers.mjs";
import { typescriptReference } from "./typescript.mjs";

function pythonReference(out) {
  const script = join(root, "js/docs/references/python_api.py");
  execFileSync(process.env.PYTHON ?? "python3", [
    script,
    join(root, "bindings/python/fvv"),
    join(out, "python/api.md"),
  ]);
  return { title: "Python", folder: "python", pages: [{ text: "fvv", link: "/python/api" }], files: ["python/api.md"] };
}

/** tools: the folder of the native tools. work: a folder for files in between. Writes the pages; returns [{title, folder, pages: [{text, link}], files}], files with .md. */
export async function makeReferences(out, tools, work) {
  return [
    cliReference(out, tools),
    ...headerReferences(out),
    pythonReference(out),
    await typescriptReference(out, work),
  ];
}
