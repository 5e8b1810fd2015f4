// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/opened_files.h"

#include <cstdio>
#include <cstdlib>

namespace dpl {

void OpenedFiles::begin(Loader& loader, bool script) {
    if (script) return;
    file_ = settingsFile(thisSystem(), [](const char* name) {
        const char* value = std::getenv(name);
        return std::string(value ? value : "");
    });
    if (!file_.empty()) loader.loadSettings(file_);
}

bool OpenedFiles::take(ViewerState& state, LoadedFile& news, double nowS) {
    if (news.settings) {
        ViewerSettings& now = state.settings;  // something may have been opened already
        ViewerSettings kept = std::move(*news.settings);
        saved_ = kept;
        for (auto path = now.recent.rbegin(); path != now.recent.rend(); ++path) kept.remember(*path);
        if (!now.room.empty()) kept.room = now.room;
        now = std::move(kept);
        state.wantsKeptRoom = true;
        return true;
    }
    if (news.folder) {
        if (!state.open) return true;  // closed meanwhile
        state.settings.folder = news.folder->folder.string();
        state.open->list = std::move(*news.folder);
        state.open->waits = false;
        return true;
    }
    if (news.asked || news.run || news.avatar || news.error.empty()) return false;
    if (state.open) state.open->waits = false;
    state.messages.info(news.error, nowS);  // a folder that cannot be listed, or settings that cannot be written: nothing is lost
    if (news.file == kSettings) file_.clear();
    return true;
}

void OpenedFiles::remember(ViewerState& state, const LoadedFile& news) const {
    if (file_.empty() || !news.asked || news.opened.empty()) return;
    if (news.error.empty())
        state.settings.remember(news.opened.string());
    else
        state.settings.forget(news.opened.string());
}

void OpenedFiles::keep(const ViewerSettings& settings) {
    if (file_.empty() || !saved_) return;
    if (const Status written = writeSettings(file_, settings); !written)
        std::fprintf(stderr, "doppel-viewer: settings are not kept: %s\n", written.error().message.c_str());
}

size_t OpenedFiles::fulfil(ViewerState& state, Loader& loader) {
    size_t asked = 0;
    if (state.wantsOpen) {
        const ViewedSubject* chosen = state.chosen();
        loader.load(*state.wantsOpen, chosen && chosen->isAvatar() ? chosen->avatar.handle() : nullptr);
        ++asked;
    }
    if (state.wantsOpenWindow && !state.open) {
        state.open.emplace();
        std::error_code error;
        loader.list(!state.settings.folder.empty() ? std::filesystem::path(state.settings.folder) : std::filesystem::current_path(error));
    }
    if (state.wantsFolder && state.open) {
        state.open->waits = true;
        loader.list(*state.wantsFolder);
    }
    state.wantsOpen.reset(), state.wantsFolder.reset();
    state.wantsOpenWindow = false;
    if (!file_.empty() && saved_ && *saved_ != state.settings) {
        saved_ = state.settings;
        loader.save(file_, state.settings);
    }
    return asked;
}

}  // namespace dpl
