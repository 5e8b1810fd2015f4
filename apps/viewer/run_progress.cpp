// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/run_progress.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "reconstruction/base/json_fields.h"
#include "reconstruction/base/time_words.h"

namespace dpl {
namespace {

constexpr double kMost = 1e12;  // of counts and seconds: more is damage

Result<double> count(const JsonFields& fields, const char* key) {
    DPL_TRY(const double value, fields.number(key, 0));
    if (value < 0 || value > kMost)
        return fail(Code::CorruptData, "{}: '{}' is out of range; the run writes the file again", fields.where(), key);
    return value;
}

Result<std::string> text(const JsonFields& fields, const char* key) {
    DPL_TRY(std::string value, fields.text(key, ""));
    if (value.size() <= RunProgress::kMostText) return value;
    size_t cut = RunProgress::kMostText;
    while (cut > 0 && (uint8_t(value[cut]) & 0xc0) == 0x80) --cut;  // whole characters
    return value.substr(0, cut) + " ...";
}

Result<RunProgress::State> stateOf(const JsonFields& fields) {
    DPL_TRY(const std::string name, fields.text("state"));
    if (name == "running") return RunProgress::State::Running;
    if (name == "done") return RunProgress::State::Done;
    if (name == "stopped") return RunProgress::State::Stopped;
    if (name == "failed") return RunProgress::State::Failed;
    return fail(Code::CorruptData, "{}: the state '{}' is not known; the run writes the file again", fields.where(), name.substr(0, 40));
}

Status readCurve(const JsonFields& fields, std::vector<RunProgress::Point>& curve) {
    if (!fields.has("curve")) return {};
    DPL_TRY(const nlohmann::json* points, fields.array("curve"));
    if (points->size() > RunProgress::kMostPoints)
        return fail(Code::CorruptData, "{}: a curve of {} points; the run writes the file again", fields.where(), points->size());
    for (const nlohmann::json& point : *points) {
        if (!point.is_array() || point.size() < 2 || !point[0].is_number() || !point[1].is_number())
            return fail(Code::CorruptData, "{}: a point of the curve is damaged; the run writes the file again", fields.where());
        const double step = point[0].get<double>(), db = point[1].get<double>();
        if (std::isfinite(step) && std::isfinite(db)) curve.push_back({std::clamp(step, 0.0, kMost), std::clamp(db, -1000.0, 1000.0)});
    }
    return {};
}

/** An object of the file, or null where it is absent. */
Result<const nlohmann::json*> object(const nlohmann::json& in, const JsonFields& fields, const char* key) {
    static const nlohmann::json kNone;
    if (!fields.has(key)) return &kNone;
    const nlohmann::json& value = in[key];
    if (!value.is_object()) return fail(Code::CorruptData, "{}: '{}' is damaged; the run writes the file again", fields.where(), key);
    return &value;
}

}  // namespace

Result<RunProgress> parseRunProgress(std::string_view bytes, const std::string& where) {
    if (bytes.size() > RunProgress::kMostBytes) return fail(Code::CorruptData, "{}: {} bytes, more than a run writes", where, bytes.size());
    DPL_TRY(const nlohmann::json file, parseJsonObject(bytes, where));
    const JsonFields fields(file, where);
    DPL_TRY(const std::string format, fields.text("format"));
    if (format != "doppel-progress") return fail(Code::CorruptData, "{}: this is no progress.json of doppel reconstruct", where);
    DPL_TRY(const double version, fields.number("version"));
    if (version != 1) return fail(Code::Version, "{}: version {}, and this viewer reads version 1; update it", where, version);
    RunProgress p;
    DPL_TRY(p.state, stateOf(fields));
    DPL_TRY(p.sentence, text(fields, "sentence"));
    DPL_TRY(p.startedUnixS, count(fields, "started_unix_s"));
    DPL_TRY(p.unixS, count(fields, "unix_s"));
    DPL_TRY(p.beat, count(fields, "beat"));
    DPL_TRY(p.seconds, count(fields, "seconds"));
    DPL_TRY(p.words, text(fields, "words"));
    DPL_TRY(p.detail, text(fields, "detail"));
    DPL_TRY(const double share, count(fields, "share"));
    p.share = std::min(share, 1.0);
    DPL_TRY(const double place, count(fields, "place"));
    DPL_TRY(const double places, count(fields, "places"));
    p.places = uint32_t(std::min(places, 1000.0)), p.place = uint32_t(std::min(place, double(p.places)));
    if (fields.has("seconds_left")) {
        DPL_TRY(p.secondsLeft, count(fields, "seconds_left"));
    }
    if (fields.has("run_seconds_left")) {
        DPL_TRY(p.runSecondsLeft, count(fields, "run_seconds_left"));
    }
    DPL_TRY(p.steps, count(fields, "steps"));
    DPL_RETURN_IF_ERROR(readCurve(fields, p.curve));
    DPL_TRY(const nlohmann::json* heldBack, object(file, fields, "held_back"));
    if (heldBack->is_object()) {
        const JsonFields of(*heldBack, where);
        DPL_TRY(p.heldBackFrame, text(of, "frame"));
        DPL_TRY(p.heldBackPicture, text(of, "picture"));
    }
    DPL_TRY(const nlohmann::json* avatar, object(file, fields, "avatar"));
    if (avatar->is_object()) {
        const JsonFields of(*avatar, where);
        DPL_TRY(p.avatar, text(of, "file"));
        DPL_TRY(p.avatarStep, count(of, "step"));
        DPL_TRY(p.avatarChange, count(of, "change"));
    }
    return p;
}

std::string wordsOfTheRest(const RunProgress& progress) {
    if (progress.place == 0) return {};
    const uint32_t behind = progress.places - progress.place;
    if (behind == 0) return "This is the last part of the run.";
    if (progress.runSecondsLeft) {
        std::string text = wordsOfRunLeft(*progress.runSecondsLeft);
        text[0] = char(std::toupper(uint8_t(text[0])));
        return text + ".";
    }
    if (behind == 1) return "One more part comes after this one; how long it takes is not known yet.";
    return formatText("{} more parts come after this one; how long they take is not known yet.", behind);
}

}  // namespace dpl
