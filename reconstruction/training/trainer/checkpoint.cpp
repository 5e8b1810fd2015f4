// SPDX-License-Identifier: Apache-2.0
// CoOptimiser::checkpoint() and restore(). The versioned file holds every number that the next step reads:
//
//   "DPLT" | version u32 | fingerprint u64 | payload bytes u64 | payload hash u64 | payload: the fields of learned.h in order
#include <xxhash.h>

#include <cmath>

#include "reconstruction/training/trainer/co_optimise_state.h"
#include "reconstruction/training/trainer/corrective_bytes.h"
#include "reconstruction/training/trainer/settings_fields.h"
#include "sdk/core/arrays.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint32_t kMagic = 0x544C5044, kVersion = 6;

/** True when all `count` values are finite. Integers always are. */
template <class Number>
bool numbersFinite(const void* data, size_t count) {
    for (const Number* n = static_cast<const Number*>(data); count > 0; ++n, --count)
        if (!std::isfinite(*n)) return false;
    return true;
}
bool allFinite(const float* v, size_t n) {
    return numbersFinite<float>(v, n);
}
bool allFinite(const double* v, size_t n) {
    return numbersFinite<double>(v, n);
}
template <int L, class Number>
bool allFinite(const glm::vec<L, Number>* v, size_t n) {
    return numbersFinite<Number>(v, n * L);
}
bool allFinite(const Quatf* v, size_t n) {
    return numbersFinite<float>(v, n * 4);
}
template <class Other>
bool allFinite(const Other*, size_t) {
    return true;
}

Status wrongSize(const char* name, size_t size, size_t wanted) {
    return fail(Code::CorruptData, "{}: {} entries, {} belong there", name, size, wanted);
}

/** Visitor of visitLearned() that writes. It refuses the sizes that restore() would refuse. */
struct FieldWriter {
    Writer& out;

    template <class T>
    Status value(const char*, const T& field) {
        out.value(field);
        return {};
    }
    template <class T>
    Status array(const char* name, const std::vector<T>& field, size_t count) {
        if (field.size() != count) return wrongSize(name, field.size(), count);
        return arrayOfAnySize(name, field);
    }
    template <class T>
    Status arrayOrEmpty(const char* name, const std::vector<T>& field, size_t count) {
        return array(name, field, field.empty() ? 0 : count);
    }
    template <class T>
    Status arrayOfAnySize(const char*, const std::vector<T>& field) {
        putArray(out, field);
        return {};
    }
};

/** Visitor of visitLearned() that reads. It checks that sizes are right and numbers finite. */
struct FieldReader {
    Reader& in;

    template <class T>
    Status value(const char* name, T& field) {
        DPL_TRY(field, in.value<T>());
        return finite(name, &field, 1);
    }
    template <class T>
    Status array(const char* name, std::vector<T>& field, size_t count) {
        DPL_RETURN_IF_ERROR(arrayOfAnySize(name, field));
        if (field.size() != count) return wrongSize(name, field.size(), count);
        return {};
    }
    template <class T>
    Status arrayOrEmpty(const char* name, std::vector<T>& field, size_t count) {
        DPL_RETURN_IF_ERROR(arrayOfAnySize(name, field));
        if (!field.empty() && field.size() != count) return wrongSize(name, field.size(), count);
        return {};
    }
    template <class T>
    Status arrayOfAnySize(const char* name, std::vector<T>& field) {
        DPL_RETURN_IF_ERROR(getArray(in, field));
        return finite(name, field.data(), field.size());
    }

private:
    template <class T>
    Status finite(const char* name, const T* values, size_t count) {
        if (!allFinite(values, count)) return fail(Code::CorruptData, "{}: numbers that are not finite", name);
        return {};
    }
};

/** Visitor of the settings' fields that writes them one by one. The bytes of a whole struct would include undefined padding. */
struct SettingsWriter {
    Writer& out;
    template <class T>
    void operator()(const char*, const T& field) const {
        if constexpr (std::is_arithmetic_v<T>)
            out.value(field);
        else
            visitFields(field, *this);
    }
    template <class T>
    void operator()(const char*, const std::vector<T>& field) const {
        putArray(out, field);
    }
};

/** The checks that need several fields: triangle order, complete poses, moments of equal length. */
Status checkLearned(const Learned& learned, const CoOptimiseInput& input, uint32_t steps) {
    const auto damaged = [](const char* what) { return fail(Code::CorruptData, "{}", what); };
    if (learned.step > steps) return damaged("more steps than the run has");
    const std::vector<uint32_t>& triangle = learned.layer.splats.triangle;
    for (size_t i = 0; i < triangle.size(); ++i)
        if (triangle[i] >= input.mesh.triangles.size() || (i > 0 && triangle[i] < triangle[i - 1])) return damaged("triangle order");
    if (learned.layer.adamOffsets.first.size() != learned.layer.adamOffsets.second.size()) return damaged("moments of the offsets");
    for (const LearnedFrame& frame : learned.frames) {
        if (!checkPose(input.joints, frame.pose)) return damaged("a pose");
        if (frame.adamPose.first.size() != frame.adamPose.second.size()) return damaged("moments of a frame");
    }
    return {};
}

}  // namespace

