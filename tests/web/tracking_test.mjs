// SPDX-License-Identifier: Apache-2.0
// node --test: a person who follows landmarks of MediaPipe Pose, in Node. WEB_MODULE: doppel.wasm. WEB_PERSON: a sample person.
// WEB_REFEREE_PROGRAM: web_referee, which does the same by the native library.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import { test } from 'node:test';
import { Doppel, DoppelError } from '../../platform/web/doppel.js';

const wasm = await WebAssembly.compile(fs.readFileSync(process.env.WEB_MODULE));
const load = () => Doppel.load(fs.readFileSync(process.env.WEB_PERSON), { module: wasm });
const fails = (what, pattern) => assert.throws(what, error => {
  assert.ok(error instanceof DoppelError, String(error));
  assert.equal(error.code, 'DPL_ERROR_INVALID_ARGUMENT', error.message);
  assert.match(error.message, pattern);
  return true;
});
const STEP_MS = 33;

function placesOf(person) {
  const at = person.jointPositions();
  return bone => {
    const joint = person.joints.findIndex(j => j.bone === bone);
    assert.ok(joint >= 0, bone);
    return [0, 1, 2].map(k => at[3 * joint + k]);
  };
}

/** What MediaPipe would see of a person: y down, z away from the camera, from between the hips. */
function landmarksOf(person) {
  const place = placesOf(person), middle = place('hips'), head = place('head');
  const face = [[0, 0.1], [0.02, 0.1], [0.03, 0.1], [0.04, 0.09], [-0.02, 0.1], [-0.03, 0.1], [-0.04, 0.09], [0.07, 0], [-0.07, 0],
    [0.02, 0.1], [-0.02, 0.1]].map(([x, z]) => [head[0] + x, head[1] + 0.08, head[2] + z]);
  const limbs = ['UpperArm', 'LowerArm', 'Hand', 'Hand', 'Hand', 'Hand', 'UpperLeg', 'LowerLeg', 'Foot', 'Foot', 'Toes']
    .flatMap(bone => [place(`left${bone}`), place(`right${bone}`)]);
  return [...face, ...limbs].map(p => ({ x: p[0] - middle[0], y: middle[1] - p[1], z: middle[2] - p[2], visibility: 1 }));
}

/** A walk as a camera sees it: {landmarks, timeMs} of each frame. */
async function walk(frames) {
  const seen = await load();
  return Array.from({ length: frames }, (_, i) => {
    seen.setClip('walk', i * STEP_MS / 1000);
    return { landmarks: landmarksOf(seen), timeMs: STEP_MS * (i + 1) };
  });
}

/** {state, drivenJoints, positions} that the native library shows for lines of its protocol (referee.cpp). */
function referee(lines) {
  const out = execFileSync(process.env.WEB_REFEREE_PROGRAM, [process.env.WEB_PERSON, '--track'], { input: lines.join('\n') + '\n', encoding: 'utf8' });
  return out.trim().split('\n').map(line => {
    const [state, drivenJoints, ...positions] = line.split(' ').map(Number);
    return { state: ['waiting', 'tracking', 'lost'][state], drivenJoints, positions };
  });
}
const seenLine = ({ landmarks, timeMs }) => `seen ${timeMs} ${[...landmarks.flatMap(({ x, y, z }) => [x, y, z]), ...landmarks.map(l => l.visibility)]
  .map(v => Number.isFinite(v) ? v : 'nan').join(' ')}`;

/** Gives the same to the module and to the native library, and compares what they show after each step. Returns the largest distance, m. */
async function compareWithNative(steps) {
  const person = await load();
  person.startTracking({ inPlace: true });
  const lines = [], shown = [];
  for (const step of steps) {
    if (step.landmarks) {
      person.track(step.landmarks, step.timeMs);
      lines.push(seenLine(step));
    }
    const { state, drivenJoints } = person.setPoseFromTracker(step.showMs ?? step.timeMs);
    lines.push(`show ${step.showMs ?? step.timeMs}`);
    shown.push({ state, drivenJoints, positions: person.jointPositions() });
  }
  let largest = 0;
  for (const [i, native] of referee(lines).entries()) {
    assert.equal(shown[i].state, native.state, `step ${i}`);
    assert.equal(shown[i].drivenJoints, native.drivenJoints, `step ${i}`);
    assert.equal(shown[i].positions.length, native.positions.length);
    native.positions.forEach((value, k) => { largest = Math.max(largest, Math.abs(value - shown[i].positions[k])); });
  }
  return { largest, shown };
}

