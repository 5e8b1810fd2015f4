// SPDX-License-Identifier: Apache-2.0
// Cameras from which other viewers draw exported files: eight sides, and the face from 0.7 m; expressions of that face; and poses that they
// draw live.
import { expressionOf } from './shots.mjs';

export const WIDTH = 480, HEIGHT = 640;

/** Of the pages: the viewers make code and workers of texts. */
export const POLICY = "script-src * 'unsafe-inline' 'unsafe-eval' data: blob:; worker-src * data: blob:";

const side = i => [3 * Math.sin(i * Math.PI / 4), 1, 3 * Math.cos(i * Math.PI / 4)];
export const SHOTS = [
  ...Array.from({ length: 8 }, (_, i) => ({ name: `side-${i}`, eye: side(i), target: [0, 0.9, 0], fovY: 0.7 })),
  { name: 'near', eye: [0.12, 1.6, 0.7], target: [0, 1.55, 0], fovY: 0.6 },
];

/** The shots of a viewer. Two take some twenty seconds a picture where SwiftShader stands in for a GPU. */
const SLOW = ['three-splats', 'spark'], FEW = ['side-0', 'side-3', 'near'];
export const shotsOf = viewer => SHOTS.filter(({ name }) => !SLOW.includes(viewer) || FEW.includes(name));

/** A line of the referee's input: the avatar at rest. */
export const line = (shot, weights) => [-1, 0, ...shot.eye, ...shot.target, shot.fovY, WIDTH, HEIGHT, expressionOf(weights), `${shot.name}.rgba`].join(' ');

/** Expressions by ARKit's names, and what shows the same in a VRM. */
const both = (name, weight) => ({ [`${name}Left`]: weight, [`${name}Right`]: weight });
export const FACES = [
  { name: 'jaw', weights: { jawOpen: 1 }, vrm: { jawOpen: 1 } },
  { name: 'blink', weights: both('eyeBlink', 1), vrm: { blink: 1 } },
  { name: 'smile', weights: { ...both('mouthSmile', 0.8), ...both('cheekSquint', 0.5), ...both('eyeSquint', 0.3) }, vrm: { happy: 1 } },
];
export const NEAR = SHOTS.find(({ name }) => name === 'near');

/** Poses of the first clip, from two sides in turn. Each fifth has files: these are exported five a second. */
const POSES = 30, POSES_A_SECOND = 25, A_FILE = 5;
export const FILES_A_SECOND = POSES_A_SECOND / A_FILE;
export const posesWith = filesOf => Array.from({ length: POSES }, (_, i) =>
  ({ time: i / POSES_A_SECOND, shot: SHOTS[[0, 3][i % 2]], files: i % A_FILE ? undefined : filesOf(String(i / A_FILE).padStart(5, '0')) }));
export const poseLine = ({ time, shot }, i) => [0, time, ...shot.eye, ...shot.target, shot.fovY, WIDTH, HEIGHT, expressionOf(), `pose-${i}.rgba`].join(' ');
