// SPDX-License-Identifier: Apache-2.0
// Runs in the browser: draws SHOTS and tries <doppel-avatar>, and sends what it found to the server of browser_test.mjs.
import { Doppel } from '../../platform/web/doppel.js';
import '../../platform/web/doppel-avatar.js';
import { SHOTS, poseAs } from './shots.mjs';

const MODULE = '/module/doppel.wasm', PERSON = '/work/person.glb';
const LIMIT_MS = 600000;
const post = (path, body) => fetch(path, { method: 'POST', body });
const found = {};

const happens = (target, type) => new Promise((done, fail) => {
  target.addEventListener(type, event => done(event.detail), { once: true });
  setTimeout(() => fail(new Error(`no event ${type}`)), LIMIT_MS);
});
const becomes = async (what, ready) => {
  const end = performance.now() + LIMIT_MS;
  while (!ready()) {
    if (performance.now() > end) throw new Error(`never: ${what}`);
    await new Promise(requestAnimationFrame);
  }
};
function element(attributes) {
  const made = document.createElement('doppel-avatar');
  for (const [name, value] of Object.entries({ module: MODULE, ...attributes })) made.setAttribute(name, value);
  document.querySelector('main').append(made);
  return made;
}
const canvasOf = made => made.shadowRoot.querySelector('canvas');
const pixels = made => made.readPicture()?.rgba ?? [];
const opaque = data => data.filter((value, i) => i % 4 === 3 && value > 200).length;
const differ = (a, b) => a.length !== b.length || a.some((value, i) => Math.abs(value - b[i]) > 40);

async function pictures() {
  const started = performance.now();
  const person = await Doppel.load(PERSON, { module: MODULE });
  found.loadMs = performance.now() - started;
  for (const shot of SHOTS) {
    poseAs(person, shot);
    await post(`/picture/${shot.name}.rgba`, person.draw(person.lookAt(shot)));
  }
  const times = [], camera = person.lookAt({ ...SHOTS[0], width: 480, height: 640 });
  for (let i = 0; i < 20; ++i) {
    const t = performance.now();
    person.setClip(0, i / 30);
    person.draw(camera);
    times.push(performance.now() - t);
  }
  found.frameMs = times.sort((a, b) => a - b)[10];
  person.dispose();
}

async function theElement() {
  const shown = element({ src: PERSON, autoplay: '', 'camera-controls': '', alt: 'a person' });
  const steps = [];
  for (const type of ['progress', 'load', 'first-picture']) shown.addEventListener(type, () => { if (!steps.includes(type)) steps.push(type); });
  await happens(shown, 'first-picture');
  found.events = steps;
  found.opaque = opaque(pixels(shown));
  found.drawnBy = shown.drawnBy;
  found.size = [canvasOf(shown).width, canvasOf(shown).height];
  await post('/picture/element.rgba', pixels(shown));
  found.label = canvasOf(shown).getAttribute('aria-label');
  const time = shown.currentTime;
  await becomes('time goes on', () => shown.currentTime > time + 0.2);
  shown.pause();
  shown.currentTime = 0.5;
  await becomes('a whole picture that stands', () => canvasOf(shown).width === Math.round(300 * Math.min(2, devicePixelRatio)));
  const before = pixels(shown);
  canvasOf(shown).dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true }));
  await becomes('a turned picture', () => differ(before, pixels(shown)));
  const turned = pixels(shown), at = (type, x, id = 1) => canvasOf(shown).dispatchEvent(new PointerEvent(type, { pointerId: id, clientX: x, clientY: 50 }));
  canvasOf(shown).setPointerCapture = () => {};  // the browser knows no such pointer
  at('pointerdown', 50);
  at('pointermove', 120);
  at('pointerup', 120);
  await becomes('a dragged picture', () => differ(turned, pixels(shown)));
  const whole = opaque(pixels(shown));
  canvasOf(shown).dispatchEvent(new WheelEvent('wheel', { deltaY: -300, cancelable: true }));
  await becomes('a nearer picture', () => opaque(pixels(shown)) > 1.3 * whole);
  shown.style.width = '200px';
  await becomes('a narrower picture', () => canvasOf(shown).width === Math.round(200 * Math.min(2, devicePixelRatio)));
  shown.remove();
  found.disposed = shown.person === null;
  document.querySelector('main').append(shown);
  await happens(shown, 'first-picture');
  shown.remove();
}