test('a walk before the camera becomes the pose of the native library', async t => {
  const { largest, shown } = await compareWithNative(await walk(60));
  t.diagnostic(`60 frames, ${shown.at(-1).drivenJoints} joints: at most ${largest} m`);
  assert.equal(shown.at(-1).state, 'tracking');
  assert.ok(largest < 1e-5, `${largest} m`);
});

test('the person follows: hands and knees come nearer to those who are seen', async () => {
  const [seen, follower] = await Promise.all([load(), load()]);
  const relative = person => {
    const place = placesOf(person), hips = place('hips');
    return ['leftHand', 'rightHand', 'leftLowerLeg', 'rightLowerLeg'].map(bone => place(bone).map((v, k) => v - hips[k]));
  };
  const far = (a, b) => a.reduce((sum, p, i) => sum + Math.hypot(...p.map((v, k) => v - b[i][k])), 0) / a.length;
  follower.startTracking({ inPlace: true });
  const rest = relative(follower);
  assert.deepEqual(follower.setPoseFromTracker(0), { state: 'waiting', drivenJoints: 0, rateHz: 0, delay: 0 });
  seen.setClip('walk', 0.4);
  let status;
  for (let i = 1; i <= 30; ++i) {  // each picture: a joint that has begun to be seen is faded in, within 0.25 s
    follower.track(landmarksOf(seen), STEP_MS * i);
    status = follower.setPoseFromTracker(STEP_MS * i);
  }
  assert.equal(status.state, 'tracking');
  assert.ok(Math.abs(status.rateHz - 1000 / STEP_MS) < 1 && status.drivenJoints > 8, JSON.stringify(status));
  const before = far(rest, relative(seen)), after = far(relative(follower), relative(seen));
  assert.ok(before > 0.1 && after < 0.4 * before, `hands and knees were ${before.toFixed(3)} m off, now ${after.toFixed(3)}`);
  assert.equal(follower.setPoseFromTracker(STEP_MS * 30 + 5000).state, 'lost');
  follower.startTracking();
  assert.equal(follower.setPoseFromTracker(STEP_MS * 31).state, 'waiting');
});

test('over a pose: what is not seen follows the clip', async () => {
  const person = await load(), leg = () => placesOf(person)('leftFoot');
  const [{ landmarks, timeMs }] = await walk(1);
  person.startTracking({ inPlace: true, overPose: true });
  person.track(landmarks.map((l, i) => ({ ...l, visibility: i < 23 ? 1 : 0 })), timeMs);  // someone at a desk
  const feet = [0, 0.4].map(time => {
    person.setClip('walk', time);
    person.setPoseFromTracker(timeMs);
    return leg();
  });
  assert.ok(Math.hypot(...feet[0].map((v, k) => v - feet[1][k])) > 0.1, JSON.stringify(feet));
});

test('hostile landmarks and times do to the pose what they do natively', async () => {
  const frames = await walk(20), damaged = structuredClone(frames);
  damaged[8].landmarks = damaged[8].landmarks.map(() => ({ x: NaN, y: Infinity, z: -Infinity, visibility: NaN }));
  damaged[9].landmarks[13].x = NaN;            // one elbow
  damaged[10].landmarks[15].visibility = 0.1;  // a hand that is hidden
  damaged[12].landmarks[0] = { x: 1e30, y: -1e30, z: 1e30, visibility: 2 };
  const steps = [...damaged, { ...frames[3], showMs: STEP_MS * 21 }, { ...frames[4], timeMs: STEP_MS * 20, showMs: STEP_MS * 22 },
    { landmarks: frames[5].landmarks, timeMs: -90000, showMs: -90000 }, { showMs: 9e12 }];
  const { largest, shown } = await compareWithNative(steps);
  assert.ok(largest < 1e-5, `${largest} m`);
  assert.ok(shown.every(step => step.positions.every(Number.isFinite)));
});

test('wrong calls are errors, and the person lives', async () => {
  const person = await load(), [{ landmarks }] = await walk(1);
  fails(() => person.track(landmarks, 0), /startTracking/);
  fails(() => person.setPoseFromTracker(0), /startTracking/);
  person.startTracking();
  fails(() => person.track(landmarks.slice(1), 0), /32 landmarks/);
  fails(() => person.track([], 0), /0 landmarks/);
  fails(() => person.track(null, 0), /no landmarks/);
  for (const time of [NaN, Infinity, 1e13, 'now', undefined]) {
    fails(() => person.track(landmarks, time), /must be a finite number/);
    fails(() => person.setPoseFromTracker(time), /must be a finite number/);
  }
  person.track(new Array(33), 0);
  person.track(landmarks, 100);
  assert.equal(person.setPoseFromTracker(100).state, 'tracking');
  person.dispose();
  fails(() => person.track(landmarks, 200), /disposed/);
  fails(() => person.startTracking(), /disposed/);
});
