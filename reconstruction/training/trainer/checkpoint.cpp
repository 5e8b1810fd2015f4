// SPDX-License-Identifier: Apache-2.0
// CoOptimiser::checkpoint(), restore() and branch(). The versioned file holds every number that the next step reads:
//
//   "DPLT" | version u32 | input hash u64 | payload bytes u64 | payload hash u64 | payload: the fields of learned.h in order, the settings
#include <xxhash.h>

#include <charconv>
#include <cmath>
#include <cstring>

#include "reconstruction/training/trainer/co_optimise_state.h"
#include "reconstruction/training/trainer/corrective_bytes.h"
#include "reconstruction/training/trainer/settings_fields.h"
#include "sdk/core/arrays.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr uint32_t kMagic = 0x544C5044, kVersion = 7;

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

/** Visitor of the settings' fields that writes a line each: "loss.l1 0.8". Numbers are as short as they can be read back. */
struct SettingsText {
    std::string& out;
    std::string group;
    template <class T>
    void operator()(const char* name, const T& field) const {
        if constexpr (std::is_arithmetic_v<T>)
            out += group + name + number(field) + "\n";
        else
            visitFields(field, SettingsText{out, group + name + "."});
    }
    template <class T>
    void operator()(const char* name, const std::vector<T>& field) const {
        out += group + name;
        for (const T& one : field) out += number(one);
        out += "\n";
    }

private:
    template <class T>
    static std::string number(T value) {
        char text[40] = " ";
        if constexpr (std::is_same_v<T, bool>)
            text[1] = value ? '1' : '0';
        else
            std::to_chars(text + 1, text + sizeof text - 1, value);
        return text;
    }
};

std::string textOf(const CoOptimiseSettings& settings) {
    std::string text;
    visitFields(settings, SettingsText{text, {}});
    return text;
}

/** The value of a line of SettingsText. */
std::string valueOf(const std::string& text, const std::string& name) {
    const std::string lines = "\n" + text;
    const size_t at = lines.find("\n" + name + " ");
    if (at == std::string::npos) return {};
    const size_t begin = at + name.size() + 2;
    return lines.substr(begin, lines.find('\n', begin) - begin);
}

/** What changed between two texts of settings: "steps 3000 to 5000, rateDc 0.005 to 0.004". */
std::string changesOf(const std::string& before, const std::string& now) {
    std::string changes;
    for (size_t at = 0; at < now.size(); at = now.find('\n', at) + 1) {
        const std::string name = now.substr(at, now.find_first_of(" \n", at) - at);
        const std::string was = valueOf(before, name), is = valueOf(now, name);
        if (was != is) changes += (changes.empty() ? "" : ", ") + formatText("{} {} to {}", name, was.empty() ? "nothing" : was, is);
    }
    return changes;
}

/** The checks that need several fields: triangle order, complete poses, moments of equal length. */
Status checkLearned(const Learned& learned, const CoOptimiseInput& input) {
    const auto damaged = [](const char* what) { return fail(Code::CorruptData, "{}", what); };
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

uint64_t CoOptimiser::State::inputHash() const {
    Writer w;
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
    if (state_->engineLost) return *state_->engineLost;
    Writer w;
    FieldWriter fields{w};
    if (Status written = visitLearned(state_->learned, state_->learned, fields); !written)
        return fail(Code::Internal, "checkpoint '{}': {}", path.string(), written.error().message);
    const std::string settings = textOf(state_->settings);
    putArray(w, std::vector<char>(settings.begin(), settings.end()));
    const std::vector<uint8_t> payload = w.finish();
    Writer file;
    file.value(kMagic), file.value(kVersion), file.value(state_->inputHash()), file.value(uint64_t(payload.size()));
    file.value(uint64_t(XXH3_64bits(payload.data(), payload.size())));
    file.append(payload);
    return writeFileAtomically(path, file.finish());
}

Result<CoOptimiser::State::Stored> CoOptimiser::State::read(const std::filesystem::path& path) const {
    DPL_TRY(const std::vector<uint8_t> bytes, readFile(path));
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
    DPL_TRY(const uint64_t input, r.value<uint64_t>());
    if (input != inputHash())
        return fail(Code::InvalidArgument, "checkpoint '{}' belongs to other pictures, poses, clothes or light: delete it and train again",
                    path.string());
    DPL_TRY(const uint64_t size, r.value<uint64_t>());
    DPL_TRY(const uint64_t hash, r.value<uint64_t>());
    if (size != r.remaining() || hash != XXH3_64bits(bytes.data() + r.position(), size)) return damaged("wrong length or hash");

    Stored stored{learned, {}};  // fields that are not stored keep their values
    FieldReader fields{r};
    if (Status good = visitLearned(stored.learned, learned, fields); !good) return damaged(good.error().message);
    if (Status good = checkLearned(stored.learned, this->input); !good) return damaged(good.error().message);
    std::vector<char> text;
    if (Status good = getArray(r, text); !good) return damaged(good.error().message);
    stored.changes = changesOf({text.begin(), text.end()}, textOf(settings));
    return stored;
}

void CoOptimiser::State::adopt(Learned stored) {
    learned = std::move(stored);
    engineCurrent = engineAhead = false;
    TrainableSplats& splats = learned.layer.splats;
    std::vector<float> rows = std::move(splats.rows);
    splats.resize(uint32_t(splats.triangle.size()), splats.shDegree);
    splats.rows = std::move(rows);
    splats.indexTriangles(mesh.triangles.size());
    splats.activateAll(jobs);
    learned.layer.adam.stride = splats.stride;
    orderEpoch = ~0ull;
    applyOffsets();
}

Status CoOptimiser::restore(const std::filesystem::path& path) {
    DPL_TRY(State::Stored stored, state_->read(path));
    if (!stored.changes.empty())
        return fail(Code::InvalidArgument, "checkpoint '{}' belongs to other settings ({}): delete it and train again", path.string(),
                    stored.changes);
    if (stored.learned.step > state_->settings.steps)
        return fail(Code::CorruptData, "checkpoint '{}' is damaged (more steps than the run has): delete it and train again",
                    path.string());
    state_->adopt(std::move(stored.learned));
    return {};
}

Result<std::string> CoOptimiser::branch(const std::filesystem::path& path) {
    DPL_TRY(State::Stored stored, state_->read(path));
    for (const char* fixed : {"init.shDegree ", "smoothingLengthM "})  // decide what the stored numbers mean
        if (stored.changes.find(fixed) != std::string::npos)
            return fail(Code::InvalidArgument, "checkpoint '{}' cannot go on with other settings of this kind ({}): keep {}", path.string(),
                        stored.changes, std::string(fixed, std::strlen(fixed) - 1));
    if (stored.learned.step >= state_->settings.steps)
        return fail(Code::InvalidArgument, "checkpoint '{}' has taken {} steps, and this training has {}: give it more", path.string(),
                    stored.learned.step, state_->settings.steps);
    state_->adopt(std::move(stored.learned));
    return stored.changes;
}

}  // namespace dpl
