// libFuzzer's entry to everything that reads files: the first byte says which reader, the rest is
// the file.
#include <cstddef>
#include <cstdint>

#include "fuzz/hostile_files.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using pierce::fuzz::Reader;
    if (size == 0) return 0;
    const auto reader = static_cast<Reader>(data[0] % static_cast<unsigned>(Reader::count));
    pierce::fuzz::read(reader, {reinterpret_cast<const char*>(data + 1), size - 1});
    return 0;
}
