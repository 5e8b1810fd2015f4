// SPDX-License-Identifier: Apache-2.0
// The first answer of `doppel check`: faults of the film itself, from a sample of its pictures, while the person is still there.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reconstruction/judging/coach/film_faults.h"
#include "reconstruction/run/reconstruct.h"

namespace dpl {

struct FirstLook {
    size_t pictures = 0;
    bool withNetworks = false;
    std::vector<FilmFault> faults;

    /** Lines for the terminal, without a line break at the end. */
    std::string text() const;
};

/** Takes up to 76 pictures of the videos that the options name, or of a scan without cameras, and judges them. Decodes only those; ends
 *  looking with networks after a minute, and judges what was seen until then. nullopt: the source has cameras or is none of these, and the
 *  long check is quick or alone can read it. Errors: a video cannot be read; Cancelled. Leaves no files. */
Result<std::optional<FirstLook>> takeFirstLook(const ReconstructOptions& options, Progress& progress);

}  // namespace dpl
