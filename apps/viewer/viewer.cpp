// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/viewer.h"

#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <thread>
#include <utility>

#include "apps/shared/pictures.h"
#include "apps/viewer/compared_avatar.h"
#include "apps/viewer/export_panel.h"
#include "apps/viewer/help_panel.h"
#include "apps/viewer/log_panel.h"
#include "apps/viewer/messages_panel.h"
#include "apps/viewer/new_runs.h"
#include "apps/viewer/open_panel.h"
#include "apps/viewer/overlay_panel.h"
#include "apps/viewer/room_plan.h"
#include "apps/viewer/watched_run.h"
#include "reconstruction/base/sdk_camera.h"

namespace dpl {
namespace {

/** Where self-tests of drivers are kept between runs; empty if there is no such folder. */
std::string cacheFolder() {
    const char *cache = std::getenv("XDG_CACHE_HOME"), *home = std::getenv("HOME");
    if ((!cache || !*cache) && (!home || !*home)) return {};
    const std::filesystem::path folder =
        (cache && *cache ? std::filesystem::path(cache) : std::filesystem::path(home) / ".cache") / "doppel";
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    return error ? "" : folder.string();
}

std::optional<platform::RoomLight> roomOf(const std::string& name) {
    if (name == "none") return std::nullopt;
    return name == "bright" ? platform::RoomLight::Bright : platform::RoomLight::Dark;
}

platform::ShellInfo shellInfo(const ViewerOptions& options, Timings& timings) {
    platform::ShellInfo info;
    info.title = "Doppel";
    info.widthPx = options.size.widthPx, info.heightPx = options.size.heightPx;
    info.fixedPicture = options.isScript();
    info.validation = options.validation;
    info.scale = options.scale;
    info.onStep = [&timings](const char* step) { timings.mark(step); };
    return info;
}

/** How far to the right general splats go so that they stand beside the others: files give them places and sizes of their own. */
float besideM(const std::vector<ViewedSubject>& others, const ViewedSubject& splats) {
    constexpr double kGapM = 0.3;
    return others.empty() ? 0 : float(boxOf(others).high.x + kGapM - splats.box().low.x);
}

Status ofShell(const doppel::Status& status) {
    return status ? Status() : fromSdk(status.error());
}

/** Seconds of a clock that never goes back. */
double steadyS() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/** Between two tries to open a lost device. */
void awaitDriver(const std::string& why) {
    constexpr std::chrono::seconds kPause{2};  // a driver that restarts needs a moment
    std::fprintf(stderr, "doppel-viewer: the graphics device was lost and cannot be opened again yet: %s\n", why.c_str());
    std::this_thread::sleep_for(kPause);
}

Error lostForGood(const std::string& why, const char* kept) {
    return fail(Code::Device, "the graphics device was lost {} times within a minute: {}. {}start again", DeviceTries::kMost, why, kept);
}

}  // namespace

Result<std::unique_ptr<Viewer>> Viewer::create(const ViewerOptions& options, Timings& timings) {
    DeviceTries tries;
    bool lost = false;
    auto shell = platform::Shell::create(shellInfo(options, timings), [&](const platform::Error& why) {
        if (!tries.take(steadyS())) return false;
        if (std::exchange(lost, true)) awaitDriver(why.message);
        return true;
    });
    if (!shell && shell.error().code == DPL_ERROR_DEVICE) return lostForGood(shell.error().message, "");
    if (!shell) return fromSdk(shell.error());
    std::unique_ptr<Viewer> made(new Viewer(options, timings, std::move(*shell)));
    made->deviceTries_ = std::move(tries);
    if (lost) made->tellReopened("The graphics device was lost at the start");
    return made;
}

Viewer::Viewer(const ViewerOptions& options, Timings& timings, std::unique_ptr<platform::Shell> shell)
    : options_(options), timings_(timings), shell_(std::move(shell)), startS_(steadyS()) {
    state_.room = roomOf(options.room);
    state_.axes = options.axes;
    state_.panels = !options.hidePanels;
    state_.magnification = options.magnification;
    state_.camera.setAzimuth(options.azimuthDeg * std::numbers::pi / 180);
}

Viewer::~Viewer() {
    shell_->hideWindow();
    (void)shell_->waitIdle();  // fails if the device is lost; then nothing runs on it
}

Result<int> Viewer::run() {
    while (!done_ && shell_->beginFrame()) {
        const Status framed = frame();
        if (framed) continue;
        if (framed.error().code != Code::Device) return framed.error();
        DPL_RETURN_IF_ERROR(recover(framed.error().message));
    }
    for (const std::string& complaint : shell_->complaints()) std::fprintf(stderr, "doppel-viewer: validation: %s\n", complaint.c_str());
    return failed_ || !shell_->complaints().empty() ? 1 : 0;
}

/** Opens the lost device again. why: what said that it is lost. An error: it cannot be done, and what is to be kept is kept. */
Status Viewer::recover(std::string why) {
    while (deviceTries_.take(steadyS())) {
        const Status opened = reopenDevice();
        if (opened) {
            tellReopened("The graphics device was lost");
            return {};
        }
        why = opened.error().message;
        awaitDriver(why);
    }
    opened_.keep(state_.settings);
    return lostForGood(why, "Settings are kept, and runs go on; ");
}

void Viewer::tellReopened(const char* what) {
    const std::string told = std::string(what) + " and is open again (" + shell_->deviceName() + "); everything goes on.";
    std::fprintf(stderr, "doppel-viewer: %s\n", told.c_str());
    state_.messages.info(told, nowS());
}

Status Viewer::reopenDevice() {
    if (loader_) loader_->awaitContext();
    DPL_RETURN_IF_ERROR(ofShell(shell_->rebuild()));
    if (loader_) DPL_RETURN_IF_ERROR(loader_->moveContext());
    shell_->forgetLostDevice();
    return {};
}

double Viewer::nowS() const {
    return steadyS() - startS_;
}

void Viewer::report(const std::string& problem) {
    std::fprintf(stderr, "doppel-viewer: %s\n", problem.c_str());
    state_.messages.error(problem);
    if (options_.isScript()) failed_ = done_ = true;
}

Status Viewer::frame() {
    state_.nowS = nowS();
    if (loader_ && loader_->lost()) return fail(Code::Device, "the graphics device was lost");
    if (loader_) takeFiles();
    takeInput();
    fulfilWishes();
    advanceTime();
    DPL_RETURN_IF_ERROR(arrange());
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    state_.messages.tick(nowS());
    for (const LibraryLog::Line& line : libraryLog_.take()) state_.messages.note(line.text, line.warning);
    if (!state_.compared) drawOverlay(state_, cameraNow(), ImGui::GetIO().DisplayFramebufferScale.x);
    if (!exporter_.records()) {
        if (state_.panels) drawPanels(state_, size.x, size.y);
        drawHelp(state_, size.x, size.y);
        drawOpen(state_, size.x, size.y);
        drawExport(state_, size.x, size.y);
        drawLog(state_, size.x, size.y);
    }
    drawExportProgress(state_, size.x);
    drawMessages(state_, size.x, size.y);

    platform::FrameContents what = contents();
    std::vector<uint8_t> rgb;
    const bool scripted = options_.isScript() && scriptMayBegin() && !options_.screenshot.empty();
    if (scripted) what.panels = !options_.hidePanels;
    what.rgbPanels = !exporter_.wantsPicture();
    if (exporter_.wantsPicture() || (scripted && scriptFrame_ + 1 == options_.frames)) what.rgb = &rgb;
    if (exporter_.wantsCutOut())
        if (const Status saved = exporter_.drawCutOut(state_, what.view, what.context); !saved) {
            if (saved.error().code == Code::Device) return saved;
            report(saved.error().message);
        }
    const uint64_t before = shell_->shown();
    const auto drawn = shell_->draw(what);
    if (!drawn) return fromSdk(drawn.error());
    if (!drawn->empty()) report(*drawn);
    return afterDraw(shell_->shown() > before, rgb);
}

FreeSpan Viewer::freeNow() const {
    const float width = ImGui::GetIO().DisplaySize.x;
    return exporter_.wantsPicture() || exporter_.wantsCutOut() ? FreeSpan{0, width} : freeSpan(state_, width);
}

Camerad Viewer::cameraNow() const {
    const VkExtent2D size = shell_->picturePx();
    const FreeSpan free = freeNow();
    return state_.camera.camera(size.width, size.height, 0.5 * (free.left + free.right) * ImGui::GetIO().DisplayFramebufferScale.x);
}

platform::FrameContents Viewer::contents() {
    platform::FrameContents what;
    what.view = sdkCamera(cameraNow().cast<float>());
    what.room = state_.room;
    if (const auto doppel = loader_ ? loader_->doppel() : std::nullopt) what.context = doppel->context, what.composer = doppel->composer;
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    if (state_.compared) {
        what.room.reset();
        for (platform::PlacedPicture placed : placesOfComparison(state_, size.x, size.y).pictures) {
            for (float* edge : {&placed.left, &placed.top, &placed.right, &placed.bottom})
                *edge *= ImGui::GetIO().DisplayFramebufferScale.x;
            what.pictures.push_back(placed);
        }
        return what;
    }
    if (!exporter_.wantsPicture()) what.pictures = picturesOfRun(state_, size.x, size.y, ImGui::GetIO().DisplayFramebufferScale.x);
    for (const ViewedSubject& subject : state_.subjects) {
        if (!subject.shown) continue;
        what.avatars.push_back(subject.avatar.handle());
        if (!state_.room || !subject.isAvatar()) continue;
        const auto shadow = subject.avatar.contactShadow();
        if (shadow)
            what.shadows.push_back(*shadow);
        else
            report(subject.file + ": " + shadow.error().message);
    }
    return what;
}

void Viewer::takeFiles() {
    std::vector<std::string> dropped = shell_->takeDropped();
    const ViewedSubject* chosen = state_.chosen();
    for (std::string& path : dropped) {
        // A motion that comes with other files belongs to the avatar among them.
        const DplAvatar motionOf = dropped.size() == 1 && chosen && chosen->isAvatar() ? chosen->avatar.handle() : nullptr;
        loader_->load(std::move(path), motionOf);
        ++waitingFor_;
    }
    if (state_.rendererName.empty())
        if (const auto doppel = loader_->doppel()) {
            timings_.mark("Doppel's context and pipelines");
            const char* name = "";
            if (dplGetRendererName(doppel->context, &name) == DPL_OK) state_.rendererName = name;
        }
    for (LoadedFile& file : loader_->take()) {
        if (file.hidden) {
            takeHidden(std::move(file));
            continue;
        }
        if (opened_.take(state_, file, nowS())) continue;
        opened_.remember(state_, file);
        if (!file.file.empty() && file.asked) --waitingFor_;
        if (file.compared) {
            if (const Status taken = takeCompared(state_, *shell_, std::move(file)); !taken) report(taken.error().message);
            if (options_.isScript() && state_.compared && !state_.compared->problem.empty()) report(state_.compared->problem);
        } else if (!file.error.empty()) {
            report(file.error);
        } else if (!file.film.empty() || (!file.scan.empty() && !(state_.chosen() && state_.chosen()->comparable))) {
            if (const Status offered = offerRun(state_, {file.film.empty() ? file.scan : file.film}); !offered)
                report(offered.error().message);
        } else if (!file.scan.empty()) {
            if (const Status begun = beginComparing(state_, *shell_, file.scan, {}); !begun) report(begun.error().message);
        } else if (file.run) {
            if (const Status taken = takeRunNews(state_, *shell_, std::move(file)); !taken) report(taken.error().message);
        } else if (file.avatar) {
            addSubject(std::move(file));
            timings_.mark("first file loaded");
        } else {
            for (ViewedSubject& subject : state_.subjects)
                if (subject.avatar.handle() == file.clipOf)
                    if (const Status taken = subject.takeNewClip(file.clipFrom); !taken) report(taken.error().message);
        }
    }
    state_.atHand = loader_->atHand();
}

void Viewer::addSubject(LoadedFile loaded) {
    const std::string& file = loaded.file;
    if (state_.subjects.size() == DPL_MAX_TOGETHER)
        return report(
            formatText("{}: not shown; at most {} avatars and splats can be drawn together. Remove one first", file, DPL_MAX_TOGETHER));
    auto made = ViewedSubject::of(std::move(*loaded.avatar), file);
    if (!made) return report(file + ": " + made.error().message);
    made->path = loaded.path, made->comparable = loaded.comparable;
    if (!options_.clip.empty() && made->isAvatar()) {
        const auto clip = chooseClip(made->avatar, options_.clip, options_.animation);
        if (!clip) return report(clip.error().message);
        std::error_code error;
        const auto from = made->clips.size() == *clip ? std::filesystem::absolute(options_.clip, error) : std::filesystem::path();
        if (const Status taken = made->takeNewClip(from); !taken) return report(taken.error().message);
        made->clip = *clip;
    }
    if (!made->axes.stated && state_.axes.empty())
        state_.messages.info(file + ": no up axis stated; if it stands wrong, choose another under Picture", nowS());
    if (state_.subjects.empty() && options_.room == "auto" && state_.settings.room.empty() && !made->isAvatar()) state_.room.reset();
    made->upright = uprightFromLoaded(state_.axes, loadedFromFile(made->axes));
    if (!made->isAvatar()) made->movedM.x = besideM(state_.subjects, *made);
    state_.subjects.push_back(std::move(*made));
    state_.selected = state_.subjects.size() - 1;
    state_.wantsFrame = true;
}

void Viewer::fulfilWishes() {
    if (state_.wantsRemoval && *state_.wantsRemoval < state_.subjects.size()) {
        if (state_.run && state_.subjects[*state_.wantsRemoval].avatar.handle() == state_.run->avatar) {
            dropRun(state_, *shell_);
            loader_->stopWatching();
        }
        state_.subjects.erase(state_.subjects.begin() + ptrdiff_t(*state_.wantsRemoval));
        state_.wantsFrame = true;
        if (state_.selected > 0 && state_.selected >= *state_.wantsRemoval) --state_.selected;
    }
    if (ViewedSubject* chosen = state_.chosen()) {
        if (state_.wantsClip) chosen->play(*state_.wantsClip, nowS());
        if (state_.wantsPart) {
            if (const auto box = boxOfPart(*chosen, *state_.wantsPart))
                frame(*box);
            else
                state_.messages.info(chosen->file + " has no joint that is known as this part of a body", nowS());
        }
    }
    if (state_.compared && !state_.subjectOf(state_.compared->avatar)) state_.wantsCompareEnd = true;  // it was removed, or replaced
    if (state_.wantsCompareEnd) endComparing(state_, *shell_);
    const bool first = !options_.compare.empty() && !comparedFirst_ && state_.chosen() && state_.chosen()->comparable;
    if (state_.wantsCompare || first)
        if (const Status begun = beginComparing(state_, *shell_, {}, first ? options_.compare : ""); !begun) report(begun.error().message);
    comparedFirst_ |= first;
    if (auto task = comparisonToDraw(state_)) loader_->compare(std::move(*task)), ++waitingFor_;
    if (loader_) {
        if (const Status followed = fulfilRuns(state_); !followed) report(followed.error().message);
        waitingFor_ += opened_.fulfil(state_, *loader_);
        if (const auto avatar = std::exchange(state_.wantsWalk, std::nullopt)) loader_->loadWalk(*avatar), ++waitingFor_;
    }
    if (std::exchange(state_.wantsKeptRoom, false) && options_.room == "auto" && !state_.settings.room.empty())
        state_.room = roomOf(state_.settings.room);
    if (state_.wantsSample && loader_) loader_->loadSample(), ++waitingFor_;
    state_.wantsRemoval.reset(), state_.wantsClip.reset(), state_.wantsPart.reset();
    state_.wantsSample = state_.wantsCompare = state_.wantsCompareEnd = false;
    const VkExtent2D size = shell_->picturePx();
    if (!options_.turntable.empty() && scriptMayBegin() && !exporter_.records() && !done_)
        if (const Status begun =
                exporter_.beginVideo(state_, ExportKind::Turntable, options_.turntable, options_.frames, size.width, size.height, false);
            !begun)
            report(begun.error().message);
    if (const Status exported = exporter_.fulfil(state_, size.width, size.height); !exported) report(exported.error().message);
}

void Viewer::advanceTime() {
    const double now = nowS(), passed = now - lastS_;
    lastS_ = now;
    if (exporter_.records())
        exporter_.advance(state_);
    else if (options_.isScript())
        state_.playback.timeS = Exporter::kStepS * scriptFrame_;
    else
        state_.playback.advance(passed);
    if (!exporter_.records()) turnRun(state_, !options_.isScript() ? passed : scriptFrame_ > 0 ? Exporter::kStepS : 0);
}

Status Viewer::arrange() {
    const auto& subjects = state_.subjects;
    const std::vector<double> places =
        placesInRow(size_t(std::count_if(subjects.begin(), subjects.end(), [](const auto& subject) { return subject.isAvatar(); })));
    auto place = places.begin();
    for (ViewedSubject& subject : state_.subjects) {
        subject.upright = uprightFromLoaded(state_.axes, loadedFromFile(subject.axes));
        if (subject.isAvatar()) subject.asideM = *place++;
        if (const Status posed = subject.pose(state_.playback, lastS_); !posed) report(subject.file + ": " + posed.error().message);
    }
    findWeak();
    if (state_.wantsFrame || !framed_) DPL_RETURN_IF_ERROR(frameAll());
    if (state_.wantsRoom) DPL_RETURN_IF_ERROR(buildRoom());
    state_.wantsFrame = state_.wantsRoom = false;
    if (!options_.isScript() && !exporter_.records()) keepAway();
    applyLimits();
    return {};
}

/** What is weak in the pose of the selected avatar, where it is asked for. */
void Viewer::findWeak() {
    ViewedSubject* chosen = state_.chosen();
    state_.weak = {};
    if (!chosen || !chosen->shown || state_.overlay == Overlay::None) return;
    if (state_.overlay == Overlay::Hidden) return findHidden(*chosen);
    auto shapes = overlays_.shapes(*chosen, state_.overlay, state_.playback, lastS_);
    if (shapes)
        state_.weak = std::move(*shapes);
    else
        report(chosen->file + ": " + shapes.error().message), state_.overlay = Overlay::None;
}

/** The splats that the gate hides: the loader's last answer, and the next question once it has answered. */
void Viewer::findHidden(const ViewedSubject& subject) {
    if (!subject.isAvatar()) {
        state_.weak.words = "General splats show all their sides.";
        return;
    }
    if (hidden_ && hidden_->question.avatar == subject.avatar.handle()) {
        const HiddenSplats& splats = hidden_->splats;
        state_.weak.hidden = splats.places;
        state_.weak.words = formatText("{} of {} splats are hidden from here.", splats.hidden, splats.splats);
    }
    if (gateAsked_ || !loader_) return;
    auto question = gateQuestion(subject, cameraNow().eye());
    if (!question) return report(subject.file + ": " + question.error().message);
    if (hidden_ && hidden_->question == *question) return;
    gateAsked_ = *question;
    loader_->findHidden(std::move(*question));
}

void Viewer::takeHidden(LoadedFile news) {
    gateAsked_.reset();
    if (news.error.empty())
        hidden_ = std::move(news.hidden);
    else
        state_.messages.error(news.error), state_.overlay = Overlay::None;
}

/** Holds the camera where the scan still has details to show. */
void Viewer::keepAway() {
    state_.keptAway = false;
    if (!(state_.magnification > 0)) return;
    const VkExtent2D size = shell_->picturePx();
    const Camerad camera = state_.camera.camera(size.width, size.height, 0);
    const double nearest = nearestM(state_.subjects, state_.camera.middle(), camera.eye(), camera.fy, state_.magnification);
    state_.keptAway = nearest > 0 && state_.camera.distanceM() <= nearest * (1 + 1e-6);
    state_.camera.keepAway(nearest);
}

/** Puts the camera before a box, in what the panels leave free. */
void Viewer::frame(const WorldBox& box) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    if (size.x <= 0 || size.y <= 0) return;  // minimised
    const FreeSpan free = freeSpan(state_, size.x);
    state_.camera.frame(box, double(free.right - free.left) / double(size.y));
}

