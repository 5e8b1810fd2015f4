// SPDX-License-Identifier: Apache-2.0
#include "sdk/api/decode_file.h"
#include "sdk/core/log.h"
#include "sdk/core/task.h"
#include "sdk/format/splat_file.h"

namespace dpl::api {

Result<Decoded> decodeGeneralSplats(std::span<const uint8_t> bytes, const std::string& file) {
    SplatFile read;
    {
        const TaskPart part(0, 0.9);
        DPL_TRY(read, readSplats(bytes));
    }
    for (const std::string& note : read.remarks.notes) log(LogLevel::Warning, "{}: {}", file.empty() ? nameOf(read.format) : file, note);
    auto made = std::make_shared<Avatar>();
    AvatarData named;
    named.name = nameOf(read.format);
    made->data = std::make_shared<const AvatarData>(std::move(named));
    made->fileSplatCount = read.splats.count(), made->fileShDegree = read.splats.shDegree;
    made->axesStated = !read.remarks.axes.stated.empty(), made->loadedFromFile = read.remarks.axes.uprightFromFile;
    DPL_RETURN_IF_ERROR(taskAt(0.9));
    const SplatBox box = boxOf(read.splats);
    made->restMin = box.low, made->restMax = box.high;
    return Decoded{std::move(made), {}, std::move(read.splats)};
}

}  // namespace dpl::api
