// SPDX-License-Identifier: Apache-2.0
// Makes the context and loads files on a thread of its own, one after the other, so that the window never waits.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <doppel/doppel.hpp>
#include <future>
#include <mutex>
#include <thread>

#include "apps/viewer/comparer.h"
#include "apps/viewer/folder_list.h"
#include "apps/viewer/hidden_splats.h"
#include "apps/viewer/new_run.h"
#include "apps/viewer/run_reader.h"
#include "apps/viewer/settings.h"
#include "platform/desktop/shell.h"
#include "sdk/core/result.h"

namespace dpl {

/** A frame that is to be compared with an avatar of the run in whose folder the avatar's file is. */
struct CompareTask {
    std::filesystem::path file, scan;  // scan: where the pictures are; empty: where the run says
    size_t frame = 0;
    std::string name;  // if not empty: the frame whose name begins so, instead
};

/** What became of it. */
struct ComparedNews {
    std::filesystem::path file;
    std::vector<std::string> frames;  // for people; empty: it is no avatar with frames
    size_t frame = 0;
    bool named = false;  // the task named it
    ComparedPictures pictures;
};

/** What an eye does not see of an avatar. */
struct HiddenNews {
    GateQuestion question;
    HiddenSplats splats;
};

/** LoadedFile::file where settings could not be written. */
constexpr const char* kSettings = "settings";

/** What became of one file, or what a watched run told. */
struct LoadedFile {
    std::string file;                      // without folders; empty: not a file, but the context
    std::optional<doppel::Avatar> avatar;  // a new avatar, or general splats; of a run: in place of that of before
    DplAvatar clipOf = nullptr;            // the avatar that got a new clip
    std::filesystem::path clipFrom;        // from this file
    std::filesystem::path opened;          // the file or folder that was asked for, absolute
    std::filesystem::path path;            // of the avatar's file
    bool comparable = false;               // its folder has cameras and poses of its scan
    std::filesystem::path scan;            // the file is the folder of a scan
    std::filesystem::path film;            // the file is a video, or a folder that can be imported
    std::optional<ComparedNews> compared;  // `error` says why there are no pictures
    std::optional<FolderList> folder;      // what it holds; nobody has asked for a file
    std::optional<ViewerSettings> settings;
    std::optional<RunReader::News> run;  // of the run in the folder `file`, where nobody has asked for a file
    std::optional<NewRun> request;       // with which the viewer has begun it; told when it is opened
    bool asked = true;                   // it answers load() or loadSample()
    std::optional<HiddenNews> hidden;    // `error` says why there are none
    std::string error;                   // a sentence, if none of these but `compared` and `hidden`
};

/** The context and the composer for the shell's window. */
struct DoppelOnShell {
    DplContext context = nullptr;
    uint32_t composer = 0;
};

class Loader {
public:
    /** Starts the thread. The shell must outlive the loader. cacheFolder: for DplContextInfo; empty: none. */
    Loader(platform::Shell& shell, DplFill fill, std::string cacheFolder);
    /** Drops waiting files and the one at hand, and destroys the context. No frame with it may be in flight any more. */
    ~Loader();
    Loader(const Loader&) = delete;
    Loader& operator=(const Loader&) = delete;

    /** A motion is loaded onto `motionOf`; if that is NULL, onto the avatar that was loaded last. The folder of a run is watched from then
     *  on, in place of another one: it is looked into every second between files. */
    void load(std::string path, DplAvatar motionOf);
    /** Draws a frame of a scan, and reads its frames before if the avatar or scan is another one than before. */
    void compare(CompareTask task);
    /** Lists a folder, beside what is being loaded; the answer to an earlier wish is dropped. One that cannot be listed is an error, with
     * the folder as `path`. */
    void list(std::filesystem::path folder);
    /** Finds which splats the gate hides. */
    void findHidden(GateQuestion question);
    void loadSettings(std::filesystem::path file);
    /** Writes settings. */
    void save(std::filesystem::path file, ViewerSettings settings);
    /** No run is watched any more. */
    void stopWatching();
    /** Has an avatar walk as the sample does, unless their skeletons differ too much. */
    void loadWalk(DplAvatar avatar);
    /** Loads the built-in sample avatar. The program `doppel` makes it the first time, which takes seconds. */
    void loadSample();

    /** The context could not be made, because the device is lost. */
    bool lost() const { return lost_; }
    /** Waits until the thread is not at making the context, which uses the shell. Call before Shell::rebuild(). */
    void awaitContext();
    /** The shell has rebuilt: moves the context with its avatars to its device, and makes a composer. What could not be loaded on the lost
     *  device is loaded again. */
    Status moveContext();

    /** Set once the context is ready. */
    std::optional<DoppelOnShell> doppel() const;
    /** What was finished since the last call. */
    std::vector<LoadedFile> take();
    /** The file at hand and how far it is, for people; "" if nothing is left to do. */
    std::string atHand() const;

private:
    struct Task {
        std::string path;
        DplAvatar motionOf = nullptr;
        bool sample = false;
        std::optional<CompareTask> compare;
        std::filesystem::path settingsFile;
        DplAvatar walks = nullptr;
        std::optional<GateQuestion> gate;
        std::optional<ViewerSettings> save;
    };
    void run();
    Status makeContext();
    void add(Task task);
    LoadedFile loadOne(const Task& task);
    LoadedFile lookIntoRun(bool asked);
    LoadedFile settingsNow(const Task& task);
    LoadedFile compareNow(const CompareTask& task);
    LoadedFile walkNow(DplAvatar avatar);
    LoadedFile hiddenNow(const GateQuestion& question);
    Result<std::filesystem::path> sampleNow();
    Result<doppel::Avatar> loadAvatar(std::vector<uint8_t> bytes, const std::string& file);
    bool ends(const doppel::Load& load, const std::string& file);
    bool awaitMove(uint64_t moves);
    uint64_t moves() const;

    platform::Shell& shell_;
    const DplFill fill_;
    const std::string cacheFolder_;
    std::optional<doppel::Context> context_;  // written by the thread before ready_
    DplAvatar lastAvatar_ = nullptr;          // only the thread uses it, as the next
    bool deviceLost_ = false;                 // the load at hand met a lost device
    std::optional<RunReader> run_;
    std::optional<GateFinder> gate_;
    std::optional<Comparer> comparer_;
    std::filesystem::path comparedFile_, comparedScan_;  // of comparer_

    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Task> tasks_;
    std::vector<LoadedFile> done_;
    std::optional<DoppelOnShell> ready_;
    std::string atHand_ = "the renderer";
    bool stopWatching_ = false;
    bool makesContext_ = true;
    uint64_t moves_ = 0;  // of the context to another device
    std::atomic<bool> stop_{false}, lost_{false};
    std::atomic<uint64_t> lastList_{0};     // the number of the folder that was wished last
    std::vector<std::future<void>> lists_;  // that are being made; of the main thread
    std::thread thread_;                    // last: it uses all of the above
};

}  // namespace dpl
