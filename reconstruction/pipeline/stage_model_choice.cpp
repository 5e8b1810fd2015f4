#include "reconstruction/pipeline/subject_data.h"
#include "sdk/core/files.h"

namespace dpl {
namespace {

struct LeftOut {
    const char* stage;
    const char* part;
    const char* reason;
};

// Each is a stage of the design whose first version decides not to model the part. The report and the file repeat the reason.
constexpr LeftOut kLeftOut[] = {
    {"garments", "garment layers", "one layer in this version: clothes are part of the body's surface and follow its skin weights"},
    {"illumination", "pose-dependent light", "not modelled in this version: shading is what the training frames show on average; gain not measured"},
    {"distil", "pose-dependent offsets", "not modelled in this version, so there is nothing to distil: cloth does not swing; gain not measured"},
};

}  // namespace

Status runModelChoice(SubjectData& subject) {
    for (const LeftOut& part : kLeftOut) {
        auto folder = subject.chain.run(part.stage, 1, {{"decision", part.reason}}, [&](StageContext& context) {
            return writeFileAtomically(context.folder / "decision.json", nlohmann::json{{"part", part.part}, {"kept", false}, {"reason", part.reason}}.dump(1));
        });
        if (!folder) return folder.error();
        subject.evidence.push_back({part.part, false, 0, 0, part.reason});
        subject.limits.push_back(std::string(part.part) + ": " + part.reason);
    }
    return {};
}

}  // namespace dpl
