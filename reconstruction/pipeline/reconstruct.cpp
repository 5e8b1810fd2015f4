// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/pipeline/reconstruct.h"

#include <cmath>

#include "reconstruction/body/body_io.h"
#include "reconstruction/body/body_tools.h"
#include "reconstruction/pipeline/subject_data.h"
#include "reconstruction/sample/builtin_body.h"

namespace dpl {
namespace {

Status loadBody(SubjectData& subject) {
    if (subject.options.body.empty()) {
        subject.body = withBoneMorphs(makeBuiltinBody(subject.jobs));
    } else {
        DPL_TRY(subject.body, readBody(subject.options.body));
    }
    if (Status checked = checkBody(subject.body); !checked)
        return fail(checked.error().code, "{}: {}", subject.options.body.empty() ? "the built-in body" : subject.options.body.string(),
                    checked.error().message);
    DPL_TRY(auto bytes, encodeBody(subject.body));
    subject.bodyHash = hashBytes(bytes);
    return {};
}

}  // namespace

Result<ReconstructResult> reconstruct(const ReconstructOptions& options, Progress& progress) {
    std::error_code error;
    std::filesystem::create_directories(options.out, error);
    if (error) return fail(Code::Io, "cannot create {}: {}; choose another output with -o", options.out.string(), error.message());
    Jobs jobs(options.threadCount);
    StageChain chain(options.out, progress);
    SubjectData subject{options, jobs, chain};
    DPL_CHECK_OK(runIngest(subject));
    progress.note(subject.verdict.substr(0, subject.verdict.find_last_not_of('\n') + 1));
    DPL_CHECK_OK(loadBody(subject));
    DPL_CHECK_OK(runBodyFit(subject));
    DPL_CHECK_OK(runSurface(subject));
    DPL_CHECK_OK(runGarments(subject));
    DPL_CHECK_OK(runCoOptimise(subject));
    DPL_CHECK_OK(runEvidence(subject));
    DPL_CHECK_OK(runPackage(subject));
    DPL_CHECK_OK(runPoseFit(subject));
    DPL_CHECK_OK(runReport(subject));
    return ReconstructResult{options.out / "avatar.glb", options.out / "poses.json", options.out / "report.html", subject.summary};
}

}  // namespace dpl
