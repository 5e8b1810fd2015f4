// SPDX-License-Identifier: Apache-2.0
// The ladder of a scan with a truth (reconstruction/judging/ladder measures it): its figures, and its table for terminal, page and
// programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "reconstruction/input/capture/scan.h"

namespace dpl {

/** Mean scores of one rung of the ladder over one group of frames. */
struct LadderCell {
    size_t frames = 0;  // scored at this rung; 0: the rung does not apply
    double maskedPsnrDb = 0;
    std::optional<double> surfaceMm;  // mean distance of the avatar's vertices from where the true surface would carry them
};

/** One rung: what the truth has replaced. */
struct LadderRung {
    std::string key, what;
    std::vector<LadderCell> cells;  // one a group
};

/** Mean symmetric distance of a garment from the true one over one group of frames, millimetres (docs/reference/metrics.md). */
struct GarmentCell {
    size_t frames = 0;  // 0: not measured
    double correctedMm = 0;
    double plainMm = 0;                             // of the same avatar without pose correctives
    double pointCorrectedMm = 0, pointPlainMm = 0;  // of its points from where they belong: slip counts
};

enum class GarmentPoses : uint8_t {
    Fitted,  // to the pictures
    True,    // as on the rung of the true poses
};

/** Distances of one garment from the truth, in one kind of poses. */
struct GarmentRow {
    std::string garment;
    GarmentPoses poses = GarmentPoses::Fitted;
    std::vector<GarmentCell> cells;  // one a group
};

/** Frames of one kind and split. */
struct LadderGroup {
    FrameKind kind = FrameKind::StaticFull;
    Split split = Split::Train;
    size_t frames = 0;
};

/** The ladder of a scan with a truth (reconstruction/judging/ladder). */
struct Ladder {
    std::vector<LadderGroup> groups;
    std::vector<LadderRung> rungs;
    std::vector<GarmentRow> garments;
};

/** Aligned lines of text. */
std::string ladderText(const Ladder& ladder);
/** A heading, a paragraph and a table. */
std::string ladderHtml(const Ladder& ladder);
nlohmann::ordered_json ladderJson(const Ladder& ladder);
/** One entry a row of Ladder::garments; groups without frames are left out. */
nlohmann::ordered_json garmentsJson(const Ladder& ladder);

}  // namespace dpl
