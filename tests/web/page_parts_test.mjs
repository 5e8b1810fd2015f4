// SPDX-License-Identifier: Apache-2.0
// node --test: parts of pages that need no browser: labels, and the unpacker against what xz packs. WEB_MODULE:
// doppel.wasm; its packed twin lies in page/ beside it.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { labelOf } from '../../platform/web/page/label.js';
import { unlzma } from '../../platform/web/page/lzma.js';

const packedModule = fs.readFileSync(path.join(path.dirname(process.env.WEB_MODULE), 'page/doppel.wasm.lzma'));
const pack = (bytes, options) => {
  const { status, stdout } = spawnSync('xz', ['--format=lzma', `--lzma1=${options}`, '--stdout'], { input: bytes, maxBuffer: 1 << 28 });
  assert.equal(status, 0);
  return stdout;
};
const same = (a, b) => Buffer.compare(Buffer.from(a), Buffer.from(b)) === 0;

test('the module comes out as it went in', t => {
  const started = performance.now();
  assert.ok(same(unlzma(packedModule), fs.readFileSync(process.env.WEB_MODULE)));
  t.diagnostic(`${packedModule.length} bytes unpacked in ${(performance.now() - started).toFixed(0)} ms`);
});

test('every property, short texts, long runs and noise', () => {
  let seed = 7;
  const random = () => (seed = (seed * 1103515245 + 12345) >>> 0) >>> 16;
  const texts = [Buffer.alloc(0), Buffer.from('a'), Buffer.alloc(70000, 'ab'), Buffer.from(Array.from({ length: 50000 }, () => random() & 255)),
    Buffer.from(Array.from({ length: 60000 }, () => 'abcdefgh'[random() % 8] + 'x'.repeat(random() % 3)).join(''))];
  for (const text of texts)
    for (const options of ['lc=3,lp=0,pb=2', 'lc=0,lp=0,pb=0', 'lc=4,lp=0,pb=4', 'lc=0,lp=4,pb=1', 'lc=1,lp=2,pb=3', 'dict=4KiB'])
      assert.ok(same(unlzma(pack(text, options)), text), `${text.length} bytes, ${options}`);
});

test('a size that the header states', () => {
  const text = Buffer.from('somebody walks, somebody walks');
  const packed = pack(text, 'preset=6');
  packed.writeBigUInt64LE(BigInt(text.length), 5);
  assert.ok(same(unlzma(packed), text));
  packed.writeBigUInt64LE(BigInt(text.length + 1), 5);
  assert.throws(() => unlzma(packed), /damaged/);
  packed.writeBigUInt64LE(1n << 40n, 5);
  assert.throws(() => unlzma(packed), /damaged/);
});

test('every truncation and many changed bytes end, in bytes or in an error', () => {
  const text = Buffer.from('the person in this page '.repeat(40) + Array.from({ length: 300 }, (_, i) => i * i % 97).join(' '));
  const packed = pack(text, 'preset=6');
  for (let length = 0; length < packed.length; ++length) assert.throws(() => unlzma(packed.subarray(0, length)), /damaged/, `${length} bytes`);
  for (let i = 0; i < packed.length; ++i) {
    const changed = Buffer.from(packed);
    changed[i] ^= 1 << i % 8;
    try {
      assert.ok(unlzma(changed).length < 1 << 26);
    } catch (error) {
      assert.match(error.message, /damaged/);
    }
  }
});

test('a label is the name of the clip as text, whatever it spells', () => {
  assert.equal(labelOf('scan-motion'), 'As filmed');
  for (const name of ['constructor', '__proto__', '<img src=x>', '']) assert.equal(labelOf(name), name);
  assert.equal(labelOf('x'.repeat(1000)).length, 24);
});
