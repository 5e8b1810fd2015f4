// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/loader.h"

#include <algorithm>
#include <chrono>
#include <functional>

#include "apps/shared/pictures.h"
#include "apps/viewer/file_kind.h"
#include "apps/viewer/sample.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

constexpr std::chrono::seconds kLookEvery{1};  // into a watched run

LoadedFile listed(const std::filesystem::path& folder) {
    LoadedFile out;
    out.asked = false;
    auto list = listFolder(folder);
    if (list) {
        out.folder = std::move(*list);
    } else {
        out.error = list.error().message;
        out.path = folder;
    }
    return out;
}

}  // namespace

Loader::Loader(platform::Shell& shell, DplFill fill, std::string cacheFolder)
    : shell_(shell), fill_(fill), cacheFolder_(std::move(cacheFolder)), thread_([this] { run(); }) {}

Loader::~Loader() {
    {
        std::lock_guard lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Loader::load(std::string path, DplAvatar motionOf) {
    add({std::move(path), motionOf});
}

void Loader::loadSample() {
    add({"the sample avatar", nullptr, true});
}

void Loader::loadWalk(DplAvatar avatar) {
    add({.path = "a walk", .walks = avatar});
}

void Loader::add(Task task) {
    {
        std::lock_guard lock(mutex_);
        tasks_.push_back(std::move(task));
    }
    changed_.notify_all();
}

void Loader::compare(CompareTask task) {
    add({.path = {}, .compare = std::move(task)});
}

void Loader::list(std::filesystem::path folder) {
    std::erase_if(lists_, [](const auto& made) { return made.wait_for(std::chrono::seconds(0)) == std::future_status::ready; });
    lists_.push_back(std::async(std::launch::async, [this, folder = std::move(folder), number = ++lastList_] {
        LoadedFile found = listed(folder);
        std::lock_guard lock(mutex_);
        if (number == lastList_) done_.push_back(std::move(found));
    }));
}

void Loader::findHidden(GateQuestion question) {
    add({.path = {}, .gate = std::move(question)});
}

void Loader::loadSettings(std::filesystem::path file) {
    add({.path = {}, .settingsFile = std::move(file)});
}

void Loader::save(std::filesystem::path file, ViewerSettings settings) {
    add({.path = {}, .settingsFile = std::move(file), .save = std::move(settings)});
}

void Loader::stopWatching() {
    std::lock_guard lock(mutex_);
    stopWatching_ = true;
}

std::optional<DoppelOnShell> Loader::doppel() const {
    std::lock_guard lock(mutex_);
    return ready_;
}

void Loader::awaitContext() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !makesContext_; });
}

Status Loader::moveContext() {
    const std::optional<DoppelOnShell> before = doppel();
    uint32_t composer = 0;
    if (before) {
        const DplVulkanDevice device = shell_.deviceForDoppel();
        if (const DplResult moved = dplRebuildVulkan(before->context, &device); moved != DPL_OK) return fromSdk(doppel::lastError(moved));
        if (const DplResult made = shell_.makeComposer(before->context, &composer); made != DPL_OK) return fromSdk(doppel::lastError(made));
    }
    {
        std::lock_guard lock(mutex_);
        if (before) ready_->composer = composer;
        ++moves_;
        lost_ = false;
        makesContext_ = !before;  // the thread tries again now
    }
    changed_.notify_all();
    return {};
}

/** False: the loader is stopped. */
bool Loader::awaitMove(uint64_t moves) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stop_ || moves_ > moves; });
    return !stop_;
}

uint64_t Loader::moves() const {
    std::lock_guard lock(mutex_);
    return moves_;
}

std::vector<LoadedFile> Loader::take() {
    std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
}

std::string Loader::atHand() const {
    std::lock_guard lock(mutex_);
    const auto next = std::find_if(tasks_.begin(), tasks_.end(), [](const Task& t) { return t.settingsFile.empty() && !t.save; });
    if (next == tasks_.end()) return atHand_;
    const std::string name = std::filesystem::path(next->path).filename().string();
    return atHand_.empty() ? name : formatText("{}, then {}", atHand_, name);  // a click is seen before its turn comes
}

Status Loader::makeContext() {
    const DplVulkanDevice device = shell_.deviceForDoppel();
    DplContextInfo info{};
    info.structSize = sizeof info;
    info.fill = fill_;
    info.cacheFolder = cacheFolder_.empty() ? nullptr : cacheFolder_.c_str();
    DplContext context = nullptr;
    if (const DplResult made = dplCreateVulkanContext(&device, &info, &context); made != DPL_OK) return fromSdk(doppel::lastError(made));
    context_.emplace(context);
    DoppelOnShell ready{context, 0};
    if (const DplResult made = shell_.makeComposer(context, &ready.composer); made != DPL_OK) {
        const Error error = fromSdk(doppel::lastError(made));
        context_.reset();
        return error;
    }
    std::lock_guard lock(mutex_);
    ready_ = ready;
    return {};
}