/** The clip that raises both arms, in a square: whether any part of the person leaves the picture. */
async function whole() {
  const shown = element({ src: PERSON, clip: 'moves' });
  await happens(shown, 'first-picture');
  const { duration } = shown.person.clips.find(({ name }) => name === 'moves');
  found.atBorder = 0;
  found.highest = Infinity;
  for (let i = 0; i < 15; ++i) {
    shown.currentTime = duration * (i + 0.5) / 15;
    await new Promise(requestAnimationFrame).then(() => new Promise(requestAnimationFrame));
    const { width, height, rgba } = shown.readPicture(), alpha = (x, y) => rgba[4 * (y * width + x) + 3];
    const first = Array.from({ length: height }, (_, y) => y).find(y => Array.from({ length: width }, (_, x) => alpha(x, y)).some(a => a > 100));
    found.highest = Math.min(found.highest, first / height);
    for (let x = 0; x < width; ++x) found.atBorder += (alpha(x, 0) > 0) + (alpha(x, height - 1) > 0);
    for (let y = 0; y < height; ++y) found.atBorder += (alpha(0, y) > 0) + (alpha(width - 1, y) > 0);
  }
  shown.remove();
}

/** How long after the page was asked for the element shows somebody: an avatar of 1.5 MB. */
async function first() {
  const shown = element({ src: '/work/person-small.glb' });
  await happens(shown, 'first-picture');
  found.firstMs = performance.now();
  found.renderer = shown.drawnBy;
  shown.remove();
}

/** What visitors and pages do beside turning: two fingers, a wish for less motion, scrolling away, another tab, contents of their own. */
async function visitors() {
  const shown = element({ src: PERSON, 'camera-controls': '' });
  await happens(shown, 'first-picture');
  const before = opaque(pixels(shown));
  canvasOf(shown).setPointerCapture = () => {};
  const finger = (type, x, id) => canvasOf(shown).dispatchEvent(new PointerEvent(type, { pointerId: id, clientX: x, clientY: 50 }));
  finger('pointerdown', 100, 1);
  finger('pointerdown', 140, 2);
  finger('pointermove', 160, 2);
  finger('pointerup', 160, 2);
  finger('pointercancel', 100, 1);
  await becomes('two fingers that part bring the person nearer', () => opaque(pixels(shown)) > 1.3 * before);

  const goesOn = async () => {
    const time = shown.currentTime;
    await becomes('the clip goes on', () => shown.currentTime > time + 0.1);
  };
  const stops = async () => {
    let time = NaN, still = 0;
    await becomes('the clip stops', () => {
      still = shown.currentTime === time ? still + 1 : 0;
      time = shown.currentTime;
      return still > 20;
    });
  };
  shown.play();
  await goesOn();
  document.querySelector('main').style.paddingTop = '10000px';
  await stops();
  document.querySelector('main').style.paddingTop = '';
  await goesOn();
  Object.defineProperty(document, 'hidden', { value: true, configurable: true });
  document.dispatchEvent(new Event('visibilitychange'));
  await stops();
  delete document.hidden;
  document.dispatchEvent(new Event('visibilitychange'));
  await goesOn();
  shown.remove();

  await without(globalThis, 'matchMedia', () => () => ({ matches: true }), async () => {
    const calm = element({ src: PERSON, autoplay: '' });
    await happens(calm, 'first-picture');
    found.calm = calm.paused && calm.currentTime === 0;
    calm.remove();
  });

  const slotted = element({ src: PERSON }), own = document.createElement('p');
  own.slot = 'poster';
  own.textContent = 'somebody comes';
  slotted.append(own);
  const seen = () => own.checkVisibility();
  found.slot = { before: seen() };
  await happens(slotted, 'first-picture');
  found.slot.after = seen();
  slotted.remove();
}

/** On a screen of three pixels a CSS pixel, of which two are drawn; by the CPU, too. */
async function dense() {
  found.density = devicePixelRatio;
  found.dense = {};
  for (const renderer of ['webgl', 'cpu']) {
    const shown = element({ src: PERSON, ...(renderer === 'cpu' && { renderer }) });
    await happens(shown, 'first-picture');
    const { width, height } = shown.readPicture(), { clientWidth, clientHeight } = shown, seen = canvasOf(shown).getBoundingClientRect();
    found.dense[renderer] = { width, height, clientWidth, clientHeight, shownWidth: seen.width, shownHeight: seen.height, opaque: opaque(pixels(shown)) };
    if (renderer === 'webgl') await post('/picture/dense.rgba', pixels(shown));
    shown.remove();
  }
}

