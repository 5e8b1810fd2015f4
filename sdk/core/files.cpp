// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace dpl {
namespace {

Error ioError(const char* what, const std::filesystem::path& path) {
    const int reason = errno;
    const Code code = reason == ENOENT ? Code::NotFound : Code::Io;
    const char* remedy = reason == ENOSPC   ? "; free some disk space and run again"
                         : reason == EACCES ? "; check the permissions"
                         : reason == ENOENT ? "; check the path"
                                            : "";
    return fail(code, "cannot {} {}: {}{}", what, path.string(), std::strerror(reason), remedy);
}

struct Descriptor {
    int fd = -1;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
};

Status readFully(int fd, std::span<uint8_t> bytes, const std::filesystem::path& path) {
    while (!bytes.empty()) {
        const ssize_t got = ::read(fd, bytes.data(), bytes.size());
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return ioError("read", path);
        if (got == 0) return fail(Code::CorruptData, "{} became shorter while it was read; run again", path.string());
        bytes = bytes.subspan(size_t(got));
    }
    return {};
}

Status writeFully(int fd, std::span<const uint8_t> bytes, const std::filesystem::path& path) {
    while (!bytes.empty()) {
        const ssize_t put = ::write(fd, bytes.data(), bytes.size());
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) return ioError("write", path);
        bytes = bytes.subspan(size_t(put));
    }
    if (::fsync(fd) != 0 && errno != EINVAL && errno != EROFS) return ioError("write", path);
    return {};
}

/** The path at the end of a chain of symbolic links. A file need not exist there. */
std::filesystem::path endOfLinks(std::filesystem::path path) {
    constexpr int kMaxLinks = 40;  // limit of the Linux kernel; opening a longer chain fails
    std::error_code error;
    for (int i = 0; i < kMaxLinks && std::filesystem::is_symlink(path, error); ++i) {
        const std::filesystem::path next = std::filesystem::read_symlink(path, error);
        if (error) break;
        path = path.parent_path() / next;  // an absolute `next` replaces the whole path
    }
    return path;
}

}  // namespace

Result<std::vector<uint8_t>> readFile(const std::filesystem::path& path, uint64_t maxBytes, CheckFileHead check) {
    Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.fd < 0) return ioError("open", path);
    struct stat info {};
    if (::fstat(file.fd, &info) != 0) return ioError("read", path);
    if (!S_ISREG(info.st_mode)) return fail(Code::InvalidArgument, "{} is not a file", path.string());
    if (uint64_t(info.st_size) > maxBytes)
        return fail(Code::Unsupported, "{} has {} bytes, more than the {} that are read; is it the right file?", path.string(),
                    info.st_size, maxBytes);
    const uint64_t fileBytes = uint64_t(info.st_size);
    std::vector<uint8_t> bytes(size_t(check ? std::min<uint64_t>(fileBytes, kFileHeadBytes) : fileBytes));
    DPL_CHECK_OK(readFully(file.fd, bytes, path));
    if (!check) return bytes;
    if (const Status accepted = check(bytes, fileBytes); !accepted)
        return fail(accepted.error().code, "{}: {}", path.string(), accepted.error().message);
    const size_t headBytes = bytes.size();
    bytes.resize(size_t(fileBytes));
    DPL_CHECK_OK(readFully(file.fd, std::span(bytes).subspan(headBytes), path));
    return bytes;
}

Status writeFileAtomically(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    const std::filesystem::path target = endOfLinks(path);
    struct stat info {};
    if (::stat(target.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode)) {
        const Descriptor device{::open(target.c_str(), O_WRONLY | O_CLOEXEC)};
        return device.fd < 0 ? ioError("open", target) : writeFully(device.fd, bytes, path);
    }
    const std::filesystem::path temporary = target.string() + ".part" + std::to_string(::getpid());
    Status written = [&]() -> Status {
        const Descriptor file{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
        return file.fd < 0 ? ioError("create", temporary) : writeFully(file.fd, bytes, path);
    }();
    if (written && ::rename(temporary.c_str(), target.c_str()) != 0) written = ioError("rename to", target);
    if (!written) ::unlink(temporary.c_str());
    return written;
}

Status writeFileAtomically(const std::filesystem::path& path, std::string_view text) {
    return writeFileAtomically(path, std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
}

}  // namespace dpl
