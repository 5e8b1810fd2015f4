// SPDX-License-Identifier: Apache-2.0
// A browser's profile outlives the browser by a moment: processes of its own that still end write into it.
import fs from 'node:fs';

/** Removes the folder. Throws where it still fills up after five seconds. */
export async function removeProfile(folder) {
  for (const end = Date.now() + 5000; ;) {
    try {
      fs.rmSync(folder, { recursive: true, force: true });
      return;
    } catch (error) {
      if (Date.now() > end) throw error;
      await new Promise(next => setTimeout(next, 100));
    }
  }
}
