// SPDX-License-Identifier: Apache-2.0
// The viewer: one window, its subjects and its frame loop. A script (screenshot, turntable) is the same loop with a fixed time step, which
// begins when all files are loaded.
#pragma once

#include <memory>

#include "apps/viewer/device_tries.h"
#include "apps/viewer/exporter.h"
#include "apps/viewer/library_log.h"
#include "apps/viewer/loader.h"
#include "apps/viewer/opened_files.h"
#include "apps/viewer/options.h"
#include "apps/viewer/panels.h"
#include "apps/viewer/state.h"
#include "apps/viewer/timings.h"

namespace dpl {

class Viewer {
public:
    /** Opens the window. `timings` must live longer. */
    static Result<std::unique_ptr<Viewer>> create(const ViewerOptions& options, Timings& timings);
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    /** Runs until the window is closed or the script is done. Returns the exit code. A lost graphics device is opened again. An error: the
     *  window failed, or the device for good. */
    Result<int> run();

private:
    Viewer(const ViewerOptions& options, Timings& timings, std::unique_ptr<platform::Shell> shell);
    Status frame();
    Status recover(std::string why);
    Status reopenDevice();
    void tellReopened(const char* what);
    void takeFiles();
    void addSubject(LoadedFile loaded);
    void takeInput();
    void takeKey(int key);
    void escape();
    void dragWipe();
    void focusOn(float x, float y);
    void fulfilWishes();
    void advanceTime();
    Status arrange();
    Status frameAll();
    Status buildRoom();
    void frame(const WorldBox& box);
    FreeSpan freeNow() const;
    Camerad cameraNow() const;
    Status afterDraw(bool drawn, std::vector<uint8_t>& rgb);
    void refreshFigures();
    void findWeak();
    void findHidden(const ViewedSubject& subject);
    void takeHidden(LoadedFile news);
    void keepAway();
    void applyLimits();
    void report(const std::string& problem);
    platform::FrameContents contents();
    double nowS() const;
    bool scriptMayBegin() const { return waitingFor_ == 0 && settling_ == 0; }

    LibraryLog libraryLog_;  // first, so that it hears all
    const ViewerOptions options_;
    Timings& timings_;
    const std::unique_ptr<platform::Shell> shell_;
    std::unique_ptr<Loader> loader_;
    OpenedFiles opened_;
    ViewerState state_;  // its avatars are destroyed before the context

    const double startS_;  // of the steady clock
    double lastS_ = 0, figuresAtS_ = -1;
    uint64_t figuresAtFrame_ = 0;
    size_t waitingFor_ = 0;       // files that are not loaded yet
    bool framed_ = false;         // the camera was put before the first subject
    bool comparedFirst_ = false;  // --compare was heard
    bool rightHand_ = false;      // is the next that is looked at
    float detailSet_ = 0, budgetSet_ = 0;
    Exporter exporter_;
    OverlayMaker overlays_;
    std::optional<GateQuestion> gateAsked_;  // of the loader, which has not answered
    std::optional<HiddenNews> hidden_;       // its last answer
    DeviceTries deviceTries_;
    uint32_t settling_ = 2;  // frames that a script waits after loading, until panels have their sizes
    uint32_t scriptFrame_ = 0;
    bool done_ = false, failed_ = false;
};

}  // namespace dpl
