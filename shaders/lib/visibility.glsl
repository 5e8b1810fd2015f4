// What the passes tell each other of half-chunks (kSplatGroup neighbouring splats), in one buffer. The includer declares it as `uint visibility[]`.
uint dplFirstLive(uint groups) { return groups; }            // behind a flag each: the numbers of the live ones, in order
uint dplFirstMask(uint groups) { return 2u * groups; }       // kMaskWords each: which splats some view shows
uint dplFirstSplat(uint groups) { return 6u * groups; }      // number of its first
uint dplFirstSum(uint groups) { return 7u * groups; }        // how many show, then how many before it; the total behind them
uint dplFirstDepth(uint groups) { return 8u * groups + 1u; } // a splat: its sort depth, float bits, where the mask has it

#ifdef DPL_SEEN
shared uint dplSeen[4];  // kMaskWords

// Called by all lanes of the workgroup that projects a half-chunk, a barrier before dplSee and one before dplWriteSeen.
void dplClearSeen(uint lane) {
    if (lane < kMaskWords) dplSeen[lane] = 0u;
}
void dplSee(uint lane) { atomicOr(dplSeen[lane >> 5u], 1u << (lane & 31u)); }
void dplWriteSeen(uint lane, uint groups, uint group, uint firstSplat) {
    if (lane < kMaskWords) visibility[dplFirstMask(groups) + kMaskWords * group + lane] = dplSeen[lane];
    if (lane == 0u) {
        visibility[dplFirstSplat(groups) + group] = firstSplat;
        visibility[dplFirstSum(groups) + group] = uint(bitCount(dplSeen[0]) + bitCount(dplSeen[1]) + bitCount(dplSeen[2]) + bitCount(dplSeen[3]));
    }
}
#endif
