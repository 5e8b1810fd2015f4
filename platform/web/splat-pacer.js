// SPDX-License-Identifier: Apache-2.0
// Keeps moving pictures at 30 a second by fewer splats, where the device draws too slowly: a budget of Doppel.setDetail, so the SDK's level
// of detail says which splats are left out. It goes by the time from frame to frame, which is all that a page learns of a graphics device.
// The SDK's own frame budget (dplSetFrameBudget) sees only the CPU here.
const TARGET_MS = 1000 / 30;
const TOO_SLOW_MS = 1.15 * TARGET_MS, FAST_MS = 0.7 * TARGET_MS;
const STALL_MS = 1000;       // the page was hidden, or did something else
const SLOW_FRAMES = 3;       // in a row, until the budget falls
const FAST_FRAMES = 45;      // in a row, until it rises; each rise that was too much doubles it
const MOST_FAST_FRAMES = 1440;
const LEAST_SHARE = 0.08;    // of the splats
const RISE = 1.2;

export class SplatPacer {
  #share = 1; #slow = 0; #fast = 0; #wait = FAST_FRAMES; #risen = false; #set = 1;

  /** For another person. */
  reset(person) {
    this.#share = this.#set = 1;
    this.#slow = this.#fast = 0;
    this.#wait = FAST_FRAMES;
    this.#risen = false;
    person.setDetail();
  }

  /** Share of the splats that a moving picture has. */
  get share() { return this.#share; }

  /** Before a picture is drawn. interval: ms since the last one of a motion; 0: a picture by itself, which gets all splats. */
  pace(person, interval) {
    if (interval > 0 && interval < STALL_MS) this.#learn(interval);
    const wanted = interval > 0 ? this.#share : 1;
    if (wanted === this.#set) return;
    this.#set = wanted;
    person.setDetail(wanted < 1 ? { splatBudget: Math.max(1, Math.round(wanted * person.splatCount)) } : undefined);
  }

  #learn(interval) {
    this.#slow = interval > TOO_SLOW_MS ? this.#slow + 1 : 0;
    this.#fast = interval < FAST_MS ? this.#fast + 1 : 0;
    if (this.#slow >= SLOW_FRAMES) {
      if (this.#risen) this.#wait = Math.min(MOST_FAST_FRAMES, 2 * this.#wait);
      this.#share = Math.max(LEAST_SHARE, this.#share * Math.max(0.6, TARGET_MS / interval));
      this.#slow = 0;
      this.#risen = false;
    } else if (this.#fast >= this.#wait && this.#share < 1) {
      this.#share = Math.min(1, RISE * this.#share);
      this.#fast = 0;
      this.#risen = true;
    }
  }
}
