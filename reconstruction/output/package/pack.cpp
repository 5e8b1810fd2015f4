// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/output/package/pack.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numeric>
#include <span>

#include "reconstruction/output/package/avatar_bytes.h"
#include "reconstruction/output/package/pack_pictures.h"
#include "reconstruction/output/package/sh_palette.h"
#include "sdk/core/task.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/expressions.h"
#include "sdk/format/splat_codec.h"
#include "sdk/math/sh.h"

namespace dpl {
namespace {

constexpr std::array kSplatPercents = {100, 95, 90, 85, 80, 75, 70, 65, 60, 55, 50, 45, 40, 35, 30, 25, 20, 15, 10, 5, 2};
constexpr std::array kModePercents = {100, 85, 70, 55, 40, 25, 10, 0};
constexpr std::array kPalettes = {8192u, 2048u, 512u, 128u};

struct ShChoice {
    uint32_t degree = 0, entries = 0;  // entries 0: SH as in the input, with or without a palette
};

/** From the avatar's own SH to none. */
std::vector<ShChoice> shLadder(uint32_t degree) {
    std::vector<ShChoice> ladder = {{degree, 0}};
    for (uint32_t d = degree; d >= 1; --d)
        for (const uint32_t entries : kPalettes) ladder.push_back({d, entries});
    if (degree > 0) ladder.push_back({0, 0});
    return ladder;
}

/** A field of coded splats and the numbers of bits to try. */
struct BitLadder {
    const char* field;
    uint8_t SplatBits::*bits;
    std::array<uint8_t, 5> rungs;
};
constexpr std::array kBitLadders = {
    BitLadder{"places on the triangles", &SplatBits::uv, {9, 8, 7, 6, 5}}, BitLadder{"angles", &SplatBits::phi, {8, 7, 6, 5, 4}},
    BitLadder{"sizes", &SplatBits::scale, {9, 8, 7, 6, 5}}, BitLadder{"opacity", &SplatBits::opacity, {7, 6, 5, 4, 3}},
    BitLadder{"colour", &SplatBits::colour, {9, 8, 7, 6, 5}}};
constexpr size_t kLadders = 3 + kBitLadders.size();

/** A candidate's position on each ladder. compact: splats are entropy-coded (encoding 3). */
struct Rungs {
    size_t splats = 0, sh = 0, modes = 0;
    bool compact = false;
    SplatBits bits;
};

void lowerShDegree(SplatData& s, uint32_t degree) {
    const size_t from = shCoefficientCount(s.shDegree) * 3, to = shCoefficientCount(degree) * 3;
    for (size_t i = 0; i < s.count(); ++i) std::copy_n(s.sh.begin() + ptrdiff_t(i * from), to, s.sh.begin() + ptrdiff_t(i * to));
    s.sh.resize(s.count() * to);
    s.shDegree = degree;
}

/** Keeps the first `count` splats of `order`, without reordering them. */
void keepSplats(SplatData& s, const std::vector<uint32_t>& order, size_t count) {
    std::vector<bool> kept(s.count(), false);
    for (size_t i = 0; i < count; ++i) kept[order[i]] = true;
    const size_t stride = shCoefficientCount(s.shDegree) * 3;
    SplatData out;
    out.shDegree = s.shDegree;
    out.triangleStart.push_back(0);
    for (size_t t = 0; t + 1 < s.triangleStart.size(); ++t) {
        for (uint32_t i = s.triangleStart[t]; i < s.triangleStart[t + 1]; ++i) {
            if (!kept[i]) continue;
            out.uv.push_back(s.uv[i]), out.phi.push_back(s.phi[i]), out.scaleM.push_back(s.scaleM[i]), out.opacity.push_back(s.opacity[i]),
                out.flags.push_back(s.flags[i]);
            out.sh.insert(out.sh.end(), s.sh.begin() + ptrdiff_t(i * stride), s.sh.begin() + ptrdiff_t((i + 1) * stride));
        }
        out.triangleStart.push_back(out.count());
    }
    s = std::move(out);
}

/** Number of different SH rows (without coefficient 0) if the input probably had a palette, else 0. A palette is assumed when the number
 * fits one and is less than half the splats. */
uint32_t ownPalette(const SplatData& s) {
    const size_t stride = shCoefficientCount(s.shDegree) * 3;
    if (stride <= 3 || s.count() == 0) return 0;
    std::vector<uint32_t> order(s.count());
    std::iota(order.begin(), order.end(), 0u);
    const auto row = [&](uint32_t i) { return std::span(s.sh).subspan(i * stride + 3, stride - 3); };
    const auto before = [&](uint32_t a, uint32_t b) {
        return std::lexicographical_compare(row(a).begin(), row(a).end(), row(b).begin(), row(b).end());
    };
    std::sort(order.begin(), order.end(), before);
    size_t different = 1;
    for (size_t i = 1; i < order.size(); ++i) different += before(order[i - 1], order[i]);
    return different <= kMaxShPalette && different * 2 < s.count() ? uint32_t(different) : 0;
}

/** Modes of the pose sorted by the sum of squares of their nodes' offsets and brightness, strongest first. */
std::vector<uint32_t> modesByStrength(const PoseCorrectiveData& c) {
    constexpr double kMetresOfLight = 0.05;  // a change of brightness by 1 counts like an offset of 5 cm
    std::vector<double> strength(c.modeCount, 0.0);
    for (size_t e = 0; e < c.nodes.size(); ++e) {
        if (e % c.columnCount() >= c.modeCount) continue;
        const Vec4d n(c.nodes[e]);
        strength[e % c.columnCount()] += n.x * n.x + n.y * n.y + n.z * n.z + kMetresOfLight * kMetresOfLight * n.w * n.w;
    }
    std::vector<uint32_t> order(c.modeCount);
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return strength[a] > strength[b]; });
    return order;
}

