// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/new_runs.h"

#include "apps/viewer/sample.h"

namespace dpl {

using Step = RunStarter::Step;

Status offerRun(ViewerState& state, const std::vector<std::filesystem::path>& film) {
    if (state.starter && state.starter->step() != Step::Choosing)
        return fail(Code::InvalidArgument, "{}: not taken, because another film is being looked at; end that first",
                    film[0].filename().string());
    std::vector<std::filesystem::path> all;
    if (state.starter && isVideoName(film[0].string())) {
        const NewRun& chosen = state.starter->run;
        if (isVideoName(chosen.scan.string())) all.push_back(chosen.scan);
        for (const NewRun::Video& video : chosen.videos) all.push_back(video.file);
    }
    all.insert(all.end(), film.begin(), film.end());
    state.starter = std::make_unique<RunStarter>(newRunOf(all));
    return {};
}

namespace {

/** On a thread of its own: neither a slow disk nor what is being loaded may keep it waiting. */
Status followStop(ViewerState& state, bool wanted) {
    if (!state.run) return {};
    WatchedRun& run = *state.run;
    if (wanted && !run.stops) {
        run.stops = true;
        run.stopping = std::async(std::launch::async, [folder = run.folder] { return stopRun(folder); });
    }
    if (!run.stopping.valid() || run.stopping.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    Status asked = run.stopping.get();
    run.stops = false;
    if (asked) run.watch.knowStopped();
    return asked;
}

}  // namespace

Status fulfilRuns(ViewerState& state) {
    const bool look = std::exchange(state.wantsLook, false), begin = std::exchange(state.wantsRun, false),
               stop = std::exchange(state.wantsRunStop, false), goOn = std::exchange(state.wantsRunContinue, false);
    if (std::exchange(state.wantsStarterEnd, false) && state.starter) {
        if (state.starter->step() == Step::Choosing)
            state.starter.reset();
        else
            state.starter->back();
    }
    DPL_RETURN_IF_ERROR(followStop(state, stop));
    if (goOn && state.run && state.run->request && !state.starter) state.starter = std::make_unique<RunStarter>(*state.run->request);
    if (state.starter && (look || begin || goOn)) {
        DPL_TRY(const std::filesystem::path program, doppelProgram());
        if (look)
            state.starter->look(program);
        else
            state.starter->begin(program);
    }
    if (!state.starter) return {};
    state.starter->tick();
    if (state.starter->step() != Step::Started) return {};
    const std::filesystem::path out = state.starter->run.out;
    state.coach = {out, state.starter->coach().advice};
    state.starter.reset();
    if (state.run && state.run->folder == out)
        state.run->coach = state.coach.words;
    else
        state.wantsOpen = out.string();
    return {};
}

}  // namespace dpl
