#include "scratch.h"

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

PXR_NAMESPACE_OPEN_SCOPE

namespace {

[[noreturn]] void Fail(const std::string &message)
{
    throw std::system_error(errno, std::generic_category(), message);
}

std::string TemporaryFolder()
{
    const char *named = std::getenv("TMPDIR");
    return named && *named ? named : "/tmp";
}

} // namespace

TailorScratchFile::TailorScratchFile(const std::string &name) : _folder(TemporaryFolder() + "/usdtailor.XXXXXX")
{
    if (!mkdtemp(_folder.data())) {
        Fail("cannot create a temporary folder " + _folder);
    }
    _path = _folder + "/" + name;
}

TailorScratchFile::~TailorScratchFile()
{
    unlink(_path.c_str());
    rmdir(_folder.c_str());
}

TailorMappedFile::TailorMappedFile(const std::string &path) : _bytes(MAP_FAILED), _size(0)
{
    const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const off_t size = file >= 0 ? lseek(file, 0, SEEK_END) : -1;
    if (size >= 0) {
        _size = static_cast<size_t>(size);
        _bytes = mmap(nullptr, _size, PROT_READ, MAP_PRIVATE, file, 0);
    }
    const int error = errno;
    if (file >= 0) {
        close(file);
    }
    if (_bytes == MAP_FAILED) {
        errno = error;
        Fail("cannot read " + path);
    }
}

TailorMappedFile::~TailorMappedFile()
{
    munmap(_bytes, _size);
}

TailorMemoryFile::TailorMemoryFile(const uint8_t *bytes, size_t size)
    : _file(memfd_create("usdtailor", MFD_CLOEXEC))
{
    if (_file < 0) {
        Fail("cannot create a file in memory");
    }
    for (size_t done = 0; done < size;) {
        const ssize_t written = write(_file, bytes + done, size - done);
        if (written < 0 && errno != EINTR) {
            const int error = errno;
            close(_file);
            errno = error;
            Fail("cannot write a file in memory");
        }
        done += written > 0 ? static_cast<size_t>(written) : 0;
    }
    _path = "/proc/self/fd/" + std::to_string(_file);
}

TailorMemoryFile::~TailorMemoryFile()
{
    close(_file);
}

PXR_NAMESPACE_CLOSE_SCOPE
