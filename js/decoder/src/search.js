// Searches in sorted lists, which may have a hundred thousand entries: each takes as many steps as their number has bits.

/** The index of the last entry whose key is at most a value; -1: none. Keys ascend. */
export function lastAtMost(list, value, keyOf = (entry) => entry) {
  let [low, high] = [0, list.length];
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (keyOf(list[middle]) <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
