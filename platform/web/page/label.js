// SPDX-License-Identifier: Apache-2.0
// What a button says of a clip.
const LABELS = new Map([['scan-motion', 'As filmed'], ['walk', 'Walk'], ['stroll', 'Stroll']]);
const LONGEST = 24;

/** Text, never HTML: the name comes from the file, and a stranger may have written it. */
export function labelOf(name) {
  return (LABELS.get(name) ?? name).slice(0, LONGEST);
}
