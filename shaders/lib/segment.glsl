// SPDX-License-Identifier: Apache-2.0
// The spans of a row of tiles have kTileSegments segments: equal parts, in order. The includer declares `sums` by DPL_WORDS and the
// push constants as TilePush `push`.
uint dplSegment(uint row, uint segment, out uint end) {
    uint first = DPL_WORD(sums, push.firstSpanSum + row * kRowScanGroup), last = DPL_WORD(sums, push.firstSpanSum + (row + 1u) * kRowScanGroup);
    uint share = (last - first + kTileSegments - 1u) / kTileSegments, begin = first + segment * share;
    end = min(begin + share, last);
    return begin;
}
