// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/coach/shots.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reconstruction/judging/coach/imagined_shots.h"
#include "reconstruction/judging/coach/weighted_median.h"
#include "sdk/core/percentile.h"

namespace dpl {
namespace {

constexpr size_t kShots = 3;
constexpr double kFinestM = 0.0005, kCoarsestM = 0.064;  // detail below the first is worth nothing; unseen counts as the second
constexpr double kEnoughViews = 6, kViewsOctaves = 3;    // a place in fewer pictures than this lacks up to so many halvings
constexpr double kWorthwhile = 0.5;                      // mean halvings over what a shot is of, below which it is not asked for
constexpr double kWorthwhileWalk = 0.25;                 // of a walk, over the whole body

/** How much is wrong with a triangle, in halvings of the finest visible detail. */
double lackOf(const SeenTriangle& t) {
    const double detail = t.seen() ? std::clamp(double(t.detailM), kFinestM, kCoarsestM) : kCoarsestM;
    return std::log2(detail / kFinestM) + kViewsOctaves * std::max(0.0, kEnoughViews - double(t.views)) / kEnoughViews;
}

SeenTriangle improved(SeenTriangle t, const ImaginedShot& shot, size_t triangle) {
    if (!(shot.pixelM[triangle] > 0)) return t;
    if (!t.seen() || shot.pixelM[triangle] < t.detailM) t.pixelM = t.detailM = shot.pixelM[triangle], t.blurPx = 0;
    t.views += shot.views[triangle];
    return t;
}

std::string millimetres(double metres) {
    const double mm = metres * 1000;
    return formatText("{}", mm < 9.95 ? std::round(mm * 10) / 10 : std::round(mm));
}
std::string oneDigit(double value) {
    return formatText("{}", std::round(value * 10) / 10);
}
std::string percent(double share) {
    return formatText("{} %", std::max(1.0, std::round(100 * share)));
}

class Coach {
public:
    Coach(const MeshData& surface, std::span<const BodyPlace> places, std::span<const SeenTriangle> map, std::vector<ImaginedShot> imagined)
        : places_(places), map_(map.begin(), map.end()), imagined_(std::move(imagined)) {
        const size_t count = surface.triangles.size();
        out_.viewable.assign(count, 0);
        area_ = restAreas(surface);
        for (size_t t = 0; t < count; ++t) {
            out_.viewable[t] = map_[t].seen();
            for (const ImaginedShot& shot : imagined_) out_.viewable[t] |= shot.pixelM[t] > 0;
            if (out_.viewable[t]) placeArea_[size_t(places[t])] += area_[t];
        }
    }

    FilmAgain run() {
        describePlaces();
        for (size_t round = 0; round < kShots; ++round) {
            const ImaginedShot* best = nullptr;
            double most = 0;
            for (const ImaginedShot& shot : imagined_) {
                if (meanHalvings(shot) < (shot.of.empty() ? kWorthwhileWalk : kWorthwhile)) continue;
                if (const double gain = gainOf(shot) / shot.effort; gain > most) most = gain, best = &shot;
            }
            if (!best) break;
            out_.shots.push_back({best->key, sentence(*best), gainOf(*best)});
            for (size_t t = 0; t < map_.size(); ++t) map_[t] = improved(map_[t], *best, t);
        }
        return std::move(out_);
    }

private:
    std::span<const BodyPlace> places_;
    std::vector<SeenTriangle> map_;
    std::vector<ImaginedShot> imagined_;
    std::vector<double> area_;
    std::array<double, kBodyPlaces> placeArea_{};
    FilmAgain out_;

    double weightOf(size_t t) const {
        const size_t place = size_t(places_[t]);
        return out_.viewable[t] ? wordsOf(places_[t]).importance * area_[t] / placeArea_[place] : 0;
    }
    double gainAt(const ImaginedShot& shot, size_t t) const { return lackOf(map_[t]) - lackOf(improved(map_[t], shot, t)); }
    /** Of a close-up only what it is of counts: that is what the sentence says. */
    double gainOf(const ImaginedShot& shot) const {
        double gain = 0;
        for (size_t t = 0; t < map_.size(); ++t)
            if (shot.pixelM[t] > 0 && isOf(shot, t)) gain += weightOf(t) * gainAt(shot, t);
        return gain;
    }
    bool isOf(const ImaginedShot& shot, size_t t) const {
        return shot.of.empty() || std::find(shot.of.begin(), shot.of.end(), places_[t]) != shot.of.end();
    }
    /** Over what the shot is of: the places of a close-up, the whole body for a walk. */
    double meanHalvings(const ImaginedShot& shot) const {
        double gain = 0, weight = 0;
        for (size_t t = 0; t < map_.size(); ++t)
            if (isOf(shot, t)) gain += weightOf(t) * gainAt(shot, t), weight += weightOf(t);
        return weight > 0 ? gain / weight : 0;
    }

    void describePlaces() {
        for (size_t p = 0; p < kBodyPlaces; ++p) {
            if (!(placeArea_[p] > 0)) continue;
            std::vector<WeightedValue> pixel, blur, detail, views;
            double unseen = 0;
            for (size_t t = 0; t < map_.size(); ++t) {
                if (size_t(places_[t]) != p || !out_.viewable[t]) continue;
                if (!map_[t].seen()) {
                    unseen += area_[t];
                    continue;
                }
                pixel.push_back({map_[t].pixelM, area_[t]}), blur.push_back({map_[t].blurPx, area_[t]});
                detail.push_back({map_[t].detailM, area_[t]}), views.push_back({double(map_[t].views), area_[t]});
            }
            out_.places.push_back({BodyPlace(p), placeArea_[p], weightedMedian(pixel), weightedMedian(blur), weightedMedian(detail),
                                   weightedMedian(views), unseen / placeArea_[p]});
        }
    }

