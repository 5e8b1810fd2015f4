// SPDX-License-Identifier: Apache-2.0
// Runs stages, each once. A stage's folder appears complete, with a manifest of its inputs, or not at all.
//
//   OUT/stages/body-fit/            appears by a rename when the stage has ended
//       manifest.json               key (hash of name, version and inputs), inputs, seconds, peak memory, hash of each file
//       ...                         files of the stage
//   OUT/stages/body-fit.work/       the folder during the run; it and its checkpoints survive a kill, but not a change of the key
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "reconstruction/run/progress.h"
#include "sdk/core/result.h"

namespace dpl {

/** 128-bit content hash as 32 hex digits. */
std::string hashBytes(std::span<const uint8_t> bytes);
std::string hashText(std::string_view text);
Result<std::string> hashFile(const std::filesystem::path& path);

/** The key of a stage: a hash of its name, its version and its inputs. */
std::string stageKey(const std::string& name, uint32_t version, const nlohmann::json& inputs);

struct StageRecord {
    std::string name;
    double seconds = 0;
    uint64_t peakBytes = 0;
    bool reused = false;
};

/** A finished stage. The key is a hash of everything that its files depend on. Later stages include it in their inputs. */
struct StageOutput {
    std::filesystem::path folder;
    std::string key;
};

/** The arguments of a running stage. Its work is the task of its thread: taskAt() shows how far it is, and says when it is cancelled. */
struct StageContext {
    std::filesystem::path folder;  // for its files; also holds checkpoints of an interrupted run with the same key
    Progress& progress;
};

/** Runs stages under OUT/stages, and records the time and memory of each. For use by one thread. */
class StageChain {
public:
    StageChain(std::filesystem::path outFolder, Progress& progress);

    /** Runs `work` unless a finished folder with the same key exists and each of its files is as it was written; a note says which is not.
     * `inputs` holds every value that the result depends on: settings, hashes of input files, keys of earlier stages, priors. `version`
     * must change when the code makes other files from the same inputs. */
    Result<StageOutput> run(const std::string& name, uint32_t version, const nlohmann::json& inputs,
                            const std::function<Status(StageContext&)>& work);

    /** Whether a finished folder of this stage exists, whatever its inputs were. */
    bool hasFinished(const std::string& name) const;

    const std::filesystem::path& outFolder() const { return outFolder_; }

    /** One record a stage, in the order of the runs. */
    const std::vector<StageRecord>& records() const { return records_; }

private:
    std::filesystem::path outFolder_, stagesFolder_;
    Progress& progress_;
    std::vector<StageRecord> records_;
};

}  // namespace dpl
