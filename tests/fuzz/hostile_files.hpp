#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace pierce::fuzz {

/// What reads files, or streams, that anybody may have made.
enum class Reader : std::uint8_t {
    obj,
    ply,
    stl,
    off,
    npy,
    recording,
    truth,
    sheet_truth,
    saved_world,
    program,
    count
};

const char* name_of(Reader reader);

/// A small file that the reader takes.
std::string sound_file(Reader reader, std::uint64_t seed);

/// Hands a file with this content to the reader. It must be taken or refused with InputError; any
/// other exception comes out. True if it was taken.
bool read(Reader reader, const std::string& content);

/// Changed here and there: bits, bytes, numbers, parts left out or doubled, an end that is missing.
std::string spoiled(std::string content, std::uint64_t seed);

}  // namespace pierce::fuzz
