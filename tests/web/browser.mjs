// SPDX-License-Identifier: Apache-2.0
// Opens a page of this folder in headless Chromium and waits for what it finds. WEB_MODULE: doppel.wasm. WEB_WORK: folder of person.glb and
// the kit, and for the browser's profile. WEB_CHROMIUM: the browser.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import crypto from 'node:crypto';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import { removeProfile } from './profile.mjs';

const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const { WEB_MODULE, WEB_WORK, WEB_CHROMIUM } = process.env;
const FOLDERS = { tests: path.join(root, 'tests/web'), platform: path.join(root, 'platform'), module: path.dirname(WEB_MODULE), work: WEB_WORK };
const TYPES = { '.html': 'text/html', '.mjs': 'text/javascript', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
const LIMIT_MS = Number(process.env.WEB_LIMIT_S ?? 600) * 1000;
// Without a GPU, Chromium draws WebGL with SwiftShader. gc: so that what is left of memory can be compared.
const FLAGS = ['--headless=new', '--no-sandbox', '--no-first-run', '--enable-logging=stderr', '--use-gl=angle', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--enable-precise-memory-info', '--js-flags=--expose-gc'];

const POLICY = "script-src 'self' 'wasm-unsafe-eval'";

/** An inline import map of a page, for its policy. */
function hashOfMap(file) {
  const map = file.endsWith('.html') && /<script type="importmap">(.*?)<\/script>/s.exec(fs.readFileSync(file, 'utf8'));
  return map ? ` 'sha256-${crypto.createHash('sha256').update(map[1]).digest('base64')}'` : '';
}

/** folders: more of them, by the name that addresses begin with. policy: of the pages. flags: more of them, of
 *  Chromium. {result, pictures, moduleRequests}: what the page
 *  posted to /found, and to /picture by name, and the requests for the module. */
export async function visit(page, folders = {}, policy = POLICY, flags = []) {
  const all = { ...FOLDERS, ...folders };
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
    const file = first === 'tests' ? path.join(all.tests, rest.slice(rest[0] === 'web' ? 1 : 0).join('/')) : path.join(all[first] ?? '/nowhere', rest.join('/'));
    if (file.endsWith('.wasm')) moduleRequests.push(at);
    if (!Object.values(all).some(folder => file.startsWith(folder + path.sep)) || !fs.existsSync(file)) return response.writeHead(404).end();
    response.writeHead(200, {
      'content-type': TYPES[path.extname(file)] ?? 'application/octet-stream', 'content-length': fs.statSync(file).size,
      'content-security-policy': policy === POLICY ? POLICY + hashOfMap(file) : policy,
    });
    fs.createReadStream(file).pipe(response);
  });
  await new Promise(ready => server.listen(0, '127.0.0.1', ready));
  const url = `http://127.0.0.1:${server.address().port}/tests/web/${page}`;
  const profile = fs.mkdtempSync(path.join(WEB_WORK, 'profile-'));
  const browser = spawn(WEB_CHROMIUM, [...FLAGS, ...flags, `--user-data-dir=${profile}`, url], { stdio: ['ignore', 'ignore', 'pipe'] });
  let log = '';
  browser.stderr.on('data', text => { log += text; });
  const ended = new Promise(done => browser.on('exit', code => done({ thrown: `the browser ended with ${code}` })));
  const late = new Promise(done => setTimeout(() => done({ thrown: 'no answer from the page in time' }), LIMIT_MS).unref());
  const result = await Promise.race([found, ended, late]);
  browser.kill();
  await ended;
  server.close();
  server.closeAllConnections?.();
  await removeProfile(profile);
  const console_ = log.split('\n').filter(line => line.includes('CONSOLE')).join('\n');
  assert.equal(result.thrown, undefined, `${result.thrown}\n${console_}`);
  return { result, pictures, moduleRequests };
}
