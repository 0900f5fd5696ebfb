// The reference of the command line, from what the tools say of their options (--help-json).

import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const TOOLS = {
  fvvmux: "fvvmux-budget.md",
  fvvinfo: "outputs.md",
  fvvdemux: "outputs.md",
  fvvimport: "calibration.md",
  fvvcompare: "fvvcompare.md",
  fvvrender: "fvvrender.md",
  fvvrecover: "fvvrecover.md",
  fvvserve: "fvvserve.md",
  fvvsynth: "fvvsynth.md",
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

/** Writes the pages below cli/. tools: the folder that has each tool in a folder of its name. Returns a reference. */
export function cliReference(out, tools) {
  mkdirSync(join(out, "cli"), { recursive: true });
  const rows = [];
  for (const [name, more] of Object.entries(TOOLS)) {
    const program = join(tools, name, name);
    if (!existsSync(program)) throw new Error(`${program} is missing: build ${name} first`);
    const help = JSON.parse(execFileSync(program, ["--help-json"], { encoding: "utf8" }));
    writeFileSync(join(out, `cli/${name}.md`), `${page(help, more)}\n`);
    rows.push(`| [${name}](./${name}.md) | ${inCell(escaped(help.summary))} |`);
  }
  const index = `# Command line\n\n| tool | |\n|---|---|\n${rows.join("\n")}\n\nExit codes: 0 done, 1 failed, 2 usage, 3 done with loss or warnings. [Outputs](../outputs.md) says what \`--force\` replaces.\n`;
  writeFileSync(join(out, "cli/index.md"), index);
  const names = Object.keys(TOOLS);
  return {
    title: "Command line",
    folder: "cli",
    pages: [{ text: "All tools", link: "/cli/" }, ...names.map((text) => ({ text, link: `/cli/${text}` }))],
    files: ["cli/index.md", ...names.map((name) => `cli/${name}.md`)],
  };
}
