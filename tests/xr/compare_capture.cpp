// SPDX-License-Identifier: Apache-2.0
// Compares pictures that doppel-xr captured from a headset with what dplRender draws on the CPU of the same views.
//   compare_xr_capture AVATAR FOLDER [ROOM]
// FOLDER: written by doppel-xr --capture. ROOM: another capture, --without-avatar, of a headset that did not move; without it, FOLDER shows
// the avatar alone (--without-room). Exit codes: 0 all views at 50 dB or more and not empty, and with ROOM the depth holds the avatar; 1
// not so, 2 wrong arguments.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/shared/pictures.h"
#include "reconstruction/base/image_codec.h"
#include "reconstruction/output/package/avatar_bytes.h"
#include "sdk/core/files.h"
#include "tests/reference/composition.h"

namespace dpl {
namespace {

constexpr double kLeastDb = 50;

Result<std::vector<uint8_t>> readPicture(const std::filesystem::path& path, const DplCamera& camera) {
    DPL_TRY(const auto file, readFile(path));
    DPL_TRY(Picture picture, decodePicture(file, PictureChannels::AsStored));
    if (picture.widthPx != camera.widthPx || picture.heightPx != camera.heightPx || picture.channels != 4)
        return fail(Code::CorruptData, "{} does not have the size that views.json says", path.string());
    return std::move(picture.pixels);
}

/** A PFM of one channel, little-endian, bottom row first; the result has its top row first. */
Result<std::vector<float>> readDepth(const std::filesystem::path& path, const DplCamera& camera) {
    DPL_TRY(const auto file, readFile(path));
    const size_t row = size_t(camera.widthPx) * sizeof(float), bytes = row * camera.heightPx;
    if (file.size() < bytes) return fail(Code::CorruptData, "{} does not have the size that views.json says", path.string());
    std::vector<float> depth(size_t(camera.widthPx) * camera.heightPx);
    for (uint32_t y = 0; y < camera.heightPx; ++y)
        std::memcpy(depth.data() + size_t(y) * camera.widthPx, file.data() + file.size() - (y + 1) * row, row);
    return depth;
}

DplCamera cameraOf(const nlohmann::json& view) {
    DplCamera camera{};
    camera.structSize = sizeof camera;
    camera.widthPx = view.at("widthPx"), camera.heightPx = view.at("heightPx");
    camera.fx = view.at("fx"), camera.fy = view.at("fy"), camera.cx = view.at("cx"), camera.cy = view.at("cy");
    for (size_t i = 0; i < 12; ++i) camera.viewFromWorld[i] = view.at("viewFromWorld").at(i);
    return camera;
}

struct Compared {
    double db = 0;
    size_t avatarPixels = 0, depthPixels = 0;  // that show the avatar; in whose depth it is, before the room
};

Result<Compared> compareView(const doppel::Context& context, const doppel::Avatar& avatar, const nlohmann::json& view, size_t index,
                             const std::filesystem::path& folder, const std::filesystem::path& room) {
    DplCamera camera = cameraOf(view);
    const std::string name = formatText("view_{}", index);
    DPL_TRY(const std::vector<uint8_t> captured, readPicture(folder / (name + ".png"), camera));
    std::vector<uint8_t> expected(captured.size(), 0);
    std::vector<float> depth;
    Compared out;
    if (!room.empty()) {
        DPL_TRY(expected, readPicture(room / (name + ".png"), camera));
        DPL_TRY(depth, readDepth(room / (name + "_depth.pfm"), camera));
        DPL_TRY(const auto together, readDepth(folder / (name + "_depth.pfm"), camera));
        for (size_t i = 0; i < depth.size(); ++i) out.depthPixels += together[i] > 0 && (depth[i] == 0 || together[i] < depth[i]);
        camera.sceneDepthM = depth.data(), camera.sceneDepthCount = depth.size();
    }
    const std::vector<uint8_t> background = expected;
    DplImage image{sizeof image, DPL_IMAGE_OVER, expected.data(), expected.size(), 0, nullptr, 0};
    image.format = DPL_FORMAT_RGBA8_SRGB;
    if (const auto rendered = doppel::status(dplRender(context.handle(), avatar.handle(), &camera, 1, &image)); !rendered)
        return fromSdk(rendered.error());
    out.db = reference::psnrDb(reference::TargetFormat::Rgba8Srgb, captured, expected, 3);
    for (size_t i = 0; i < captured.size(); i += 4) out.avatarPixels += !std::equal(&captured[i], &captured[i] + 3, &background[i]);
    return out;
}

Status compare(const std::filesystem::path& avatarFile, const std::filesystem::path& folder, const std::filesystem::path& room) {
    DPL_TRY(const auto text, readFile(folder / "views.json"));
    const nlohmann::json capture = nlohmann::json::parse(text.begin(), text.end());
    DPL_TRY(const auto bytes, readAvatarBytes(avatarFile));
    auto context = doppel::Context::create(DPL_RENDERER_SOFTWARE);
    if (!context) return fromSdk(context.error());
    auto avatar = context->loadAvatar(bytes);
    if (!avatar) return fromSdk(avatar.error());
    if (const std::string clip = capture.at("clip"); !clip.empty()) {
        DPL_TRY(const uint32_t index, chooseClip(*avatar, clip));
        if (const auto posed = avatar->setPoseFromClip(index, capture.at("timeS")); !posed) return fromSdk(posed.error());
    }
    const std::array<float, 12> worldFromAvatar = capture.at("worldFromAvatar");
    if (const auto placed = avatar->setTransform(worldFromAvatar); !placed) return fromSdk(placed.error());
    size_t index = 0;
    bool good = !capture.at("views").empty();
    for (const nlohmann::json& view : capture.at("views")) {
        DPL_TRY(const Compared compared, compareView(*context, *avatar, view, index, folder, room));
        std::printf("view %zu of %s: %.1f dB to dplRender, the avatar in %zu pixels\n", index,
                    capture.at("runtime").get<std::string>().c_str(), compared.db, compared.avatarPixels);
        good = good && compared.db >= kLeastDb && compared.avatarPixels > 0;
        if (!room.empty()) {
            std::printf("  its depth in %zu pixels\n", compared.depthPixels);
            good = good && compared.depthPixels > compared.avatarPixels / 2;
        }
        ++index;
    }
    if (!good) return fail(Code::CorruptData, "{}: a view is empty or below {} dB", folder.string(), kLeastDb);
    return {};
}

}  // namespace
}  // namespace dpl

int main(int argc, char** argv) {
    if (argc != 3 && argc != 4) {
        std::fputs("usage: compare_xr_capture AVATAR FOLDER [ROOM]\n", stderr);
        return 2;
    }
    try {
        if (const auto done = dpl::compare(argv[1], argv[2], argc == 4 ? argv[3] : ""); !done) {
            std::fprintf(stderr, "compare_xr_capture: %s\n", done.error().message.c_str());
            return 1;
        }
    } catch (const nlohmann::json::exception& error) {
        std::fprintf(stderr, "compare_xr_capture: %s: views.json is not what doppel-xr writes: %s\n", argv[2], error.what());
        return 1;
    }
    return 0;
}
