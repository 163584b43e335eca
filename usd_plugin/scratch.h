#pragma once

#include <pxr/pxr.h>

#include <cstddef>
#include <cstdint>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The path of a file that is not there yet, in a folder of its own that nobody else can enter. Both are removed at the
/// end.
class TailorScratchFile {
public:
    explicit TailorScratchFile(const std::string &name);
    ~TailorScratchFile();
    TailorScratchFile(const TailorScratchFile &) = delete;
    TailorScratchFile &operator=(const TailorScratchFile &) = delete;

    const std::string &GetPath() const { return _path; }

private:
    std::string _folder;
    std::string _path;
};

/// Bytes that can be opened by a path, in memory where the system has such files.
class TailorMemoryFile {
public:
    TailorMemoryFile(const uint8_t *bytes, size_t size);
    ~TailorMemoryFile();
    TailorMemoryFile(const TailorMemoryFile &) = delete;
    TailorMemoryFile &operator=(const TailorMemoryFile &) = delete;

    const std::string &GetPath() const { return _path; }

private:
    int _file;
    std::string _path;
};

/// The content of a file, mapped.
class TailorMappedFile {
public:
    explicit TailorMappedFile(const std::string &path);
    ~TailorMappedFile();
    TailorMappedFile(const TailorMappedFile &) = delete;
    TailorMappedFile &operator=(const TailorMappedFile &) = delete;

    const uint8_t *data() const { return static_cast<const uint8_t *>(_bytes); }
    size_t size() const { return _size; }

private:
    void *_bytes;
    size_t _size;
};

PXR_NAMESPACE_CLOSE_SCOPE
