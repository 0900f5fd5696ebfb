// The reference of the command line, from what the tools report with --help-json.

import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

import { root } from "../sources.mjs";

const TOOLS = {
  fvvmux: "encoding/budget.md",
  fvvinfo: "tools/outputs.md",
  fvvdemux: "tools/outputs.md",
  fvvimport: "tools/calibration.md",
  fvvcompare: "tools/fvvcompare.md",
  fvvrender: "tools/fvvrender.md",
  fvvrecover: "tools/fvvrecover.md",
  fvvserve: "tools/fvvserve.md",
  fvvsynth: "tools/fvvsynth.md",
};
/** Of the Python package, which need not be built. */
const PYTHON_TOOLS = {
  fvvcapture: "tools/fvvcapture.md",
  "fvvcapture calibrate": "tools/fvvcapture-calibrate.md",
  "fvvcapture live": "guide/live.md",
};

const escaped = (text) =>
  text
    .replace(/&/g, "&amp;")
    .replace(/</g, "&lt;")
    .replace(/([*_`[\]{}])/g, "\\$1");
const inCell = (text) => text.replace(/\|/g, "\\|");
const code = (text) => `\`${text}\``;
const listed = (all) => all.map(code).join(", ");

/** What is to be known of an option besides its text. */
function rules({ default: preset, range, choices, extensions, required, repeated, needs, excludes }) {
  return [
    choices && `One of ${listed(choices)}.`,
    range && `${code(range)}.`,
    extensions && `Files: ${listed(extensions.map((end) => `.${end}`))}.`,
    preset !== undefined && `Default: ${code(preset)}.`,
    required && "Required.",
    repeated && "May be given several times.",
    needs && `Needs ${listed(needs)}.`,
    excludes && `Not with ${listed(excludes)}.`,
  ].filter(Boolean);
}

const sentences = (text, more) => [/[.:]$/.test(text) || !more.length ? text : `${text}.`, ...more].join(" ");

function table(options) {
  const rows = options.map((option) => {
    const names = option.names ?? [option.name];
    const value = option.value ? ` ${option.value}` : "";
    const shown = `${names.map(code).join(", ")}${value ? ` ${code(option.value)}` : ""}`;
    return `| ${inCell(shown)} | ${inCell(sentences(escaped(option.text), rules(option)))} |`;
  });
  return ["| | |", "|---|---|", ...rows].join("\n");
}

/** The page of a tool, from its --help-json. */
function page(help, more) {
  const { tool, summary, usage, positionals, groups, examples, exit_codes: codes, notes } = help;
  const heading = (text) => text[0].toUpperCase() + text.slice(1);
  return [
    `# ${tool}`,
    escaped(summary),
    `\`\`\`text\n${usage}\n\`\`\``,
    ...(examples.length ? ["## Examples", `\`\`\`sh\n${examples.join("\n")}\n\`\`\``] : []),
    ...(positionals.length ? ["## Arguments", table(positionals)] : []),
    ...groups.flatMap(({ title, options }) => [`## ${escaped(heading(title))}`, table(options)]),
    "## Exit codes",
    ["| | |", "|---|---|", ...codes.map((row) => `| ${row.code} | ${inCell(escaped(row.text))} |`)].join("\n"),
    escaped(notes),
    `[More about it](../${more})`,
  ].join("\n\n");
}

const jsonOf = (program, ...parameters) => JSON.parse(execFileSync(program, parameters, { encoding: "utf8" }));

function helpOfTools(tools) {
  return Object.keys(TOOLS).map((name) => {
    const program = join(tools, name, name);
    if (!existsSync(program)) throw new Error(`${program} is missing: build ${name} first`);
    return jsonOf(program, "--help-json");
  });
}

/** The page of one tool, as Markdown. */
export function toolReference(name, tools) {
  return page(jsonOf(join(tools, name, name), "--help-json"), TOOLS[name]);
}

function helpOfPython() {
  const script = join(root, "js/docs/references/capture_help.py");
  return jsonOf(process.env.PYTHON ?? "python3", script, join(root, "bindings/python/fvv"));
}

/** Writes the pages below cli/. tools: the folder that has each tool in a folder of its name. Returns a reference. */
export function cliReference(out, tools) {
  mkdirSync(join(out, "cli"), { recursive: true });
  const more = { ...TOOLS, ...PYTHON_TOOLS };
  const described = [...helpOfTools(tools), ...helpOfPython()];
  const named = described.map((help) => ({ help, name: help.tool, file: help.tool.replace(" ", "-") }));
  const rows = named.map(({ help, name, file }) => {
    writeFileSync(join(out, `cli/${file}.md`), `${page(help, more[name])}\n`);
    return `| [${name}](./${file}.md) | ${inCell(escaped(help.summary))} |`;
  });
  const index = `# Command line\n\n| tool | |\n|---|---|\n${rows.join("\n")}\n\nExit codes: 0 done, 1 failed, 2 usage, 3 done with loss or warnings. [Outputs](../tools/outputs.md) says what \`--force\` replaces.\n`;
  writeFileSync(join(out, "cli/index.md"), index);
  return {
    title: "Command line",
    folder: "cli",
    pages: [
      { text: "All tools", link: "/cli/" },
      ...named.map(({ name, file }) => ({ text: name, link: `/cli/${file}` })),
    ],
    files: ["cli/index.md", ...named.map(({ file }) => `cli/${file}.md`)],
  };
}
