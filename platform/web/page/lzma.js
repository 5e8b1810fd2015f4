// SPDX-License-Identifier: Apache-2.0
// Unpacks a .lzma file (LZMA1 with its 13-byte header, as `xz --format=lzma` writes it). Pages that hold the module in themselves need it:
// gzip, which browsers unpack themselves, takes a third more (docs/adr/0087).

const TOP = 1 << 24, HALF = 1024;  // range below which the coder takes another byte; a probability of one half, of 2048
const MOST_BYTES = 64 * 1024 * 1024;
const LITERAL_STATES = 7;          // states below it follow a literal

const damaged = () => new Error('the packed module in this page is damaged; make the page again');

/** The unpacked bytes. packed: a whole .lzma file. Throws an Error where it is damaged or larger than 64 MB. */
export function unlzma(packed) {
  if (packed.length < 18 || packed[0] >= 9 * 5 * 5) throw damaged();
  const lc = packed[0] % 9, lp = Math.floor(packed[0] / 9) % 5, pb = Math.floor(packed[0] / 45);
  const header = new DataView(packed.buffer, packed.byteOffset, 13);
  const low = header.getUint32(5, true), high = header.getUint32(9, true);
  const stated = low === 0xffffffff && high === 0xffffffff ? Infinity : high * 2 ** 32 + low;
  if (stated !== Infinity && stated > MOST_BYTES) throw damaged();
  let out = new Uint8Array(stated === Infinity ? 4 * packed.length : stated), size = 0;
  let at = 18, range = 0xffffffff, code = 0;
  for (let i = 14; i < 18; ++i) code = (code << 8 | packed[i]) >>> 0;

  const probabilities = count => new Uint16Array(count).fill(HALF);
  const posMask = (1 << pb) - 1, literalPosMask = (1 << lp) - 1;
  const literals = probabilities(0x300 << lc + lp);
  const isMatch = probabilities(12 << 4), isRep = probabilities(12), isRep0 = probabilities(12), isRep1 = probabilities(12);
  const isRep2 = probabilities(12), isRep0Long = probabilities(12 << 4);
  const slots = probabilities(4 << 6), special = probabilities(128), alignment = probabilities(16);
  const lengthCoder = () => ({ choice: probabilities(2), low: probabilities(16 << 3), mid: probabilities(16 << 3), high: probabilities(256) });
  const matchLength = lengthCoder(), repLength = lengthCoder();

  const normalize = () => {
    if (range >>> 0 >= TOP) return;
    if (at >= packed.length) throw damaged();
    range = range << 8 >>> 0;
    code = (code << 8 | packed[at++]) >>> 0;
  };
  const bit = (table, i) => {
    const bound = (range >>> 11) * table[i] >>> 0;
    let value = 0;
    if (code < bound) {
      range = bound;
      table[i] += 2048 - table[i] >> 5;
    } else {
      range = range - bound >>> 0;
      code = code - bound >>> 0;
      table[i] -= table[i] >> 5;
      value = 1;
    }
    normalize();
    return value;
  };
  const tree = (table, from, bits) => {
    let node = 1;
    for (let i = 0; i < bits; ++i) node = node << 1 | bit(table, from + node);
    return node - (1 << bits);
  };
  const reverseTree = (table, from, bits) => {
    let node = 1, value = 0;
    for (let i = 0; i < bits; ++i) {
      const b = bit(table, from + node);
      node = node << 1 | b;
      value |= b << i;
    }
    return value;
  };
  const direct = bits => {
    let value = 0;
    for (let i = 0; i < bits; ++i) {
      range >>>= 1;
      const one = code >= range ? 1 : 0;
      if (one) code = code - range >>> 0;
      normalize();
      value = value << 1 | one;
    }
    return value >>> 0;
  };
  const lengthOf = (coder, posState) => {
    if (!bit(coder.choice, 0)) return 2 + tree(coder.low, posState << 3, 3);
    if (!bit(coder.choice, 1)) return 10 + tree(coder.mid, posState << 3, 3);
    return 18 + tree(coder.high, 0, 8);
  };
  const room = bytes => {
    if (size + bytes <= out.length) return;
    if (stated !== Infinity || size + bytes > MOST_BYTES) throw damaged();
    const larger = new Uint8Array(Math.min(MOST_BYTES, Math.max(2 * out.length, size + bytes)));
    larger.set(out);
    out = larger;
  };
  const copy = (distance, length) => {
    if (distance >= size) throw damaged();
    room(length);
    for (let i = 0; i < length; ++i, ++size) out[size] = out[size - distance - 1];
  };

  let state = 0, rep0 = 0, rep1 = 0, rep2 = 0, rep3 = 0;
  while (size < stated) {
    const posState = size & posMask, matchAt = (state << 4) + posState;
    if (!bit(isMatch, matchAt)) {
      const before = size ? out[size - 1] : 0;
      const from = 0x300 * (((size & literalPosMask) << lc) + (before >> 8 - lc));
      let symbol = 1;
      if (state >= LITERAL_STATES) {
        if (rep0 >= size) throw damaged();
        let expected = out[size - rep0 - 1];
        while (symbol < 0x100) {
          const expectedBit = expected >> 7 & 1, got = bit(literals, from + (1 + expectedBit << 8) + symbol);
          expected <<= 1;
          symbol = symbol << 1 | got;
          if (got !== expectedBit) break;
        }
      }
      while (symbol < 0x100) symbol = symbol << 1 | bit(literals, from + symbol);
      room(1);
      out[size++] = symbol;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    if (!bit(isRep, state)) {
      rep3 = rep2, rep2 = rep1, rep1 = rep0;
      const length = lengthOf(matchLength, posState);
      state = state < LITERAL_STATES ? 7 : 10;
      const slot = tree(slots, Math.min(length - 2, 3) << 6, 6);
      rep0 = slot;
      if (slot >= 4) {
        const bits = (slot >> 1) - 1, base = (2 | slot & 1) * 2 ** bits;
        if (slot < 14) rep0 = base + reverseTree(special, base - slot, bits);
        else rep0 = base + direct(bits - 4) * 16 + reverseTree(alignment, 0, 4);
      }
      if (rep0 === 0xffffffff) {  // the end marker
        if (stated !== Infinity) throw damaged();
        return out.subarray(0, size);
      }
      copy(rep0, length);
      continue;
    }
    if (!bit(isRep0, state)) {
      if (!bit(isRep0Long, matchAt)) {
        state = state < LITERAL_STATES ? 9 : 11;
        copy(rep0, 1);
        continue;
      }
    } else {
      let distance = rep1;
      if (bit(isRep1, state)) {
        distance = rep2;
        if (bit(isRep2, state)) {
          distance = rep3;
          rep3 = rep2;
        }
        rep2 = rep1;
      }
      rep1 = rep0;
      rep0 = distance;
    }
    const length = lengthOf(repLength, posState);
    state = state < LITERAL_STATES ? 8 : 11;
    copy(rep0, length);
  }
  return out;
}
