// SPDX-License-Identifier: Apache-2.0
// Writes a whole clip of an avatar as a numbered folder of splat files, for viewers and editors that play such folders.
#pragma once

#include <memory>
#include <string>

#include "reconstruction/output/package/posed_splats.h"

namespace dpl {

/** A clip that is ready to be written; its size is known.
 *
 *      folder/ clip.json     what the folder holds: avatar, clip, frames a second, format; written first
 *              00000.spz …   a file a frame; the same splats in the same order in each
 *
 *  A file appears when it is complete. A folder of the same clip.json goes on where it was stopped, and other folders are not touched. */
class ClipExport {
public:
    /** Reads avatar and clip, and checks the folder. InvalidArgument: the folder holds something else. Sentences name files and options. */
    static Result<std::unique_ptr<ClipExport>> open(const ExportOptions& options);
    ~ClipExport();
    /** Lines for the user, before anything is written: frames, most splats and bytes, what is there already. */
    std::string plan() const;
    /** Writes what is missing; taskAt hears each frame. Returns lines for the user. Cancelled: what is written stays for the next run. */
    Result<std::string> write();

private:
    struct State;
    explicit ClipExport(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dpl
