// SPDX-License-Identifier: Apache-2.0
// Gives the entries of a workgroup's lanes their places in lists, in the order of the lanes. The ends of the lists stay in shared memory,
// because a GPU waits hundreds of cycles for a count in a buffer. A lane joins the lists of its entry; after a barrier it finds its places;
// after another it leaves, and may at once join those of its next entry. The includer defines DPL_LISTS, the most lists.
shared uint dplEnds[DPL_LISTS];     // where the next entry of a list goes
shared uint dplJoining[DPL_LISTS];  // one bit for each lane

/** All lanes must call it, and a barrier must follow. */
void dplStartList(uint list, uint begin) {
    dplEnds[list] = begin;
    dplJoining[list] = 0u;
}
uint dplLaneBit() { return 1u << gl_LocalInvocationIndex; }
void dplJoin(uint list) { atomicOr(dplJoining[list], dplLaneBit()); }
uint dplPlaceIn(uint list) { return dplEnds[list] + uint(bitCount(dplJoining[list] & (dplLaneBit() - 1u))); }
void dplLeave(uint list) {
    atomicAdd(dplEnds[list], 1u);
    atomicAnd(dplJoining[list], ~dplLaneBit());
}
