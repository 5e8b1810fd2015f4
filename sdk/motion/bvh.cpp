// SPDX-License-Identifier: Apache-2.0
// BVH (Biovision hierarchy) is a text: nested joints with offsets and channels, then one line of numbers per frame.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sdk/core/numbers.h"
#include "sdk/motion/motion.h"

namespace dpl {
namespace {

constexpr size_t kMaxJoints = 1024;
constexpr size_t kMaxDepth = 256;
constexpr size_t kMaxFrames = 1000000;
constexpr size_t kMaxFrameRotations = size_t(32) << 20;  // frames × joints; 512 MiB
constexpr size_t kMaxNameBytes = 256;
constexpr size_t kMaxTextBytes = size_t(1) << 30;
constexpr double kMaxNumber = 1e9;  // sanity limit of lengths and degrees; keeps squares and products finite in float

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

enum Channel : uint8_t { PositionX, PositionY, PositionZ, RotationX, RotationY, RotationZ };

bool isSpace(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

bool sameWord(std::string_view a, std::string_view lower) {
    if (a.size() != lower.size()) return false;
    for (size_t i = 0; i < a.size(); ++i)
        if ((a[i] >= 'A' && a[i] <= 'Z' ? char(a[i] + 32) : a[i]) != lower[i]) return false;
    return true;
}

class BvhReader {
public:
    BvhReader(std::string_view text, std::string_view name) : text_(text) { motion_.name = name; }

    Result<Motion> read() {
        if (text_.size() > kMaxTextBytes)
            return fail(Code::CorruptData, "{}: a BVH text of {} bytes is refused", motion_.name, text_.size());
        if (text_.size() >= 3 && text_.substr(0, 3) == "\xEF\xBB\xBF") position_ = 3;  // byte order mark
        if (const std::string_view first = word(); !sameWord(first, "hierarchy"))
            return error(formatText("no BVH: the text begins with '{}' instead of HIERARCHY", first.substr(0, 40)));
        if (!sameWord(word(), "root")) return error("ROOT is missing after HIERARCHY");
        DPL_RETURN_IF_ERROR(readTree());
        DPL_RETURN_IF_ERROR(readFrames());
        scaleToMetres(motion_);
        return std::move(motion_);
    }

private:
    Error error(std::string_view what) const { return fail(Code::CorruptData, "{}, line {}: {}", motion_.name, line_, what); }

    void skipSpace() {
        while (position_ < text_.size() && isSpace(text_[position_])) line_ += text_[position_++] == '\n';
    }
    /** Next word; empty at the end of the text. A brace is a word of its own. */
    std::string_view word() {
        skipSpace();
        const size_t begin = position_;
        while (position_ < text_.size() && !isSpace(text_[position_])) {
            const bool brace = text_[position_] == '{' || text_[position_] == '}';
            if (brace && position_ > begin) break;
            ++position_;
            if (brace) break;
        }
        return text_.substr(begin, position_ - begin);
    }
    /** Skips a label such as "Frame Time:", whose words and colon may stand with or without spaces. False: something else stands here. */
    bool label(std::string_view lowerLetters) {
        skipSpace();
        size_t at = position_;
        const auto skipBlanks = [&] {
            while (at < text_.size() && (text_[at] == ' ' || text_[at] == '\t')) ++at;
        };
        for (const char letter : lowerLetters) {
            skipBlanks();
            if (at >= text_.size() || (text_[at] | 0x20) != letter) return false;
            ++at;
        }
        skipBlanks();
        if (at < text_.size() && text_[at] == ':') ++at;
        position_ = at;
        return true;
    }
    /** Rest of the line up to an opening brace, without spaces around it. Joint names may contain spaces. */
    std::string_view restOfLine() {
        size_t begin = position_;
        while (position_ < text_.size() && text_[position_] != '\n' && text_[position_] != '{') ++position_;
        size_t end = position_;
        while (begin < end && isSpace(text_[begin])) ++begin;
        while (end > begin && isSpace(text_[end - 1])) --end;
        return text_.substr(begin, end - begin);
    }
    Result<double> number(std::string_view what) {
        DPL_TRY(const double value, numberOrNone(what));
        if (!std::isfinite(value)) return error(formatText("{} is not a finite number", what));
        return value;
    }
    /** The next number; NaN for one that a program wrote without having it ("nan", "-inf", "1.#QNAN", 1e300). */
    Result<double> numberOrNone(std::string_view what) {
        std::string_view w = word();
        if (w.empty()) return error(formatText("the text ends where {} should be", what));
        if (w.front() == '+') w.remove_prefix(1);
        double value = 0;
        if (readNumber(w, value)) return std::abs(value) <= kMaxNumber ? value : kNone;
        std::string_view bare = w;
        if (bare.starts_with('-')) bare.remove_prefix(1);
        for (const std::string_view none : {"nan", "inf", "infinity", "-nan", "1.#", "null"})
            if (sameWord(bare.substr(0, none.size()), none)) return kNone;
        return error(formatText("{} is '{}', not a number", what, w.substr(0, 40)));
    }
    Result<Vec3f> offset(std::string_view what) {
        if (!sameWord(word(), "offset")) return error(formatText("OFFSET of {} is missing", what));
        Vec3f v(0);
        for (int axis = 0; axis < 3; ++axis) {
            DPL_TRY(const double value, number("an OFFSET"));
            v[axis] = float(value);
        }
        return v;
    }

    /** Reads name, brace and OFFSET of a joint whose keyword was just read. */
    Status openJoint(bool endSite) {
        if (motion_.joints.size() >= kMaxJoints) return error(formatText("more than {} joints", kMaxJoints));
        if (open_.size() >= kMaxDepth) return error(formatText("joints nest deeper than {}", kMaxDepth));
        JointData joint;
        const std::string_view text = restOfLine();
        joint.parent = open_.empty() ? -1 : open_.back();
        joint.name = endSite ? motion_.joints[size_t(joint.parent)].name + " end" : std::string(text);
        if (joint.name.empty() || joint.name.size() > kMaxNameBytes) return error("a joint has no name or a name that is too long");
        if (word() != "{") return error(formatText("an opening brace is missing after joint '{}'", joint.name));
        DPL_TRY(const Vec3f at, offset(formatText("joint '{}'", joint.name)));
        joint.restPosition = at + (joint.parent < 0 ? Vec3f(0) : motion_.joints[size_t(joint.parent)].restPosition);
        offsets_.push_back(at);
        firstChannel_.push_back(channels_.size());
        open_.push_back(int32_t(motion_.joints.size()));
        motion_.joints.push_back(std::move(joint));
        return {};
    }

    Status readChannels() {
        DPL_TRY(const double count, number("the number of CHANNELS"));
        if (!(count >= 0 && count <= 6) || count != std::floor(count)) return error("a joint has 0 to 6 channels");
        const std::string& joint = motion_.joints.back().name;
        if (open_.empty() || size_t(open_.back()) + 1 != motion_.joints.size() || firstChannel_.back() != channels_.size())
            return error(formatText("CHANNELS in the wrong place after joint '{}'", joint));
        uint32_t seen = 0;
        for (int i = 0; i < int(count); ++i) {
            static constexpr std::array<std::string_view, 6> kNames = {"xposition", "yposition", "zposition",
                                                                       "xrotation", "yrotation", "zrotation"};
            const std::string_view w = word();
            size_t channel = 0;
            while (channel < kNames.size() && !sameWord(w, kNames[channel])) ++channel;
            if (channel == kNames.size()) return error(formatText("joint '{}' has an unknown channel '{}'", joint, w.substr(0, 40)));
            if (seen & (1u << channel)) return error(formatText("joint '{}' has channel '{}' twice", joint, w));
            seen |= 1u << channel;
            channels_.push_back(Channel(channel));
        }
        return {};
    }

    Status readTree() {
        DPL_RETURN_IF_ERROR(openJoint(false));
        while (!open_.empty()) {
            const std::string_view w = word();
            if (w.empty()) return error("the text ends inside the hierarchy");
            if (w == "}") {
                open_.pop_back();
            } else if (sameWord(w, "channels")) {
                DPL_RETURN_IF_ERROR(readChannels());
            } else if (sameWord(w, "joint")) {
                DPL_RETURN_IF_ERROR(openJoint(false));
            } else if (sameWord(w, "end")) {
                if (!sameWord(word(), "site")) return error("'End' is not followed by 'Site'");
                DPL_RETURN_IF_ERROR(openJoint(true));
            } else {
                return error(formatText("'{}' is not expected in the hierarchy", w.substr(0, 40)));
            }
        }
        firstChannel_.push_back(channels_.size());
        return {};
    }

    Status readFrames() {
        std::string_view w = word();
        if (sameWord(w, "root"))
            return fail(Code::Unsupported, "{}, line {}: a second ROOT; only one skeleton per file is read", motion_.name, line_);
        if (!sameWord(w, "motion")) return error("MOTION is missing after the hierarchy");
        if (!label("frames")) return error("'Frames:' is missing after MOTION");
        DPL_TRY(const double frames, number("the number of frames"));
        if (!(frames >= 1 && frames <= double(kMaxFrames)) || frames != std::floor(frames))
            return error(formatText("{} frames; 1 to {} are read", frames, kMaxFrames));
        if (!label("frametime")) return error("'Frame Time:' is missing");
        DPL_TRY(const double frameTimeS, number("the frame time"));
        if (!(frameTimeS > 1e-5 && frameTimeS < 1e3))
            return error(formatText("the frame time is {} s; 0.00001 to 1000 are possible", frameTimeS));
        if (channels_.empty()) return error("no joint has a channel");
        // A number and its separator take at least two bytes, which bounds what the frames below can allocate.
        const size_t promised = size_t(frames), room = (text_.size() - position_ + 1) / 2 / channels_.size();
        const size_t keys = std::min(promised, room), joints = motion_.joints.size();
        if (keys * joints > kMaxFrameRotations) return error(formatText("{} frames of {} joints are too many", keys, joints));
        motion_.timesS.reserve(keys);
        motion_.rotations.reserve(keys * joints);
        std::vector<size_t> translationOf(joints, SIZE_MAX);
        for (size_t j = 0; j < joints; ++j)
            for (size_t c = firstChannel_[j]; c < firstChannel_[j + 1]; ++c)
                if (channels_[c] <= PositionZ && translationOf[j] == SIZE_MAX) {
                    translationOf[j] = motion_.translations.size();
                    motion_.translations.push_back({uint32_t(j), {}});
                }
        std::vector<double> row(channels_.size());
        size_t read = 0, notFinite = 0;
        bool whole = true;
        while (read < promised) {
            DPL_TRY(whole, readRow(row, read));
            if (!whole || (position_ == text_.size() && read + 1 < promised)) break;  // its last number may be cut too
            if (std::all_of(row.begin(), row.end(), [](double v) { return std::isfinite(v); }))
                addFrame(row, float(double(read) * frameTimeS), translationOf);
            else
                ++notFinite;
            ++read;
        }
        size_t more = 0;
        for (bool rows = read == promised; rows && !atEnd();) {
            DPL_TRY(rows, readRow(row, promised + more));
            ++more;
        }
        if (motion_.timesS.empty())
            return error(notFinite > 0 ? "no frame has only finite numbers" : "the text ends before its first frame does");
        const float first = motion_.timesS.front();
        for (float& t : motion_.timesS) t -= first;
        if (read < promised) note(formatText("'Frames:' promises {} frames, there are {}: the file may be cut off", promised, read));
        if (more > 0) note(formatText("'Frames:' promises {} frames, {} more stand below them and were left out", promised, more));
        if (notFinite > 0) note(formatText("{} of {} frames have numbers that are not finite and were left out", notFinite, read));
        settleTranslations();
        return {};
    }

    void note(std::string text) { motion_.notes.push_back(std::move(text)); }
    bool atEnd() {
        skipSpace();
        return position_ == text_.size();
    }

    /** The numbers of one frame. False: the text ends before the frame does. */
    Result<bool> readRow(std::vector<double>& row, size_t frame) {
        size_t joint = 0;
        for (size_t c = 0; c < row.size(); ++c) {
            while (c >= firstChannel_[joint + 1]) ++joint;
            if (atEnd()) return false;
            auto value = numberOrNone("a frame value");
            if (!value) {
                if (position_ == text_.size()) return false;
                return fail(value.error().code, "{} (frame {}, joint '{}')", value.error().message, frame + 1, motion_.joints[joint].name);
            }
            row[c] = *value;
        }
        return true;
    }

    void addFrame(std::span<const double> row, float timeS, std::span<const size_t> translationOf) {
        motion_.timesS.push_back(timeS);
        for (size_t j = 0; j < motion_.joints.size(); ++j) {
            Quatd rotation(1, 0, 0, 0);
            Vec3f position(0);
            for (size_t c = firstChannel_[j]; c < firstChannel_[j + 1]; ++c) {
                if (channels_[c] <= PositionZ) {
                    position[channels_[c] - PositionX] = float(row[c]);
                } else {
                    Vec3d axis(0);
                    axis[channels_[c] - RotationX] = 1;
                    rotation = rotation * glm::angleAxis(glm::radians(row[c]), axis);  // the first channel is the outermost rotation
                }
            }
            motion_.rotations.push_back(Quatf(glm::normalize(rotation)));
            if (translationOf[j] != SIZE_MAX) motion_.translations[translationOf[j]].offsets.push_back(position);
        }
    }

    /** Position channels replace OFFSET in files of some programs and add to it in others. If the first frame lies nearer to OFFSET than to
     *  zero, they replace it, and it is subtracted here. */
    void settleTranslations() {
        for (Motion::Translation& translation : motion_.translations) {
            const Vec3f offset = offsets_[translation.joint], first = translation.offsets.front();
            if (glm::length(first - offset) < glm::length(first))
                for (Vec3f& v : translation.offsets) v -= offset;
        }
    }

    std::string_view text_;
    size_t position_ = 0;
    size_t line_ = 1;
    Motion motion_;
    std::vector<int32_t> open_;  // joints whose '{' is not closed yet
    std::vector<Vec3f> offsets_;
    std::vector<Channel> channels_;     // of all joints, file order
    std::vector<size_t> firstChannel_;  // J+1: channels of joint j are [firstChannel_[j], firstChannel_[j+1])
};

}  // namespace

Result<Motion> readBvh(std::string_view text, std::string_view name) {
    return BvhReader(text, name).read();
}

}  // namespace dpl
