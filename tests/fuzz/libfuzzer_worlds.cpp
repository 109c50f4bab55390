// libFuzzer's entry to random worlds: its bytes make the decisions.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "fuzz/generator.hpp"
#include "fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const std::vector<pierce::test::NamedBackend> backends = pierce::test::backends();
    pierce::fuzz::Choices choices({data, size});
    pierce::fuzz::JudgeCounts counts;
    if (const auto failure = pierce::fuzz::judge(pierce::fuzz::random_program(choices), backends,
                                                 counts)) {
        std::fprintf(stderr, "%s\n%s\n", failure->kind.c_str(), failure->text.c_str());
        std::abort();
    }
    return 0;
}
