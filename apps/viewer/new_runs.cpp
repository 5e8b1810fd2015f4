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

Status fulfilRuns(ViewerState& state, Loader& loader) {
    const bool look = std::exchange(state.wantsLook, false), begin = std::exchange(state.wantsRun, false),
               stop = std::exchange(state.wantsRunStop, false), goOn = std::exchange(state.wantsRunContinue, false);
    if (std::exchange(state.wantsStarterEnd, false) && state.starter) {
        if (state.starter->step() == Step::Choosing)
            state.starter.reset();
        else
            state.starter->back();
    }
    if (stop && state.run) loader.stopRun(state.run->folder);
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
