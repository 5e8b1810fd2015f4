// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: opens each file of /work/viewers/files.json in the viewer that the address names, draws it from the cameras of
// viewers_shots.mjs over white, with expressions where it finds some, and posts the pictures. What a viewer cannot open is an answer too.
import { KINDS, pixelsOf, VIEWERS } from './viewers.mjs';
import { FACES, NEAR, shotsOf } from './viewers_shots.mjs';

const post = (path, body) => fetch(path, { method: 'POST', body });
const pause = ms => new Promise(done => setTimeout(done, ms));
const LONGEST_LOAD_MS = 40000, LONGEST_SORT_MS = 60000;

/** The pictures of one file, or why there are none. */
async function show(viewer, file) {
  try {
    const late = new Promise((_, fail) => setTimeout(() => fail(new Error('it did not finish loading')), LONGEST_LOAD_MS));
    const shown = await Promise.race([VIEWERS[viewer](file), late]);
    await drawAll(viewer, file, shown);
    shown.end();
    return {};
  } catch (error) {
    return { cannot: String(error?.message ?? error).slice(0, 200) };
  } finally {
    document.querySelector('main').replaceChildren();
  }
}

async function drawAll(viewer, file, shown) {
  shown.draw(shotsOf(viewer)[0]);
  await pause(1500);  // shaders and textures are made
  for (const shot of shotsOf(viewer)) {
    const late = performance.now() + LONGEST_SORT_MS;
    shown.draw(shot);
    do await pause(400);  // splats are sorted meanwhile
    while (shown.isSorting?.() && performance.now() < late);
    await post(`/picture/${file.label}-${shot.name}.rgba`, pixelsOf(shown.draw(shot)));
  }
  for (const face of shown.express ? FACES : []) {
    if (!shown.express(face)) break;  // the file has none
    await post(`/picture/${file.label}-face-${face.name}.rgba`, pixelsOf(shown.draw(NEAR)));
  }
}

const viewer = new URLSearchParams(location.search).get('viewer'), found = { viewer, files: {} };
try {
  const files = await (await fetch('/work/viewers/files.json')).json();
  for (const file of files.filter(({ kind }) => KINDS[viewer].includes(kind))) found.files[file.label] = await show(viewer, file);
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
