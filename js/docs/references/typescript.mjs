// The reference of the packages for browsers and Node, from their type declarations, by TypeDoc.

import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { Application } from "typedoc";

import { root } from "../sources.mjs";

const PACKAGES = ["player", "decoder", "three", "analysis", "shading", "video-fallback"];

/** The declarations of a package, by its exports; those of dist are copies of those of src. */
function entries(folder) {
  const { exports } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
  const types = Object.values(exports).flatMap((entry) => (entry.types ? [entry.types] : []));
  return [...new Set(types)].map((path) => join(folder, path.replace("./dist/", "./src/")));
}

/** Of several modules of a package the first is the package itself, and not "index". */
function nameFirstModule(folder, name) {
  const page = join(folder, "index-1.md");
  if (!existsSync(page)) return;
  writeFileSync(page, readFileSync(page, "utf8").replace(/^# index$/m, `# ${name}: types`));
  const list = join(folder, "index.md");
  writeFileSync(list, readFileSync(list, "utf8").replace("[index](index-1.md)", `[${name}](index-1.md)`));
}

/** Writes a page below js/api/ for each package. Returns a reference. */
export async function typescriptReference(out, work) {
  const config = join(work, "tsconfig.json");
  const target = join(out, "js/api");
  mkdirSync(target, { recursive: true });
  const files = [];
  const pages = [];
  for (const name of PACKAGES) {
    const folder = join(root, "js", name);
    const entryPoints = entries(folder);
    const compilerOptions = {
      target: "es2022",
      lib: ["es2023", "dom", "dom.iterable"],
      module: "nodenext",
      noEmit: true,
    };
    writeFileSync(
      config,
      JSON.stringify({ compilerOptions: { ...compilerOptions, skipLibCheck: false }, files: entryPoints }),
    );
    const app = await Application.bootstrapWithPlugins(
      {
        plugin: ["typedoc-plugin-markdown"],
        entryPoints,
        outputs: [{ name: "markdown", path: join(target, name) }],
        tsconfig: config,
        name: `@fvv/${name}`,
        readme: "none",
        disableSources: true,
        // What other packages declare is theirs; style tests compile the declarations themselves.
        skipErrorChecking: true,
        excludeExternals: true,
        logLevel: "Error",
        router: "module",
        hideBreadcrumbs: true,
        hidePageHeader: true,
        useCodeBlocks: true,
        expandObjects: false,
        parametersFormat: "table",
        interfacePropertiesFormat: "table",
        classPropertiesFormat: "table",
        typeDeclarationFormat: "table",
        entryFileName: "index",
      },
      [],
    );
    const project = await app.convert();
    if (!project) throw new Error(`TypeDoc could not read ${entryPoints.join(", ")}`);
    await app.generateOutputs(project);
    if (app.logger.hasErrors()) throw new Error(`TypeDoc failed on ${entryPoints.join(", ")}`);
    nameFirstModule(join(target, name), `@fvv/${name}`);
    files.push(`js/api/${name}/index.md`);
    pages.push({ text: `@fvv/${name}`, link: `/js/api/${name}/` });
  }
  const list = PACKAGES.map((name) => `- [@fvv/${name}](./${name}/), explained by [its page](../${name}.md)`);
  writeFileSync(join(target, "index.md"), `# JavaScript\n\nThe types of the packages.\n\n${list.join("\n")}\n`);
  files.push("js/api/index.md");
  return { title: "JavaScript", folder: "js/api", pages: [{ text: "Packages", link: "/js/api/" }, ...pages], files };
}
