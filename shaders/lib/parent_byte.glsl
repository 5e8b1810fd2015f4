// SPDX-License-Identifier: Apache-2.0
// Which entry of its chunk's table of parents a splat sits on. The includer declares the codes by DPL_WORDS `codes` and the push constants as CodesPush `push`.
uint dplParentByte(uint splat) { return (DPL_WORD(codes, push.firstParentByte + (splat >> 2u)) >> ((splat & 3u) * 8u)) & 0xFFu; }
