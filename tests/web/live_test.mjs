// SPDX-License-Identifier: Apache-2.0
// node live_test.mjs [--json FILE]: a live person among the splats of other people's viewers, pose by pose against dplRender, beside exported
// files of some of them. WEB_WORK/viewers holds poses.json and the referee's pictures pose-N.rgba; WEB_VIEWERS as in viewers_test.mjs.
// Pictures go to WEB_WORK/viewers/VIEWER/live-N.png, figures to FILE, a JSON object a line. The rest: browser.mjs.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { parseArgs } from 'node:util';
import { visit } from './browser.mjs';
import { png } from './png.mjs';
import { decibels, differences, reference } from './viewers_compare.mjs';
import { HEIGHT, POLICY, WIDTH } from './viewers_shots.mjs';

const MOST_BELOW_DB = 0.5;  // a live pose below its file
const work = path.join(process.env.WEB_WORK, 'viewers');
const { values: options } = parseArgs({ options: { json: { type: 'string' } } });
const poses = JSON.parse(fs.readFileSync(path.join(work, 'poses.json')));
const references = poses.map((_, i) => reference(path.join(work, `pose-${i}.rgba`)));
const mean = numbers => numbers.reduce((sum, number) => sum + number, 0) / numbers.length;
const rows = [];
for (const [viewer, { version, folders }] of Object.entries(JSON.parse(process.env.WEB_VIEWERS))) {
  const { result, pictures } = await visit(`live.html?viewer=${viewer}`, folders, POLICY);
  const folder = path.join(work, viewer);
  fs.mkdirSync(folder, { recursive: true });
  const scoreOf = (kind, i) => {
    const rgba = pictures.get(`${kind}-${i}`);
    fs.writeFileSync(path.join(folder, `${kind}-${i}.png`), png(rgba, WIDTH, HEIGHT));
    return decibels(differences(rgba, references[i]).all, WIDTH * HEIGHT);
  };
  const live = poses.map((_, i) => scoreOf('live', i)), withFile = [...poses.keys()].filter(i => poses[i].files), file = withFile.map(i => scoreOf('file', i));
  const below = withFile.map((i, k) => file[k] - live[i]);
  const took = [...result.tookMs].sort((a, b) => a - b)[poses.length >> 1];
  const row = { row: 'live', viewer, version, poses: poses.length, live_db: mean(live), least_live_db: Math.min(...live), files: file.length,
    files_live_db: mean(withFile.map(i => live[i])), file_db: mean(file), worst_below_db: Math.max(...below), write_ms: took };
  rows.push(row);
  console.log(`${viewer} ${version}: ${poses.length} poses: live ${row.live_db.toFixed(1)} dB, at least ${row.least_live_db.toFixed(1)}; ${file.length} of them ` +
    `${row.files_live_db.toFixed(1)}, their files ${row.file_db.toFixed(1)}, the worst ${row.worst_below_db.toFixed(2)} dB below its file; ${took.toFixed(1)} ms to write the splats`);
}
for (const [i, { rgba }] of references.entries()) fs.writeFileSync(path.join(work, `pose-${i}.png`), png(rgba, WIDTH, HEIGHT));
if (options.json) fs.writeFileSync(options.json, rows.map(row => `${JSON.stringify(row)}\n`).join(''));
for (const row of rows) assert.ok(row.worst_below_db <= MOST_BELOW_DB, `${row.viewer}: a live pose is ${row.worst_below_db} dB below its file`);