/** Puts the camera before all subjects, and the room around both. */
Status Viewer::frameAll() {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    if (size.x <= 0 || size.y <= 0) return {};
    frame(boxOf(state_.subjects));
    framed_ = true;
    return buildRoom();
}

Status Viewer::buildRoom() {
    return ofShell(shell_->buildRoom(roomAround(state_.subjects, boxOf(state_.subjects), state_.camera.distanceM())));
}

void Viewer::applyLimits() {
    const auto doppel = loader_ ? loader_->doppel() : std::nullopt;
    if (!doppel) return;
    if (detailSet_ != state_.splatsPerPixel) {
        DplDetail detail{};
        detail.structSize = sizeof detail, detail.splatsPerPixel = detailSet_ = state_.splatsPerPixel;
        if (dplSetDetail(doppel->context, &detail) != DPL_OK) report(dplGetLastError());
    }
    if (budgetSet_ != state_.frameBudgetMs && dplSetFrameBudget(doppel->context, budgetSet_ = state_.frameBudgetMs) != DPL_OK)
        report(dplGetLastError());
}

Status Viewer::afterDraw(bool drawn, std::vector<uint8_t>& rgb) {
    if (!drawn) return {};
    const VkExtent2D size = shell_->picturePx();
    const bool withSubjects = !state_.subjects.empty();
    if (options_.timings && shell_->shown() == 1) DPL_RETURN_IF_ERROR(ofShell(shell_->waitIdle()));
    timings_.mark("first picture: the room and the panels");
    if (options_.timings && withSubjects) DPL_RETURN_IF_ERROR(ofShell(shell_->waitIdle()));
    if (withSubjects) timings_.mark("first picture with a subject");
    if (!loader_) {  // only now, so that nothing competes with the first picture
        loader_ = std::make_unique<Loader>(*shell_, fillOf(options_.fill), cacheFolder());
        opened_.begin(*loader_, options_.isScript());
        for (const std::string& file : options_.files) loader_->load(file, nullptr);
        waitingFor_ = options_.files.size();
        return {};
    }
    refreshFigures();
    if (exporter_.wantsPicture()) {
        const auto last = exporter_.take(state_, rgb, size.width, size.height);
        if (!last) report(last.error().message);
        done_ |= last && *last && options_.isScript();
    }
    if (!options_.screenshot.empty() && scriptMayBegin() && !failed_) {
        if (!rgb.empty()) {
            if (const Status written = writeScreenshot(options_.screenshot, rgb, size.width, size.height); !written)
                report(written.error().message);
            done_ = true;
        }
        ++scriptFrame_;
    }
    if (waitingFor_ == 0 && settling_ > 0) --settling_;
    return {};
}

void Viewer::refreshFigures() {
    const double now = nowS();
    if (now - figuresAtS_ < 0.25) return;
    Figures figures;
    if (now > figuresAtS_) figures.framesPerSecond = double(shell_->shown() - figuresAtFrame_) / (now - figuresAtS_);
    figuresAtS_ = now, figuresAtFrame_ = shell_->shown();
    if (!state_.subjects.empty()) {
        const doppel::Avatar& first = state_.subjects[0].avatar;  // the picture belongs to it
        if (const auto stats = first.frameStats()) figures.stats = *stats;
        for (uint32_t i = 0; i < figures.stats.passCount; ++i)
            if (const auto pass = first.passTime(i)) {
                auto& passes = figures.passesMs;
                const auto same = std::find_if(passes.begin(), passes.end(), [&](const auto& p) { return p.first == pass->label; });
                if (same == passes.end())
                    passes.emplace_back(pass->label, pass->milliseconds);
                else
                    same->second += pass->milliseconds;
            }
    }
    state_.figures = std::move(figures);
}

}  // namespace dpl
