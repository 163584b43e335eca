#pragma once

#include <pxr/pxr.h>

#include <cstddef>
#include <cstdint>
#include <string>

PXR_NAMESPACE_OPEN_SCOPE

/// The path of a file to be written, in a private temporary folder. The destructor removes both.
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

/// A file in memory with a path, holding a copy of some bytes.
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

/// The memory-mapped content of a file.
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