async function failures() {
  const gone = element({ src: '/work/none.glb', poster: '/poster.svg' });
  found.missing = await happens(gone, 'error');
  const poster = gone.shadowRoot.querySelector('img');
  found.poster = !poster.hidden && canvasOf(gone).style.visibility === 'hidden';
  gone.setAttribute('src', `http://localhost:${location.port}${PERSON}`);  // the same server by another name, which allows no other page
  found.cors = await happens(gone, 'error');
  gone.setAttribute('src', '/tests/page.html');
  found.foreign = await happens(gone, 'error');
  gone.setAttribute('src', PERSON);
  gone.setAttribute('clip', '<img src=x onerror=alert(1)>');
  found.clip = await happens(gone, 'error');
  gone.setAttribute('clip', '1');
  gone.setAttribute('src', `${PERSON}?again`);
  await happens(gone, 'first-picture');
  const removed = element({ src: PERSON });
  let said = false;
  for (const type of ['load', 'error']) removed.addEventListener(type, () => { said = true; });
  removed.remove();
  await fetch(PERSON).then(response => response.arrayBuffer());
  found.silentAfterRemoval = !said && removed.person === null;
  found.tags = [...new Set([...gone.shadowRoot.querySelectorAll('*')].map(node => node.localName))].sort();
  gone.remove();
}

/** Runs `body` while `object[name]` is replaced. */
async function without(object, name, replacement, body) {
  const before = object[name];
  object[name] = replacement(before);
  try {
    await body();
  } finally {
    object[name] = before;
  }
}

/** Elements whose browser refuses something, or takes the graphics device away. */
async function fallbacks() {
  const drawn = async attributes => {
    const made = element({ src: PERSON, ...attributes });
    const { renderer } = await happens(made, 'first-picture'), seen = opaque(pixels(made));
    made.remove();
    return { renderer, seen };
  };
  const noWebGL2 = get => function(kind, ...rest) { return kind === 'webgl2' ? null : get.call(this, kind, ...rest); };
  found.wanted = await drawn({ renderer: 'cpu' });
  await without(HTMLCanvasElement.prototype, 'getContext', noWebGL2, async () => { found.absent = await drawn({}); });
  await without(WebGL2RenderingContext.prototype, 'linkProgram', () => () => {}, async () => { found.shadersRefused = await drawn({}); });
  const noCanvas = () => () => null;
  await without(HTMLCanvasElement.prototype, 'getContext', noCanvas, async () => {
    const made = element({ src: PERSON, poster: '/poster.svg' });
    found.nothing = await happens(made, 'error');
    found.posterThen = !made.shadowRoot.querySelector('img').hidden;
    made.remove();
  });
  const taken = element({ src: PERSON });
  await happens(taken, 'first-picture');
  const device = canvasOf(taken).getContext('webgl2').getExtension('WEBGL_lose_context'), before = pixels(taken);
  device.loseContext();
  await happens(taken, 'device-lost');
  found.hidden = canvasOf(taken).style.visibility === 'hidden';
  await new Promise(done => setTimeout(done));  // while the event is told, the browser gives nothing back
  device.restoreContext();
  await happens(taken, 'device-restored');
  await becomes('the picture comes back', () => opaque(pixels(taken)) > 500);
  found.back = taken.drawnBy === found.drawnBy && !differ(before, pixels(taken)) && canvasOf(taken).style.visibility === '';
  canvasOf(taken).getContext('webgl2').getExtension('WEBGL_lose_context').loseContext();
  found.instead = await happens(taken, 'first-picture');
  taken.remove();
}

async function several() {
  const all = Array.from({ length: 3 }, (_, i) => element({ src: PERSON, clip: String(i % 2) }));
  await Promise.all(all.map(one => happens(one, 'first-picture')));
  found.several = all.every(one => opaque(pixels(one)) > 500);
  for (const one of all) one.remove();
}

const ALL = [pictures, theElement, visitors, whole, failures, several, fallbacks], ALONE = { '?dense': dense, '?first': first };
try {
  for (const part of location.search ? [ALONE[location.search]] : ALL) await part();
} catch (error) {
  found.thrown = `${error.message}\n${error.stack}`;
}
await post('/found', JSON.stringify(found));
