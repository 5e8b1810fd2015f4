// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/subject_data.h"
#include "sdk/core/files.h"

namespace dpl {

// The design's stage whose first version decides not to model the part. The report and the file repeat the reason.
Status runGarments(SubjectData& subject) {
    const std::string part = "garment layers";
    const std::string reason =
        "one layer in this version: clothes are part of the body's surface and follow its skin weights and pose correctives";
    auto folder = subject.chain.run("garments", 1, {{"decision", reason}}, [&](StageContext& context) {
        return writeFileAtomically(context.folder / "decision.json",
                                   nlohmann::json{{"part", part}, {"kept", false}, {"reason", reason}}.dump(1));
    });
    if (!folder) return folder.error();
    subject.evidence.push_back({part, false, 0, 0, reason});
    subject.limits.push_back(part + ": " + reason);
    return {};
}

}  // namespace dpl
