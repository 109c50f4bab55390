#include <array>
#include <istream>
#include <ostream>
#include <streambuf>

#include "c_api/arguments.hpp"
#include "c_api/border.hpp"
#include "c_api/settings.hpp"
#include "c_api/world_state.hpp"
#include "pierce/c/world.h"

namespace pierce::c {
namespace {

/// Hands what a stream writes to the caller's function, in pieces.
class WrittenBytes : public std::streambuf {
public:
    WrittenBytes(pierce_write write, void* user) : write_(write), user_(user) { begin(); }

protected:
    int overflow(int c) override {
        if (sync() != 0) return traits_type::eof();
        if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
        return traits_type::not_eof(c);
    }

    int sync() override {
        const auto size = static_cast<std::size_t>(pptr() - pbase());
        if (size > 0 && write_(pbase(), size, user_) != 0) return -1;
        begin();
        return 0;
    }

private:
    void begin() { setp(piece_.data(), piece_.data() + piece_.size()); }

    pierce_write write_;
    void* user_;
    std::array<char, 1 << 16> piece_{};
};

/// Reads the caller's bytes, which stay where they are.
class GivenBytes : public std::streambuf {
public:
    GivenBytes(const void* bytes, std::size_t size) {
        char* const begin = const_cast<char*>(static_cast<const char*>(bytes));
        setg(begin, begin, begin + size);
    }
};

}  // namespace
}  // namespace pierce::c

using namespace pierce::c;

pierce_status pierce_save(const pierce_world* world, pierce_write write, void* user) {
    return guarded([&] {
        auto& inner = world_of(world);
        if (write == nullptr) throw pierce::InputError("write is null");
        WrittenBytes bytes(write, user);
        std::ostream out(&bytes);
        inner.save(out);
    });
}

pierce_status pierce_restore(const void* bytes, size_t size, const pierce_backend_options* backend,
                             pierce_world** world) {
    return guarded([&] {
        required(world, "world");
        if (bytes == nullptr) throw pierce::InputError("bytes is null");
        GivenBytes given(bytes, size);
        std::istream in(&given);
        *world = new pierce_world(pierce::World::restore(in, backend_of(backend)));
    });
}
