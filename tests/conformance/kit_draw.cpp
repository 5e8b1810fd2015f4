// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/kit_draw.h"

#include <nlohmann/json.hpp>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/base/sdk_camera.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;

Error sdk(const doppel::Error& error) {
    return fail(error.code == DPL_ERROR_UNSUPPORTED ? Code::Unsupported : Code::Internal, "{}", error.message);
}

constexpr uint64_t kMaxJsonBytes = 1 << 22, kMaxAvatarBytes = 1 << 26;

Cameraf cameraFrom(const nlohmann::json& j) {
    Cameraf c;
    c.widthPx = j.at("width_px"), c.heightPx = j.at("height_px");
    c.fx = j.at("fx"), c.fy = j.at("fy"), c.cx = j.at("cx"), c.cy = j.at("cy");
    const auto& m = j.at("view_from_world");
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) c.viewFromWorldRotation[column][row] = m.at(size_t(row * 4 + column));
        c.viewFromWorldTranslation[row] = m.at(size_t(row * 4 + 3));
    }
    return c;
}

}  // namespace

Result<std::vector<KitCase>> readKit(const fs::path& folder) {
    const fs::path path = folder / "kit.json";
    DPL_TRY(const auto bytes, readFile(path, kMaxJsonBytes));
    std::vector<KitCase> cases;
    try {
        const auto json = nlohmann::json::parse(bytes.begin(), bytes.end());
        if (json.at("format") != "doppel-conformance" || json.at("version") != kKitVersion)
            return fail(Code::Version, "{} is not a conformance kit of version {}; write it again with `tools/conformance write`",
                        path.string(), kKitVersion);
        for (const auto& c : json.at("cases")) {
            KitCase k{c.at("name"), c.at("about"), c.at("avatar"), c.at("rotations"), Vec3f(0), {}, c.at("may_be_blank"), {}};
            for (int a = 0; a < 3; ++a) k.rootTranslation[a] = c.at("root_translation").at(size_t(a));
            for (const auto& v : c.at("views")) k.views.push_back({v.at("picture"), cameraFrom(v)});
            for (const auto& e : c.value("earlier", nlohmann::json::array())) k.earlier.push_back({e.at("rotations"), e.at("time_ns")});
            if (!k.earlier.empty()) k.timeNs = c.at("time_ns");
            k.band = {c.at("band").at("psnr_db"), c.at("band").at("covered_psnr_db"), c.at("band").at("max_levels")};
            cases.push_back(std::move(k));
        }
    } catch (const nlohmann::json::exception& error) {
        return fail(Code::CorruptData, "{}: {}", path.string(), error.what());
    }
    if (cases.empty()) return fail(Code::CorruptData, "{} has no cases", path.string());
    return cases;
}

Result<std::string> drawKit(const fs::path& kit, const fs::path& pictures, DplRenderer renderer, DplFill fill) {
    auto context = doppel::Context::create(renderer, 0, 0, fill);
    if (!context) return sdk(context.error());
    return drawKit(kit, pictures, *context);
}

Result<std::string> drawKit(const fs::path& kit, const fs::path& pictures, doppel::Context& context) {
    DPL_TRY(const auto cases, readKit(kit));
    std::error_code ignored;
    fs::create_directories(pictures, ignored);
    for (const KitCase& c : cases) {
        DPL_TRY(const auto bytes, readFile(kit / c.avatarFile, kMaxAvatarBytes));
        auto avatar = context.loadAvatar(bytes);
        if (!avatar) return sdk(avatar.error());
        std::vector<DplCamera> cameras;
        std::vector<DplImage> images;
        std::vector<std::vector<uint8_t>> pixels;
        for (const KitView& view : c.views) {
            cameras.push_back(sdkCamera(view.camera));
            pixels.emplace_back(size_t(view.camera.widthPx) * view.camera.heightPx * 4);
            images.push_back({.structSize = sizeof(DplImage),
                              .flags = 0,
                              .rgba = pixels.back().data(),
                              .rgbaBytes = pixels.back().size(),
                              .rowBytes = 0,
                              .depthM = nullptr,
                              .depthCount = 0});
        }
        const std::span root(&c.rootTranslation.x, 3);
        for (const KitEarlierPose& e : c.earlier) {
            if (auto set = avatar->setPose(e.rotations, root, e.timeNs); !set) return sdk(set.error());
            if (auto drawn = avatar->render(cameras, images); !drawn) return sdk(drawn.error());
        }
        const auto set = c.earlier.empty() ? avatar->setPose(c.rotations, root) : avatar->setPose(c.rotations, root, c.timeNs);
        if (!set) return sdk(set.error());
        if (auto drawn = avatar->render(cameras, images); !drawn) return sdk(drawn.error());
        for (size_t v = 0; v < c.views.size(); ++v) {
            DPL_TRY(const auto png, encodePng(pixels[v], cameras[v].widthPx, cameras[v].heightPx, 4));
            DPL_RETURN_IF_ERROR(writeFileAtomically(pictures / c.views[v].picture, png));
        }
    }
    return context.rendererName();
}

}  // namespace dpl
