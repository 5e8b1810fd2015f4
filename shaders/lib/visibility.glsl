// SPDX-License-Identifier: Apache-2.0
// Layout of the buffers by which passes share the state of groups (kSplatGroup neighbouring splats) and of their splats.
// `visibility`: for each group a flag (1: live), the list of live groups, the range of splats of each group; then the
// sort depth of every splat.
uint dplFirstLive(uint groups) { return groups; }
uint dplFirstRange(uint groups) { return 2u * groups; }
// float bits, written for splats of live groups only; kUnseenDepth: no view shows the splat
uint dplFirstDepth(uint groups) { return 3u * groups; }
// `survivors`: for each group kMaskWords of bits, set where some view shows the splat; then the number of survivors before each group,
// and the total.
uint dplFirstSum(uint groups) { return kMaskWords * groups; }

// The splats of a group in one word: number of the first, and the count in the upper bits.
uint dplRange(uint first, uint count) { return first | count << kSortIndexBits; }
uint dplRangeFirst(uint range) { return range & ((1u << kSortIndexBits) - 1u); }
uint dplRangeCount(uint range) { return range >> kSortIndexBits; }
