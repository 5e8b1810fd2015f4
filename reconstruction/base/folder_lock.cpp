// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/base/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <ctime>
#include <system_error>
#include <utility>

namespace dpl {
namespace {

std::string localTime() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    localtime_r(&now, &parts);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M:%S", &parts);
    return text.data();
}

}  // namespace

Result<FolderLock> FolderLock::take(const std::filesystem::path& folder, const std::filesystem::path& output) {
    const std::filesystem::path file = folder / kName;
    const std::string named = (output.empty() ? folder : output).string();
    const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor < 0) return fail(Code::Io, "cannot open {}: {}", file.string(), std::generic_category().message(errno));
    FolderLock lock(descriptor);
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
        if (errno != EWOULDBLOCK)  // some network file systems cannot lock
            return fail(Code::Io, "cannot lock {}: {}; choose a folder on a local disk with -o", file.string(),
                        std::generic_category().message(errno));
        std::array<char, 128> text{};
        const ssize_t length = ::pread(descriptor, text.data(), text.size(), 0);
        std::string holder(text.data(), size_t(length > 0 ? length : 0));
        while (!holder.empty() && holder.back() == '\n') holder.pop_back();
        return fail(Code::Io, "another run uses {} {}; wait for it, stop it, or choose another output with -o", named,
                    holder.empty() ? "now" : holder);
    }
    struct stat info {};
    if (::fstat(descriptor, &info) != 0 || info.st_nlink == 0)  // its holder removed it, with the folder, after it was opened here
        return fail(Code::Io, "another run used {} until now; run again", named);
    const std::string text = formatText("since {} (process {})\n", localTime(), ::getpid());
    if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, text.data(), text.size(), 0) != ssize_t(text.size()))
        return fail(Code::Io, "cannot write {}: {}", file.string(), std::generic_category().message(errno));
    return lock;
}

FolderLock::FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderLock::~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);  // gives the lock back
}

}  // namespace dpl
