// SPDX-License-Identifier: Apache-2.0
// The clock of the clips.
#pragma once

namespace dpl {

struct Playback {
    double timeS = 0;
    double speed = 1;  // negative: backwards
    bool playing = true, loop = true;

    void advance(double seconds) {
        if (playing) timeS += speed * seconds;
    }
};

/** timeS brought into a clip: repeated, from 0 to below durationS; or, without loop, held at its first and last pose. 0 for a clip without
 *  length. */
double timeInClip(double timeS, double durationS, bool loop = true);

}  // namespace dpl
