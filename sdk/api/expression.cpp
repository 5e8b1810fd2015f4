// SPDX-License-Identifier: Apache-2.0
// What the face shows: weights of the expressions, beside the pose.
#include <algorithm>

#include "sdk/api/api_state.h"
#include "sdk/avatar/expression_stream.h"
#include "sdk/core/edit_distance.h"

using namespace dpl;
using namespace dpl::api;

namespace {

static_assert(DPL_EXPRESSION_COUNT == kExpressionCount);

constexpr uint32_t kMostNames = 1024;  // streams have at most 70; so a count that was not initialised reads no memory of others

Status checkWeightCount(uint32_t count) {
    if (count == kExpressionCount) return {};
    return fail(Code::InvalidArgument, "count is {}; there are {} expressions", count, kExpressionCount);
}

}  // namespace

extern "C" {

DplResult dplGetExpressionInfo(DplAvatar avatar, uint32_t expression, DplExpressionInfo* info) {
    return guarded("dplGetExpressionInfo", [&]() -> Status {
        DPL_TRY(const auto found, avatarOf(avatar));
        if (expression >= kExpressionCount)
            return fail(Code::NotFound, "there is no expression {}; there are {}", expression, kExpressionCount);
        const std::vector<uint8_t>& shapes = found->data->expressions.shapes;
        DplExpressionInfo out{};
        out.name = kExpressionNames[expression];
        out.drawn = std::binary_search(shapes.begin(), shapes.end(), uint8_t(expression)) ? DPL_TRUE : DPL_FALSE;
        return writeStruct(info, out, "info");
    });
}

DplResult dplFindExpression(const char* name, uint32_t* expression) {
    return guarded("dplFindExpression", [&]() -> Status {
        if (name == nullptr || expression == nullptr)
            return fail(Code::InvalidArgument, "{} is NULL", name == nullptr ? "name" : "expression");
        const auto found = expressionOf(name);
        if (!found)
            return fail(Code::NotFound, "there is no expression '{}'{}; names are those of ARKit", name,
                        didYouMean(name, {kExpressionNames.begin(), kExpressionNames.end()}));
        *expression = uint32_t(*found);
        return {};
    });
}

DplResult dplSetExpression(DplAvatar avatar, const float* weights, uint32_t count) {
    return guarded("dplSetExpression", [&]() -> Status {
        if (weights == nullptr) return fail(Code::InvalidArgument, "weights is NULL");
        DPL_RETURN_IF_ERROR(checkWeightCount(count));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        DPL_TRY(const ExpressionWeights taken, expressionFrom({}, {weights, count}));
        std::lock_guard lock(found->context->mutex);
        found->expression = taken;
        return {};
    });
}

DplResult dplSetExpressionNamed(DplAvatar avatar, const char* const* names, const float* weights, uint32_t count) {
    return guarded("dplSetExpressionNamed", [&]() -> Status {
        if (weights == nullptr && count > 0) return fail(Code::InvalidArgument, "weights is NULL");
        if (count > kMostNames) return fail(Code::InvalidArgument, "count is {}; at most {} names are read", count, kMostNames);
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        ExpressionWeights taken{};  // no names: none is shown
        if (names == nullptr || count > 0) {
            const std::span<const char* const> given = names == nullptr ? std::span<const char* const>() : std::span(names, count);
            DPL_TRY(taken, expressionFrom(given, {weights, count}));
        }
        std::lock_guard lock(found->context->mutex);
        found->expression = taken;
        return {};
    });
}

DplResult dplGetExpression(DplAvatar avatar, float* weights, uint32_t count) {
    return guarded("dplGetExpression", [&]() -> Status {
        if (weights == nullptr) return fail(Code::InvalidArgument, "weights is NULL");
        DPL_RETURN_IF_ERROR(checkWeightCount(count));
        DPL_TRY(const auto found, avatarOf(avatar));
        std::lock_guard lock(found->context->mutex);
        const ExpressionWeights shown = found->shownExpression();
        std::copy(shown.begin(), shown.end(), weights);
        return {};
    });
}

DplResult dplSetFaceMotion(DplAvatar avatar, const DplFaceMotion* motion, int64_t timeNs) {
    return guarded("dplSetFaceMotion", [&]() -> Status {
        DPL_TRY(const DplFaceMotion given, readStruct<DplFaceMotion>(motion, "motion"));
        DPL_TRY(const auto found, avatarOf(avatar));
        DPL_RETURN_IF_ERROR(checkPosable(*found));
        const FaceMotion taken{given.seed, given.blinks, given.glances, given.holdS, given.heardNs};
        DPL_RETURN_IF_ERROR(checkFaceMotion(taken));
        std::lock_guard lock(found->context->mutex);
        found->faceMotion = taken, found->faceTimeNs = timeNs;
        return {};
    });
}

}  // extern "C"