/** Motion modes stay as long as any mode does. */
void keepModes(AvatarData& avatar, const std::vector<uint32_t>& order, uint32_t count) {
    PoseCorrectiveData& c = avatar.correctives;
    if (count == 0) {
        dropPoseModes(c, avatar.expressions);
        return;
    }
    std::vector<uint32_t> kept(order.begin(), order.begin() + count);
    std::sort(kept.begin(), kept.end());
    const size_t features = c.joints.size() * 6;
    PoseCorrectiveData out = c;
    out.modeCount = count;
    out.modes.clear(), out.nodes.clear();
    double off2 = double(c.reachOffModes) * c.reachOffModes;
    for (uint32_t i = 0; i < c.modeCount; ++i) {
        const auto row = c.modes.begin() + ptrdiff_t(i * features);
        if (std::binary_search(kept.begin(), kept.end(), i)) {
            out.modes.insert(out.modes.end(), row, row + ptrdiff_t(features));
        } else {
            // The part of a pose along a removed mode now counts as distance off the modes. Allow as much of it as training poses had,
            // so that the remaining modes do not fade for those poses.
            const double squares = std::inner_product(row, row + ptrdiff_t(features), row, 0.0);
            if (squares > 0) off2 += double(c.reach) * c.reach / squares;
        }
    }
    out.reachOffModes = float(std::min(std::sqrt(off2), double(PoseCorrectiveData().reachOffModes)));
    for (uint32_t i = c.modeCount; i < c.columnCount(); ++i) kept.push_back(i);
    for (uint32_t n = 0; n < c.nodeCount; ++n)
        for (const uint32_t i : kept) out.nodes.push_back(c.nodes[size_t(n) * c.columnCount() + i]);
    c = std::move(out);
}

std::string decibels(double db) {
    return std::isfinite(db) ? formatText("{} dB", std::round(db * 10) / 10) : "equal";
}
/** Bits of positions / angles / sizes / opacity / colour. */
std::string bitsAsText(const SplatBits& b) {
    return formatText("{}/{}/{}/{}/{}", int(b.uv), int(b.phi), int(b.scale), int(b.opacity), int(b.colour));
}
double megabytes(uint64_t bytes) {
    return std::round(double(bytes) / 1e4) / 100;
}

