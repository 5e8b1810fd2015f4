// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: a live person among the splats of the viewer that the address names, by the adapters of platform/web, in the poses of
// /work/viewers/poses.json {time, shot, files}; and exported files of some of them, by viewer. Posts the pictures.
import { Doppel } from '../../platform/web/doppel.js';
import { pixelsOf, VIEWERS } from './viewers.mjs';

const post = (path, body) => fetch(path, { method: 'POST', body });
const pause = ms => new Promise(done => setTimeout(done, ms));
const SORT_MS = 400;  // viewers sort beside
const viewer = new URLSearchParams(location.search).get('viewer'), found = { viewer, tookMs: [] };

/** What is shown, once it is sorted. */
async function drawn(shown, shot, first) {
  if (first) {
    shown.draw(shot);
    await pause(1500);  // shaders are made
  }
  for (let i = 0; i < 2 && !shown.sortsAtOnce; ++i) {
    shown.draw(shot);
    await pause(SORT_MS);
  }
  return pixelsOf(shown.draw(shot));
}

try {
  const poses = await (await fetch('/work/viewers/poses.json')).json();
  const person = await Doppel.load('/work/person.glb', { module: '/module/doppel.wasm' });
  const live = await VIEWERS[viewer]({ person });
  for (const [i, { time, shot }] of poses.entries()) {
    person.setClip(0, time);
    const start = performance.now();
    person.writeSplats([{ property: 'position' }, { property: 'covariance', offset: 12 * person.splatCount }], { eye: shot.eye });
    found.tookMs.push(performance.now() - start);
    await post(`/picture/live-${i}.rgba`, await drawn(live, shot, i === 0));
  }
  live.end();
  for (const [i, { shot, files }] of poses.entries()) {
    const name = files?.[viewer];
    if (!name) continue;
    const shown = await VIEWERS[viewer]({ url: `/work/viewers/${name}`, name, kind: 'splats' });
    await post(`/picture/file-${i}.rgba`, await drawn(shown, shot, true));
    shown.end();
    document.querySelector('main').replaceChildren();
  }
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
