// SPDX-License-Identifier: Apache-2.0
// Videos on the command line, named by what they show: for `doppel import` and `doppel reconstruct`.
#pragma once

#include <CLI/CLI.hpp>

#include "reconstruction/input/import/video_capture.h"

namespace dpl {

/** Adds --static, --closeup and --motion. They exclude `source`, the folder or file that is given in their place. */
inline void addVideoOptions(CLI::App& command, VideoSources& videos, CLI::Option* source) {
    for (CLI::Option* option : {command.add_option("--static", videos.still, "Videos of a walk round the subject, who stands still"),
                                command.add_option("--closeup", videos.closeup, "Videos of face, hands and clothes from near"),
                                command.add_option("--motion", videos.moving, "Videos of the subject in motion")})
        option->excludes(source);
}

inline bool anyVideo(const VideoSources& videos) {
    return !videos.still.empty() || !videos.closeup.empty() || !videos.moving.empty();
}

/** The error when neither a source nor a video is given. */
inline Error missingSource() {
    return fail(Code::InvalidArgument, "name a folder or file, or videos with --static, --closeup and --motion");
}

}  // namespace dpl
