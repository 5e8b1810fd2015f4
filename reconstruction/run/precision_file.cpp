// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/precision_file.h"

#include <algorithm>
#include <cmath>

#include "sdk/core/arrays.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint32_t kPrecisionMagic = 0x43525044;  // "DPRC"
constexpr uint32_t kPrecisionVersion = 1;

bool fits(const PosePrecision& p, size_t jointCount) {
    if (p.joints.empty() || p.joints.front() != 0 || p.joints.back() >= jointCount) return false;
    if (std::adjacent_find(p.joints.begin(), p.joints.end(), std::greater_equal<uint32_t>()) != p.joints.end()) return false;
    return p.matrix.size() == p.size() * p.size() &&
           std::all_of(p.matrix.begin(), p.matrix.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace

Status writePrecisions(const std::vector<PosePrecision>& precisions, const std::filesystem::path& path) {
    Writer out;
    out.value(kPrecisionMagic), out.value(kPrecisionVersion);
    for (const PosePrecision& p : precisions) putArray(out, p.joints), putArray(out, p.matrix);
    return writeFileAtomically(path, out.finish());
}

Result<std::vector<std::shared_ptr<const PosePrecision>>> readPrecisions(const std::filesystem::path& path, size_t frameCount,
                                                                         size_t jointCount) {
    DPL_TRY(const auto bytes, readFile(path));
    Reader in(bytes);
    std::vector<std::shared_ptr<const PosePrecision>> precisions;
    const auto read = [&]() -> Status {
        DPL_TRY(const uint32_t magic, in.u32());
        DPL_TRY(const uint32_t version, in.u32());
        if (magic != kPrecisionMagic || version != kPrecisionVersion)
            return fail(Code::Version, "not a file of precisions of version {}", kPrecisionVersion);
        for (size_t f = 0; f < frameCount; ++f) {
            PosePrecision p;
            DPL_RETURN_IF_ERROR(getArray(in, p.joints));
            DPL_RETURN_IF_ERROR(getArray(in, p.matrix));
            if (!fits(p, jointCount)) return fail(Code::CorruptData, "the precision of frame {} does not fit the body", f);
            precisions.push_back(std::make_shared<const PosePrecision>(std::move(p)));
        }
        if (in.remaining() > 0) return fail(Code::CorruptData, "more frames than the scan has");
        return {};
    };
    if (Status done = read(); !done) return fail(done.error().code, "{}: {}; delete it and run again", path.string(), done.error().message);
    return precisions;
}

}  // namespace dpl
