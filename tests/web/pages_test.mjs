// SPDX-License-Identifier: Apache-2.0
// node pages_test.mjs: pages that hold a person in themselves, opened from disk in headless Chromium. WEB_RUN: the output folder of a
// reconstruction whose scan is called WEB_SCAN_NAME and lies at WEB_SCAN. WEB_DOPPEL: the program. WEB_WORK: a folder. WEB_CHROMIUM.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { startChromium } from './chromium.mjs';

const { WEB_RUN, WEB_SCAN, WEB_SCAN_NAME, WEB_DOPPEL, WEB_WORK, WEB_CHROMIUM } = process.env;
const SHARE_LIMIT = 650000, REPORT_LIMIT = 700000;  // bytes beyond 4/3 of the avatar
const report = path.join(WEB_RUN, 'report.html'), shared = path.join(WEB_WORK, 'shared.html');
const avatarBytes = fs.statSync(path.join(WEB_RUN, 'avatar.glb')).size;
const blocks = /<script type="application\/octet-stream" id=(dpl-\w+)>([^<]*)<\/script>/g;

function doppel(...words) {
  const { status, stderr } = spawnSync(WEB_DOPPEL, words, { encoding: 'utf8' });
  return { status, stderr };
}
const SHARED = ['--name', 'Ada <i>the first</i>', '--licence', 'CC0-1.0'];
assert.deepEqual(doppel('share', WEB_RUN, '-o', shared, ...SHARED), { status: 0, stderr: '' });

