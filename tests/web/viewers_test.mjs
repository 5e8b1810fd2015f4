// SPDX-License-Identifier: Apache-2.0
// node viewers_test.mjs [--json FILE]: what `doppel export` wrote, in other people's viewers, against dplRender. WEB_WORK/viewers holds
// files.json ({label, name, url, kind}) and the pictures of the referee; WEB_VIEWERS: JSON of {viewer: {version, folders of visit()}},
// or with `folder` in their place, that of blender_draw.py. Pictures go to
// WEB_WORK/viewers/VIEWER, figures to FILE, a JSON object a line. The rest: browser.mjs.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { visit } from './browser.mjs';
import { png } from './png.mjs';
import { decibels, differences, isDrawn, reference, whereItMoves } from './viewers_compare.mjs';
import { FACES, HEIGHT, POLICY, SHOTS, shotsOf, WIDTH } from './viewers_shots.mjs';

const LEAST_SEEN = 0.5;  // of the height: less is a person who hangs below the floor, head down
const work = path.join(process.env.WEB_WORK, 'viewers');
const { values: options } = parseArgs({ options: { json: { type: 'string' } } });
const files = JSON.parse(fs.readFileSync(path.join(work, 'files.json')));

function heightOf(isSet) {
  let first = -1, last = -1;
  for (let y = 0; y < HEIGHT; ++y)
    for (let x = 0; x < WIDTH; ++x)
      if (isSet(y * WIDTH + x)) {
        if (first < 0) first = y;
        last = y;
        break;
      }
  return first < 0 ? 0 : last - first + 1;
}

/** "upright", or how the picture is turned, by the turn that suits best. */
function standing(rgba, expected) {
  const turned = { upright: (x, y) => y * WIDTH + x, 'upside down': (x, y) => (HEIGHT - 1 - y) * WIDTH + (WIDTH - 1 - x),
    mirrored: (x, y) => y * WIDTH + (WIDTH - 1 - x), 'mirrored upside down': (x, y) => (HEIGHT - 1 - y) * WIDTH + x };
  let best = ['', Infinity];
  for (const [name, at] of Object.entries(turned)) {
    let sum = 0;
    for (let y = 0; y < HEIGHT; ++y)
      for (let x = 0; x < WIDTH; ++x) for (let c = 0; c < 3; ++c) sum += (rgba[4 * at(x, y) + c] - expected.rgba[4 * (y * WIDTH + x) + c]) ** 2;
    if (sum < best[1]) best = [name, sum];
  }
  return best[0];
}

const references = Object.fromEntries(SHOTS.map(shot => [shot.name, reference(path.join(work, `${shot.name}.rgba`))]));

/** The row of a file in a viewer. Of a VRM only how it stands: it has another pose. */
function score({ label, kind }, viewer, pictures) {
  const shots = shotsOf(viewer), count = shots.length - 1;
  const sides = { all: 0, inside: 0, insideCount: 0, patch: 0 };
  let near;
  for (const shot of shots) {
    const found = differences(pictures.get(`${label}-${shot.name}`), references[shot.name]);
    if (shot.name === 'near') near = found;
    else sides.all += found.all, sides.inside += found.inside, sides.insideCount += found.insideCount, sides.patch = Math.max(sides.patch, found.patch);
  }
  const front = pictures.get(`${label}-side-0`), expected = references['side-0'];
  const height = heightOf(p => isDrawn(front, p)) / heightOf(p => isDrawn(expected.rgba, p));
  const measured = kind !== 'vrm' && {
    sides: count, sides_db: decibels(sides.all, count * WIDTH * HEIGHT), sides_covered_db: decibels(sides.inside, sides.insideCount), sides_patch: sides.patch,
    near_db: decibels(near.all, WIDTH * HEIGHT), near_covered_db: decibels(near.inside, near.insideCount), near_patch: near.patch,
  };
  return {
    stands: height < LEAST_SEEN ? 'out of sight' : standing(front, expected), height,
    ...measured,
  };
}

/** Of each expression that the viewer showed: dB where it moves the face, against that expression and against the face at rest. */
function scoreFaces(label, pictures) {
  const shown = FACES.filter(({ name }) => pictures.has(`${label}-face-${name}`));
  return shown.map(({ name }) => {
    const file = path.join(work, `face-${name}.rgba`), { toExpressed, toRest, pixels } = whereItMoves(pictures.get(`${label}-face-${name}`), reference(file), references.near);
    return { name, pixels, db: decibels(toExpressed, pixels), rest_db: decibels(toRest, pixels) };
  });
}

