// SPDX-License-Identifier: Apache-2.0
// What the jury's frames say of an avatar, and the file that keeps it while the stage evidence judges the next one.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "reconstruction/judging/evidence/motion_faults.h"
#include "sdk/core/result.h"

namespace dpl {

struct JuryScore {
    double maskedPsnrDb = 0;  // mean over full-body and moving frames
    double detail = 0;        // report/detail.h, mean over close-ups, or over all frames where the jury has no close-up
    MotionFaults faults;

    friend bool operator==(const JuryScore&, const JuryScore&) = default;
};

/** Scores by the name of what was judged. A stage that was killed reads those that it had, bit for bit, instead of training again. */
class JuryScores {
public:
    /** Reads `file`. One that is missing or damaged has no scores. */
    explicit JuryScores(std::filesystem::path file);

    std::optional<JuryScore> find(const std::string& name) const;
    /** Adds a score and writes the file. */
    Status add(const std::string& name, const JuryScore& score);

private:
    std::filesystem::path file_;
    std::map<std::string, JuryScore> scores_;
};

}  // namespace dpl
