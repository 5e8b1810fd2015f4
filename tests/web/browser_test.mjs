// SPDX-License-Identifier: Apache-2.0
// node browser_test.mjs: page.mjs in headless Chromium, served with a strict script-src. WEB_MODULE, WEB_REFEREE: as in module_test.mjs.
// WEB_WORK: folder of person.glb, and for the browser's profile. WEB_CHROMIUM: the browser.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { SHOTS, compare } from './shots.mjs';

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const { WEB_MODULE, WEB_REFEREE, WEB_WORK, WEB_CHROMIUM } = process.env;
const FOLDERS = { tests: path.join(root, 'tests/web'), platform: path.join(root, 'platform'), module: path.dirname(WEB_MODULE), work: WEB_WORK };
const TYPES = { '.html': 'text/html', '.mjs': 'text/javascript', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
const LIMIT_MS = 600000;

const pictures = new Map(), moduleRequests = [];
let foundAll;
const found = new Promise(done => { foundAll = done; });
const server = http.createServer(async (request, response) => {
  const at = decodeURIComponent(new URL(request.url, 'http://server').pathname);
  if (request.method === 'POST') {
    const parts = [];
    for await (const part of request) parts.push(part);
    response.end();
    if (at === '/found') foundAll(JSON.parse(Buffer.concat(parts)));
    else pictures.set(path.basename(at, '.rgba'), Buffer.concat(parts));
    return;
  }
  // The pages name the repository's layout: /tests/web/page.html, /platform/web/doppel.js.
  const [, first, ...rest] = at.split('/');
  const file = first === 'tests' ? path.join(FOLDERS.tests, rest.slice(rest[0] === 'web' ? 1 : 0).join('/')) : path.join(FOLDERS[first] ?? '/nowhere', rest.join('/'));
  if (file.endsWith('.wasm')) moduleRequests.push(at);
  if (!Object.values(FOLDERS).some(folder => file.startsWith(folder + path.sep)) || !fs.existsSync(file)) return response.writeHead(404).end();
  response.writeHead(200, {
    'content-type': TYPES[path.extname(file)] ?? 'application/octet-stream', 'content-length': fs.statSync(file).size,
    'content-security-policy': "script-src 'self' 'wasm-unsafe-eval'",
  });
  fs.createReadStream(file).pipe(response);
});
await new Promise(ready => server.listen(0, '127.0.0.1', ready));
const url = `http://127.0.0.1:${server.address().port}/tests/web/page.html`;
const profile = fs.mkdtempSync(path.join(WEB_WORK, 'profile-'));
const browser = spawn(WEB_CHROMIUM, ['--headless=new', '--no-sandbox', '--disable-gpu', '--no-first-run', '--enable-logging=stderr', `--user-data-dir=${profile}`, url], { stdio: ['ignore', 'ignore', 'pipe'] });
let log = '';
browser.stderr.on('data', text => { log += text; });
const ended = new Promise(done => browser.on('exit', code => done({ thrown: `the browser ended with ${code}` })));
const late = new Promise(done => setTimeout(() => done({ thrown: 'no answer from the page within ten minutes' }), LIMIT_MS).unref());
const result = await Promise.race([found, ended, late]);
browser.kill();
await ended;
server.close();
server.closeAllConnections?.();
fs.rmSync(profile, { recursive: true, force: true, maxRetries: 5 });
const console_ = log.split('\n').filter(line => line.includes('CONSOLE')).join('\n');
assert.equal(result.thrown, undefined, `${result.thrown}\n${console_}`);
fs.writeFileSync(path.join(WEB_WORK, 'element.png'), pictures.get('element.png'));
for (const shot of SHOTS) {
  const { db, levels, covered } = compare(pictures.get(shot.name), fs.readFileSync(path.join(WEB_REFEREE, `${shot.name}.rgba`)));
  console.log(`${shot.name}: ${db === Infinity ? 'equal bytes' : `${db.toFixed(1)} dB, at most ${levels} levels`}`);
  assert.ok(covered > 500 && db >= 80 && levels <= 1, shot.name);
}
assert.deepEqual(result.events, ['progress', 'load', 'first-picture']);
assert.ok(result.opaque > 2000, `${result.opaque} opaque pixels`);
assert.equal(result.label, 'a person');
assert.ok(result.disposed && result.poster && result.silentAfterRemoval && result.several, JSON.stringify(result));
assert.match(result.missing.message, /none\.glb: the server answers 404/);
assert.equal(result.missing.code, 'NETWORK');
assert.equal(result.foreign.code, 'DPL_ERROR_UNSUPPORTED', result.foreign.message);
assert.match(result.clip.message, /there is no clip '<img/);
assert.deepEqual(result.tags, ['canvas', 'img', 'slot', 'style']);
assert.equal(moduleRequests.length, 1, 'all people of a page share one module');
console.log(`the element's first picture: ${path.join(WEB_WORK, 'element.png')}`);
console.log(`load ${result.loadMs.toFixed(0)} ms, 480 × 640 by the CPU ${result.frameMs.toFixed(1)} ms a frame`);
