// SPDX-License-Identifier: Apache-2.0
// How pictures of other people's viewers differ from those of the referee.
import fs from 'node:fs';
import { HEIGHT, WIDTH } from './viewers_shots.mjs';

const PATCH = 16;

/** The referee's picture, premultiplied, over white. */
export function reference(file) {
  const rgba = fs.readFileSync(file), out = new Uint8Array(rgba.length).fill(255);
  const covered = new Uint8Array(WIDTH * HEIGHT);
  for (let p = 0; p < covered.length; ++p) {
    covered[p] = rgba[4 * p + 3] > 0;
    for (let c = 0; c < 3; ++c) out[4 * p + c] = Math.min(255, rgba[4 * p + c] + 255 - rgba[4 * p + 3]);
  }
  return { rgba: out, covered };
}

export const isDrawn = (rgba, p) => Math.min(rgba[4 * p], rgba[4 * p + 1], rgba[4 * p + 2]) < 250;

/** Sums of squares: of all pixels, of covered ones; the patch with the largest mean difference, levels. */
export function differences(rgba, { rgba: expected, covered }) {
  let all = 0, inside = 0, insideCount = 0, patch = 0;
  for (let y0 = 0; y0 + PATCH <= HEIGHT; y0 += PATCH)
    for (let x0 = 0; x0 + PATCH <= WIDTH; x0 += PATCH) {
      let sum = 0;
      for (let y = y0; y < y0 + PATCH; ++y)
        for (let x = x0; x < x0 + PATCH; ++x) {
          const p = y * WIDTH + x;
          let square = 0;
          for (let c = 0; c < 3; ++c) square += (rgba[4 * p + c] - expected[4 * p + c]) ** 2, sum += Math.abs(rgba[4 * p + c] - expected[4 * p + c]);
          all += square;
          if (covered[p] || isDrawn(rgba, p)) inside += square, ++insideCount;
        }
      patch = Math.max(patch, sum / (3 * PATCH * PATCH));
    }
  return { all, inside, insideCount, patch };
}

/** What a picture differs from that of an expression and from that of the face at rest, where these two differ: sums of squares, and values
 *  over three channels. */
export function whereItMoves(rgba, { rgba: expressed }, { rgba: rest }) {
  const STILL = 8;  // levels
  let toExpressed = 0, toRest = 0, pixels = 0;
  for (let p = 0; p < WIDTH * HEIGHT; ++p) {
    if ([0, 1, 2].every(c => Math.abs(expressed[4 * p + c] - rest[4 * p + c]) <= STILL)) continue;
    ++pixels;
    for (let c = 0; c < 3; ++c) toExpressed += (rgba[4 * p + c] - expressed[4 * p + c]) ** 2, toRest += (rgba[4 * p + c] - rest[4 * p + c]) ** 2;
  }
  return { toExpressed, toRest, pixels };
}

export const decibels = (sum, pixels) => 10 * Math.log10(255 * 255 * 3 * pixels / Math.max(sum, 1e-9));
