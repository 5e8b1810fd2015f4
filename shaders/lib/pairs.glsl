// SPDX-License-Identifier: Apache-2.0
// Names what the uvec2s of the lists hold.
SortPair dplSortPair(uvec2 pair) { return SortPair(pair.x, pair.y); }
TileSpan dplTileSpan(uvec2 pair) { return TileSpan(pair.x, pair.y); }

uint dplFirstColumn(uint columns) { return columns & 0xFFFFu; }  // of TileSpan.columns
uint dplLastColumn(uint columns) { return columns >> 16u; }