/** The avatar, its ladders, and results that are expensive to compute twice. The avatar must outlive it. */
class Walk {
public:
    Walk(const AvatarData& avatar, const PackSettings& settings, Jobs& jobs)
        : whole_(avatar),
          jobs_(jobs),
          pictures_(avatar, settings.pictures, settings.seed, jobs),
          sh_(shLadder(avatar.splats.shDegree)),
          ownPalette_(ownPalette(avatar.splats)),
          modes_(modesByStrength(avatar.correctives)) {
        if (const auto coded = codeSplats(avatar.mesh, avatar.splats)) first_.bits = neededBits(*coded);
        first_.compact = settings.compact;
        const std::vector<float> importance = pictures_.importance(avatar);
        splats_.resize(importance.size());
        std::iota(splats_.begin(), splats_.end(), 0u);
        std::stable_sort(splats_.begin(), splats_.end(), [&](uint32_t a, uint32_t b) { return importance[a] > importance[b]; });
    }

    /** The unpacked avatar. */
    const Rungs& first() const { return first_; }

    struct Candidate {
        Rungs at;
        PackPoint point;
        double squares = 0;
        std::vector<uint8_t> file;
    };

    Result<Candidate> measure(const Rungs& at) {
        Candidate c;
        c.at = at;
        AvatarData packed = whole_;
        const ShChoice sh = sh_[at.sh];
        packed.splats.sh = shRows(at.sh);
        packed.splats.shDegree = sh.degree;
        keepSplats(packed.splats, splats_, splatCount(at));
        keepModes(packed, modes_, modeCount(at));
        c.point.splats = packed.splats.count(), c.point.shDegree = sh.degree, c.point.modes = packed.correctives.modeCount;
        if (at.splats || at.sh || at.modes || at.bits != first_.bits)
            packed.evidence.push_back({"packed", true, 0, 0,
                                       formatText("{} of {} splats, SH degree {} of {}{}, {} of {} modes of pose correctives, {} bits",
                                                  c.point.splats, whole_.splats.count(), sh.degree, whole_.splats.shDegree,
                                                  sh.entries ? formatText(" from a palette of {}", sh.entries) : "", c.point.modes,
                                                  whole_.correctives.modeCount, bitsAsText(at.bits))});
        DPL_TRY(
            c.file,
            writeAvatar(packed, {.shPalette = sh.entries > 0 || (at.sh == 0 && ownPalette_ > 0), .compact = at.compact, .bits = at.bits}));
        DPL_TRY(const AvatarData decoded, readAvatar(c.file));
        DPL_TRY(const AvatarInfo info, inspectAvatar(c.file));
        c.point.shEntries = info.shPaletteSize, c.point.bits = at.bits, c.point.compact = info.splatEncoding == 3;
        const PackError error = pictures_.compare(decoded);
        c.point.bytes = c.file.size(), c.point.psnrDb = error.psnrDb(), c.point.wholePsnrDb = error.wholePsnrDb();
        c.squares = error.squares;
        return c;
    }

    struct Move {
        size_t ladder;
        Rungs to;
        std::string name;
    };
    /** The next step of each ladder that has one. Steps that would change nothing (few splats, few modes) are skipped. */
    std::vector<Move> moves(const Rungs& from) const {
        std::vector<Move> out;
        Rungs next = from;
        while (++next.splats < kSplatPercents.size())
            if (splatCount(next) < splatCount(from)) {
                out.push_back({0, next, formatText("{} % of the splats", kSplatPercents[next.splats])});
                break;
            }
        next = from;
        while (++next.sh < sh_.size()) {
            const ShChoice sh = sh_[next.sh];
            if (sh.entries > 0 && sh.entries >= splatCount(from)) continue;
            if (sh.entries > 0 && ownPalette_ > 0 && sh.entries >= ownPalette_ && sh.degree == whole_.splats.shDegree) continue;
            out.push_back(
                {1, next, sh.entries ? formatText("SH degree {}, palette of {}", sh.degree, sh.entries) : "no view-dependent colour"});
            break;
        }
        next = from;
        while (++next.modes < kModePercents.size())
            if (modeCount(next) < modeCount(from)) {
                out.push_back(
                    {2, next, modeCount(next) ? formatText("{} modes of pose correctives", modeCount(next)) : "no pose correctives"});
                break;
            }
        for (size_t k = 0; k < kBitLadders.size(); ++k) {
            const BitLadder& ladder = kBitLadders[k];
            const auto rung =
                std::find_if(ladder.rungs.begin(), ladder.rungs.end(), [&](uint8_t bits) { return bits < from.bits.*ladder.bits; });
            if (rung == ladder.rungs.end()) continue;
            next = from;
            next.bits.*ladder.bits = *rung;
            out.push_back({3 + k, next, formatText("{} in {} bits", ladder.field, int(*rung))});
        }
        return out;
    }

