// SPDX-License-Identifier: Apache-2.0
// Range of cells that one lane adds up: each workgroup handles one row of a table, and its lanes share the row. The includer declares
// counts and the push constants as RowScanPush `push`.
uint dplRowShare(out uint end) {
    uint lane = gl_LocalInvocationIndex, count = push.perRow != 0u ? push.perRow : counts.runs, first = push.firstTable + gl_WorkGroupID.x * count;
    uint share = (count + kRowScanGroup - 1u) / kRowScanGroup;
    end = first + min((lane + 1u) * share, count);
    return first + min(lane * share, count);
}
