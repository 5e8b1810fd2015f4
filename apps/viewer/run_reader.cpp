// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_reader.h"

#include "reconstruction/base/image_file.h"
#include "reconstruction/base/json_fields.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kMostPicturePx = 4096;

std::string changeOf(const RunProgress& progress, double change) {
    return formatText("{} {}", int64_t(progress.startedUnixS), int64_t(change));
}

std::optional<Picture> readPicture(const fs::path& folder, const std::string& relative) {
    const auto path = fileInside(folder, relative, "progress.json");
    if (!path) return std::nullopt;
    const auto bytes = readCompleteImage(*path);
    if (!bytes) return std::nullopt;
    auto picture = decodePicture(*bytes, PictureChannels::Rgba);
    if (!picture || picture->widthPx > kMostPicturePx || picture->heightPx > kMostPicturePx) return std::nullopt;
    return std::move(*picture);
}

}  // namespace

bool isRunFolder(const fs::path& folder) {
    std::error_code error;
    return fs::is_regular_file(folder / "progress.json", error) || fs::is_regular_file(folder / "run.json", error);
}

RunLook RunReader::look() const {
    RunLook look;
    std::error_code error;
    if (!fs::is_directory(folder_, error)) {
        look.sentence = formatText("The folder {} is gone; what was drawn stays.", folder_.string());
        return look;
    }
    const fs::path file = folder_ / "progress.json";
    const auto bytes = readFile(file, RunProgress::kMostBytes);
    if (!bytes && bytes.error().code == Code::NotFound) {
        look.kind = isRunFolder(folder_) ? RunLook::Kind::Untold : RunLook::Kind::NoRun;
        look.sentence =
            look.kind == RunLook::Kind::Untold
                ? formatText("{} is a run of an earlier version, which does not tell how far it is.", folder_.string())
                : formatText("{} is no run of doppel reconstruct: it has neither progress.json nor run.json.", folder_.string());
        return look;
    }
    look.kind = RunLook::Kind::Damaged;
    if (!bytes) {
        look.sentence = bytes.error().message;
        return look;
    }
    auto progress = parseRunProgress({reinterpret_cast<const char*>(bytes->data()), bytes->size()}, file.string());
    if (!progress) {
        look.sentence = progress.error().message;
        return look;
    }
    look.kind = RunLook::Kind::Told;
    look.progress = std::move(*progress);
    return look;
}

RunReader::News RunReader::read() {
    News news;
    news.look = look();
    const RunProgress& p = news.look.progress;
    const bool told = news.look.kind == RunLook::Kind::Told;
    if (!told && news.look.kind != RunLook::Kind::Untold) return news;
    // The finished avatar of an earlier run may lie there while another one is running.
    const bool finished = !told || p.state == RunProgress::State::Done;
    const fs::path file = finished ? "avatar.glb" : fs::path(p.avatar);
    const std::string change = finished ? changeOf(p, -1) : p.avatar.empty() ? "" : changeOf(p, p.avatarChange);
    if (!change.empty() && change != shownAvatar_)
        if (auto path = fileInside(folder_, file.string(), "progress.json"))
            news.avatar = *path, news.finished = finished, shownAvatar_ = change;
    if (const std::string picture = changeOf(p, 0) + p.heldBackPicture; !p.heldBackPicture.empty() && picture != shownPicture_) {
        news.heldBack = readPicture(folder_, p.heldBackPicture);
        if (news.heldBack) shownPicture_ = picture;
    }
    return news;
}

}  // namespace dpl
