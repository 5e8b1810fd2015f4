// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/stage.h"

#include <sys/resource.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "reconstruction/run/stage_words.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Writing 5 resets the process's peak resident size on Linux, so each stage reports its own peak.
void resetPeakMemory() {
    std::ofstream("/proc/self/clear_refs") << 5;
}

uint64_t peakMemoryBytes() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmHWM:", 0) == 0) return std::stoull(line.substr(6)) * 1024;
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return uint64_t(usage.ru_maxrss) * 1024;
}

json readManifest(const fs::path& folder) {
    auto bytes = readFile(folder / "manifest.json", 16 << 20);
    if (!bytes) return {};
    return json::parse(bytes->begin(), bytes->end(), nullptr, false);
}

std::string stringField(const json& object, const char* name) {
    return object.is_object() && object.contains(name) && object[name].is_string() ? object[name].get<std::string>() : std::string();
}

double numberField(const json& object, const char* name) {
    return object.is_object() && object.contains(name) && object[name].is_number() ? object[name].get<double>() : 0;
}

/** Hash and size of every file of a stage's folder but its manifest, by relative path. */
Result<json> listFiles(const fs::path& folder) {
    json files = json::object();
    std::error_code error;
    fs::recursive_directory_iterator at(folder, error);
    for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
        const std::string name = at->path().lexically_relative(folder).generic_string();
        if (!at->is_regular_file() || name == "manifest.json") continue;
        DPL_TRY(const std::string hash, hashFile(at->path()));
        files[name] = {{"bytes", at->file_size()}, {"hash", hash}};
    }
    if (error) return fail(Code::Io, "cannot list {}: {}", folder.string(), error.message());
    return files;
}

bool isManifest(const json& manifest) {
    return manifest.is_object() && manifest.contains("inputs");
}

/** What is wrong with the files of a finished stage, as part of a sentence; empty when all are as its manifest says. */
std::string damageIn(const fs::path& folder, const json& manifest) {
    if (!manifest.contains("files") || !manifest["files"].is_object())
        return "its manifest, of an earlier version, does not list its files";
    for (const auto& [name, about] : manifest["files"].items()) {
        const fs::path file = folder / name;
        std::error_code error;
        if (!fs::is_regular_file(file, error)) return formatText("{} is missing", file.string());
        const auto hash = hashFile(file);
        if (!hash) return hash.error().message;
        if (*hash != stringField(about, "hash")) return formatText("{} is not as the stage wrote it", file.string());
    }
    return {};
}

/** Why a stage runs although its folder has a manifest: the inputs that changed since, or its version. Part of a sentence. */
std::string whatChanged(const json& manifest, uint32_t version, const json& inputs) {
    if (!isManifest(manifest)) return "it has no result yet";
    if (manifest.value("version", 0u) != version) return "the program makes other files than the version that ran before";
    const json before = manifest["inputs"].flatten(), now = inputs.flatten();
    std::vector<std::string> changed;
    for (const auto& [name, value] : now.items())
        if (const auto old = before.find(name); old == before.end() || *old != value) changed.push_back(name.substr(1));
    for (const auto& [name, value] : before.items())
        if (!now.contains(name)) changed.push_back(name.substr(1) + " (gone)");
    if (changed.empty()) return "its name changed";
    std::string text = changed[0];
    for (size_t i = 1; i < std::min<size_t>(3, changed.size()); ++i) text += ", " + changed[i];
    if (changed.size() > 3) text += formatText(" and {} more", changed.size() - 3);
    return "changed inputs: " + text;
}

Status makeFolder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", folder.string(), error.message());
    return {};
}

}  // namespace

