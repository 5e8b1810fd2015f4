// SPDX-License-Identifier: Apache-2.0
// Index of a splat's triangle in the table of parents of its chunk. The includer declares `codes` by DPL_WORDS and the push constants
// as CodesPush `push`.
uint dplParentByte(uint splat) { return (DPL_WORD(codes, push.firstParentByte + (splat >> 2u)) >> ((splat & 3u) * 8u)) & 0xFFu; }
