// Where the tools of analysis begin: a script of their own, which is loaded when the page asks for one of them.

export const TOOLS = ["measure"];

export class ToolsEntry {
  #host;
  #loading = null;
  #tools = null;
  #names = [];

  /** host: {player, root, surface, scene, notify}, as Tools takes it. */
  constructor(host, signal) {
    this.#host = { ...host, signal };
    signal.addEventListener("abort", () => this.#close());
  }

  /** names: what the page wants, of TOOLS. Resolves when they are there, to the Tools; null: none is wanted. */
  async choose(names) {
    this.#names = names;
    if (!names.length) {
      this.#close();
      return null;
    }
    if (!this.#tools) {
      const { Tools } = await (this.#loading ??= import("./index.js"));
      if (!this.#names.length || this.#host.signal.aborted) return null;
      this.#tools ??= new Tools(this.#host);
    }
    this.#tools.names = this.#names;
    return this.#tools;
  }

  /** What is open; null: no script is loaded. */
  get open() {
    return this.#tools;
  }

  #close() {
    this.#tools?.close();
    this.#tools = null;
  }
}
