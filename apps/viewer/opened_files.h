// SPDX-License-Identifier: Apache-2.0
// Opening files from the window, and remembering them and other settings.
#pragma once

#include "apps/viewer/loader.h"
#include "apps/viewer/state.h"

namespace dpl {

class OpenedFiles {
public:
    /** Asks the loader for the settings. A script neither reads nor writes any. */
    void begin(Loader& loader, bool script);

    /** Takes settings, and lists of folders for the window that chooses a file. False: the news is of something else. */
    bool take(ViewerState& state, LoadedFile& news, double nowS);
    /** Remembers what was opened, or forgets what could not be. */
    void remember(ViewerState& state, const LoadedFile& news) const;
    /** Fulfils wishes for files and folders, and saves settings that have changed. Returns how many files the loader was asked for. */
    size_t fulfil(ViewerState& state, Loader& loader);
    /** Saves settings that have changed now, without the loader. */
    void keep(const ViewerSettings& settings);

private:
    std::filesystem::path file_;  // of the settings; empty: they are not kept
    std::optional<ViewerSettings> saved_;
};

}  // namespace dpl
