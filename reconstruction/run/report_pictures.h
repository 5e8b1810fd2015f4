// SPDX-License-Identifier: Apache-2.0
// Pictures of the report that no score needs: the avatar in motion, and the shots of the advice.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/judging/report/report.h"
#include "reconstruction/output/package/poses_file.h"
#include "reconstruction/run/frame_table.h"
#include "sdk/format/avatar_data.h"

namespace dpl {

/** A finished avatar with the film that it was made of. cameras: metres, one a row of the table; poses: one a row. */
struct FilmedAvatar {
    const FrameTable& table;
    std::span<const Camerad> cameras;
    const PosesFile& poses;
    const AvatarData& avatar;
};

/** The moving pictures beside the avatar, at most 32 of them, evenly; then the avatar in moves that nobody filmed (move_poses.h). Films of
 *  fewer than eight moving pictures with masks, and rigs without legs, have no such clip. Draws about 90 small pictures. */
Result<std::vector<ReportClip>> drawClips(const FilmedAvatar& filmed, AvatarView& view);

/** One card a shot, with the avatar as the shot would show it. shots: key and sentence, as of the stage body-map. */
Result<std::vector<AdviceCard>> drawAdvice(const FilmedAvatar& filmed, AvatarView& view,
                                           std::span<const std::pair<std::string, std::string>> shots);

}  // namespace dpl
