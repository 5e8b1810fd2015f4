// SPDX-License-Identifier: Apache-2.0
// Pictures of the sample person that the module and the referee (referee.cpp) both draw, and how they are compared.
export const SHOTS = [
  { name: 'rest', clip: -1, time: 0, eye: [0, 1, 3.2], target: [0, 0.9, 0], fovY: 0.7, width: 240, height: 400 },
  { name: 'walk', clip: 0, time: 0.4, eye: [1.4, 1.2, 2.6], target: [0, 0.9, 0], fovY: 0.7, width: 320, height: 480 },
  { name: 'walk-late', clip: 0, time: 1.9, eye: [-2.4, 1.5, -1.6], target: [0, 0.9, 0], fovY: 0.7, width: 320, height: 480 },
  { name: 'moves', clip: 1, time: 2.5, eye: [0.3, 1.4, 3], target: [0, 1, 0], fovY: 0.75, width: 301, height: 477 },
  { name: 'face', clip: 0, time: 0.4, eye: [0.1, 1.6, 0.8], target: [0, 1.5, 0], fovY: 0.6, width: 400, height: 400 },
  { name: 'smile', clip: 0, time: 0.4, eye: [0.1, 1.6, 0.8], target: [0, 1.5, 0], fovY: 0.6, width: 400, height: 400,
    expression: { mouthSmileLeft: 0.9, mouthSmileRight: 0.8, eyeBlinkLeft: 1, jawOpen: 0.4 } },
  { name: 'far', clip: 0, time: 1, eye: [4, 2, 9], target: [0, 0.9, 0], fovY: 0.7, width: 320, height: 240 },
];

/** Weights by ARKit's names, as a field of the referee's input. */
export const expressionOf = (weights = {}) => Object.entries(weights).map(weight => weight.join('=')).join(',') || '-';

/** A line of the referee's input. */
export const line = (shot, file) => [shot.clip, shot.time, ...shot.eye, ...shot.target, shot.fovY, shot.width, shot.height,
  expressionOf(shot.expression), file].join(' ');

/** Poses a Doppel as a shot has it. */
export function poseAs(person, shot) {
  if (shot.clip >= 0) person.setClip(shot.clip, shot.time);
  else person.setPose(person.joints.flatMap(() => [0, 0, 0, 1]));
  person.setExpression(shot.expression ?? {});
}

/** {db, levels, covered}: PSNR over all channels, Infinity for equal bytes; the largest difference; pixels where the first picture is not empty. */
export function compare(a, b) {
  if (a.length !== b.length) throw new Error(`pictures of ${a.length} and ${b.length} bytes`);
  let sum = 0, levels = 0, covered = 0;
  for (let i = 0; i < a.length; ++i) {
    const d = Math.abs(a[i] - b[i]);
    sum += d * d;
    if (d > levels) levels = d;
    if (i % 4 === 3 && a[i] > 0) ++covered;
  }
  return { db: sum ? 10 * Math.log10(255 * 255 * a.length / sum) : Infinity, levels, covered };
}
