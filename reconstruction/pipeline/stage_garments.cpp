// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/stages.h"
#include "sdk/core/files.h"

namespace dpl {

Result<std::vector<EvidenceData>> runGarments(const StageRun& run) {
    const std::string part = "garment layers";
    const std::string reason =
        "one layer in this version: clothes are part of the body's surface and follow its skin weights and pose correctives";
    auto stage = run.chain.run("garments", 1, {{"decision", reason}}, [&](StageContext& context) {
        return writeFileAtomically(context.folder / "decision.json",
                                   nlohmann::json{{"part", part}, {"kept", false}, {"reason", reason}}.dump(1));
    });
    if (!stage) return stage.error();
    return std::vector<EvidenceData>{{part, false, 0, 0, reason}};
}

}  // namespace dpl
