// SPDX-License-Identifier: Apache-2.0
// Reads the records of general splats. The includer declares the buffer `splats` by DPL_FOURS: every GeneralSplatRecord, then one GroupBox
// for each group. The compiler drops the reads of members that the includer does not use.
GeneralSplatRecord dplGeneralSplat(uint index) {
    uint at = kGeneralSplatFours * index;
    vec4 centre = dplFloats(DPL_FOUR(splats, at)), axis1 = dplFloats(DPL_FOUR(splats, at + 1u));
    vec4 axis2 = dplFloats(DPL_FOUR(splats, at + 2u)), axis3 = dplFloats(DPL_FOUR(splats, at + 3u));
    return GeneralSplatRecord(centre.x, centre.y, centre.z, centre.w, axis1.x, axis1.y, axis1.z, 0.0, axis2.x, axis2.y, axis2.z, 0.0,
                              axis3.x, axis3.y, axis3.z, 0.0);
}

vec3 dplCentreOf(GeneralSplatRecord s) { return vec3(s.centreX, s.centreY, s.centreZ); }

GroupBox dplGroupBox(uint splatCount, uint group) {
    uint at = kGeneralSplatFours * splatCount + kGroupBoxFours * group;
    vec4 middle = dplFloats(DPL_FOUR(splats, at)), reach = dplFloats(DPL_FOUR(splats, at + 1u)), detail = dplFloats(DPL_FOUR(splats, at + 2u));
    return GroupBox(middle.x, middle.y, middle.z, 0.0, reach.x, reach.y, reach.z, 0.0, detail.x, detail.y, detail.z, 0.0);
}
