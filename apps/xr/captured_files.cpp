// SPDX-License-Identifier: Apache-2.0
#include "apps/xr/captured_files.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "reconstruction/base/image_codec.h"
#include "sdk/core/files.h"
#include "sdk/math/half.h"
#include "sdk/math/srgb.h"

namespace dpl {
namespace {

/** RGBA, 8 bits, sRGB codes. */
std::vector<uint8_t> codesOf(const xr::CapturedView& view) {
    if (view.format == VK_FORMAT_R16G16B16A16_SFLOAT) {
        std::vector<uint8_t> codes(view.colour.size() / 2);
        for (size_t i = 0; i < codes.size(); ++i) {
            uint16_t half;
            std::memcpy(&half, view.colour.data() + 2 * i, sizeof half);
            const double linear = std::clamp(double(floatFromHalf(half)), 0.0, 1.0);
            codes[i] = uint8_t(std::lround(255 * (i % 4 == 3 ? linear : srgbFromLinear(linear))));
        }
        return codes;
    }
    std::vector<uint8_t> codes = view.colour;
    if (view.format == VK_FORMAT_B8G8R8A8_SRGB)
        for (size_t i = 0; i + 2 < codes.size(); i += 4) std::swap(codes[i], codes[i + 2]);
    return codes;
}

std::string pfmOf(const xr::CapturedView& view) {
    std::string file = formatText("Pf\n{} {}\n-1.0\n", view.widthPx, view.heightPx);
    for (uint32_t row = view.heightPx; row-- > 0;) {
        const auto* from = reinterpret_cast<const char*>(view.depthM.data() + size_t(row) * view.widthPx);
        file.append(from, size_t(view.widthPx) * sizeof(float));
    }
    return file;
}

nlohmann::json jsonOf(const xr::CapturedView& view) {
    const DplCamera& world = view.camera;
    const XrPosef& pose = view.pose;
    return {{"widthPx", world.widthPx},
            {"heightPx", world.heightPx},
            {"fx", world.fx},
            {"fy", world.fy},
            {"cx", world.cx},
            {"cy", world.cy},
            {"viewFromWorld", world.viewFromWorld},
            {"position", {pose.position.x, pose.position.y, pose.position.z}},
            {"orientation", {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w}},
            {"fov", {view.fov.angleLeft, view.fov.angleRight, view.fov.angleUp, view.fov.angleDown}}};
}

}  // namespace

Result<std::string> writeCapture(const std::filesystem::path& folder, std::span<const xr::CapturedView> views, const AvatarScene& scene,
                                 const CapturedFrame& frame) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail(Code::Io, "the folder {} cannot be made: {}", folder.string(), error.message());
    nlohmann::json all = {{"runtime", frame.runtime}, {"frame", frame.number}, {"timeS", frame.timeS}, {"clip", frame.clip}};
    all["worldFromAvatar"] = scene.worldFromAvatar();
    all["views"] = nlohmann::json::array();
    for (size_t i = 0; i < views.size(); ++i) {
        const xr::CapturedView& view = views[i];
        DPL_TRY(const auto png, encodePng(codesOf(view), view.widthPx, view.heightPx, 4));
        DPL_RETURN_IF_ERROR(writeFileAtomically(folder / formatText("view_{}.png", i), png));
        DPL_RETURN_IF_ERROR(writeFileAtomically(folder / formatText("view_{}_depth.pfm", i), pfmOf(view)));
        all["views"].push_back(jsonOf(view));
    }
    std::string text = all.dump(1) + "\n";
    DPL_RETURN_IF_ERROR(writeFileAtomically(folder / "views.json", text));
    return text;
}

}  // namespace dpl
