// SPDX-License-Identifier: Apache-2.0
// What the passes tell each other of half-chunks (kSplatGroup neighbouring splats) and of their splats.
// `visibility`: a flag each whether it lives, the live ones in order, which splats each has; then the sort depth of every splat.
uint dplFirstLive(uint groups) { return groups; }
uint dplFirstRange(uint groups) { return 2u * groups; }
uint dplFirstDepth(uint groups) { return 3u * groups; }  // float bits, of the splats of live ones; kUnseenDepth: no view shows it
// `survivors`: kMaskWords each, which splats some view shows; then how many before it, and the total.
uint dplFirstSum(uint groups) { return kMaskWords * groups; }

// Which splats a half-chunk has: the number of its first, and how many behind.
uint dplRange(uint first, uint count) { return first | count << kSortIndexBits; }
uint dplRangeFirst(uint range) { return range & ((1u << kSortIndexBits) - 1u); }
uint dplRangeCount(uint range) { return range >> kSortIndexBits; }