/** The line of a traceback of Python that says what went wrong. */
const lastError = text => text.split('\n').filter(line => /^\w*Error: (?!Python: Traceback)/.test(line)).at(-1) ?? text.replaceAll(/\s+/g, ' ');

/** What blender_draw.py left, as visit() tells it. */
function ofBlender(folder) {
  const found = {}, pictures = new Map();
  for (const { label } of files.filter(({ kind }) => kind === 'mesh')) {
    const why = path.join(folder, `${label}.txt`);
    found[label] = fs.existsSync(why) ? { cannot: lastError(fs.readFileSync(why, 'utf8')).slice(0, 200) } : {};
    for (const { name } of found[label].cannot ? [] : SHOTS) pictures.set(`${label}-${name}`, fs.readFileSync(path.join(folder, `${label}-${name}.rgba`)));
  }
  return { result: { files: found }, pictures };
}

const rows = [];
for (const [viewer, { version, folders, folder }] of Object.entries(JSON.parse(process.env.WEB_VIEWERS))) {
  const { result, pictures } = folder ? ofBlender(folder) : await visit(`viewers.html?viewer=${viewer}`, folders, POLICY);
  fs.mkdirSync(path.join(work, viewer), { recursive: true });
  for (const { label, kind } of files.filter(file => result.files[file.label])) {  // others are not for this viewer
    const { cannot } = result.files[label];
    const row = { row: 'viewer', viewer, version, file: label, kind, ...(cannot ? { cannot } : score({ label, kind }, viewer, pictures)) };
    const faces = cannot ? [] : scoreFaces(label, pictures);
    if (faces.length) row.faces = faces;
    for (const { name } of faces) fs.writeFileSync(path.join(work, viewer, `${label}-face-${name}.png`), png(pictures.get(`${label}-face-${name}`), WIDTH, HEIGHT));
    for (const shot of cannot ? [] : shotsOf(viewer))
      fs.writeFileSync(path.join(work, viewer, `${label}-${shot.name}.png`), png(pictures.get(`${label}-${shot.name}`), WIDTH, HEIGHT));
    rows.push(row);
    const measured = cannot || kind === 'vrm' ? '' : `, ${row.sides} sides ${row.sides_db.toFixed(1)} dB (covered ${row.sides_covered_db.toFixed(1)}, patch ` +
      `${row.sides_patch.toFixed(1)}), near ${row.near_db.toFixed(1)} dB (${row.near_covered_db.toFixed(1)}, ${row.near_patch.toFixed(1)})`;
    const shows = cannot ? `cannot: ${cannot}` : `${row.stands}, ${(100 * row.height).toFixed(1)} % of the height`;
    const moved = faces.map(({ name, db, rest_db }) => `, ${name} ${db.toFixed(1)} dB (the face at rest: ${rest_db.toFixed(1)})`).join('');
    console.log(`${viewer} ${version}: ${label}: ${shows}${measured}${moved}`);
  }
}
for (const shot of SHOTS) fs.writeFileSync(path.join(work, `${shot.name}.png`), png(references[shot.name].rgba, WIDTH, HEIGHT));
if (options.json) fs.writeFileSync(options.json, rows.map(row => `${JSON.stringify(row)}\n`).join(''));

for (const { name } of FACES)
  if (fs.existsSync(path.join(work, `face-${name}.rgba`))) fs.writeFileSync(path.join(work, `face-${name}.png`), png(reference(path.join(work, `face-${name}.rgba`)).rgba, WIDTH, HEIGHT));
// A face that a viewer moves is nearer to that expression than to the face at rest.
for (const { viewer, file, faces } of rows)
  for (const { name, db, rest_db } of faces ?? []) assert.ok(db > rest_db, `${viewer} shows ${name} of ${file} at ${db} dB, the face at rest has ${rest_db}`);
// What the guide promises of each file must hold: somebody shows it, upright and of the right size.
for (const { label, kind } of files) {
  const shown = rows.filter(row => row.file === label && !row.cannot);
  assert.ok(shown.length > 0, `no viewer shows ${label}`);
  assert.ok(shown.some(row => row.stands === 'upright'), `${label} stands in no viewer`);
  for (const row of shown.filter(({ stands }) => stands === 'upright')) assert.ok(Math.abs(row.height - 1) < 0.02, `${row.viewer} shows ${label} at ${row.height} of its height`);
}
