// SPDX-License-Identifier: Apache-2.0
// What the panels show and change. The viewer reads it every frame.
#pragma once

#include <algorithm>
#include <map>

#include "apps/viewer/comparison.h"
#include "apps/viewer/dressing.h"
#include "apps/viewer/exports.h"
#include "apps/viewer/focus.h"
#include "apps/viewer/folder_list.h"
#include "apps/viewer/messages.h"
#include "apps/viewer/orbit_camera.h"
#include "apps/viewer/overlays.h"
#include "apps/viewer/playback.h"
#include "apps/viewer/run_starter.h"
#include "apps/viewer/run_watch.h"
#include "apps/viewer/settings.h"
#include "apps/viewer/subject.h"
#include "platform/common/room_mesh.h"

namespace dpl {

/** Figures of the last frames, refreshed a few times a second so that they can be read. */
struct Figures {
    DplFrameStats stats{};
    std::vector<std::pair<std::string, double>> passesMs;  // rounds of a pass added up
    double framesPerSecond = 0;
};

/** A picture in the window. */
struct ShownPicture {
    uint32_t id = 0;  // of Shell::addPicture; 0: none
    uint32_t widthPx = 0, heightPx = 0;
};

/** The run that is watched. */
struct WatchedRun {
    RunWatch watch;
    DplAvatar avatar = nullptr;  // the subject that shows it; NULL: there is none yet
    bool finished = false;       // that is the finished avatar
    bool turns = true;           // slowly, until it is finished
    ShownPicture heldBack;
    std::string heldBackFrame;
    std::filesystem::path folder;
    std::optional<NewRun> request;  // with which it goes on; nothing: the viewer has not begun it
    std::string coach;              // what the coach said of its film, or ""
    std::future<Status> stopping;   // valid while it is being asked to stop
    bool stops = false;             // the same, for the panel
};

/** What the coach said last, and of the film of which run. */
struct CoachSaid {
    std::filesystem::path out;
    std::string words;
};

/** The avatar that is compared with the photographs of its scan. */
struct ComparedAvatar {
    DplAvatar avatar = nullptr;
    std::filesystem::path file, scan;  // as in CompareTask
    std::string firstFrame;            // its name; empty: any
    Comparison comparison;
    ShownPicture photo, drawn, error;  // of the frame that was drawn last
    double db = 0;
    bool masked = false;
    std::string problem;  // why that frame has no pictures, or ""
};

/** How far an export is. */
struct ExportProgress {
    std::string words;
    double share = 0;
};

/** The window that exports. */
struct ExportWindow {
    bool open = false;
    ExportKind kind = ExportKind::Picture;
    std::string here;  // where files go as long as settings.exports is empty
    std::optional<ExportProgress> running;
    std::string told;  // how the last export ended
};

/** The window that chooses a file. */
struct OpenWindow {
    FolderList list;
    bool waits = true;  // for another list
};

struct ViewerState {
    std::vector<ViewedSubject> subjects;
    size_t selected = 0;  // of subjects, where there is one
    Playback playback;
    OrbitCamera camera;
    std::optional<platform::RoomLight> room = platform::RoomLight::Dark;
    std::string axes;                             // of files, of kAxesNames; empty: as they state
    float splatsPerPixel = 0, frameBudgetMs = 0;  // 0: off
    float magnification = 8;                      // of the scan's finest details, at most; 0: no limit
    bool keptAway = false;                        // the limit holds the camera back in this frame
    bool panels = true, help = false, log = false;
    std::unique_ptr<RunStarter> starter;  // NULL: no run is being begun
    CoachSaid coach;
    std::optional<WatchedRun> run;
    std::optional<ComparedAvatar> compared;
    std::optional<OpenWindow> open;
    ExportWindow exports;
    Outfit outfit{};         // what the selected avatar is to put on
    std::string faceSearch;  // among the sliders of a face
    Overlay overlay = Overlay::None;
    OverlayShapes weak;  // of the selected avatar in this frame
    ViewerSettings settings;
    double nowS = 0;  // the viewer's clock in this frame
    Messages messages;
    Figures figures;
    std::string rendererName, atHand;  // atHand: what is being loaded, or ""

    // Wishes of the user, which the viewer fulfils and takes back.
    std::optional<ExportKind> wantsExport;
    bool wantsDress = false;      // the selected avatar, in the outfit
    bool wantsExportEnd = false;  // of the one that is running
    bool wantsSample = false, wantsOpenWindow = false, wantsFrame = false, wantsRoom = false,
         wantsKeptRoom = false;                                         // wantsRoom: it is to be built anew around the subjects
    std::optional<std::string> wantsOpen, wantsFolder;                  // a file; a folder to be listed
    bool wantsCompare = false, wantsCompareEnd = false;                 // of the selected avatar, which is comparable
    bool wantsLook = false, wantsRun = false, wantsStarterEnd = false;  // of the starter: the coach; the run; one step back, or none
    bool wantsRunStop = false, wantsRunContinue = false;                // of the run that is watched
    std::optional<DplAvatar> wantsWalk;                                 // an avatar that is to walk
    std::optional<size_t> wantsRemoval;
    std::optional<SeenPart> wantsPart;                 // of the selected avatar, to be seen from near
    std::optional<std::optional<uint32_t>> wantsClip;  // for the selected avatar; within: nothing is the rest pose

    ViewedSubject* subjectOf(DplAvatar avatar) {
        for (ViewedSubject& subject : subjects)
            if (avatar && subject.avatar.handle() == avatar) return &subject;
        return nullptr;
    }
    ViewedSubject* chosen() { return selected < subjects.size() ? &subjects[selected] : nullptr; }
    /** Whose clip the bar and videos go by: the selected one's, or else that of the first that is seen to play one. NULL: nobody plays. */
    const ViewedSubject* player() {
        if (const ViewedSubject* one = chosen(); one && one->clip) return one;
        const auto plays = [](const ViewedSubject& subject) { return subject.shown && subject.clip.has_value(); };
        const auto found = std::find_if(subjects.begin(), subjects.end(), plays);
        return found == subjects.end() ? nullptr : &*found;
    }
};

}  // namespace dpl
