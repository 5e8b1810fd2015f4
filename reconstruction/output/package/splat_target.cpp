// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/splat_target.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "sdk/format/gltf_splats.h"
#include "sdk/format/ply.h"
#include "sdk/format/spz.h"

namespace dpl {
namespace {

/** Splats with a number that SPZ clamps. */
size_t clampedBySpz(const StaticSplatData& s) {
    const size_t shFloats = s.sh.size() / std::max<size_t>(1, s.count());
    size_t clamped = 0;
    for (size_t i = 0; i < s.count(); ++i) {
        bool any = false;
        for (size_t k = 0; k < shFloats; ++k) any = any || std::abs(s.sh[i * shFloats + k]) > (k < 3 ? 0.5 / 0.15 : 1.0);
        clamped += any;
    }
    return clamped;
}

}  // namespace

SplatTarget splatTargetOf(const std::filesystem::path& out) {
    std::string name = out.filename().string();
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (name.ends_with(".compressed.ply")) return SplatTarget::CompressedPly;
    const std::string extension = out.extension().string();
    return extension == ".glb"   ? SplatTarget::Glb
           : extension == ".spz" ? SplatTarget::Spz
           : extension == ".ply" ? SplatTarget::Ply
                                 : SplatTarget::None;
}

Result<std::vector<uint8_t>> splatFileOf(const StaticSplatData& splats, SplatTarget target, const ExportOptions& options,
                                         std::vector<std::string>& lost) {
    if (target == SplatTarget::Glb) {
        if (splats.compensated) lost.push_back("the antialiased mark (.ply and .spz hold it)");
        return writeGltfSplats(splats);
    }
    if (target == SplatTarget::Ply) return writePly(splats, {.axes = options.axes == "y-up" ? "RUB" : "LDB"});
    if (const size_t clamped = clampedBySpz(splats))
        lost.push_back(formatText("colours or SH of {} splats beyond the range of SPZ, which are clamped", clamped));
    return writeSpz(splats, options.spzVersion);
}

std::string viewersFor(SplatTarget target, const ExportOptions& options) {
    if (target == SplatTarget::Glb) return "upright (y up, by the glTF standard) in every viewer of KHR_gaussian_splatting";
    if (target == SplatTarget::Spz) return "upright (y up, SPZ's default) in every viewer of SPZ";
    if (options.axes == "y-up")
        return "y up, as stated: upright in three.js, Spark and the PlayCanvas engine; for SuperSplat, splat-transform and Babylon.js "
               "leave out --axes";
    return "half a turn about z, as stated: upright in SuperSplat, splat-transform and Babylon.js; for three.js, Spark and the PlayCanvas "
           "engine add "
           "--axes y-up";
}

}  // namespace dpl