/** Waits for the end of a load, which the window's frames upload. False: the loader is stopped. file: for atHand(); empty: says nothing. */
bool Loader::ends(const doppel::Load& load, const std::string& file) {
    std::unique_lock lock(mutex_);
    while (!stop_) {
        const auto status = load.status();
        if (!status || status->state >= DPL_LOAD_READY) return true;
        if (!file.empty()) atHand_ = formatText("{} ({} %)", file, int(status->progress * 100));
        changed_.wait_for(lock, std::chrono::milliseconds(2));
    }
    return false;
}

Result<doppel::Avatar> Loader::loadAvatar(std::vector<uint8_t> bytes, const std::string& file) {
    deviceLost_ = false;
    const auto failed = [this](const doppel::Error& error) {
        deviceLost_ = error.code == DPL_ERROR_DEVICE;
        return fromSdk(error);
    };
    auto load = context_->startLoad(std::move(bytes));
    if (!load) return failed(load.error());
    if (!ends(*load, file)) return fail(Code::Cancelled, "not loaded, because the viewer was closed");
    auto avatar = load->finish();
    if (!avatar) return failed(avatar.error());
    const auto info = avatar->info();
    if (info && info->jointCount > 0) lastAvatar_ = avatar->handle();
    return std::move(*avatar);
}

/** A look at the watched run, with its avatar if there is another one than before. */
LoadedFile Loader::lookIntoRun(bool asked) {
    LoadedFile out;
    out.asked = asked;
    out.file = run_->folder().filename().string();
    out.run = run_->read();
    if (out.run->avatar.empty()) return out;
    auto bytes = readFile(out.run->avatar);
    auto avatar = bytes ? loadAvatar(std::move(*bytes), asked ? out.file : "") : Result<doppel::Avatar>(bytes.error());
    if (avatar) {
        out.avatar = std::move(*avatar);
        out.path = out.run->avatar, out.comparable = out.run->finished && hasScanFrames(run_->folder());
        if (comparedFile_ == out.path) comparer_.reset();  // it has drawn the one of before
    } else if (out.run->finished && !deviceLost_) {
        out.error = out.file + ": " + avatar.error().message;
    } else {  // the run replaces or removes it just now, or the device is lost
        run_->forgetAvatar();
    }
    return out;
}

LoadedFile Loader::settingsNow(const Task& task) {
    LoadedFile out;
    out.asked = false;
    if (!task.save)
        out.settings = readSettings(task.settingsFile);
    else if (const Status written = writeSettings(task.settingsFile, *task.save); !written)
        out.error = "settings are not kept: " + written.error().message, out.file = kSettings;
    return out;
}

LoadedFile Loader::compareNow(const CompareTask& task) {
    LoadedFile out;
    out.file = task.file.filename().string();
    ComparedNews& news = out.compared.emplace();
    news.file = task.file, news.frame = task.frame;
    if (!comparer_ || comparedFile_ != task.file || comparedScan_ != task.scan) {
        comparer_.reset();
        auto opened = Comparer::open(task.file.parent_path(), task.file, task.scan);
        if (!opened) {
            out.error = opened.error().message;
            return out;
        }
        comparer_.emplace(std::move(*opened));
        comparedFile_ = task.file, comparedScan_ = task.scan;
    }
    for (const ComparedFrame& frame : comparer_->frames()) {
        if (!task.name.empty() && !news.named && frame.name.starts_with(task.name)) news.frame = news.frames.size(), news.named = true;
        news.frames.push_back(frame.name + (frame.split == "train" ? ", trained on" : ", not trained on"));
    }
    if (!task.name.empty() && !news.named) {
        out.error = formatText("{}: no frame is called {}", out.file, task.name);
        return out;
    }
    auto pictures = comparer_->compare(news.frame);
    if (pictures)
        news.pictures = std::move(*pictures);
    else
        out.error = pictures.error().message;
    return out;
}

Result<std::filesystem::path> Loader::sampleNow() {
    DPL_TRY(const std::filesystem::path program, doppelProgram());
    return sampleAvatar(program, cacheFolder_.empty() ? std::filesystem::temp_directory_path() : std::filesystem::path(cacheFolder_),
                        stop_);
}

LoadedFile Loader::hiddenNow(const GateQuestion& question) {
    LoadedFile out;
    out.asked = false;
    out.hidden.emplace().question = question;
    if (!gate_) gate_.emplace();
    auto found = gate_->find(question);
    if (found)
        out.hidden->splats = std::move(*found);
    else
        out.error = found.error().message;
    return out;
}

LoadedFile Loader::walkNow(DplAvatar avatar) {
    LoadedFile out;
    out.file = "a walk";
    const auto sample = sampleNow();
    const auto bytes = sample ? readFile(*sample) : Result<std::vector<uint8_t>>(sample.error());
    if (!bytes) return out;
    DplClipOptions how{};
    how.structSize = sizeof how;
    how.flags = DPL_CLIP_IN_PLACE;  // it walks on its stand
    how.name = how.animationName = kWalk;
    uint32_t clip = 0;
    if (dplLoadClip(avatar, bytes->data(), bytes->size(), &how, &clip) == DPL_OK) out.clipOf = avatar, out.clipFrom = *sample;
    return out;
}

