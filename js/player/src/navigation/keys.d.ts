/** What keys do, as people read it. */
export interface KeyHelp {
  /** Keys as they are written. */
  shown: string[];
  says: string;
}

export const COMMANDS: readonly KeyHelp[];
/** Keys that move while they are held. */
export const MOVES: readonly KeyHelp[];