void CoOptimiser::State::hashPicture(const FramePicture& picture) {
    for (const std::vector<uint8_t>* pixels : {&picture.image.pixels, &picture.mask.pixels, &picture.labels.pixels})
        pictureHashes.push_back(XXH3_64bits(pixels->data(), pixels->size()));
}

uint64_t CoOptimiser::State::fingerprint() const {
    Writer w;
    visitFields(settings, SettingsWriter{w});
    putArray(w, input.mesh.restPositions), putArray(w, input.mesh.triangles), putArray(w, input.triangleLabel);
    putCorrectiveModel(w, input.correctives);
    w.value(input.light.irradiance);
    for (size_t i = 0; i < input.frames.size(); ++i) {
        const TrainFrame& f = input.frames[i];
        for (size_t plane = 0; plane < 3; ++plane) w.value(pictureHashes[3 * i + plane]);
        w.value(f.camera.viewFromWorldRotation), w.value(f.camera.viewFromWorldTranslation);
        w.value(f.camera.fx), w.value(f.camera.fy), w.value(f.camera.cx), w.value(f.camera.cy), w.value(f.kind);
        putArray(w, f.pose.localRotations), w.value(f.pose.rootTranslation), w.value(f.pose.before);
        if (f.precision) putArray(w, f.precision->joints), putArray(w, f.precision->matrix);
    }
    for (const Pose& pose : input.stress) putArray(w, pose.localRotations), w.value(pose.rootTranslation), w.value(pose.before);
    const std::vector<uint8_t> bytes = w.finish();
    return XXH3_64bits(bytes.data(), bytes.size());
}

Status CoOptimiser::checkpoint(const std::filesystem::path& path) const {
    Writer w;
    FieldWriter fields{w};
    if (Status written = visitLearned(state_->learned, state_->learned, fields); !written)
        return fail(Code::Internal, "checkpoint '{}': {}", path.string(), written.error().message);
    const std::vector<uint8_t> payload = w.finish();
    Writer file;
    file.value(kMagic), file.value(kVersion), file.value(state_->fingerprint()), file.value(uint64_t(payload.size()));
    file.value(uint64_t(XXH3_64bits(payload.data(), payload.size())));
    file.append(payload);
    return writeFileAtomically(path, file.finish());
}

Status CoOptimiser::restore(const std::filesystem::path& path) {
    DPL_TRY(const std::vector<uint8_t> bytes, readFile(path));
    State& s = *state_;
    const auto damaged = [&](std::string_view what) {
        return fail(Code::CorruptData, "checkpoint '{}' is damaged ({}): delete it and train again", path.string(), what);
    };
    Reader r(bytes);
    DPL_TRY(const uint32_t magic, r.u32());
    if (magic != kMagic) return damaged("not a checkpoint");
    DPL_TRY(const uint32_t version, r.u32());
    if (version != kVersion)
        return fail(Code::Version, "checkpoint '{}' has version {}, this build reads {}: delete it and train again", path.string(), version,
                    kVersion);
    DPL_TRY(const uint64_t fingerprint, r.value<uint64_t>());
    if (fingerprint != s.fingerprint())
        return fail(Code::InvalidArgument, "checkpoint '{}' belongs to other input or settings: delete it and train again", path.string());
    DPL_TRY(const uint64_t size, r.value<uint64_t>());
    DPL_TRY(const uint64_t hash, r.value<uint64_t>());
    if (size != r.remaining() || hash != XXH3_64bits(bytes.data() + r.position(), size)) return damaged("wrong length or hash");

    Learned read = s.learned;  // fields that are not stored keep their values
    FieldReader fields{r};
    if (Status good = visitLearned(read, s.learned, fields); !good) return damaged(good.error().message);
    if (Status good = checkLearned(read, s.input, s.settings.steps); !good) return damaged(good.error().message);

    s.learned = std::move(read);
    TrainableSplats& splats = s.learned.layer.splats;
    std::vector<float> rows = std::move(splats.rows);
    splats.resize(uint32_t(splats.triangle.size()), splats.shDegree);
    splats.rows = std::move(rows);
    splats.indexTriangles(s.mesh.triangles.size());
    splats.activateAll(s.jobs);
    s.learned.layer.adam.stride = splats.stride;
    s.orderEpoch = ~0ull;
    s.applyOffsets();
    return {};
}

}  // namespace dpl