// What is in the page of doppel share.
const text = fs.readFileSync(shared, 'utf8');
const beyond = text.length - avatarBytes * 4 / 3;
console.log(`shared page: ${Buffer.byteLength(text)} bytes, ${Math.round(beyond)} beyond 4/3 of the avatar (limit ${SHARE_LIMIT})`);
assert.ok(beyond <= SHARE_LIMIT);
assert.match(text, /<meta name="dcterms.license" content="CC0-1.0">/);
assert.match(text, /<title>Ada &lt;i&gt;the first&lt;\/i&gt;<\/title>/);
const inside = Object.fromEntries([...text.matchAll(blocks)].map(([, id, base64]) => [id, Buffer.from(base64, 'base64')]));
const runFacts = fs.readFileSync(path.join(WEB_RUN, 'report.json'), 'utf8');
const scanHash = /"scan": "[^"]*, ([^"]+)"/.exec(runFacts)?.[1];
assert.ok(scanHash?.length >= 8, 'report.json names the hash of the scan');
const secrets = [WEB_SCAN_NAME, scanHash, path.resolve(WEB_SCAN), path.resolve(WEB_RUN), 'masked PSNR'];
for (const [name, bytes] of Object.entries({ page: Buffer.from(text), ...inside }))
  for (const secret of secrets) assert.ok(!bytes.includes(secret), `${name} holds '${secret}'`);
assert.equal(text.match(/data:image/g).length, 1, 'one picture, which is drawn');

// What the report gained.
const html = fs.readFileSync(report, 'utf8');
const gained = [...html.matchAll(blocks)].reduce((sum, [whole]) => sum + whole.length, 0) + /<script type=module>[^]*?<\/script>/.exec(html)[0].length;
console.log(`report: ${Buffer.byteLength(html)} bytes; the living person takes ${gained}, ${Math.round(gained - avatarBytes * 4 / 3)} beyond the avatar (limit ${REPORT_LIMIT})`);
assert.ok(gained - avatarBytes * 4 / 3 <= REPORT_LIMIT);

const browser = await startChromium(WEB_CHROMIUM, WEB_WORK);
const PIXELS = `(() => {
  const { width, height, rgba } = document.querySelector('doppel-avatar').readPicture();
  const [whole, copy] = [[width, height], [90, 120]].map(([w, h]) => Object.assign(document.createElement('canvas'), { width: w, height: h }));
  whole.getContext('2d').putImageData(new ImageData(rgba, width, height), 0, 0);
  const context = copy.getContext('2d');
  context.drawImage(whole, 0, 0, 90, 120);
  return [...context.getImageData(0, 0, 90, 120).data];
})()`;
const differ = (a, b) => a.filter((value, i) => Math.abs(value - b[i]) > 40).length;
const seen = pixels => pixels.filter((value, i) => i % 4 === 3 && value > 200).length;

/** Zooms in as far as it goes: not nearer than the pictures of the scan show detail. */
async function staysFarEnough(page) {
  const { distance, nearest, before } = await page.eval(`(async () => {
    const avatar = document.querySelector('doppel-avatar'), { person } = avatar, look = person.lookAt.bind(person);
    let view = null;
    person.lookAt = (options, into) => {
      view = { eye: [...options.eye], target: [...options.target], height: options.height };
      return look(options, into);
    };
    const frame = () => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)));
    const far = () => Math.hypot(...view.eye.map((place, k) => place - view.target[k]));
    avatar.redraw();
    await frame();
    const before = far();
    for (let i = 0; i < 40; ++i) avatar.shadowRoot.querySelector('canvas').dispatchEvent(new WheelEvent('wheel', { deltaY: -400, cancelable: true }));
    await frame();
    const nearest = person.nearestDistance(view.target, view.eye, view.height / (2 * Math.tan(0.3)), 3);
    delete person.lookAt;
    return { distance: far(), nearest, before };
  })()`);
  assert.ok(nearest > 0, 'the avatar has a capture map');
  const least = Math.max(0.25 * before, Math.min(before, nearest));
  assert.ok(Math.abs(distance - least) < 0.01 * least, `${distance} m of ${before} m; ${nearest} m is the nearest that shows more`);
}

async function lives(file, name, width, height) {
  const started = performance.now();
  const page = await browser.open(pathToFileURL(file).href, { width, height });
  await page.until("document.querySelector('#person.alive, #person .said')");
  const ms = performance.now() - started;
  assert.equal(await page.eval("document.querySelector('#person .said')?.textContent ?? ''"), '');
  const first = await page.eval(PIXELS);
  assert.ok(seen(first) > 800, `${seen(first)} pixels of somebody`);
  await page.until(`document.querySelector('doppel-avatar').currentTime > 0.5`);
  assert.ok(differ(first, await page.eval(PIXELS)) > 300, 'the person moves');
  const clips = await page.eval("[...document.querySelectorAll('#person .moves button')].map(b => b.textContent)");
  assert.deepEqual(clips, ['As filmed', 'Walk', 'Stroll', 'Pause']);
  await page.eval("document.querySelectorAll('#person .moves button')[1].click()");
  await page.until("document.querySelector('doppel-avatar').currentTime > 0.3");
  assert.equal(await page.eval("document.querySelector('doppel-avatar').person.clips[+document.querySelector('doppel-avatar').getAttribute('clip')].name"), 'walk');
  await page.screenshot(path.join(WEB_WORK, `${name}-${width}.png`));
  assert.equal(await page.eval('document.scrollingElement.scrollWidth > innerWidth'), false, 'it scrolls sideways');
  assert.equal(await page.eval("getComputedStyle(document.querySelector('#person img')).visibility"), 'hidden');
  // Pause: the last pictures become sharper, and then the person stands.
  await page.eval("document.querySelector('#person .moves button:last-child').click()");
  assert.equal(await page.eval("document.querySelector('#person .moves button:last-child').textContent"), 'Play');
  let stands = false;
  for (let tries = 0, last = await page.eval(PIXELS); !stands && tries < 100; ++tries) {
    await page.eval('new Promise(next => setTimeout(next, 200))');
    const now = await page.eval(PIXELS);
    stands = differ(last, now) === 0;
    last = now;
  }
  assert.ok(stands, 'a paused person stands still');
  await staysFarEnough(page);
  const asked = page.requests.filter(url => !url.startsWith('data:') && !url.startsWith('blob:') && !url.startsWith('file:'));
  assert.deepEqual(asked, [], 'no network');
  assert.deepEqual(page.errors, []);
  console.log(`${name} at ${width} px: alive after ${ms.toFixed(0)} ms, by ${await page.eval("document.querySelector('doppel-avatar').drawnBy")}`);
  await page.close();
}

try {
  for (const [width, height] of [[1280, 800], [390, 844]]) {
    await lives(report, 'report', width, height);
    await lives(shared, 'shared', width, height);
  }

  // Scripts are off: the still picture is what the page holds.
  for (const file of [report, shared]) {
    const page = await browser.open(pathToFileURL(file).href, { width: 390, height: 844, scripts: false });
    await page.screenshot(path.join(WEB_WORK, `${path.basename(file, '.html')}-still.png`));
    await page.close();
    const still = fs.readFileSync(file, 'utf8');
    assert.match(still, /<figure id=person><div class=stage><img alt="[^"]+"/);
  }

  // A page that was damaged on its way keeps its picture and says so in a sentence.
  const broken = [['cut off', text.slice(0, text.indexOf('id=dpl-module') - 40) + text.slice(text.lastIndexOf('<script type=module>')), /cut off/],
    ['a damaged module', text.replace(/(id=dpl-module>.{4000}).{40}/, `$1${'A'.repeat(40)}`), /./],
    ['a damaged avatar', text.replace(/(id=dpl-avatar>.{400}).{400}/, `$1${'A'.repeat(400)}`), /./],
    ['no base64', text.replace(/id=dpl-avatar>.{9}/, 'id=dpl-avatar>*********'), /this page is damaged/]];
  for (const [what, source, sentence] of broken) {
    const file = path.join(WEB_WORK, 'broken.html');
    assert.notEqual(source, text, what);
    fs.writeFileSync(file, source);
    const page = await browser.open(pathToFileURL(file).href);
    await page.until("document.querySelector('#person .said')");
    const said = await page.eval("document.querySelector('#person .said').textContent");
    assert.match(said, /^The person cannot move here: ./, what);
    assert.match(said, sentence, what);
    assert.equal(await page.eval("getComputedStyle(document.querySelector('#person img')).visibility"), 'visible', what);
    assert.equal(await page.eval("document.querySelector('doppel-avatar')"), null, what);
    console.log(`${what}: "${said}"`);
    await page.close();
  }

  // Under the content policy that docs/guides/web.md states.
  const policy = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; img-src data:; connect-src blob:";
  assert.ok(fs.readFileSync(new URL('../../docs/guides/web.md', import.meta.url), 'utf8').includes(policy.replace("default-src 'none'; ", '')));
  const guarded = path.join(WEB_WORK, 'guarded.html');
  fs.writeFileSync(guarded, text.replace('<meta charset=utf-8>', `<meta charset=utf-8><meta http-equiv="Content-Security-Policy" content="${policy}">`));
  await lives(guarded, 'guarded', 390, 844);

  // The slider between picture and avatar, from the images of the gallery.
  const page = await browser.open(pathToFileURL(report).href, { width: 390, height: 844 });
  const at = "document.querySelector('.compare .layers').style.getPropertyValue('--at')";
  assert.equal(await page.eval(at), '50%');
  await page.eval("(s => { s.value = 20; s.dispatchEvent(new Event('input')); })(document.querySelector('.compare input'))");
  assert.equal(await page.eval(at), '20%');
  await page.eval("document.querySelector('.compare').scrollIntoView()");
  await page.screenshot(path.join(WEB_WORK, 'compare-390.png'));
  const difference = "document.querySelector('.compare .difference')";
  assert.equal(await page.eval(`${difference}.hidden`), true);
  await page.eval("[...document.querySelectorAll('.compare button')].find(b => b.textContent === 'Difference').click()");
  assert.equal(await page.eval(`${difference}.hidden || !${difference}.naturalWidth`), false);
  const covered = "[...document.querySelectorAll('.layers .under, .layers .over, .layers .line')].every(e => getComputedStyle(e).display === 'none')";
  assert.ok(await page.eval(covered), 'nothing lies over the difference');
  await page.screenshot(path.join(WEB_WORK, 'difference-390.png'));
  const before = await page.eval(`${difference}.src`);
  await page.eval("document.querySelector('.compare button[aria-label=\"The next picture\"]').click()");
  assert.notEqual(await page.eval(`${difference}.src`), before);
  await page.close();
} finally {
  await browser.close();
}
console.log(`pictures of the pages: ${WEB_WORK}`);
