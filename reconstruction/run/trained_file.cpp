// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/trained_file.h"

#include "reconstruction/training/trainer/corrective_bytes.h"
#include "sdk/core/arrays.h"
#include "sdk/core/files.h"
#include "sdk/format/light.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr uint32_t kMagic = 0x4e525444;  // "DTRN"
constexpr uint32_t kVersion = 6;

void putPose(Writer& out, const Pose& pose) {
    putArray(out, pose.localRotations);
    out.value(pose.rootTranslation);
}

Status readBody(Reader& in, CoOptimiseResult& r) {
    DPL_TRY(uint32_t magic, in.u32());
    DPL_TRY(uint32_t version, in.u32());
    if (magic != kMagic || version != kVersion) return fail(Code::Version, "not a trained file of version {}", kVersion);
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.triangleStart));
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.uv));
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.phi));
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.scaleM));
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.opacity));
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.flags));
    DPL_TRY(r.splats.shDegree, in.u32());
    DPL_RETURN_IF_ERROR(getArray(in, r.splats.sh));
    DPL_RETURN_IF_ERROR(getArray(in, r.restPositions));
    DPL_RETURN_IF_ERROR(getCorrectives(in, r.correctives));
    DPL_TRY(r.light.irradiance, in.value<decltype(r.light.irradiance)>());
    DPL_TRY(uint32_t poseCount, in.u32());
    for (uint32_t i = 0; i < poseCount; ++i) {
        Pose pose;
        DPL_RETURN_IF_ERROR(getArray(in, pose.localRotations));
        DPL_TRY(pose.rootTranslation, in.value<Vec3f>());
        r.poses.push_back(std::move(pose));
    }
    DPL_RETURN_IF_ERROR(getArray(in, r.curve));
    DPL_TRY(r.profile, in.value<StepProfile>());
    DPL_TRY(r.framesUsed, in.u32());
    return {};
}

}  // namespace

Status writeTrainedFile(const CoOptimiseResult& r, const std::filesystem::path& path) {
    Writer out;
    out.value(kMagic);
    out.value(kVersion);
    putArray(out, r.splats.triangleStart);
    putArray(out, r.splats.uv);
    putArray(out, r.splats.phi);
    putArray(out, r.splats.scaleM);
    putArray(out, r.splats.opacity);
    putArray(out, r.splats.flags);
    out.value(r.splats.shDegree);
    putArray(out, r.splats.sh);
    putArray(out, r.restPositions);
    putCorrectives(out, r.correctives);
    out.value(r.light.irradiance);
    out.value(uint32_t(r.poses.size()));
    for (const Pose& pose : r.poses) putPose(out, pose);
    putArray(out, r.curve);
    out.value(r.profile);
    out.value(r.framesUsed);
    return writeFileAtomically(path, out.finish());
}

Result<CoOptimiseResult> readTrainedFile(const std::filesystem::path& path, size_t triangleCount, size_t vertexCount, size_t jointCount) {
    DPL_TRY(auto bytes, readFile(path));
    CoOptimiseResult r;
    Reader in(bytes);
    if (Status read = readBody(in, r); !read)
        return fail(read.error().code, "{}: {}; delete it and run again", path.string(), read.error().message);
    const size_t count = r.splats.uv.size();
    bool whole = r.splats.triangleStart.size() == triangleCount + 1 && r.splats.triangleStart.back() == count &&
                 r.splats.phi.size() == count && r.splats.scaleM.size() == count && r.splats.opacity.size() == count &&
                 r.splats.flags.size() == count && r.splats.shDegree <= kMaxShDegree &&
                 r.splats.sh.size() == count * 3 * shCoefficientCount(r.splats.shDegree) && r.restPositions.size() == vertexCount;
    for (const Pose& pose : r.poses) whole &= pose.localRotations.size() == jointCount;
    if (!whole) return fail(Code::CorruptData, "{}: its arrays do not fit the body; delete it and run again", path.string());
    if (Status fits = checkCorrectives(r.correctives, jointCount, vertexCount); !fits)
        return fail(Code::CorruptData, "{}: {}; delete it and run again", path.string(), fits.error().message);
    if (Status good = checkLight(r.light); !good)
        return fail(Code::CorruptData, "{}: {}; delete it and run again", path.string(), good.error().message);
    return r;
}

}  // namespace dpl
