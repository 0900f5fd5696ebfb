// Where the tools of analysis begin: a script of their own, which is loaded when the page asks for one of them.

export const TOOLS = ["measure", "mark", "follow"];

export class ToolsEntry {
  #host;
  #loading = null;
  #tools = null;
  #names = [];
  #marks = ""; // the address of those that are shown

  /** host: {player, root, surface, scene}, as Tools takes it. */
  constructor(host, signal) {
    this.#host = { ...host, signal };
    signal.addEventListener("abort", () => this.#close());
  }

  /** names: what the page wants, of TOOLS; marks: URL of a document, or "". */
  async choose(names, marks) {
    this.#names = names;
    if (!names.length && !marks) return this.#close();
    await this.#import();
    // Meanwhile the page may want something else.
    if (this.#names !== names || this.#host.signal.aborted) return;
    const tools = await this.load();
    tools.names = names;
    if (marks === this.#marks) return;
    this.#marks = marks;
    await tools.fetchMarks(marks);
  }
  #import() {
    return (this.#loading ??= import("./index.js"));
  }
  /** The Tools, as soon as their script is there; null: the player has left its page. */
  async load() {
    const { Tools } = await this.#import();
    if (this.#host.signal.aborted) return null;
    return (this.#tools ??= new Tools(this.#host));
  }

  /** What is open; null: no script is loaded. */
  get open() {
    return this.#tools;
  }

  #close() {
    this.#tools?.close();
    this.#tools = null;
    this.#marks = "";
  }
}