std::string hashBytes(std::span<const uint8_t> bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    char text[33];
    std::snprintf(text, sizeof text, "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                  static_cast<unsigned long long>(hash.low64));
    return text;
}

std::string hashText(std::string_view text) {
    return hashBytes({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

std::string stageKey(const std::string& name, uint32_t version, const json& inputs) {
    return hashText(json{{"stage", name}, {"version", version}, {"inputs", inputs}}.dump());
}

Result<std::string> hashFile(const fs::path& path) {
    DPL_TRY(auto bytes, readFile(path));
    return hashBytes(bytes);
}

StageChain::StageChain(fs::path outFolder, Progress& progress)
    : outFolder_(std::move(outFolder)), stagesFolder_(outFolder_ / "stages"), progress_(progress) {}

Result<StageOutput> StageChain::run(const std::string& name, uint32_t version, const json& inputs,
                                    const std::function<Status(StageContext&)>& work) {
    const fs::path folder = stagesFolder_ / name, workFolder = folder.string() + ".work";
    const std::string key = stageKey(name, version, inputs);

    progress_.beginStage(name);
    std::error_code ignored;
    // After a kill between the last write and the rename, the work folder is complete and can be used.
    if (const json manifest = readManifest(workFolder);
        stringField(manifest, "key") == key && manifest.contains("finished") && manifest["finished"] == true) {
        fs::remove_all(folder, ignored);
        fs::rename(workFolder, folder, ignored);
    }
    const json manifest = readManifest(folder);
    const bool made = stringField(manifest, "key") == key;
    std::string damage;
    if (made)
        damage = damageIn(folder, manifest);
    else if (!isManifest(manifest) && fs::is_directory(folder, ignored))
        damage = (folder / "manifest.json").string() + " is missing or damaged";
    if (!damage.empty()) progress_.note(formatText("{} runs again: {}", wordsOfStage(name), damage));
    if (made && damage.empty()) {
        records_.push_back({name, numberField(manifest, "seconds"), uint64_t(std::max(0.0, numberField(manifest, "peakBytes"))), true});
        progress_.skipStage(numberField(manifest, "seconds"));
        return StageOutput{folder, key};
    }
    if (stringField(readManifest(workFolder), "key") == key)
        progress_.detail(formatText("{} continues in {}", name, workFolder.string()));
    else
        fs::remove_all(workFolder, ignored);
    if (!made && damage.empty()) progress_.detail(formatText("{} runs: {}", name, whatChanged(manifest, version, inputs)));
    DPL_RETURN_IF_ERROR(makeFolder(workFolder));
    DPL_RETURN_IF_ERROR(
        writeFileAtomically(workFolder / "manifest.json", json{{"stage", name}, {"key", key}, {"finished", false}}.dump(1)));

    resetPeakMemory();
    const auto start = std::chrono::steady_clock::now();
    StageContext context{workFolder, progress_};
    ShownTask task(progress_);
    const TaskScope scope(&task);
    if (Status done = work(context); !done) return fail(done.error().code, "{}: {}", wordsOfStage(name), done.error().message);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const uint64_t peakBytes = peakMemoryBytes();

    DPL_TRY(const json files, listFiles(workFolder));
    const json finished = {{"stage", name},      {"version", version},     {"key", key},    {"finished", true}, {"inputs", inputs},
                           {"seconds", seconds}, {"peakBytes", peakBytes}, {"files", files}};
    DPL_RETURN_IF_ERROR(writeFileAtomically(workFolder / "manifest.json", finished.dump(1)));
    fs::remove_all(folder, ignored);
    std::error_code error;
    fs::rename(workFolder, folder, error);
    if (error) return fail(Code::Io, "cannot rename {} to {}: {}", workFolder.string(), folder.string(), error.message());
    records_.push_back({name, seconds, peakBytes, false});
    progress_.endStage("done");
    progress_.detail(
        formatText("{} took {} s and at most {} MiB of memory; files in {}", name, std::lround(seconds), peakBytes >> 20, folder.string()));
    return StageOutput{folder, key};
}

bool StageChain::hasFinished(const std::string& name) const {
    return isManifest(readManifest(stagesFolder_ / name));
}

}  // namespace dpl