LoadedFile Loader::loadOne(const Task& task) {
    if (task.walks) return walkNow(task.walks);
    if (task.gate) return hiddenNow(*task.gate);
    if (task.compare) return compareNow(*task.compare);
    if (!task.settingsFile.empty()) return settingsNow(task);
    LoadedFile out;
    out.file = std::filesystem::path(task.path).filename().string();
    if (!task.sample) {
        std::error_code error;
        out.opened = std::filesystem::absolute(task.path, error).lexically_normal();
        if (!out.opened.has_filename()) out.opened = out.opened.parent_path();  // OUT/
    }
    const auto failed = [&](const std::string& why) {
        out.error = out.file + ": " + why;
        return std::move(out);
    };
    std::filesystem::path path = task.path;
    if (task.sample) {
        const auto made = sampleNow();
        if (!made) return failed(made.error().message);
        path = *made;
    }
    if (std::error_code error; std::filesystem::is_directory(path, error)) {
        path = out.opened;
        if (!isRunFolder(path)) {
            if (std::filesystem::is_regular_file(path / "scan.json", error))
                out.scan = path;
            else if (isCaptureFolder(path))
                out.film = path;
            else
                return failed(
                    "this folder is neither a run of doppel reconstruct (progress.json, run.json) nor a film (a scan, photos, videos)");
            return out;
        }
        run_.emplace(path);
        LoadedFile look = lookIntoRun(true);
        look.opened = path;
        look.request = readRunRequest(path);
        return look;
    }
    if (isVideoName(path.filename().string())) {
        std::error_code error;
        if (!std::filesystem::is_regular_file(out.opened, error)) return failed("there is no such file");
        out.film = out.opened;
        return out;
    }
    auto bytes = readFile(path);
    if (!bytes) return failed(bytes.error().message);
    switch (fileKindOf(*bytes, path.string())) {
        case FileKind::Subject: {
            auto avatar = loadAvatar(std::move(*bytes), out.file);
            if (!avatar) return failed(avatar.error().message);
            out.avatar = std::move(*avatar);
            std::error_code error;
            out.path = std::filesystem::absolute(path, error), out.comparable = hasScanFrames(out.path.parent_path());
            return out;
        }
        case FileKind::Motion: {
            const DplAvatar onto = task.motionOf ? task.motionOf : lastAvatar_;
            if (!onto) return failed("a motion needs an avatar; load an avatar first");
            DplClipOptions how{};
            how.structSize = sizeof how;
            how.flags = DPL_CLIP_IN_PLACE;  // it walks on its stand
            const std::string name = std::filesystem::path(task.path).stem().string();
            how.name = name.c_str();
            uint32_t clip = 0;
            if (dplLoadClip(onto, bytes->data(), bytes->size(), &how, &clip) != DPL_OK) return failed(dplGetLastError());
            out.clipOf = onto, out.clipFrom = out.opened;
            return out;
        }
        case FileKind::Unknown:
            break;
    }
    return failed("this is neither an avatar (.glb), nor splats (.ply, .spz, .glb), nor a motion (.bvh, .glb), nor a video (.mp4, .mov)");
}

void Loader::run() {
    std::string broken;
    for (uint64_t before = 0; true;) {
        const Status made = makeContext();
        {
            std::lock_guard lock(mutex_);
            makesContext_ = false;
            before = moves_;
            lost_ = !made && made.error().code == Code::Device;
        }
        changed_.notify_all();
        if (lost_ && awaitMove(before)) continue;
        if (!made) broken = made.error().message;
        break;
    }
    std::unique_lock lock(mutex_);
    if (!broken.empty()) done_.push_back({.error = broken});
    const auto guarded = [](const std::string& file, const std::function<LoadedFile()>& work) {
        try {
            return work();
        } catch (const std::bad_alloc&) {
            return LoadedFile{.file = file, .error = file + ": out of memory; close other programs"};
        }
    };
    while (true) {
        atHand_.clear();
        const bool due = !changed_.wait_for(lock, kLookEvery, [&] { return stop_ || !tasks_.empty(); });
        if (stop_) return;
        if (std::exchange(stopWatching_, false)) run_.reset();
        LoadedFile loaded;
        if (due) {
            if (!run_) continue;
            lock.unlock();
            loaded = guarded(run_->folder().filename().string(), [&] { return lookIntoRun(false); });
            loaded.asked = false;
        } else {
            const Task task = std::move(tasks_.front());
            tasks_.pop_front();
            atHand_ = std::filesystem::path(task.path).filename().string();
            const std::string file = task.compare ? task.compare->file.filename().string() : atHand_;
            lock.unlock();
            if (broken.empty() || !task.settingsFile.empty()) {
                uint64_t before = 0;
                do {
                    before = moves();
                    deviceLost_ = false;
                    loaded = guarded(file, [&] { return loadOne(task); });
                } while (deviceLost_ && awaitMove(before));
            } else {
                loaded = {.file = file, .error = file + ": not loaded, because avatars cannot be drawn here: " + broken};
            }
        }
        lock.lock();
        done_.push_back(std::move(loaded));
    }
}

}  // namespace dpl
