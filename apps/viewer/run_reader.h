// SPDX-License-Identifier: Apache-2.0
// Looks into the folder of a `doppel reconstruct` that may be running, in another process or on another machine. It only reads, and takes
// no lock, so a run does not notice how many watch it. A slow disk makes it wait: it belongs on the loader's thread.
#pragma once

#include <filesystem>

#include "apps/viewer/run_progress.h"
#include "reconstruction/base/image_codec.h"

namespace dpl {

/** What one look found. */
struct RunLook {
    enum class Kind : uint8_t {
        Told,     // progress is set
        Untold,   // a run of an earlier version, which leaves no progress.json
        Damaged,  // progress.json cannot be read; the sentence says why
        NoRun,    // the folder is no run
        Gone,     // there is no such folder
    };
    Kind kind = Kind::Gone;
    std::string sentence;
    RunProgress progress;
};

/** Whether a folder is that of a run. */
bool isRunFolder(const std::filesystem::path& folder);

class RunReader {
public:
    explicit RunReader(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /** What is new since the last call. */
    struct News {
        RunLook look;
        std::filesystem::path avatar;     // to be shown from now on; empty: that of before
        bool finished = false;            // it is the finished one
        std::optional<Picture> heldBack;  // RGBA
    };
    News read();
    /** The avatar of the last news could not be loaded: it is news again the next time. */
    void forgetAvatar() { shownAvatar_.clear(); }

    const std::filesystem::path& folder() const { return folder_; }

private:
    RunLook look() const;
    std::string shownAvatar_, shownPicture_;  // what they were, to tell whether there are others
    std::filesystem::path folder_;
};

}  // namespace dpl
