// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

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

}  // namespace

Result<std::vector<uint8_t>> readFile(const std::filesystem::path& path, uint64_t maxBytes) {
    Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC)};
    if (file.fd < 0) return ioError("open", path);
    struct stat info {};
    if (::fstat(file.fd, &info) != 0) return ioError("read", path);
    if (!S_ISREG(info.st_mode)) return fail(Code::InvalidArgument, "{} is not a file", path.string());
    if (uint64_t(info.st_size) > maxBytes)
        return fail(Code::Unsupported, "{} has {} bytes, more than the {} that are read; is it the right file?", path.string(),
                    info.st_size, maxBytes);
    std::vector<uint8_t> bytes(static_cast<size_t>(info.st_size));
    for (size_t done = 0; done < bytes.size();) {
        const ssize_t got = ::read(file.fd, bytes.data() + done, bytes.size() - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return ioError("read", path);
        if (got == 0) return fail(Code::CorruptData, "{} became shorter while it was read; run again", path.string());
        done += size_t(got);
    }
    return bytes;
}

Status writeFileAtomically(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    const std::filesystem::path temporary = path.string() + ".part" + std::to_string(::getpid());
    Status written = [&]() -> Status {
        Descriptor file{::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644)};
        if (file.fd < 0) return ioError("create", temporary);
        for (size_t done = 0; done < bytes.size();) {
            const ssize_t put = ::write(file.fd, bytes.data() + done, bytes.size() - done);
            if (put < 0 && errno == EINTR) continue;
            if (put < 0) return ioError("write", path);
            done += size_t(put);
        }
        if (::fsync(file.fd) != 0 && errno != EINVAL) return ioError("write", path);
        return {};
    }();
    if (written && ::rename(temporary.c_str(), path.c_str()) != 0) written = ioError("rename to", path);
    if (!written) ::unlink(temporary.c_str());
    return written;
}

Status writeFileAtomically(const std::filesystem::path& path, std::string_view text) {
    return writeFileAtomically(path, std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
}

}  // namespace dpl