    size_t rungs() const {
        return kSplatPercents.size() + sh_.size() + (modes_.empty() ? 0 : kModePercents.size()) +
               kBitLadders.size() * kBitLadders[0].rungs.size();
    }

private:
    size_t splatCount(const Rungs& at) const {
        return size_t(std::llround(double(whole_.splats.count()) * kSplatPercents[at.splats] / 100));
    }
    uint32_t modeCount(const Rungs& at) const { return uint32_t(std::llround(double(modes_.size()) * kModePercents[at.modes] / 100)); }

    /** SH of all splats on a rung of the SH ladder. Each palette is computed once, from all splats. */
    const std::vector<float>& shRows(size_t rung) {
        auto [made, isNew] = rows_.try_emplace(rung);
        if (isNew) {
            SplatData all = whole_.splats;
            lowerShDegree(all, sh_[rung].degree);
            if (sh_[rung].entries)
                (void)paletteSh(all, {.maxEntries = sh_[rung].entries}, jobs_);  // cannot fail: the number of entries is valid
            made->second = std::move(all.sh);
        }
        return made->second;
    }

    const AvatarData& whole_;
    Jobs& jobs_;
    PackPictures pictures_;
    std::vector<ShChoice> sh_;
    Rungs first_;
    uint32_t ownPalette_;                        // entries of the input's palette; 0: none
    std::vector<uint32_t> modes_, splats_;       // indices; strongest modes and most visible splats first
    std::map<size_t, std::vector<float>> rows_;  // by rung of the SH ladder
};

Error outOfReach(const PackLimits& limits, const PackPoint& last, const PackPoint* next) {
    if (!limits.minPsnrDb)
        return fail(Code::InvalidArgument, "{} MB cannot be reached: the smallest size of this avatar is {} MB, at {}",
                    megabytes(*limits.maxBytes), megabytes(last.bytes), decibels(last.psnrDb));
    const std::string there =
        next ? formatText("; the next step is {} MB at {}", megabytes(next->bytes), decibels(next->psnrDb)) : std::string();
    return fail(Code::InvalidArgument, "{} MB and {} dB cannot both be met: the nearest is {} MB at {}{}", megabytes(*limits.maxBytes),
                *limits.minPsnrDb, megabytes(last.bytes), decibels(last.psnrDb), there);
}

}  // namespace

