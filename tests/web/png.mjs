// SPDX-License-Identifier: Apache-2.0
// PNG files of 8-bit RGBA, as the conformance kit has them.
import zlib from 'node:zlib';

export function png(rgba, width, height) {
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type, 'latin1'), data]), out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 6, 0, 0, 0], 8);
  const rows = Buffer.alloc(height * (1 + width * 4));
  for (let y = 0; y < height; ++y) rows.set(rgba.subarray(y * width * 4, (y + 1) * width * 4), y * (1 + width * 4) + 1);
  return Buffer.concat([Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]), chunk('IHDR', head), chunk('IDAT', zlib.deflateSync(rows)), chunk('IEND', Buffer.alloc(0))]);
}

const table = Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n >>> 0;
});
function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = table[(crc ^ byte) & 255] ^ (crc >>> 8);
  return ~crc >>> 0;
}

/** {width, height, rgba} of a file that this project wrote: 8 bits a channel, 3 or 4 channels, not interlaced. */
export function readPng(file) {
  const parts = [];
  let width = 0, height = 0, channels = 0;
  for (let at = 8; at < file.length; at += 12 + file.readUInt32BE(at)) {
    const type = file.toString('latin1', at + 4, at + 8), data = file.subarray(at + 8, at + 8 + file.readUInt32BE(at));
    if (type === 'IDAT') parts.push(data);
    if (type !== 'IHDR') continue;
    width = data.readUInt32BE(0), height = data.readUInt32BE(4), channels = { 2: 3, 6: 4 }[data[9]];
    if (data[8] !== 8 || !channels || data[12] !== 0) throw new Error('not the kind of PNG that this project writes');
  }
  const rows = zlib.inflateSync(Buffer.concat(parts)), stride = width * channels, rgba = Buffer.alloc(width * height * 4, 255);
  let above = new Uint8Array(stride);
  for (let y = 0; y < height; ++y) {
    const filter = rows[y * (stride + 1)], row = rows.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1));
    for (let i = 0; i < stride; ++i) {
      const left = i < channels ? 0 : row[i - channels], up = above[i], corner = i < channels ? 0 : above[i - channels];
      const guess = left + up - corner, dl = Math.abs(guess - left), du = Math.abs(guess - up), dc = Math.abs(guess - corner);
      row[i] += [0, left, up, (left + up) >> 1, dl <= du && dl <= dc ? left : du <= dc ? up : corner][filter];
    }
    for (let x = 0; x < width; ++x) for (let c = 0; c < channels; ++c) rgba[4 * (y * width + x) + c] = row[x * channels + c];
    above = row;
  }
  return { width, height, rgba };
}