    /** What a shot would find: medians over the triangles that it improves, weighted by the gain, and why. */
    struct Reason {
        double missing = 0, blurred = 0, coarse = 0;  // gain by cause
        double pixelM = 0, blurPx = 0, detailM = 0;
        double unseenShare = 0, fewShare = 0;  // of the area: in no picture; in fewer than kEnoughViews
    };
    Reason reasonFor(const ImaginedShot& shot) const {
        Reason r;
        std::vector<WeightedValue> pixel, blur, detail;
        double area = 0, unseenArea = 0, fewArea = 0;
        for (size_t t = 0; t < map_.size(); ++t) {
            if (!(shot.pixelM[t] > 0) || !isOf(shot, t)) continue;
            const SeenTriangle& now = map_[t];
            const double gain = weightOf(t) * gainAt(shot, t);
            area += area_[t], fewArea += now.views < kEnoughViews ? area_[t] : 0;
            if (!now.seen()) {
                unseenArea += area_[t], r.missing += gain;
                continue;
            }
            pixel.push_back({now.pixelM, area_[t]}), blur.push_back({now.blurPx, area_[t]}), detail.push_back({now.detailM, area_[t]});
            // Of a gain in detail, the factor that blur costs is the blur's; the rest is the pixels'.
            SeenTriangle moreViews = now;
            moreViews.views += shot.views[t];
            const double byViews = weightOf(t) * (lackOf(now) - lackOf(moreViews)), byDetail = gain - byViews;
            const double blurs = std::min(byDetail, weightOf(t) * std::log2(now.detailM / std::max(1e-9f, now.pixelM)));
            r.missing += byViews, r.blurred += blurs, r.coarse += byDetail - blurs;
        }
        r.pixelM = weightedMedian(pixel), r.blurPx = weightedMedian(blur), r.detailM = weightedMedian(detail);
        r.unseenShare = unseenArea / std::max(1e-12, area), r.fewShare = fewArea / std::max(1e-12, area);
        return r;
    }

    /** "; the face at 0.9": the best place, where it is clearly better. */
    std::string comparison(const ImaginedShot& shot, double detailM) const {
        const PlaceFigures* best = nullptr;
        for (const PlaceFigures& place : out_.places)
            if (place.detailM > 0 && std::find(shot.of.begin(), shot.of.end(), place.place) == shot.of.end() &&
                (!best || place.detailM < best->detailM))
                best = &place;
        if (!best || best->detailM * 1.3 > detailM) return "";
        return formatText("; {} at {}", wordsOf(best->place).name, millimetres(best->detailM));
    }

    std::string sentence(const ImaginedShot& shot) const {
        const Reason r = reasonFor(shot);
        const char *it = shot.plural ? "they are" : "it is", *its = shot.plural ? "their" : "its";
        if (3 * r.blurred >= r.missing + r.blurred + r.coarse)  // said early: filmed in the same way it would be blurred again
            return formatText("{}, slower or in more light: {} pictures are blurred by {} px, so no detail below {} mm shows", shot.action,
                              shot.of.empty() ? "the" : its, oneDigit(r.blurPx), millimetres(r.detailM));
        if (r.missing >= r.coarse) {
            if (r.unseenShare > 0.05)
                return formatText("{}: {} of what shows there is in no still picture", shot.action, percent(r.unseenShare));
            return formatText("{}: {} of what shows there is seen straight on in fewer than {} still pictures", shot.action,
                              percent(r.fewShare), kEnoughViews);
        }
        if (shot.of.empty())
            return formatText("{}: the body is seen at {} mm a pixel, and {} would show there", shot.action, millimetres(r.pixelM),
                              millimetres(shot.typicalPixelM()));
        return formatText("{}: {} seen at {} mm a pixel{}", shot.action, it, millimetres(r.pixelM), comparison(shot, r.detailM));
    }
};

}  // namespace

FilmAgain bestShots(const MeshData& surface, std::span<const JointData> joints, std::span<const BodyPlace> places,
                    std::span<const SeenTriangle> map, std::span<const PosedPicture> pictures, Jobs& jobs) {
    return Coach(surface, places, map, imagineShots(surface, joints, places, pictures, jobs)).run();
}

std::string describeShots(const FilmAgain& advice) {
    if (advice.shots.empty()) {
        std::string text = "Nothing needs to be filmed again";
        const char* before = ": ";
        for (const PlaceFigures& p : advice.places)
            if (p.place == BodyPlace::Face || p.place == BodyPlace::LeftHand || p.place == BodyPlace::RightHand ||
                p.place == BodyPlace::Chest || p.place == BodyPlace::Back)
                text += formatText("{}{} {} mm", std::exchange(before, ", "), wordsOf(p.place).name, millimetres(p.detailM));
        return text + "\n";
    }
    std::string text = "What to film again, the most helpful first:\n";
    for (size_t i = 0; i < advice.shots.size(); ++i) text += formatText("  {}. {}\n", i + 1, advice.shots[i].sentence);
    return text;
}

}  // namespace dpl
