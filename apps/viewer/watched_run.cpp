// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/watched_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "apps/shared/pictures.h"
#include "apps/viewer/panels.h"
#include "apps/viewer/sample.h"

namespace dpl {
namespace {

constexpr double kTurnDegPerS = 20;

double unixS() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

Status takeAvatar(ViewerState& state, WatchedRun& run, LoadedFile& news) {
    DPL_TRY(ViewedSubject made, ViewedSubject::of(std::move(*news.avatar), news.file));
    made.path = std::move(news.path), made.comparable = news.comparable;
    const DplAvatar handle = made.avatar.handle();
    if (ViewedSubject* before = state.subjectOf(run.avatar)) {
        made.shown = before->shown, made.turnedDeg = news.run->finished ? 0 : before->turnedDeg, made.movedM = before->movedM;
        if (made.joints.size() == before->joints.size()) made.byHandDeg = before->byHandDeg;
        made.face.weights = before->face.weights, made.face.together = before->face.together, made.face.idles = before->face.idles;
        *before = std::move(made);
    } else {
        if (state.subjects.size() == DPL_MAX_TOGETHER)
            return fail(Code::InvalidArgument, "{}: not shown; at most {} avatars and splats can be drawn together. Remove one first",
                        news.file, DPL_MAX_TOGETHER);
        state.subjects.push_back(std::move(made));
        state.selected = state.subjects.size() - 1;
        state.wantsFrame = true;
    }
    run.avatar = handle, run.finished = news.run->finished;
    constexpr size_t kJointsOfAPerson = 12;
    if (const ViewedSubject* subject = state.subjectOf(handle);
        run.finished && subject->joints.size() >= kJointsOfAPerson &&
        std::none_of(subject->clips.begin(), subject->clips.end(), [](const ViewedSubject::Clip& clip) { return clip.name == kWalk; }))
        state.wantsWalk = handle;
    return {};
}

}  // namespace

Status takeRunNews(ViewerState& state, platform::Shell& shell, LoadedFile news) {
    if (news.asked) {  // another run, or the same anew
        dropRun(state, shell);
        state.run.emplace(WatchedRun{RunWatch(news.file)});
        state.run->folder = news.opened, state.run->request = std::move(news.request);
        if (state.coach.out == news.opened) state.run->coach = state.coach.words;
    }
    if (!state.run) return {};  // the last look of a run that was dropped meanwhile
    WatchedRun& run = *state.run;
    run.watch.hear(news.run->look, state.nowS, unixS());
    if (const auto& picture = news.run->heldBack) {
        shell.removePicture(run.heldBack.id);
        run.heldBack = {};
        const auto added = shell.addPicture(picture->pixels, picture->widthPx, picture->heightPx);
        if (!added) return fromSdk(added.error());
        run.heldBack = {*added, picture->widthPx, picture->heightPx};
        run.heldBackFrame = news.run->look.progress.heldBackFrame;
    }
    if (news.avatar) return takeAvatar(state, run, news);
    return {};
}

void dropRun(ViewerState& state, platform::Shell& shell) {
    if (state.run) shell.removePicture(state.run->heldBack.id);
    state.run.reset();
}

void turnRun(ViewerState& state, double seconds) {
    if (!state.run || state.run->finished || !state.run->turns) return;
    if (ViewedSubject* subject = state.subjectOf(state.run->avatar))
        subject->turnedDeg = float(std::remainder(subject->turnedDeg + kTurnDegPerS * seconds, 360));
}

std::vector<platform::PlacedPicture> picturesOfRun(const ViewerState& state, float width, float height, float scale) {
    const FreeSpan span = heldBackSpan(state, width);
    if (span.left >= span.right) return {};
    const ShownPicture& shown = state.run->heldBack;
    const float roomX = span.right - span.left, roomY = height - 2 * kHeldBackMargin;
    const float fit = std::min(roomX / float(shown.widthPx), roomY / float(shown.heightPx));
    if (!(fit > 0)) return {};
    const float halfX = 0.5f * fit * float(shown.widthPx), halfY = 0.5f * fit * float(shown.heightPx);
    const float x = 0.5f * (span.left + span.right), y = 0.5f * height;
    return {{shown.id, scale * (x - halfX), scale * (y - halfY), scale * (x + halfX), scale * (y + halfY)}};
}

}  // namespace dpl
