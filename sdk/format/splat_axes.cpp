// SPDX-License-Identifier: Apache-2.0
#include "sdk/format/splat_axes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sdk/core/numbers.h"
#include "sdk/core/result.h"
#include "sdk/math/sh_rotation.h"

namespace dpl {
namespace {

constexpr std::string_view kOurComment = "doppel axes", kVerticalComment = "vertical axis", kModeComment = "splatrendermode",
                           kPostshotComment = "antialiased";
constexpr double kAlmostAxis = 1e-6;  // an up direction this near to an axis is taken as that axis

struct Direction {
    char letter;
    const char* word;
    Vec3d ours;
};
constexpr std::array<Direction, 6> kDirections = {{{'R', "right", {1, 0, 0}},
                                                   {'L', "left", {-1, 0, 0}},
                                                   {'U', "up", {0, 1, 0}},
                                                   {'D', "down", {0, -1, 0}},
                                                   {'B', "back", {0, 0, 1}},
                                                   {'F', "front", {0, 0, -1}}}};

const Direction* directionOf(char letter) {
    const auto it = std::find_if(kDirections.begin(), kDirections.end(), [&](const Direction& d) { return d.letter == letter; });
    return it == kDirections.end() ? nullptr : &*it;
}

std::string wordsOf(std::string_view letters) {
    std::string words;
    for (size_t k = 0; k < 3; ++k) words += (k ? std::string(", ") : std::string()) + "xyz"[k] + " " + directionOf(letters[k])->word;
    return words;
}

std::string lowered(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    return out;
}

/** Words of a lowered text; commas, colons, equals signs and brackets separate them as spaces do. */
std::vector<std::string> wordsIn(std::string_view text) {
    constexpr std::string_view kBetween = ",;:=()[] \t\r\n\v\f";
    std::vector<std::string> out;
    for (size_t at = text.find_first_not_of(kBetween); at != text.npos; at = text.find_first_not_of(kBetween, at)) {
        const size_t end = std::min(text.find_first_of(kBetween, at), text.size());
        out.emplace_back(text.substr(at, end - at));
        at = end;
    }
    return out;
}

/** "x left, y down, z back" → "LDB". Empty if the words say something else. */
std::string lettersOf(const std::vector<std::string>& words) {
    std::string letters;
    for (size_t k = 0; k + 1 < words.size(); k += 2) {
        if (words[k] != std::string(1, "xyz"[std::min<size_t>(k / 2, 2)])) return {};
        const auto it = std::find_if(kDirections.begin(), kDirections.end(), [&](const Direction& d) { return words[k + 1] == d.word; });
        if (it == kDirections.end()) return {};
        letters += it->letter;
    }
    return words.size() == 6 ? letters : std::string();
}

/** A vertical axis as a letter with a sign ("y", "-Z", "z-up", "y down") or as three numbers. */
std::optional<Vec3d> upOf(const std::vector<std::string>& words) {
    if (words.size() == 3) {
        Vec3d up;
        bool numbers = true;
        for (int k = 0; k < 3; ++k) numbers = numbers && readNumber(words[size_t(k)], up[k]);
        return numbers ? std::optional(up) : std::nullopt;
    }
    if (words.empty() || words.size() > 2) return std::nullopt;
    std::string word = words[0] + (words.size() == 2 ? "-" + words[1] : "");
    double sign = 1;
    for (const auto& [ending, turns] : {std::pair<std::string, double>{"-up", 1}, {"-down", -1}, {"_up", 1}, {"_down", -1}})
        if (word.ends_with(ending)) {
            word.resize(word.size() - ending.size()), sign = turns;
            break;
        }
    if (word.size() == 2 && (word[0] == '+' || word[0] == '-')) {
        if (word[0] == '-') sign = -sign;
        word.erase(0, 1);
    }
    if (word.size() != 1 || word[0] < 'x' || word[0] > 'z') return std::nullopt;
    Vec3d up(0);
    up[word[0] - 'x'] = sign;
    return up;
}

/** The rest of a lowered comment that begins with `key`. */
std::optional<std::string> after(const std::string& comment, std::string_view key) {
    const size_t from = comment.find_first_not_of(" \t");
    if (from == std::string::npos || comment.compare(from, key.size(), key) != 0) return std::nullopt;
    const std::string rest = comment.substr(from + key.size());
    return rest.empty() || std::isalnum(static_cast<unsigned char>(rest[0])) ? std::nullopt : std::optional(rest);
}

/** The sign that each SH basis function takes when the axes take these signs. */
std::array<float, kMaxShCoefficients> signsOfSh(const Vec3d& signs) {
    const Vec3d d = glm::normalize(Vec3d(0.37, 0.53, 0.81));  // no basis function is zero here
    std::array<double, kMaxShCoefficients> at{}, turned{};
    shBasis(d, kMaxShDegree, at.data()), shBasis(d * signs, kMaxShDegree, turned.data());
    std::array<float, kMaxShCoefficients> out{};
    for (size_t k = 0; k < out.size(); ++k) out[k] = at[k] * turned[k] < 0 ? -1.0f : 1.0f;
    return out;
}

}  // namespace

std::optional<SplatAxes> axesOfLetters(std::string_view letters) {
    if (letters.size() != 3) return std::nullopt;
    SplatAxes axes;
    Vec3d used(0);
    for (int k = 0; k < 3; ++k) {
        const Direction* direction = directionOf(letters[size_t(k)]);
        if (!direction) return std::nullopt;
        axes.uprightFromFile[k] = direction->ours, used += glm::abs(direction->ours);
    }
    if (used != Vec3d(1)) return std::nullopt;
    axes.stated = wordsOf(letters);
    return axes;
}

std::optional<SplatAxes> axesOfUp(const Vec3d& given) {
    const double length = glm::length(given);
    if (!(length > 0) || !std::isfinite(length)) return std::nullopt;
    Vec3d up = given / length;
    for (int k = 0; k < 3; ++k)
        if (std::abs(up[k]) > 1 - kAlmostAxis) {
            const double sign = up[k] < 0 ? -1 : 1;
            up = Vec3d(0), up[k] = sign;
        }
    SplatAxes axes;
    axes.stated = formatText("up is ({}, {}, {})", up.x, up.y, up.z);
    // Rodrigues' rotation from `up` to y, about up × y. Its columns are exact where `up` is an axis.
    const Vec3d about = glm::cross(up, Vec3d(0, 1, 0));
    const double cosine = up.y;
    if (cosine < -1 + kAlmostAxis) {
        axes.uprightFromFile = Mat3d(1, 0, 0, 0, -1, 0, 0, 0, -1);
    } else {
        const Mat3d cross(0, about.z, -about.y, -about.z, 0, about.x, about.y, -about.x, 0);
        axes.uprightFromFile = Mat3d(1) + cross + cross * cross * (1 / (1 + cosine));
    }
    return axes;
}

SplatAxes axesOfComments(std::span<const std::string> comments, std::vector<std::string>& notes) {
    std::optional<SplatAxes> ours, vertical;
    for (const std::string& comment : comments) {
        const std::string text = lowered(comment);
        if (const auto rest = after(text, kOurComment)) ours = axesOfLetters(lettersOf(wordsIn(*rest)));
        const auto rest = after(text, kVerticalComment);
        if (!rest) continue;
        const auto up = upOf(wordsIn(*rest));
        vertical = up ? axesOfUp(*up) : std::nullopt;
        std::string shown = comment.substr(0, 64);  // of a stranger: a terminal and JSON must bear it
        std::replace_if(
            shown.begin(), shown.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
        if (!vertical)
            notes.push_back(
                formatText("the comment '{}' names no axis (such as 'Vertical axis: z' or '0 -1 0'); nothing is turned by it", shown));
    }
    return ours ? *ours : vertical.value_or(SplatAxes{});
}

bool antialiasedByComments(std::span<const std::string> comments) {
    bool antialiased = false;
    for (const std::string& comment : comments) {
        const std::string text = lowered(comment);
        if (const auto mode = after(text, kModeComment)) antialiased = wordsIn(*mode) == std::vector<std::string>{"mip"};
        if (const auto flag = after(text, kPostshotComment)) antialiased = wordsIn(*flag) == std::vector<std::string>{"1"};
    }
    return antialiased;
}

std::vector<std::string> commentsOf(std::string_view letters, bool antialiased) {
    std::vector<std::string> out;
    if (const auto axes = axesOfLetters(letters)) {
        const Vec3d up = glm::transpose(axes->uprightFromFile) * Vec3d(0, 1, 0);
        out.push_back(formatText("Vertical axis: {} {} {}", int(up.x), int(up.y), int(up.z)));
        out.push_back("Doppel axes: " + axes->stated);
    }
    if (antialiased) out.push_back("SplatRenderMode: mip");
    return out;
}

void turnSplats(StaticSplatData& s, const Mat3d& to) {
    if (to == Mat3d(1)) return;
    const bool mirrors = glm::determinant(to) < 0;
    // An ellipsoid is the same after a point reflection, so a mirror is the rotation −to for the axes of a splat.
    const Quatf turn(glm::quat_cast(mirrors ? -to : to));
    const Mat3f place(to);
    const Vec3d signs(to[0][0], to[1][1], to[2][2]);
    const bool onlySigns = glm::abs(signs) == Vec3d(1);
    const auto signsOf = signsOfSh(signs);
    const ShTurn<double> shTurn = ShRotator().turn(to, s.shDegree);
    const uint32_t coefficients = shCoefficientCount(s.shDegree);
    for (size_t i = 0; i < s.position.size(); ++i) {
        s.position[i] = onlySigns ? Vec3f(signs) * s.position[i] : place * s.position[i];
        const Quatf q = turn * s.rotation[i];
        const bool flipped = q.w < 0 || (q.w == 0 && (q.x < 0 || (q.x == 0 && (q.y < 0 || (q.y == 0 && q.z < 0)))));
        s.rotation[i] = flipped ? -q : q;  // one of the two signs, so that turning there and back gives the same bytes each time
        float* sh = s.sh.data() + i * coefficients * 3;
        if (!onlySigns) shTurn.apply(sh);
        for (uint32_t k = 1; onlySigns && k < coefficients; ++k)
            for (uint32_t c = 0; c < 3; ++c) sh[k * 3 + c] *= signsOf[k];
    }
}

}  // namespace dpl