Result<PackResult> packToLimits(const AvatarData& avatar, const PackLimits& limits, const PackSettings& settings, Jobs& jobs) {
    if (!limits.maxBytes && !limits.minPsnrDb) return fail(Code::InvalidArgument, "packing needs a limit: give a size, a PSNR or both");
    DPL_RETURN_IF_ERROR(taskAt(0, "drawing the unpacked avatar"));
    Walk walk(avatar, settings, jobs);
    DPL_TRY(Walk::Candidate here, walk.measure(walk.first()));
    here.point.move = "as it was";
    PackResult result;
    result.curve.push_back(here.point);
    size_t taken = 0;
    const auto fits = [&](const PackPoint& p) { return !limits.minPsnrDb || p.psnrDb >= *limits.minPsnrDb; };
    const auto share = [&] {  // of the ladders' steps or, on a logarithmic scale, of the way to maxBytes
        const double climbed = double(taken) / double(walk.rungs());
        if (!limits.maxBytes || result.curve[0].bytes <= *limits.maxBytes) return climbed;
        const double whole = std::log(double(result.curve[0].bytes) / double(*limits.maxBytes)),
                     done = std::log(double(result.curve[0].bytes) / double(here.point.bytes));
        return std::clamp(std::max(climbed, done / whole), 0.0, 1.0);
    };
    const auto wanted = [&] { return !limits.maxBytes || here.point.bytes > *limits.maxBytes; };
    if (!walk.first().compact && wanted()) {
        Rungs coded = walk.first();
        coded.compact = true;
        DPL_TRY(Walk::Candidate c, walk.measure(coded));
        here.at = coded;
        if (c.point.bytes < here.point.bytes) {
            here = std::move(c), here.point.move = "words entropy-coded";
            result.curve.push_back(here.point);
        }
    }
    // The next move of each ladder. `slope` is from its last measurement, which may have started at an earlier point; `fresh` holds the
    // candidate if it was measured from the current point. The best slope is measured afresh before it is taken. Error only grows, so a
    // ladder whose move once missed minPsnrDb has ended.
    struct Known {
        double slope = std::numeric_limits<double>::infinity();  // bytes saved per unit of added error; infinite: not yet measured
        std::optional<Walk::Candidate> fresh;
        bool ended = false;
    };
    std::array<Known, kLadders> known;
    std::optional<PackPoint> nearest;  // the candidate below minPsnrDb with the highest PSNR
    while (wanted()) {
        const std::vector<Walk::Move> moves = walk.moves(here.at);
        const Walk::Move* best = nullptr;
        for (;;) {
            best = nullptr;
            for (const Walk::Move& m : moves)
                if (!known[m.ladder].ended && known[m.ladder].slope > 0 && (!best || known[m.ladder].slope > known[best->ladder].slope))
                    best = &m;
            if (!best || known[best->ladder].fresh) break;
            Known& k = known[best->ladder];
            DPL_RETURN_IF_ERROR(
                taskAt(share(), formatText("{} MB, {}; trying {}", megabytes(here.point.bytes), decibels(here.point.psnrDb), best->name)));
            DPL_TRY(Walk::Candidate c, walk.measure(best->to));
            c.point.move = best->name;
            if (!fits(c.point)) {
                if (c.point.bytes < here.point.bytes && (!nearest || c.point.psnrDb > nearest->psnrDb)) nearest = c.point;
                k.ended = true;
                continue;
            }
            // The floor of 1e-9 lets a move that adds no error win over all others.
            k.slope =
                c.point.bytes < here.point.bytes ? double(here.point.bytes - c.point.bytes) / std::max(c.squares - here.squares, 1e-9) : 0;
            k.fresh = std::move(c);
        }
        if (!best) {
            if (limits.maxBytes) return outOfReach(limits, here.point, nearest ? &*nearest : nullptr);
            break;
        }
        here = std::move(*known[best->ladder].fresh);
        known[best->ladder] = {};
        for (Known& k : known) {
            k.fresh.reset();
            if (k.slope == 0) k.slope = Known().slope;  // it saved nothing before; measure it again from here
        }
        result.curve.push_back(here.point);
        ++taken;
    }
    if (!fits(here.point))
        return fail(Code::InvalidArgument, "{} dB cannot be met: encoding the avatar again already gives {}", *limits.minPsnrDb,
                    decibels(here.point.psnrDb));
    result.file = std::move(here.file);
    return result;
}

Result<PackResult> packFile(const std::filesystem::path& path, const PackLimits& limits, const PackSettings& settings, Jobs& jobs) {
    DPL_TRY(const auto bytes, readAvatarBytes(path));
    const auto avatar = readAvatar(bytes);
    if (!avatar) return fail(avatar.error().code, "{}: {}", path.string(), avatar.error().message);
    DPL_TRY(const AvatarInfo info, inspectAvatar(bytes));
    PackSettings asItCame = settings;
    asItCame.compact = info.splatEncoding == 3;
    return packToLimits(*avatar, limits, asItCame, jobs);
}

std::string curveAsText(const std::vector<PackPoint>& curve) {
    std::string out =
        "| step | bytes | of the first | PSNR dB | whole picture | splats | SH degree | palette | modes | bits "
        "|\n|---|---|---|---|---|---|---|---|---|---|\n";
    char row[300];
    for (const PackPoint& p : curve) {
        std::snprintf(row, sizeof row, "| %s | %llu | %.1f %% | %s | %s | %u | %u | %s | %u | %s |\n", p.move.c_str(),
                      static_cast<unsigned long long>(p.bytes), 100.0 * double(p.bytes) / double(curve[0].bytes),
                      decibels(p.psnrDb).c_str(), decibels(p.wholePsnrDb).c_str(), p.splats, p.shDegree,
                      p.shEntries ? formatText("{}", p.shEntries).c_str() : "–", p.modes, bitsAsText(p.bits).c_str());
        out += row;
    }
    return out;
}

}  // namespace dpl
