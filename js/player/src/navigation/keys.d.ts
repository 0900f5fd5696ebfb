/** The help text of keys. */
export interface KeyHelp {
  /** Keys as they are displayed. */
  shown: string[];
  description: string;
}

export const COMMANDS: readonly KeyHelp[];
/** Keys that move the viewer while they are pressed. */
export const MOVES: readonly KeyHelp[];
