// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/observe/person_places.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

namespace dpl {
namespace {

PersonCrop between(const PersonCrop& a, const PersonCrop& b, double share) {
    const double turn = std::remainder(b.angleRad - a.angleRad, 2 * std::numbers::pi);
    return {a.centrePx + share * (b.centrePx - a.centrePx), a.sidePx + share * (b.sidePx - a.sidePx), a.angleRad + share * turn};
}
PersonBox between(const PersonBox& a, const PersonBox& b, double share) {
    return {a.low + share * (b.low - a.low), a.high + share * (b.high - a.high)};
}

}  // namespace

void choosePlaces(const Scan& scan, std::span<const size_t> order, std::span<const PersonPoint> points, std::vector<Whereabouts>& where) {
    std::vector<PeopleOfFrame> frames;
    std::vector<size_t> training, places;
    for (size_t i = 0; i < order.size(); ++i) {
        const ScanFrame& frame = scan.frames[order[i]];
        if (frame.split == Split::Test) continue;
        PeopleOfFrame people{Vec2d(frame.camera.widthPx, frame.camera.heightPx), where[order[i]].people, {}};
        for (const PersonPoint& point : points)
            if (point.frame == frame.name) people.pointPx = point.px;
        frames.push_back(people), training.push_back(order[i]), places.push_back(i);
    }
    const std::vector<size_t> chosen = choosePerson(frames);
    for (size_t k = 0; k < training.size(); ++k) where[training[k]].chosen = chosen[k];
    // What the nearest training frames before and after a place say.
    const auto seenAt = [&](size_t k) -> const SeenPerson& { return where[training[k]].people[where[training[k]].chosen]; };
    for (size_t i = 0; i < order.size(); ++i) {
        Whereabouts& here = where[order[i]];
        if (here.chosen != kNobody) {
            here.start = here.people[here.chosen].crop;
            continue;
        }
        size_t before = kNobody, after = kNobody;
        for (size_t k = 0; k < training.size(); ++k) {
            if (where[training[k]].chosen == kNobody) continue;
            if (places[k] < i) before = k;
            if (places[k] > i && after == kNobody) after = k;
        }
        if (before == kNobody && after == kNobody) continue;
        if (before == kNobody) before = after;
        if (after == kNobody) after = before;
        const double share = before == after ? 0 : double(i - places[before]) / double(places[after] - places[before]);
        here.start = between(seenAt(before).crop, seenAt(after).crop, share);
        if (scan.frames[order[i]].split != Split::Test) continue;
        here.chosen = nearestPerson(here.people, between(seenAt(before).box, seenAt(after).box, share));
        if (here.chosen != kNobody) here.start = here.people[here.chosen].crop;
    }
}

std::string placesJson(const Scan& scan, const std::vector<Whereabouts>& where) {
    nlohmann::ordered_json frames = nlohmann::ordered_json::array();
    for (size_t f = 0; f < where.size(); ++f) {
        nlohmann::ordered_json boxes = nlohmann::ordered_json::array();
        for (const SeenPerson& person : where[f].people)
            boxes.push_back(
                {std::round(person.box.low.x), std::round(person.box.low.y), std::round(person.box.high.x), std::round(person.box.high.y)});
        frames.push_back({{"name", scan.frames[f].name}, {"boxes", boxes}});
        if (where[f].chosen != kNobody) frames.back()["chosen"] = where[f].chosen;
    }
    return frames.dump(1) + "\n";
}

std::string describePlaces(const Scan& scan, const std::vector<Whereabouts>& where) {
    size_t several = 0, without = 0, looked = 0, example = kNobody;
    for (size_t f = 0; f < where.size(); ++f) {
        if (!scan.frames[f].maskPath.empty()) continue;
        ++looked;
        several += where[f].people.size() > 1;
        if (where[f].people.size() > 1 && where[f].chosen != kNobody && example == kNobody) example = f;
        without += where[f].chosen == kNobody;
    }
    std::string text;
    if (example != kNobody) {
        const PersonBox& box = where[example].people[where[example].chosen].box;
        text = formatText(
            "{} of {} pictures show several people. The scan is of the one who is at {},{} in {}; --person FRAME:X,Y chooses another",
            several, looked, std::lround((box.low.x + box.high.x) / 2), std::lround((box.low.y + box.high.y) / 2),
            scan.frames[example].name);
    }
    if (without > 0)
        text += formatText("{}The person was not found at first sight in {} of {} pictures", text.empty() ? "" : ". ", without, looked);
    return text;
}

}  // namespace dpl
